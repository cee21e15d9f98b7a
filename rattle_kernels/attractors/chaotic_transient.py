"""An ensemble beside a trajectory that does not settle: whether the motion is chaotic, and how long the chaos lasts.

64 trajectories start at neighbouring speeds, 1e-9 v apart. Chaos separates them within some tens of impacts; after that
they are independent. All are followed for 16,384 impacts, or more if a motion takes longer to settle at the
oscillator's damping. The growth of their tangent vectors then decides two questions:

- Is the motion chaotic? It is if the mean exponent is positive by several standard errors.
- Does it last? A trajectory that has left chaos is captured, or bounces low until it is, or its tangent vector no
  longer grows. Followed as far again, it is on a periodic orbit. Chaos that some trajectories leave is a chaotic
  saddle, not an attractor. The number that leave gives its mean life.

Then the ensemble is followed until its members settle, and what they settle on are the ends of the transient. After
every 16,384 impacts each member is looked at. It has ended if contact is permanent, if it has arrived at an orbit that
others have ended on, or if its tangent vector no longer grows and Newton's method finds an attracting orbit there. A
member that has ended is not followed any further, so this takes 64 mean lives of impacts, or 64 times half a million.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import ENSEMBLE, PERMANENT_CONTACT_ATTRACTOR, SHORTEST_RUN, Attractor
from rattle_kernels.attractors.chaotic_boxes import IMAGES, fly_and_note, keep_boxes
from rattle_kernels.attractors.matching import attractor_distance
from rattle_kernels.attractors.neighbourhoods import locate, neighbourhoods
from rattle_kernels.attractors.settled_orbit import attractor_of, settled_orbit
from rattle_kernels.cell_mapping.iterations import settled_iterations
from rattle_kernels.lanes.batch import Rules
from rattle_kernels.lanes.lyapunov import TangentGrowth, tangent_growth
from rattle_kernels.lanes.run import LOCK_TOLERANCE, run_lanes
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.pausing import Pause, never_stopped

# Initial separation of neighbouring trajectories: 1e-9 v, which is e^-21 v.
_APART = 1e-9
_LEGS = 64
_SHORTEST_LEG = SHORTEST_RUN // _LEGS
# Impacts of a test for chaos. Beyond a cascade of period doublings chaos is so weak that it needs the second.
_GROWING = 512, 8192
_STANDARD_ERRORS = 5.0
REGULAR_GROWTH = 6.0
"""Regular motions separate too, but at most in proportion to the impacts: by this factor times their number."""
SLUGGISH = 0.25
"""A tangent vector whose logarithm has grown by less than this part of what is usual is not in chaos."""
# Ever lower bounces take less and less time, down to thousands of impacts per period. On an attractor the pace is
# steady, and there are enough turns of the forcing to measure it.
_PACES = (0.5, 2.0)
_LEAST_TURNS = 8.0
# Near the bound of Eq. (8) a low bounce is captured after up to 400,000 impacts. Of those with more than 128 impacts a
# period none was seen to rattle again; of those with 64 one in seven was.
_LOW_PACE = 1.0 / 128.0
_IMPACTS_TO_CAPTURE = 1 << 19


class EnsembleRun(NamedTuple):
    """Result of following an ensemble for a number of ``impacts`` each.

    ``exponent`` (per forcing period) and its standard ``error`` are measured at the end, over ``turns`` of the forcing.
    There the logarithm of a tangent vector grew by ``growth``; in regular motion it grows by ``regular`` at most.
    ``pace`` is the time per impact there, relative to that at the beginning. ``t``, ``v`` are departures, at least 256
    impacts apart, of the trajectories that were neither captured nor settled. ``captured`` is the number captured.
    ``settled`` (shape (n, 2)) holds phases and speeds of those that seem to have settled, followed for as long again.
    """

    impacts: int
    exponent: float
    error: float
    growth: float
    regular: float
    turns: float
    pace: float
    t: np.ndarray
    v: np.ndarray
    captured: int
    settled: np.ndarray

    @property
    def chaotic(self) -> bool:
        """Whether the exponent is five standard errors above zero and the pace steady.

        The pace matters for low bounces: close to the bound of Eq. (8) their tangent vectors grow while they decay. By
        the exponent alone the decay would pass for an attractor.
        """
        steady = _PACES[0] < self.pace < _PACES[1] and self.turns > _LEAST_TURNS
        return self.exponent > _STANDARD_ERRORS * self.error and self.growth > self.regular and steady

    @property
    def ends(self) -> np.ndarray:
        """Phases and speeds, shape (n, 2), of the last departures of all trajectories that were not captured."""
        last = self.t.size - self.t.size // _LEGS
        return np.vstack([self.settled, np.column_stack([self.t[last:], self.v[last:]])])

    def mean_life(self, left: int) -> float:
        """Mean number of impacts before a trajectory leaves, if `left` of them have by the end; NaN if none has.

        Times of leaving are not known, so this takes an exponential law and the number gone at the end.
        """
        return math.nan if left == 0 else -self.impacts / math.log1p(-left / ENSEMBLE)


def _all_captured(impacts: int) -> EnsembleRun:
    nothing, nowhere = (math.nan,) * 6, np.empty(0)
    return EnsembleRun(impacts, *nothing, nowhere, nowhere, ENSEMBLE, np.empty((0, 2)))


def follow_ensemble(oscillator: Oscillator, t: float, v: float, pause: Pause = never_stopped) -> EnsembleRun:
    """Follow an ensemble beside a trajectory.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        Phase and speed of a departure from +beta.
    pause : callable
        Called several times a second; an exception raised there ends the search.

    Returns
    -------
    EnsembleRun
    """
    leg = max(_SHORTEST_LEG, settled_iterations(oscillator.damping) // _LEGS)
    begun = tangent_growth(oscillator, np.full(ENSEMBLE, t), v * (1.0 + _APART * np.arange(ENSEMBLE)), _GROWING[0])
    visits = np.full((_LEGS, 2, ENSEMBLE), np.nan)
    going = np.flatnonzero(np.isfinite(begun.t))
    times, speeds = begun.t[going], begun.v[going]
    boxes = None
    # Where a leg takes as many impacts as a point marks boxes with, these are the same flights.
    if leg == IMAGES:
        pause()
        rules = Rules(float(leg), lane_tables(oscillator).capture_bound, LOCK_TOLERANCE)
        kept, boxes = fly_and_note(oscillator, rules, times, speeds, going, visits)
        times, speeds, going = times[kept], speeds[kept], going[kept]
    else:
        for visit in visits:
            visit[:, going] = times, speeds
            kept, times, speeds = _carried(oscillator, times, speeds, leg, pause)
            going = going[kept]
    ended, grown_over = _resolved_growth(oscillator, times, speeds)
    there = np.isfinite(ended.growth)
    low = ended.elapsed < _LOW_PACE * grown_over
    there[_captured(oscillator, np.flatnonzero(low), ended, pause)] = False
    if there.sum() < 2:
        return _all_captured(_LEGS * leg)
    median = np.nanmedian(ended.growth)
    # If half of the vectors do not grow, there is no chaos for the others to have left.
    settled = there & (ended.growth < SLUGGISH * median) & (median > 0.0)
    kept, *ends = _carried(oscillator, ended.t[settled], ended.v[settled], _LEGS * leg, pause)
    staying = ended.of(there & ~settled)
    stayed = going[there & ~settled]
    points = visits[:, 0, stayed].ravel(), visits[:, 1, stayed].ravel()
    turns = float(staying.elapsed.mean())
    pace = turns / grown_over / (float(np.nanmean(begun.elapsed)) / _GROWING[0])
    ensemble = EnsembleRun(
        _LEGS * leg, staying.exponent, staying.error, float(staying.growth.mean()),
        math.log(REGULAR_GROWTH * grown_over), turns, pace, *points,
        ENSEMBLE - int(there.sum()) + int((~kept).sum()), np.column_stack(ends),
    )  # fmt: skip
    if boxes is not None and ensemble.chaotic:
        keep_boxes(oscillator, *points, boxes, stayed)
    return ensemble


def _resolved_growth(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> tuple[TangentGrowth, int]:
    """Growth of tangent vectors over enough impacts to distinguish chaos from regular motion, and that number."""
    for impacts in _GROWING:
        ended = tangent_growth(oscillator, t, v, impacts)
        growth = ended.growth[np.isfinite(ended.growth)]
        if not growth.size or not 0.0 < np.median(growth) < math.log(REGULAR_GROWTH * impacts):
            break
    return ended, impacts


def _captured(oscillator: Oscillator, low: np.ndarray, ended: TangentGrowth, pause: Pause) -> np.ndarray:
    """Which of some low bounces are captured in the end."""
    left, t, v = low, ended.t[low], ended.v[low]
    for _ in range(0, _IMPACTS_TO_CAPTURE, SHORTEST_RUN):
        if left.size:
            kept, t, v = _carried(oscillator, t, v, SHORTEST_RUN, pause)
            left = left[kept]
    return np.setdiff1d(low, left)


def _carried(
    oscillator: Oscillator, t: np.ndarray, v: np.ndarray, impacts: int, pause: Pause
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which departures are not captured within a number of impacts, and where these are then."""
    carried, _ = run_lanes(oscillator, t, v, impacts, shortcuts=True, pause=pause)
    kept = carried.outcome == Outcome.RETURNED
    return kept, carried.t[kept], carried.v[kept]


