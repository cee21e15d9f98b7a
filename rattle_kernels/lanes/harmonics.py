"""Harmonics of the forcing in lanes: their sums over one flight, or over one contact, of every lane.

The first harmonic is part of the loops of `flight` and `contact`. Each of the others has a loop of its own, which adds
to sums over them, and `plus` takes a sum where it belongs. Without harmonics nothing of this is left in the machine
code.

A step D from the guess turns the angle of order n by 2 pi n D, at most a fortieth of a radian: `highest_order` makes
longer steps unsure. So the state at the end is Taylor's polynomial of sixth order: what it leaves out is 2e-15 of the
harmonic's own part.
"""

import math

from rattle_kernels.lanes.lane_fields import (
    COSINE,
    CUBIC,
    DURATION,
    END_PHASE,
    HALF_COSINE,
    HALF_SINE,
    LANES,
    NEAR,
    NEARLY,
    ORDER_COSINE,
    ORDER_CUBIC,
    ORDER_HALF_COSINE,
    ORDER_HALF_SINE,
    ORDER_SINE,
    PHASE,
    PHI2,
    SINE,
    SUMS,
)
from rattle_kernels.model.harmonics import TWO_PI
from rattle_kernels.numerics.jit import inlined, summed_over_tuple
from rattle_kernels.numerics.phase import part_turn
from rattle_kernels.numerics.polynomials import (
    cosine_of_half_turns,
    sine_of_half_turns,
    sine_rest_of_half_turns,
    versine_of_half_turns,
)

# Sums of a flight: the displacement by the guess, the velocity there, and its first six derivatives.
FORCED, RATE_0, RATE_1, RATE_2, RATE_3, RATE_4, RATE_5, RATE_6 = (SUMS + n * LANES for n in range(8))
# Sums of a contact: slow part and rate where it begins, their changes by the guess, second to fifth derivative there.
HERE, HERE_1, CHANGE, CHANGE_1, SLOW_2, SLOW_3, SLOW_4, SLOW_5 = (SUMS + n * LANES for n in range(8))
_SUMS = 8

# How many times as close as in the middle nodes of falls back lie at speed 0, and how many times as wide at v*.
_CROWDED = 3.0

# Further from the order before than this, the angles of an order are evaluated by polynomials: that takes as long.
_LONGEST_WAY = 6.0


@summed_over_tuple
def plus(terms, total, place):
    """Add a sum over the harmonics."""
    return total + place


@summed_over_tuple
def fall_divisor(terms, total, place):
    """What the speed of a fall back is divided by for its abscissa; the total is v*, `place` the speed.

    Under higher orders slow falls bend most, so the table's nodes crowd at speed 0.
    """
    return place + (total - place) * (1.0 / _CROWDED)


@summed_over_tuple
def fall_speed(terms, total, place):
    """Speed of a fall back at an abscissa, which is `place`; the total is v* times that."""
    return total / (place + _CROWDED * (1.0 - place))  # v* itself at 1


@summed_over_tuple
def highest_order(terms, total, place):
    """Highest order of the harmonics; the total where there are none."""
    for harmonic in terms:
        total = max(total, harmonic.order)
    return total


@summed_over_tuple
def doubt(terms, total, place):
    """How unsure a flight is whose guess was off by too much; `place` is (unsure so far, last term, duration).

    Orders beside the first bend the tables of guesses. Of the flights that are off most are near enough for Newton's
    method (NEARLY), and need no search for a bracket.
    """
    unsure, last, tau = place
    return max(unsure, NEARLY if abs(last) <= NEAR * tau else total)


@inlined
def turn(turns):
    """Sine and cosine of an angle in turns, as in `flight.turn_phases`."""
    halves = math.floor(2.0 * turns + 0.5)
    r = 2.0 * turns - halves
    sign = 1.0 - 2.0 * (halves - 2.0 * math.floor(0.5 * halves))
    return sign * sine_of_half_turns(r), sign * cosine_of_half_turns(r)


@summed_over_tuple
def plus_error(terms, total, place):
    """Add the harmonics of e and e' to those of the first, at a phase."""
    error, rate = total
    for harmonic in terms:
        s, c = turn(part_turn(harmonic.order * place + part_turn(harmonic.phase)))
        error += harmonic.amplitude * c
        rate -= TWO_PI * harmonic.order * harmonic.amplitude * s
    return error, rate


