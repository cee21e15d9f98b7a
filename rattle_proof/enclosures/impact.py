"""Enclosures of the impact map P of the impacting model: images of all departures of a box, and DP over it.

The box is one of the three: all of it falls back to +beta (case a), all of it meets -beta (case b), or the grazing
curve may run through it. In the third case P is still continuous. Its image is held by the hull of both branches: those
that clear -beta fly on as if it were not there; those that meet it do so slowly, and late (theorem 3).
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.flights import LOWER, UPPER, fly_over, next_contact
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_proof.enclosures.flight import Arrivals, Box, Matrix, arrive, no_arrivals, spread
from rattle_proof.enclosures.interval import (
    Interval,
    add,
    hull,
    middle,
    multiply,
    negative,
    point,
    root,
    scale,
    subtract,
    up,
)
from rattle_proof.enclosures.machine import Machine, acceleration, error_at
from rattle_proof.enclosures.turning_point import turning_points

PROVEN = 0
STRADDLES = 1
LOST = 2


class Image(NamedTuple):
    """Image of a box under P: of its centre, the slope over it, what parameters add, and of all, as `Arrivals` has it.

    ``state`` is PROVEN, STRADDLES (only ``all`` means something) or LOST (nothing does). Velocities are speeds.
    """

    state: int
    centre: Box
    slope: Matrix
    drift: Box
    all: Box


@inlined_as_written
def product(a, b):
    """Product of two matrices."""
    return Matrix(
        add(multiply(a.tt, b.tt), multiply(a.tv, b.vt)),
        add(multiply(a.tt, b.tv), multiply(a.tv, b.vv)),
        add(multiply(a.vt, b.tt), multiply(a.vv, b.vt)),
        add(multiply(a.vt, b.tv), multiply(a.vv, b.vv)),
    )


@inlined_as_written
def _impact(machine, arrivals):
    """Departures after an impact with +beta or -beta: the velocity changes its sign and shrinks."""
    kept, one = negative(machine.restitution), negative(machine.centre.restitution)
    slope, drift = arrivals.slope, arrivals.drift
    turned = Matrix(slope.tt, slope.tv, multiply(kept, slope.vt), multiply(kept, slope.vv))
    centre = Box(arrivals.centre.t, multiply(one, arrivals.centre.w))
    if not machine.exact:
        less = multiply(subtract(kept, one), arrivals.all.w)
        drift = Box(drift.t, add(multiply(kept, drift.w), less))
    return Arrivals(True, centre, turned, drift, Box(arrivals.all.t, multiply(kept, arrivals.all.w)))


@inlined_as_written
def by_speeds(slope):
    """The slope in (time, speed) of one in (time, velocity), both departures from +beta."""
    return Matrix(slope.tt, negative(slope.tv), negative(slope.vt), slope.vv)


@inlined_as_written
def downwards(box):
    """Departures from +beta: their velocities from their speeds, or back."""
    return Box(box.t, negative(box.w))


@inlined_as_written
def _lost():
    arrivals = no_arrivals()
    return Image(LOST, arrivals.centre, arrivals.slope, arrivals.drift, arrivals.all)


@inlined_as_written
def _upwards(arrivals, slope, drift):
    """The image whose last impact, with +beta, has these departures."""
    return Image(PROVEN, downwards(arrivals.centre), by_speeds(slope), downwards(drift), downwards(arrivals.all))


@inlined_as_written
def _return(machine, centre, box, guess):
    """Case (a), -beta kept clear of or not there."""
    arrivals = arrive(machine, centre, box, 0.0, guess)
    if not (arrivals.found and arrivals.all.w.low > 0.0):
        return _lost()
    upper = _impact(machine, arrivals)
    return _upwards(upper, upper.slope, upper.drift)


@inlined_as_written
def _rise(machine, oscillator, centre, box):
    """From -beta to +beta; velocities from -beta are positive."""
    speed = middle(centre.w)
    guess = next_contact(oscillator, LOWER, middle(centre.t), speed, 1.0)
    # The kernel reduces the phase at which it starts.
    arrivals = arrive(machine, centre, box, 2.0, middle(centre.t) + guess.duration)
    if not (arrivals.found and arrivals.all.w.low > 0.0):
        return no_arrivals()
    return arrivals


@inlined_as_written
def _by_way_of_lower(machine, oscillator, centre, box, guess):
    """Case (b)."""
    fall = arrive(machine, centre, box, -2.0, guess)
    # A root of y + 2 beta on the way down is the first.
    if not (fall.found and fall.all.w.high < 0.0):
        return _lost()
    lower = _impact(machine, fall)
    rise = _rise(machine, oscillator, lower.centre, lower.all)
    if not rise.found:
        return _lost()
    upper = _impact(machine, rise)
    carried = spread(upper.slope, lower.drift.t, lower.drift.w)
    drift = Box(add(carried.t, upper.drift.t), add(carried.w, upper.drift.w))
    return _upwards(upper, product(upper.slope, lower.slope), drift)


@inlined_as_written
def _slow_impacts(machine, box, turn):
    """Impacts with -beta of those flights of a box that meet it: speeds up to one that the least height allows.

    From the impact on until it turned, a flight without -beta would fall with an acceleration of at least a's least
    value there, and fall no further than 2 beta less the least height. So it turns soon, and the impact was slow.
    """
    depth = subtract(negative(scale(machine.half_backlash, 2.0)), point(turn.height.low)).high
    if depth < 0.0:
        depth = 0.0
    times, before, most = turn.t, 0.0, 0.0
    least = machine.least_acceleration
    for _ in range(2):
        # Until it turns the speed falls, so that y'' = a - delta y' is at least a.
        before = root(Interval(0.0, up(2.0 * depth / least))).high
        times = Interval(max(subtract(turn.t, point(before)).low, box.t.low), turn.t.high)
        felt = acceleration(machine, error_at(machine, times))
        least, most = max(felt.low, least), felt.high
    # No flight is faster than when it left.
    fastest = up(before * up(most + up(machine.damping.high * -box.w.low)))
    return Box(times, multiply(machine.restitution, Interval(0.0, fastest)))


@inlined_as_written
def _straddling(machine, oscillator, centre, box, turn, guess):
    """Both branches of a box through which the grazing curve may run."""
    over = _return(machine, centre, box, guess)
    if over.state == LOST:
        return over
    impacts = _slow_impacts(machine, box, turn)
    centre_ = Box(point(middle(impacts.t)), point(middle(impacts.w)))
    rise = _rise(machine, oscillator, centre_, impacts)
    if not rise.found:
        return _lost()
    below = downwards(_impact(machine, rise).all)
    both = Box(hull(over.all.t, below.t), hull(over.all.w, below.w))
    return Image(STRADDLES, over.centre, over.slope, over.drift, both)


@inlined_as_written
def _clears_lower(machine, centre, box, duration):
    """Whether all of a box clears -beta, by its turning points; and those."""
    turn = turning_points(machine, centre, box, 0.5 * duration)
    return turn.found and turn.height.low > -scale(machine.half_backlash, 2.0).low, turn


@inlined_as_written
def image(machine, oscillator, centre, box):
    """Enclose the image of a box of departures from +beta under P.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.
    centre, box : Box
        Times and speeds; the centre lies within the box, and is a point or small.

    Returns
    -------
    Image
        Times are not reduced.
    """
    start, speeds = downwards(centre), downwards(box)
    t, w = middle(start.t), middle(start.w)
    if not box.w.low > 0.0:
        return _lost()
    contact = next_contact(oscillator, UPPER, t, w, 1.0)
    if contact.wall == LOWER:
        mapped = _by_way_of_lower(machine, oscillator, start, speeds, t + contact.duration)
        if mapped.state == PROVEN:
            return mapped
        contact = fly_over(oscillator, t, w)
        _, turn = _clears_lower(machine, start, speeds, contact.duration)
    else:
        if box.w.high <= machine.safe_speed:
            return _return(machine, start, speeds, t + contact.duration)
        clears, turn = _clears_lower(machine, start, speeds, contact.duration)
        if clears:
            return _return(machine, start, speeds, t + contact.duration)
    if not turn.found:
        return _lost()
    return _straddling(machine, oscillator, start, speeds, turn, t + contact.duration)


class Images(NamedTuple):
    """Enclosures of the images of many boxes.

    ``states``, shape (boxes,), are PROVEN, STRADDLES or LOST. ``hulls``, shape (boxes, 4), are least and greatest time,
    least and greatest speed, not numbers where LOST. ``slopes``, shape (boxes, 2, 2, 2), are the ends of the elements
    of DP over the box, by (time, speed) of the image and of the departure, not numbers where not PROVEN.
    """

    states: np.ndarray
    hulls: np.ndarray
    slopes: np.ndarray


@kernel_as_written
def _enclose_all(machine, oscillator, boxes, states, hulls, slopes):
    for k in range(boxes.shape[0]):
        box = Box(Interval(boxes[k, 0], boxes[k, 1]), Interval(boxes[k, 2], boxes[k, 3]))
        mapped = image(machine, oscillator, Box(point(middle(box.t)), point(middle(box.w))), box)
        states[k] = mapped.state
        if mapped.state != LOST:
            hulls[k, 0], hulls[k, 1] = mapped.all.t
            hulls[k, 2], hulls[k, 3] = mapped.all.w
        if mapped.state == PROVEN:
            slopes[k, 0, 0, 0], slopes[k, 0, 0, 1] = mapped.slope.tt
            slopes[k, 0, 1, 0], slopes[k, 0, 1, 1] = mapped.slope.tv
            slopes[k, 1, 0, 0], slopes[k, 1, 0, 1] = mapped.slope.vt
            slopes[k, 1, 1, 0], slopes[k, 1, 1, 1] = mapped.slope.vv


def enclose_images(machine: Machine, oscillator: Oscillator, boxes: np.ndarray) -> Images:
    """Enclose P and DP over boxes of departures.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.
    boxes : ndarray, shape (boxes, 4)
        Least and greatest time, least and greatest speed.

    Returns
    -------
    Images
        Times are not reduced: whole periods after the departure's.
    """
    states = np.empty(len(boxes), np.uint8)
    hulls, slopes = np.full((len(boxes), 4), np.nan), np.full((len(boxes), 2, 2, 2), np.nan)
    _enclose_all(machine, oscillator, np.ascontiguousarray(boxes, np.float64), states, hulls, slopes)
    return Images(states, hulls, slopes)