LONGEST = 1 << 19
"""Impacts for which a member is followed at most, after those of the ensemble."""
# Newton's method converges to 1e-11. Orbits closer than this are the same.
_SAME_ORBIT = 1e-6


def _place_of(oscillator: Oscillator, orbit: Attractor, motions: Sequence[Attractor]) -> int:
    """Place of a periodic orbit among motions; their number if it is none of them."""
    for place, motion in enumerate(motions):
        if motion[:4] == orbit[:4] and attractor_distance(oscillator, motion, orbit) < _SAME_ORBIT:
            return place
    return len(motions)


def note_orbits(
    oscillator: Oscillator, t: np.ndarray, v: np.ndarray, motions: list[Attractor], members: list[int], pause: Pause
) -> np.ndarray:
    """Find the attracting periodic orbits that settled trajectories approach.

    Most approach one that another has led to. So these are recognised by its neighbourhoods, all at once.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : ndarray of float64, shape (n,)
        Phases and speeds of their departures.
    motions : list of Attractor
        Known motions. Orbits that are none of them are added.
    members : list of int
        How many trajectories have ended in each motion; those that are found here are counted.
    pause : callable
        Called several times a second; an exception raised there ends the search.

    Returns
    -------
    ndarray of bool, shape (n,)
        Which trajectories approach an attracting periodic orbit.
    """
    left, approach = np.arange(t.size), np.zeros(t.size, np.bool_)
    while left.size:
        pause()
        member, left = left[0], left[1:]
        orbit = settled_orbit(oscillator, float(t[member]), float(v[member]))
        if orbit is None:
            continue
        found = attractor_of(orbit)
        place, approach[member] = _place_of(oscillator, found, motions), True
        if place == len(motions):
            motions.append(found)
            members.append(0)
            around = neighbourhoods(oscillator, [PERMANENT_CONTACT_ATTRACTOR, found], pause)
            alike = locate(oscillator, around, t[left], v[left]) == 1
            approach[left[alike]] = True
            members[place] += int(alike.sum())
            left = left[~alike]
        members[place] += 1
    return approach


