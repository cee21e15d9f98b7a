"""What a chaotic transient ends in: the ensemble that measures its mean life is followed until its members settle.

After every 16,384 impacts each member is looked at. It has ended if contact is permanent, if it has arrived at an orbit
that others have ended on, or if its tangent vector no longer grows and Newton's method finds an attracting orbit there.
A member that has ended is not followed any further, so this takes 64 mean lives of impacts, or 64 times half a million.
"""

from collections.abc import Sequence

import numpy as np

from rattle_kernels.attractors.attractor import PERMANENT_CONTACT_ATTRACTOR, SHORTEST_RUN, Attractor
from rattle_kernels.attractors.chaotic_transient import SLUGGISH, EnsembleRun
from rattle_kernels.attractors.matching import attractor_distance
from rattle_kernels.attractors.neighbourhoods import locate, neighbourhoods
from rattle_kernels.attractors.settled_orbit import attractor_of, settled_orbit
from rattle_kernels.lanes.lyapunov import tangent_growth
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.pausing import Pause, never_stopped

LONGEST = 1 << 19
"""Impacts for which a member is followed at most, after those of the ensemble."""
# In chaos a tangent vector grows by e^50 and more.
_GROWING = 512
# Newton's method converges to 1e-11. Orbits closer than this are the same.
_SAME_ORBIT = 1e-6


def _place_of(oscillator: Oscillator, orbit: Attractor, motions: Sequence[Attractor]) -> int:
    """Place of a periodic orbit among motions; their number if it is none of them."""
    for place, motion in enumerate(motions):
        if motion[:4] == orbit[:4] and attractor_distance(oscillator, motion, orbit) < _SAME_ORBIT:
            return place
    return len(motions)


def distinct(oscillator: Oscillator, orbits: Sequence[Attractor]) -> list[Attractor]:
    """Periodic orbits, each once.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    orbits : sequence of Attractor

    Returns
    -------
    list of Attractor
        In the order in which they come.
    """
    once: list[Attractor] = []
    for orbit in orbits:
        if _place_of(oscillator, orbit, once) == len(once):
            once.append(orbit)
    return once


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
    grown = tangent_growth(oscillator, t, v, _GROWING)
    settled = (places < 0) & (grown.growth < SLUGGISH * exponent * grown.elapsed)
    for member in np.flatnonzero(settled).tolist():
        pause()
        orbit = settled_orbit(oscillator, float(t[member]), float(v[member]))
        if orbit is not None:
            found = attractor_of(orbit)
            places[member] = _place_of(oscillator, found, motions)
            if places[member] == len(motions):
                motions.append(found)
                members.append(0)
    for place in places[places >= 0].tolist():
        members[place] += 1
    return t[places < 0], v[places < 0]
