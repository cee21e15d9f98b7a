"""Which strips between leaves the image of a strip surely crosses, after how many impacts.

A strip is the part of the set between two leaves that are neighbours. Let all of one leaf's image lie before leaf a,
and all of the other's behind leaf b. Then the image of a path in the strip from one leaf to the other crosses every
leaf from a to b. So it has a path in each strip between these, from leaf to leaf.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel_as_written
from rattle_proof.chaos.leaves import BESIDE_FIRST, BESIDE_LAST, LEFT, OUTSIDE, RIGHT, Leaves, sides_of
from rattle_proof.enclosures.flight import Box, Matrix
from rattle_proof.enclosures.following import WIDEST
from rattle_proof.enclosures.interval import (
    Interval,
    add,
    around,
    divide,
    down,
    hull,
    middle,
    multiply,
    point,
    subtract,
    up,
    width,
)
from rattle_proof.enclosures.lattice import Lattice, span_of
from rattle_proof.enclosures.machine import Machine
from rattle_proof.enclosures.moving_set import MovingSet, advance

Following = Callable[[np.ndarray, float, int], np.ndarray]
"""Encloses images of pieces of leaves.

It takes rows of times at the lower and the upper end, and the speeds of these; half the width; how many impacts. It
gives least and greatest time and speed, shape (pieces, impacts, 4), not numbers where none is known.
"""


class Crossings(NamedTuple):
    """Strips that images of strips cross, arrays of shape (strips, impacts): from `first` to one before `last`."""

    first: np.ndarray
    last: np.ndarray


@kernel_as_written
def _follow_pieces(machine, oscillator, pieces, half_width, impacts, hulls):
    none, one = point(0.0), point(1.0)
    for k in range(pieces.shape[0]):
        below, above, low, high = point(pieces[k, 0]), point(pieces[k, 1]), pieces[k, 2], pieces[k, 3]
        speeds = Interval(low, high)
        v = middle(speeds)
        slope = divide(subtract(above, below), subtract(point(high), point(low)))
        # The middle at v, not where it is rounded to.
        exact = add(below, multiply(slope, subtract(point(v), point(low))))
        t = middle(exact)
        dt, dv = around(0.0, up(half_width)), subtract(speeds, point(v))
        times = hull(subtract(below, dt), subtract(above, dt))
        times = hull(times, hull(add(below, dt), add(above, dt)))
        rest = Box(subtract(exact, point(t)), none)
        moving = MovingSet(t, v, dt, dv, Matrix(one, slope, none, one), rest, Box(times, speeds), False)
        for n in range(impacts):
            proven, moving = advance(machine, oscillator, moving)
            if not (proven and width(moving.all.t) < WIDEST):
                break
            hulls[k, n, 0], hulls[k, n, 1] = moving.all.t
            hulls[k, n, 2], hulls[k, n, 3] = moving.all.w


def following(machine: Machine, oscillator: Oscillator) -> Following:
    """How pieces of leaves are followed under P.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.

    Returns
    -------
    Following
    """

    def follow(pieces: np.ndarray, half_width: float, impacts: int) -> np.ndarray:
        hulls = np.full((len(pieces), impacts, 4), np.nan)
        _follow_pieces(machine, oscillator, pieces, half_width, impacts, hulls)
        return hulls

    return follow


@kernel_as_written
def _touched(leaves, lattice, i, pieces):
    """The pieces of a leaf that may hold departures of the set: how many.

    The uppermost row of a lattice has no span. Nor has a leaf a part of the set there: `places_of` has seen to it.
    """
    count = 0
    for j in range(leaves.times.shape[1] - 1):
        below, above = leaves.times[i, j], leaves.times[i, j + 1]
        low = (leaves.first + j) * leaves.height
        early, late = down(min(below, above) - leaves.half_width), up(max(below, above) + leaves.half_width)
        span = span_of(lattice, Box(Interval(early, late), Interval(low, low + leaves.height)))
        there = False
        for row in range(span.bottom, span.top + 1):
            for column in range(span.left, span.right + 1):
                there = there or lattice.ends[row, column % lattice.ends.shape[1]] != 0
        if there:
            pieces[count] = below, above, low, low + leaves.height
            count += 1
    return count


@kernel_as_written
def _place(leaves, lattice, places, hulls):
    """How many leaves all of some images are behind for certain, and at most; (0, -1) where that is not known."""
    count, columns = leaves.times.shape[0], lattice.ends.shape[1]
    least, greatest = count, 0
    for k in range(hulls.shape[0]):
        box = Box(Interval(hulls[k, 0], hulls[k, 1]), Interval(hulls[k, 2], hulls[k, 3]))
        span = span_of(lattice, box)
        if span.top < span.bottom:
            return 0, -1
        for row in range(span.bottom, span.top + 1):
            for column in range(span.left, span.right + 1):
                j = column % columns
                place = places[row, j]
                if lattice.ends[row, j] == 0:
                    continue  # no image of the set lies there
                if place == OUTSIDE:
                    return 0, -1
                if place == LEFT or place == RIGHT:
                    surely, most = (0, 0) if place == LEFT else (count, count)
                else:
                    turns = (column - j) // columns
                    low = (lattice.first + row) * lattice.height
                    early, late = (
                        max(down(box.t.low - turns), j / columns),
                        min(up(box.t.high - turns), (j + 1) / columns),
                    )
                    low, high = max(box.w.low, low), min(box.w.high, low + lattice.height)
                    surely, most = sides_of(leaves, early, late, low, high)
                    if place == BESIDE_FIRST:
                        surely = 0
                    if place == BESIDE_LAST:
                        most = count
                least, greatest = min(least, surely), max(greatest, most)
    return least, greatest


def crossings(leaves: Leaves, lattice: Lattice, places: np.ndarray, follow: Following, impacts: int) -> Crossings:
    """Which strips the image of each strip surely crosses.

    Parameters
    ----------
    leaves : Leaves
    lattice : Lattice
        Whose boxes with an end are a set that is mapped into itself.
    places : ndarray
        Of `places_of`.
    follow : Following
    impacts : int
        How many at most.

    Returns
    -------
    Crossings
        By strips and by impacts, from 1 on.
    """
    count, nodes = leaves.times.shape
    surely, most = np.zeros((count, impacts), np.int64), np.full((count, impacts), -1, np.int64)
    room = np.empty((nodes - 1, 4))
    for i in range(count):
        hulls = follow(room[: _touched(leaves, lattice, i, room)], leaves.half_width, impacts)
        for n in range(impacts):
            surely[i, n], most[i, n] = _place(leaves, lattice, places, np.ascontiguousarray(hulls[:, n]))
    # All of one leaf's image before some leaf, all of the other's behind another: strips between these are crossed.
    before, behind = np.minimum(most[:-1], most[1:]), np.maximum(surely[:-1], surely[1:])
    apart = (most[:-1] <= surely[1:]) | (most[1:] <= surely[:-1])
    crosses = (most[:-1] >= 0) & (most[1:] >= 0) & apart & (before < behind - 1)
    return Crossings(np.where(crosses, before, 0), np.where(crosses, behind - 1, 0))