def follow_to_ends(
    oscillator: Oscillator, ensemble: EnsembleRun, orbits: Sequence[Attractor], pause: Pause = never_stopped
) -> tuple[list[Attractor], list[int], int]:
    """Follow the members of an ensemble on a chaotic transient until they have ended.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    ensemble : EnsembleRun
        Chaotic; some of its trajectories have left.
    orbits : sequence of Attractor
        Periodic orbits that are known to attract some, each once.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    motions : list of Attractor
        Permanent contact, then periodic orbits, with the given ones first.
    members : list of int
        How many have ended in each. The others of the ensemble were still on the transient.
    later : int
        How many of them have left after the run of the ensemble itself.
    """
    motions = [PERMANENT_CONTACT_ATTRACTOR, *orbits]
    members = [ensemble.captured, *(0 for _ in orbits)]
    t, v = np.ascontiguousarray(ensemble.ends.T)
    begun = 0
    for followed in range(0, LONGEST + 1, SHORTEST_RUN):
        if followed:
            carried, _ = run_lanes(oscillator, t, v, SHORTEST_RUN, shortcuts=True, pause=pause)
            members[0] += int((carried.outcome == Outcome.PERMANENT_CONTACT).sum())
            going = carried.outcome == Outcome.RETURNED
            t, v = carried.t[going], carried.v[going]
        t, v = _not_ended(oscillator, t, v, ensemble.exponent, motions, members, pause)
        begun = begun if followed else sum(members)
        if not t.size:
            break
    return motions, members, sum(members) - begun


def _not_ended(
    oscillator: Oscillator, t: np.ndarray, v: np.ndarray, exponent: float, motions: list[Attractor], members: list[int],
    pause: Pause,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Members that are still on the transient. The others are counted, and new orbits added."""
    places = locate(oscillator, neighbourhoods(oscillator, motions, pause), t, v)
    for place in places[places >= 0].tolist():
        members[place] += 1
    t, v = t[places < 0], v[places < 0]
    grown = tangent_growth(oscillator, t, v, _GROWING[0])
    settled = np.flatnonzero(grown.growth < SLUGGISH * exponent * grown.elapsed)
    ended = settled[note_orbits(oscillator, t[settled], v[settled], motions, members, pause)]
    return np.delete(t, ended), np.delete(v, ended)
