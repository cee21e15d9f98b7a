"""A crowd beside a trajectory that does not settle, to tell whether this is chaos, and for how long chaos holds it.

64 trajectories start a hair's breadth apart. Chaos parts them within some tens of impacts; from there on they are
independent. All are carried for 16,384 impacts and tell by how their tangent vectors grow then:

- whether the motion is chaotic: their mean exponent is positive by several standard errors;
- whether it lasts: a trajectory that has left chaos is captured, or its tangent vector no longer grows. Chaos that some
  leave is a chaotic saddle, no attractor; how many leave it within so many impacts gives its mean life.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_lanes import run_lanes
from rattle_kernels.lane_flight import LANES
from rattle_kernels.lyapunov import tangent_growth
from rattle_kernels.oscillator import Oscillator
from rattle_kernels.outcome import Outcome

CROWD = LANES
# Apart by rounding's thousandfold in speed, they are e^-21 of the speed from being one.
_APART = 1e-9
_LEGS = 64
_LEG = 256
_GROWING = 512
_STANDARD_ERRORS = 5.0
# A vector that has grown by less than this part of the median does not grow as in chaos.
_SLUGGISH = 0.25
# A motion that bounces ever lower needs less and less time for an impact, and thousands of impacts fit into a period;
# one on an attractor has a steady pace, and turns of the forcing enough to have one.
_PACES = (0.5, 2.0)
_LEAST_TURNS = 8.0


class Wandering(NamedTuple):
    """What a crowd has done.

    ``exponent`` per forcing period and its standard ``error`` at the end, over so many ``turns`` of the forcing;
    ``pace`` is the time that an impact took then, as a part of what it took at the beginning. ``t``, ``v`` are
    departures on the way, 256 impacts apart, of those that have neither been captured nor settled; ``captured`` counts
    the former, and ``settled`` (shape (n, 2)) are phases and speeds at the end of those that seem to have settled.
    """

    exponent: float
    error: float
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
        return self.exponent > _STANDARD_ERRORS * self.error and steady


_ALL_CAPTURED = Wandering(math.nan, math.nan, 0.0, math.nan, np.empty(0), np.empty(0), CROWD, np.empty((0, 2)))


def mean_life(left: int) -> float:
    """Impacts after which a trajectory leaves, on average, where so many of a crowd have; NaN where none has.

    The law is exponential, and when each of them left is not known: so many are gone after all impacts.
    """
    return math.nan if left == 0 else -_LEGS * _LEG / math.log1p(-left / CROWD)


def wander(oscillator: Oscillator, t: float, v: float, pause: Callable[[], None] = lambda: None) -> Wandering:
    """Follow a crowd beside a trajectory.

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
    Wandering
    """
    times, speeds = np.full(CROWD, t), v * (1.0 + _APART * np.arange(CROWD))
    begun = tangent_growth(oscillator, times, speeds, _GROWING)
    visits = np.full((_LEGS, 2, CROWD), np.nan)
    going = np.flatnonzero(np.isfinite(begun.t))
    times, speeds = begun.t[going], begun.v[going]
    for visit in visits:
        pause()
        visit[:, going] = times, speeds
        carried, _ = run_lanes(oscillator, times, speeds, _LEG, shortcuts=True)
        kept = carried.outcome == Outcome.RETURNED
        going, times, speeds = going[kept], carried.t[kept], carried.v[kept]
    ended = tangent_growth(oscillator, times, speeds, _GROWING)
    there = np.isfinite(ended.growth)
    if there.sum() < 2:
        return _ALL_CAPTURED
    median = np.nanmedian(ended.growth)
    # Where half of them do not grow this is no chaos that others could have left.
    settled = there & (ended.growth < _SLUGGISH * median) & (median > 0.0)
    wandering = there & ~settled
    chosen = ended.of(wandering)
    points = visits[:, :, going[wandering]]
    turns = float(chosen.elapsed.mean())
    pace = turns / float(np.nanmean(begun.elapsed))
    ends = np.column_stack([ended.t[settled], ended.v[settled]])
    return Wandering(
        chosen.exponent, chosen.error, turns, pace, points[:, 0].ravel(), points[:, 1].ravel(),
        CROWD - int(there.sum()), ends,
    )  # fmt: skip
