"""A ensemble beside a trajectory that does not settle, to tell whether this is chaos, and for how long chaos holds it.

64 trajectories start a hair's breadth apart. Chaos parts them within some tens of impacts; from there on they are
independent. All are carried for 16,384 impacts, or for as many as settle a motion at the oscillator's damping where
that is more, and tell by how their tangent vectors grow then:

- whether the motion is chaotic: their mean exponent is positive by several standard errors;
- whether it lasts: a trajectory that has left chaos is captured, or its tangent vector no longer grows, and when it has
  been carried as far again it is on a periodic orbit. Chaos that some leave is a chaotic saddle, no attractor; how many
  leave it within so many impacts gives its mean life.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.cell_mapping.iterations import settled_iterations
from rattle_kernels.lanes.flight import LANES
from rattle_kernels.lanes.lyapunov import Growth, tangent_growth
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.pausing import Pause, never_stopped

ENSEMBLE = LANES
# Apart by rounding's thousandfold in speed, they are e^-21 of the speed from being one.
_APART = 1e-9
_LEGS = 64
_SHORTEST_LEG = 256
# Chaos shows within the first; behind a cascade of period doublings it is so weak that it takes the second.
_GROWING = 512, 8192
_STANDARD_ERRORS = 5.0
# Regular motions part, too, but no faster than in proportion to the impacts: by no more than so many times them.
_REGULAR_GROWTH = 6.0
# A vector that has grown by less than this part of the median does not grow as in chaos.
_SLUGGISH = 0.25
# A motion that bounces ever lower needs less and less time for an impact, and thousands of impacts fit into a period;
# one on an attractor has a steady pace, and turns of the forcing enough to have one.
_PACES = (0.5, 2.0)
_LEAST_TURNS = 8.0


class EnsembleRun(NamedTuple):
    """What a ensemble has done in so many ``impacts`` of each.

    ``exponent`` per forcing period and its standard ``error`` at the end, over so many ``turns`` of the forcing, in
    which the logarithm of a tangent vector grew by ``growth``, and by no more than ``regular`` were it not chaos;
    ``pace`` is the time that an impact took then, as a part of what it took at the beginning. ``t``, ``v`` are
    departures on the way, at least 256 impacts apart, of those that have neither been captured nor settled;
    ``captured`` counts the former, and ``settled`` (shape (n, 2)) are phases and speeds of those that seem to have
    settled, carried on for as long again.
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
        """Whether an exponent is five standard errors above zero at a steady pace.

        The second matters for low bounces: close to the bound of Eq. (8) their tangent vectors grow while they decay,
        and the exponent alone would take the decay for an attractor.
        """
        steady = _PACES[0] < self.pace < _PACES[1] and self.turns > _LEAST_TURNS
        return self.exponent > _STANDARD_ERRORS * self.error and self.growth > self.regular and steady

    @property
    def ends(self) -> np.ndarray:
        """Phases and speeds, shape (n, 2), of the last departures of all that have not been captured."""
        last = self.t.size - self.t.size // _LEGS
        return np.vstack([self.settled, np.column_stack([self.t[last:], self.v[last:]])])

    def mean_life(self, left: int) -> float:
        """Impacts after which a trajectory leaves, on average, where so many have; NaN where none has.

        The law is exponential, and when each of them left is not known: so many are gone after all impacts.
        """
        return math.nan if left == 0 else -self.impacts / math.log1p(-left / ENSEMBLE)


def _all_captured(impacts: int) -> EnsembleRun:
    nothing, nowhere = (math.nan,) * 6, np.empty(0)
    return EnsembleRun(impacts, *nothing, nowhere, nowhere, ENSEMBLE, np.empty((0, 2)))


def follow_ensemble(oscillator: Oscillator, t: float, v: float, pause: Pause = never_stopped) -> EnsembleRun:
    """Follow a ensemble beside a trajectory.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        Phase and speed of a departure from +beta.
    pause : callable
        Called several times a second; what it raises ends the search.

    Returns
    -------
    EnsembleRun
    """
    leg = max(_SHORTEST_LEG, settled_iterations(oscillator.damping) // _LEGS)
    begun = tangent_growth(oscillator, np.full(ENSEMBLE, t), v * (1.0 + _APART * np.arange(ENSEMBLE)), _GROWING[0])
    visits = np.full((_LEGS, 2, ENSEMBLE), np.nan)
    going = np.flatnonzero(np.isfinite(begun.t))
    times, speeds = begun.t[going], begun.v[going]
    for visit in visits:
        visit[:, going] = times, speeds
        kept, times, speeds = _carried(oscillator, times, speeds, leg, pause)
        going = going[kept]
    ended, grown_over = _resolved_growth(oscillator, times, speeds)
    there = np.isfinite(ended.growth)
    if there.sum() < 2:
        return _all_captured(_LEGS * leg)
    median = np.nanmedian(ended.growth)
    # Where half of them do not grow this is no chaos that others could have left.
    settled = there & (ended.growth < _SLUGGISH * median) & (median > 0.0)
    kept, *ends = _carried(oscillator, ended.t[settled], ended.v[settled], _LEGS * leg, pause)
    staying = ended.of(there & ~settled)
    points = visits[:, :, going[there & ~settled]]
    turns = float(staying.elapsed.mean())
    pace = turns / grown_over / (float(np.nanmean(begun.elapsed)) / _GROWING[0])
    return EnsembleRun(
        _LEGS * leg, staying.exponent, staying.error, float(staying.growth.mean()),
        math.log(_REGULAR_GROWTH * grown_over), turns, pace, points[:, 0].ravel(), points[:, 1].ravel(),
        ENSEMBLE - int(there.sum()) + int((~kept).sum()), np.column_stack(ends),
    )  # fmt: skip


def _resolved_growth(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> tuple[Growth, int]:
    """Growth of tangent vectors over as many impacts as tell chaos from regular motion; and how many these are."""
    for impacts in _GROWING:
        ended = tangent_growth(oscillator, t, v, impacts)
        growth = ended.growth[np.isfinite(ended.growth)]
        if not growth.size or not 0.0 < np.median(growth) < math.log(_REGULAR_GROWTH * impacts):
            break
    return ended, impacts


def _carried(
    oscillator: Oscillator, t: np.ndarray, v: np.ndarray, impacts: int, pause: Pause
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which of some departures are not captured within so many impacts, and where those are then."""
    carried, _ = run_lanes(oscillator, t, v, impacts, shortcuts=True, pause=pause)
    kept = carried.outcome == Outcome.RETURNED
    return kept, carried.t[kept], carried.v[kept]
