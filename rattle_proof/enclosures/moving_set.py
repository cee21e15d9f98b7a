"""A set of departures that moves under P as a parallelogram, held by enclosures.

After n impacts the set is held by ``m + M xi + rest``: m is near the image of the first box's centre, M encloses the
product of the slopes, xi runs through the first box less its centre, and the rest holds what was rounded and what other
parameters change. A hull is taken only to enclose DP over the set, so little is lost to wrapping.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.numerics.jit import inlined_as_written
from rattle_proof.enclosures.flight import Box, Matrix, spread
from rattle_proof.enclosures.impact import LOST, STRADDLES, image, product
from rattle_proof.enclosures.interval import Interval, add, around, hull, middle, multiply, point, scale, subtract, up
from rattle_proof.enclosures.lattice import Strip

STEEPEST = 4096.0
WIDEST = 0.5
"""A width in time beyond which a set is given up."""


class MovingSet(NamedTuple):
    """A set, its hull ``all``, and whether it has met the grazing curve; then it is a box again."""

    t: float
    v: float
    dt: Interval
    dv: Interval
    slope: Matrix
    rest: Box
    all: Box
    grazed: bool


@inlined_as_written
def _half(a, centre):
    return around(0.0, up(max(a.high - centre, centre - a.low)))


@inlined_as_written
def _both(a, b):
    return Interval(max(a.low, b.low), min(a.high, b.high))


@inlined_as_written
def set_out(box, grazed):
    """The set of all departures of a box."""
    t, v = middle(box.t), middle(box.w)
    identity = Matrix(point(1.0), point(0.0), point(0.0), point(1.0))
    rest = Box(point(0.0), point(0.0))
    return MovingSet(t, v, _half(box.t, t), _half(box.w, v), identity, rest, box, grazed)


@inlined_as_written
def _without_turns(moved):
    """The set with its middle below 1: whole turns are taken off, which rounds nothing; none are added, which would."""
    turns = max(math.floor(moved.t), 0)
    every = Box(subtract(moved.all.t, point(turns)), moved.all.w)
    return MovingSet(moved.t - turns, moved.v, moved.dt, moved.dv, moved.slope, moved.rest, every, moved.grazed)


@inlined_as_written
def advance(machine, oscillator, moving):
    """Image of a set under P.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.
    moving : MovingSet

    Returns
    -------
    (bool, MovingSet)
        Whether it is proven.
    """
    # What was rounded may have put m a little outside: slopes are needed on the whole way from m.
    whole = Box(hull(moving.all.t, point(moving.t)), hull(moving.all.w, point(moving.v)))
    mapped = image(machine, oscillator, Box(point(moving.t), point(moving.v)), whole)
    if mapped.state == LOST:
        return False, moving
    if mapped.state == STRADDLES:
        return True, _without_turns(set_out(mapped.all, True))
    t, v = middle(mapped.centre.t), middle(mapped.centre.w)
    rest = spread(mapped.slope, moving.rest.t, moving.rest.w)
    off_t, off_v = subtract(mapped.centre.t, point(t)), subtract(mapped.centre.w, point(v))
    rest = Box(add(add(rest.t, off_t), mapped.drift.t), add(add(rest.w, off_v), mapped.drift.w))
    slope = product(mapped.slope, moving.slope)
    moved = spread(slope, moving.dt, moving.dv)
    held_t, held_v = add(point(t), add(moved.t, rest.t)), add(point(v), add(moved.w, rest.w))
    every = Box(_both(held_t, mapped.all.t), _both(held_v, mapped.all.w))
    return True, _without_turns(MovingSet(t, v, moving.dt, moving.dv, slope, rest, every, moving.grazed))


@inlined_as_written
def _offset(moving, slope):
    """``v - slope t`` over a set."""
    by_t = subtract(moving.slope.vt, scale(moving.slope.tt, slope))
    by_v = subtract(moving.slope.vv, scale(moving.slope.tv, slope))
    start = subtract(point(moving.v), scale(point(moving.t), slope))
    moved = add(multiply(by_t, moving.dt), multiply(by_v, moving.dv))
    return add(add(start, moved), subtract(moving.rest.w, scale(moving.rest.t, slope)))


@inlined_as_written
def strip_of(moving):
    """The strip along one side of the parallelogram, or level, that holds a set: the narrowest of the three."""
    best = Strip(moving.all.t, moving.all.w, 0.0, moving.all.w)
    m = moving.slope
    for up_, along in ((middle(m.vt), middle(m.tt)), (middle(m.vv), middle(m.tv))):
        # A slope of few digits: single precision holds it.
        slope = float(np.float32(up_ / along)) if abs(along) * STEEPEST > abs(up_) else 0.0
        offset = _offset(moving, slope)
        if offset.high - offset.low < best.offset.high - best.offset.low:
            best = Strip(moving.all.t, moving.all.w, slope, offset)
    return best