@summed_over_tuple
def _plus_bounds(terms, total, place):
    error, rate = total
    for harmonic in terms:
        error += harmonic.amplitude
        rate += TWO_PI * harmonic.order * harmonic.amplitude
    return error, rate


@inlined
def bounds_on_error(oscillator):
    """Bounds on ``|e|`` and ``|e'|``."""
    first = oscillator.eccentricity, TWO_PI * oscillator.eccentricity
    return _plus_bounds(oscillator.harmonics, first, None)


@inlined
def _forget(lanes):
    for i in range(_SUMS * LANES):
        lanes[SUMS + i] = 0.0


@inlined
def _double(lanes, first, last):
    """The angles of order 2, twice those that the first harmonic has computed."""
    for i in range(first, last):
        s, c = lanes[SINE + i], lanes[COSINE + i]
        lanes[ORDER_SINE + i], lanes[ORDER_COSINE + i] = 2.0 * s * c, c * c - s * s
        s, c = lanes[HALF_SINE + i], lanes[HALF_COSINE + i]
        double = 2.0 * s * c
        lanes[ORDER_HALF_SINE + i], lanes[ORDER_HALF_COSINE + i] = double, c * c - s * s
        # 2 h - sin 2 h, in terms that have one sign where h is small; so in `_turn_on`.
        lanes[ORDER_CUBIC + i] = 2.0 * lanes[CUBIC + i] + 4.0 * s * s * double


@inlined
def _turn_on(lanes, first, last):
    """Go on to the angles of the next order: they are those of this one and of order 1 together."""
    for i in range(first, last):
        s, c, s1, c1 = lanes[ORDER_SINE + i], lanes[ORDER_COSINE + i], lanes[SINE + i], lanes[COSINE + i]
        lanes[ORDER_SINE + i], lanes[ORDER_COSINE + i] = s * c1 + c * s1, c * c1 - s * s1
        s, c = lanes[ORDER_HALF_SINE + i], lanes[ORDER_HALF_COSINE + i]
        s1, c1 = lanes[HALF_SINE + i], lanes[HALF_COSINE + i]
        next_ = s * c1 + c * s1
        lanes[ORDER_HALF_SINE + i], lanes[ORDER_HALF_COSINE + i] = next_, c * c1 - s * s1
        lanes[ORDER_CUBIC + i] += lanes[CUBIC + i] + 4.0 * s1 * s * next_


@inlined
def _turn_to(lanes, order, first, last):
    """The angles of an order, without those before it."""
    for i in range(first, last):
        lanes[ORDER_SINE + i], lanes[ORDER_COSINE + i] = turn(part_turn(order * lanes[PHASE + i]))
        turns = order * lanes[DURATION + i]
        r = part_turn(turns)
        rest, versine = sine_rest_of_half_turns(r), versine_of_half_turns(r)
        lanes[ORDER_HALF_SINE + i], lanes[ORDER_HALF_COSINE + i] = math.pi * r + rest, 1.0 - versine
        # h - sin h for h = 2 pi n tau, in terms of one sign.
        lanes[ORDER_CUBIC + i] = TWO_PI * (turns - r) + 2.0 * (math.pi * r * versine - rest * (1.0 - versine))


@inlined
def _add(lanes, at, term, more):
    """Add to a sum, or begin it."""
    lanes[at] = (lanes[at] if more else 0.0) + term


