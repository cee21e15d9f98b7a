"""How low flights from +beta fall: their turning points, for all departures of a box.

Where y' = 0 in freeplay, y'' = a(s) > 0: every turning point is a minimum, and none comes near being double. With the
departure its time changes by ``(a(t) - delta w) D/a(s)`` and ``-D/a(s)``, its height by ``-(w D + a(t) E)`` and ``E``.
"""

import math
from typing import NamedTuple

from rattle_kernels.numerics.jit import inlined_as_written
from rattle_proof.enclosures.flight import displacement, fall_factors, leave
from rattle_proof.enclosures.interval import (
    Interval,
    add,
    around,
    divide,
    lies_within,
    middle,
    multiply,
    negative,
    point,
    reach,
    subtract,
    up,
)
from rattle_proof.enclosures.machine import FOUR_PI, acceleration, error_at

_STEPS = 12
_SETTLED = 1e-12
_TRIES = 6
_WIDER = 1.3


class TurningPoints(NamedTuple):
    """Turning points of a box: their times and their heights, counted from the wall left."""

    found: bool
    t: Interval
    height: Interval


@inlined_as_written
def _rise(machine, departure, s):
    """Y' at all times of s, and a there."""
    _, left = fall_factors(machine, subtract(s, departure.t))
    error = error_at(machine, s)
    return add(add(FOUR_PI, error.rate), multiply(departure.lag, left)), acceleration(machine, error)


@inlined_as_written
def _guess(machine, departure, duration):
    """Time at which the centre turns, about."""
    s = departure.t.low + duration
    for _ in range(_STEPS):
        velocity, felt = _rise(machine, departure, point(s))
        step = middle(velocity) / max(middle(felt) - middle(machine.damping) * middle(velocity), 1e-300)
        s -= step
        if abs(step) < _SETTLED:
            break
    return s


@inlined_as_written
def _slopes(machine, departure, s):
    """Slopes of the turning time, and of its height, by time and velocity of the departure."""
    reached, left = fall_factors(machine, subtract(s, departure.t))
    felt = acceleration(machine, error_at(machine, s))
    pushed = subtract(departure.felt, multiply(machine.damping, departure.w))
    by_t, by_w = divide(multiply(pushed, left), felt), divide(negative(left), felt)
    lowered = add(multiply(departure.w, left), multiply(departure.felt, reached))
    return by_t, by_w, negative(lowered), reached


@inlined_as_written
def turning_points(machine, centre, box, duration):
    """Enclose the turning points of all flights of a box.

    Parameters
    ----------
    machine : Machine
    centre, box : Box
        As `flight.arrive` has them.
    duration : float
        Time from departure to the turning point, about. Nothing rests on it.

    Returns
    -------
    TurningPoints
    """
    start, wide = leave(machine, centre.t, centre.w), leave(machine, box.t, box.w)
    guess = _guess(machine, start, duration)
    nothing = Interval(math.nan, math.nan)
    velocity, _ = _rise(machine, start, point(guess))
    # On the way from the guess to the root |y'| is at most what it is at the guess, and y'' = a(s) - delta y'.
    near = around(guess, 1e-9)
    for _ in range(2):
        along, felt = _rise(machine, start, near)
        turn = subtract(point(guess), divide(velocity, subtract(felt, multiply(machine.damping, along))))
        if lies_within(turn, near):
            break
        near = around(guess, 2.0 * reach(subtract(turn, point(guess))))
    if not (lies_within(turn, near) and near.low > centre.t.high):
        return TurningPoints(False, nothing, nothing)
    dt, dw = subtract(box.t, centre.t), subtract(box.w, centre.w)
    by_t, by_w, _, _ = _slopes(machine, start, turn)
    within = add(multiply(by_t, dt), multiply(by_w, dw))
    for _ in range(_TRIES):
        sought = add(turn, around(0.0, up(_WIDER * reach(within)) + 1e-12))
        by_t, by_w, down_t, down_w = _slopes(machine, wide, sought)
        within = add(multiply(by_t, dt), multiply(by_w, dw))
        times = add(turn, within)
        if lies_within(times, sought):
            change = add(multiply(down_t, dt), multiply(down_w, dw))
            height = add(displacement(machine, start, turn), change)
            # No number where the box is so wide that some of it departs after others turned: then nothing is known.
            return TurningPoints(height.low <= height.high, times, height)
    return TurningPoints(False, nothing, nothing)
