"""Solution of each landing point: the motion it ends in, whatever the window."""

from collections.abc import Sequence

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.attractors.neighbourhoods import locate, neighbourhoods
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.phase import wrap_all

UNASSIGNED = -1
"""Arrived at no attractor of the catalogue."""

# For transients of chaotic saddles: 32 more legs of 4093 impacts before a point remains unassigned.
_LEGS = 32
# A leg of this many points takes about 0.4 s.
_POINTS_AT_A_TIME = 8192


def name_solutions(
    oscillator: Oscillator,
    attractors: Sequence[Attractor],
    t: np.typing.ArrayLike,
    v: np.typing.ArrayLike,
    pause: Pause = never_stopped,
    *,
    legs: int = _LEGS,
) -> np.ndarray:
    """Index of the attractor that each landing point ends in, found by applying P to it.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    attractors : sequence of Attractor
        Catalogue from `find_attractors`: permanent contact first.
    t, v : array_like, shape (n,)
        Landing points: finite phases and speeds of departures from +beta.
    pause : callable
        Called several times a second; an exception raised there ends the search.
    legs : int
        Stretches of 4093 impacts that a point is followed for; four times as many of low bounces.

    Returns
    -------
    ndarray of int16, shape (n,)
        UNASSIGNED (-1) for a point that reaches no attractor of the catalogue: by default within about 130,000
        impacts, or half a million of low bounces.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If a point is not a departure: not finite, or without a positive speed.
    """
    checked = check_oscillator(oscillator)
    times, speeds = np.asarray(t, np.float64), np.asarray(v, np.float64)
    if not (np.isfinite(times).all() and np.isfinite(speeds).all() and (speeds > 0.0).all()):
        raise ValueError("landing points must be finite with positive speeds; captured cells have none: leave them out")
    times = wrap_all(times)
    around = neighbourhoods(checked, attractors, pause)
    places = np.empty(times.size, np.int16)
    for start in range(0, times.size, _POINTS_AT_A_TIME):
        part = slice(start, start + _POINTS_AT_A_TIME)
        places[part] = locate(checked, around, times[part], speeds[part], legs, pause)
    return places