@summed_over_tuple
def sum_over_flights(terms, total, place):
    """Evaluate the harmonics at the guessed ends of flights; `place` is (lanes, delta, first, last + 1).

    The total is not used.
    """
    lanes, damping, first, last = place
    _double(lanes, first, last)
    reached = 2.0
    for harmonic in terms:
        order, amplitude = harmonic.order, harmonic.amplitude
        if order - reached > _LONGEST_WAY:
            _turn_to(lanes, order, first, last)
            reached = order
        while reached < order:
            _turn_on(lanes, first, last)
            reached += 1.0
        rate, angle = TWO_PI * order, TWO_PI * part_turn(harmonic.phase)
        square, turn_sine, turn_cosine = rate * rate, math.sin(angle), math.cos(angle)
        more = order > terms[0].order  # the first one begins the sums
        for i in range(first, last):
            s, c, sh, ch = (
                lanes[ORDER_SINE + i], lanes[ORDER_COSINE + i], lanes[ORDER_HALF_SINE + i],
                lanes[ORDER_HALF_COSINE + i],
            )  # fmt: skip
            s0, c0 = s * turn_cosine + c * turn_sine, c * turn_cosine - s * turn_sine
            tau = lanes[DURATION + i]
            ds, dc = 2.0 * sh * (c0 * ch - s0 * sh), -2.0 * sh * (s0 * ch + c0 * sh)
            held = rate * damping * tau * tau * lanes[PHI2 + i]
            _add(lanes, FORCED + i, amplitude * (s0 * (lanes[ORDER_CUBIC + i] - held) - 2.0 * c0 * sh * sh), more)
            _add(lanes, RATE_0 + i, amplitude * (damping * dc - rate * ds), more)
            s, c = s0 + ds, c0 + dc
            p, q = amplitude * rate * (rate * c + damping * s), amplitude * square * (rate * s - damping * c)
            _add(lanes, RATE_1 + i, -p, more)
            _add(lanes, RATE_2 + i, q, more)
            _add(lanes, RATE_3 + i, square * p, more)
            _add(lanes, RATE_4 + i, -square * q, more)
            _add(lanes, RATE_5 + i, -square * square * p, more)
            _add(lanes, RATE_6 + i, square * square * q, more)
    return total


@summed_over_tuple
def plus_rate_after(terms, total, place):
    """Add the harmonics of the velocity a step after the guess; `place` is (lanes, lane, step)."""
    lanes, i, step = place
    later = lanes[RATE_4 + i] + step * (1.0 / 5.0) * (lanes[RATE_5 + i] + step * (1.0 / 6.0) * lanes[RATE_6 + i])
    later = lanes[RATE_2 + i] + step * (1.0 / 3.0) * (lanes[RATE_3 + i] + step * 0.25 * later)
    return total + lanes[RATE_0 + i] + step * (lanes[RATE_1 + i] + step * 0.5 * later)


@summed_over_tuple
def plus_acceleration_after(terms, total, place):
    """Add the harmonics of the acceleration at rest a step after the guess; `place` is (lanes, lane, step)."""
    lanes, i, step = place
    later = lanes[RATE_4 + i] + step * 0.25 * (lanes[RATE_5 + i] + step * (1.0 / 5.0) * lanes[RATE_6 + i])
    return (
        total
        + lanes[RATE_1 + i]
        + step * (lanes[RATE_2 + i] + step * 0.5 * (lanes[RATE_3 + i] + step * (1.0 / 3.0) * later))
    )


@summed_over_tuple
def sum_over_contacts(terms, total, place):
    """Evaluate the slow parts of other orders at the guessed end of every contact above; `place` is the lanes.

    Those of contacts below have the opposite sign. The total is not used.
    """
    lanes = place
    _forget(lanes)
    for slow in terms:
        order, cosine, sine = slow.order, slow.cosine, slow.sine
        rate = TWO_PI * order
        square = rate * rate
        for i in range(LANES):
            s0, c0 = turn(part_turn(order * lanes[END_PHASE + i]))
            r = part_turn(order * lanes[DURATION + i])
            sh, ch = sine_of_half_turns(r), cosine_of_half_turns(r)
            here, quarter = cosine * c0 + sine * s0, sine * c0 - cosine * s0
            change = 2.0 * sh * (quarter * ch - here * sh)
            rate_change = -rate * 2.0 * sh * (here * ch + quarter * sh)
            depth, slope = square * (here + change), square * (rate * quarter + rate_change)
            lanes[HERE + i] += here
            lanes[HERE_1 + i] += rate * quarter
            lanes[CHANGE + i] += change
            lanes[CHANGE_1 + i] += rate_change
            lanes[SLOW_2 + i] -= depth
            lanes[SLOW_3 + i] -= slope
            lanes[SLOW_4 + i] += square * depth
            lanes[SLOW_5 + i] += square * slope
    return total
