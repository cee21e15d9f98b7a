"""The first of many oscillators that a check refuses, found with few checks.

A check is convex in a parameter if between two accepted values every value is accepted. Then both ends tell of all
values between them, and the first refused one is found by halving.

The domain of the map is convex in each number of the oscillator but the phases of harmonics: the acceleration at rest
(Eq. 8) is linear in the damping and in each amplitude at every phase, and all other bounds are monotonic or have one
maximum. The reaction of contact without ringing (Eq. 3) is linear in the amplitudes alone where the stiffness is
finite: it has a resonance. In the other parameters `worker.jobs.pressed_for_sure` decides most values at once, and the
rest is checked one by one.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np


class Axis(NamedTuple):
    """Number of values of a parameter, and whether the check is convex in it."""

    size: int
    convex: bool


def first_refused(
    axes: Sequence[Axis],
    refused: Callable[[tuple[int, ...]], bool],
    accepted: Callable[[], np.ndarray] = lambda: np.array(False),
) -> tuple[int, ...] | None:
    """Place of the first refused combination of values, the last axis fastest; None if there is none.

    Parameters
    ----------
    axes : sequence of Axis
    refused : callable
        Whether the check refuses the combination at a place.
    accepted : callable
        Which combinations the check accepts for sure, so far as it is not convex in all parameters. What else it checks
        is convex in all of them.

    Returns
    -------
    tuple of int, optional

    Examples
    --------
    >>> first_refused([Axis(1_000_000, True)], lambda place: place[0] > 314_159)
    (314160,)
    """
    found = _first((), tuple(axis.size for axis in axes), refused)
    if all(axis.convex for axis in axes):
        return found
    shape = tuple(axis.size for axis in axes)
    for number in np.flatnonzero(~np.broadcast_to(accepted(), shape)):
        place = tuple(map(int, np.unravel_index(number, shape)))
        if found is not None and place >= found:
            break
        if refused(place):
            return place
    return found


def _first(
    place: tuple[int, ...], sizes: tuple[int, ...], refused: Callable[[tuple[int, ...]], bool]
) -> tuple[int, ...] | None:
    """A refused place. No earlier one is refused by what is convex in all parameters."""
    if not sizes:
        return place if refused(place) else None
    size, rest = sizes[0], sizes[1:]
    first = _first((*place, 0), rest, refused)
    if first is not None or size == 1:
        return first
    low, high = 0, size - 1
    last = _first((*place, high), rest, refused)
    # All before `low` are accepted. Where `high` is refused, so are all from the first refused one on.
    while last is not None and high - low > 1:
        middle = (low + high) // 2
        found_there = _first((*place, middle), rest, refused)
        if found_there is None:
            low = middle
        else:
            high, last = middle, found_there
    return last
