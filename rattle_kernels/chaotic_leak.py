"""Whether a chaotic set holds what is on it, or lets it go: an attractor, or a transient.

Where a chaotic attractor has just been destroyed its remnant, a chaotic saddle, keeps motions for a long time: 1e5
impacts in the mean at the paper's delta = 0.65, after which they settle on P(3,3,1). No exponent along one trajectory
tells the two apart, but many trajectories do: points of the set are followed for some thousand impacts each, and those
that have left are counted. They leave at a constant rate, so of lives of up to some million impacts at least one is
likely to be seen ending. A set that none has left is taken for an attractor: that is what has been seen of it, no
proof.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractor import PERMANENT_CONTACT_ATTRACTOR, Attractor, AttractorKind
from rattle_kernels.impact_lanes import run_lanes
from rattle_kernels.iterations import settled_iterations
from rattle_kernels.lane_tables import lane_tables
from rattle_kernels.neighbourhoods import locate, neighbourhoods
from rattle_kernels.oscillator import Oscillator
from rattle_kernels.outcome import Outcome
from rattle_kernels.settled_orbit import attractor_of, settled_orbit

# Impacts in all: a thirtieth of a second.
_IMPACTS = 1 << 22
_FEWEST, _MOST = 64, 1024
_LEAST_IMPACTS = 4096
# Two motions this close have settled on one orbit.
_COINCIDENCE = 1e-9


class Leak(NamedTuple):
    """What becomes of motions on a chaotic set.

    ``mean_life`` is the number of impacts after which one leaves, infinite where none was seen to; ``orbits`` are the
    attracting periodic orbits on which several were found.
    """

    mean_life: float
    orbits: tuple[Attractor, ...]


def _meeting_places(t: np.ndarray, v: np.ndarray, speed_scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Points at which two or more motions are, each once."""
    boxes = np.rint(np.column_stack([t, v / speed_scale]) / _COINCIDENCE).astype(np.int64)
    _, first, count = np.unique(boxes, axis=0, return_index=True, return_counts=True)
    return t[first[count > 1]], v[first[count > 1]]


def _orbits_met(
    oscillator: Oscillator, t: np.ndarray, v: np.ndarray, known: Sequence[Attractor]
) -> tuple[Attractor, ...]:
    """Attracting orbits through some points, those known left out."""
    found: list[Attractor] = []
    while t.size:
        unknown = locate(oscillator, neighbourhoods(oscillator, [*known, *found]), t, v) < 0
        t, v = t[unknown], v[unknown]
        orbit = settled_orbit(oscillator, float(t[0]), float(v[0])) if t.size else None
        found += [] if orbit is None else [attractor_of(orbit)]
        t, v = t[1:], v[1:]
    return tuple(found)


def chaotic_leak(oscillator: Oscillator, motion: Attractor, catalogue: Sequence[Attractor]) -> Leak:
    """Follow points of a chaotic set and count those that leave it.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    motion : Attractor
        Its points are on the set.
    catalogue : sequence of Attractor
        What is known that they may leave to, permanent contact first.

    Returns
    -------
    Leak
    """
    # Where damping is weak a motion needs more impacts to be seen to have settled.
    impacts = max(_LEAST_IMPACTS, settled_iterations(oscillator.damping))
    chosen = np.linspace(0, motion.time.size - 1, min(max(_IMPACTS // impacts, _FEWEST), _MOST)).astype(np.int64)
    after, _ = run_lanes(oscillator, motion.time[chosen], motion.velocity[chosen], impacts, shortcuts=True)
    left = after.outcome == Outcome.RETURNED
    t, v = after.t[left], after.v[left]
    known = [PERMANENT_CONTACT_ATTRACTOR, *(each for each in catalogue if each.kind == AttractorKind.PERIODIC)]
    orbits = _orbits_met(oscillator, *_meeting_places(t, v, lane_tables(oscillator).speed_scale), known)
    still = int((locate(oscillator, neighbourhoods(oscillator, [*known, *orbits]), t, v) < 0).sum())
    if still == chosen.size:
        return Leak(math.inf, orbits)
    return Leak(impacts / math.log(chosen.size / max(still, 0.5)), orbits)
