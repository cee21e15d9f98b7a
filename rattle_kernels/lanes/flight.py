"""One flight of every lane at once, in loops that LLVM turns into vector code.

The lanes are 64 independent trajectories whose numbers lie in one flat buffer, field after field. The sign of a lane's
velocity gives the wall that it leaves (negative from +beta), so cases (a) and (b) of Sec. 2 are one code path with a
selected target. There are three passes:

1. `guess_durations` classifies each flight by the table of v*(t) and looks up a first guess;
2. `refine_durations` evaluates the flight once and takes one step of fifth order. Sine, cosine and phi2 are
   polynomials: no library call, no branch;
3. `fly_carefully` flies again the lanes that are not sure: too close to the grazing curve, or too large a step.

The formulas are those of `model.flight`.
"""

import math

import numpy as np

from rattle_kernels.impact_map.flights import LOWER, UPPER, FlightEnd, next_contact
from rattle_kernels.lanes.harmonics import (
    FORCED,
    RATE_0,
    RATE_1,
    RATE_2,
    RATE_3,
    doubt,
    fall_divisor,
    highest_order,
    plus,
    plus_acceleration_after,
    plus_rate_after,
    sum_over_flights,
)
from rattle_kernels.lanes.lane_fields import (
    COLUMN_PART,
    COSINE,
    COSINE_CHANGE,
    CUBIC,
    DROPS,
    DURATION,
    END_ACCELERATION,
    END_PHASE,
    END_VELOCITY,
    GRAZING,
    HALF_COSINE,
    HALF_SINE,
    HIGH_PAIR,
    LANES,
    LAST_TERM,
    LOW_PAIR,
    MISS,
    NEARLY,
    PHASE,
    PHI2,
    RATE,
    ROW_PART,
    SINE,
    SINE_CHANGE,
    TARGET,
    UNSURE,
    VELOCITY,
    count_set,
)
from rattle_kernels.lanes.tables import ABSCISSAE, BLOCK, DROP, FALL_BACK, GRAZES, PHASES, RISE, ROW
from rattle_kernels.model.flight import FOUR_PI, TWO_PI, displacement_rate, start_flight, velocity_after
from rattle_kernels.model.harmonics import add_rest_acceleration
from rattle_kernels.numerics.jit import always_inlined, inlined, inlined_in_lanes
from rattle_kernels.numerics.phase import part_turn, wrap
from rattle_kernels.numerics.polynomials import (
    cosine_of_half_turns,
    second_phi_of_part,
    sine_of_half_turns,
    sine_rest_of_half_turns,
    versine_of_half_turns,
)

_LARGEST_STEP = 4e-3
_NO_SPEED = 1e-300
_NEWTON_STEPS = 5
_ROUNDING = 2e-15
_NOT_FOUND = FlightEnd(UPPER, math.nan, math.nan, math.nan, False)


@inlined_in_lanes
def fifth_order_step(q, bend, jerk, snap):
    """Root of ``q = D + bend D^2/2 + jerk D^3/6 + snap D^4/24`` by reversion of the series, and its last term."""
    b2, b3, b4 = 0.5 * bend, jerk * (1.0 / 6.0), snap * (1.0 / 24.0)
    square = b2 * b2
    last = (b2 * (5.0 * b3 - 5.0 * square) - b4) * q * q * q
    return q * (1.0 + q * (-b2 + q * (2.0 * square - b3)) + last), last * q


@always_inlined
def turn_phases(lanes, field):
    """Sine and cosine of the phase that every lane has in a field; the reduction to a quarter turn is exact."""
    for i in range(LANES):
        phase = lanes[field + i]
        # NumPy's: that of math goes through an integer.
        halves = np.floor(2.0 * phase + 0.5)
        r = 2.0 * phase - halves
        odd = halves - 2.0 * np.floor(0.5 * halves)
        sign = 1.0 - 2.0 * odd
        lanes[SINE + i] = sign * sine_of_half_turns(r)
        lanes[COSINE + i] = sign * cosine_of_half_turns(r)


@always_inlined
def _graze_speeds(lanes, corners, graze_speed):
    """v* at every lane's phase, interpolated in its table."""
    for i in range(LANES):
        place = lanes[PHASE + i] * GRAZES
        m = min(np.floor(place), GRAZES - 1.0)
        lanes[ROW_PART + i] = place - m
        corners[i] = int(m)
    for i in range(LANES):
        at = corners[i] & 0xFFFF
        lanes[LOW_PAIR + 2 * i], lanes[LOW_PAIR + 2 * i + 1] = graze_speed[at], graze_speed[at + 1]
    for i in range(LANES):
        low = lanes[LOW_PAIR + 2 * i]
        lanes[GRAZING + i] = low + lanes[ROW_PART + i] * (lanes[LOW_PAIR + 2 * i + 1] - low)


@always_inlined
def _classify(lanes, corners, tables, two_beta, harmonics):
    """Kind of each flight, its target, and the node of its guess in the tables; selects only, no branch."""
    for i in range(LANES):
        velocity = lanes[VELOCITY + i]
        speed, graze = abs(velocity), lanes[GRAZING + i]
        rises = velocity > 0.0
        drops = (speed > graze) & (not rises)
        falls = not (rises | drops)
        divisor = speed + tables.largest_grazing_speed if rises else speed
        inverse = 1.0 / (fall_divisor(harmonics, graze, speed) if falls else divisor)
        root = math.sqrt(max(1.0 - graze * inverse, 0.0))
        abscissa = root if drops else speed * inverse
        lanes[DURATION + i] = speed if falls else inverse
        target = -two_beta if drops else 0.0
        lanes[TARGET + i] = two_beta if rises else target
        lanes[DROPS + i] = 1.0 if drops else 0.0
        close = (abs(speed - graze) <= tables.grazing_error) & (not rises)
        lanes[UNSURE + i] = 1.0 if close else 0.0
        row = lanes[PHASE + i] * PHASES
        column = min(abscissa, 1.0) * ABSCISSAE
        m, n = min(np.floor(row), PHASES - 1.0), min(np.floor(column), ABSCISSAE - 1.0)
        block = DROP * BLOCK if drops else FALL_BACK * BLOCK
        block = RISE * BLOCK if rises else block
        lanes[ROW_PART + i], lanes[COLUMN_PART + i] = row - m, column - n
        corners[i] = int(block + m * ROW + n)


@always_inlined
def look_up(lanes, corners, guess):
    """Interpolate the guesses bilinearly. The loads dominate the cost, so they have a loop of their own."""
    for i in range(LANES):
        at = corners[i] & 0xFFFFFF  # shows the compiler that the index is not negative
        lanes[LOW_PAIR + 2 * i], lanes[LOW_PAIR + 2 * i + 1] = guess[at], guess[at + 1]
        lanes[HIGH_PAIR + 2 * i], lanes[HIGH_PAIR + 2 * i + 1] = guess[at + ROW], guess[at + ROW + 1]
    for i in range(LANES):
        f, g = lanes[ROW_PART + i], lanes[COLUMN_PART + i]
        low, high = lanes[LOW_PAIR + 2 * i], lanes[HIGH_PAIR + 2 * i]
        low += g * (lanes[LOW_PAIR + 2 * i + 1] - low)
        high += g * (lanes[HIGH_PAIR + 2 * i + 1] - high)
        lanes[DURATION + i] *= low + f * (high - low)


@always_inlined
def guess_durations(lanes, corners, oscillator, tables):
    """First pass: kind of flight, target and first guess."""
    turn_phases(lanes, PHASE)
    _graze_speeds(lanes, corners, tables.graze_speed)
    _classify(lanes, corners, tables, 2.0 * oscillator.half_backlash, oscillator.harmonics)
    look_up(lanes, corners, tables.guess)


@always_inlined
def _expand(lanes, d, first, last):
    """Polynomials in the guessed duration of every flight, beside those of its phase."""
    for i in range(first, last):
        tau = lanes[DURATION + i]
        r = part_turn(tau)
        rest, versine = sine_rest_of_half_turns(r), versine_of_half_turns(r)
        lanes[HALF_SINE + i] = math.pi * r + rest
        lanes[HALF_COSINE + i] = 1.0 - versine
        # h - sin h for h = 2 pi tau, in terms of one sign: short flights keep their digits.
        lanes[CUBIC + i] = TWO_PI * (tau - r) + 2.0 * (math.pi * r * versine - rest * (1.0 - versine))
        lanes[PHI2 + i] = second_phi_of_part(d * tau)


@always_inlined
def _close(lanes, d, e, harmonics, first, last):
    """Distance by which the guess misses the target, and the velocity there."""
    for i in range(first, last):
        tau, w, s0, c0 = lanes[DURATION + i], lanes[VELOCITY + i], lanes[SINE + i], lanes[COSINE + i]
        x = d * tau
        p2, sh, ch = lanes[PHI2 + i], lanes[HALF_SINE + i], lanes[HALF_COSINE + i]
        ds, dc = 2.0 * sh * (c0 * ch - s0 * sh), -2.0 * sh * (s0 * ch + c0 * sh)
        forced = s0 * lanes[CUBIC + i] - 2.0 * c0 * sh * sh
        y = tau * (w * (1.0 - x * p2) + x * (FOUR_PI - TWO_PI * e * s0) * p2) + e * forced
        y = plus(harmonics, y, lanes[FORCED + i])
        lanes[MISS + i] = lanes[TARGET + i] - y
        rate = w - d * y + FOUR_PI * x + e * (d * dc - TWO_PI * ds)
        lanes[RATE + i] = plus(harmonics, rate, lanes[RATE_0 + i])
        lanes[SINE_CHANGE + i], lanes[COSINE_CHANGE + i] = ds, dc


@always_inlined
def evaluate(lanes, oscillator, first, last):
    """Distance by which lanes miss their target after the guessed duration, and the velocity there.

    Three loops: in a single one, chains are so long that the processor waits for them.
    """
    d, harmonics = oscillator.damping, oscillator.harmonics
    _expand(lanes, d, first, last)
    sum_over_flights(harmonics, 0.0, (lanes, d, first, last))
    _close(lanes, d, oscillator.eccentricity, harmonics, first, last)


@always_inlined
def refine_durations(lanes, oscillator):
    """Second pass: one evaluation of every flight, one step of fifth order, and the state at its end.

    Returns
    -------
    int
        Number of lanes that are not sure.
    """
    d, e, harmonics, restitution = (
        oscillator.damping, oscillator.eccentricity, oscillator.harmonics, oscillator.restitution,
    )  # fmt: skip
    evaluate(lanes, oscillator, 0, LANES)
    highest = highest_order(harmonics, 1.0, None)
    for i in range(LANES):
        tau, s0, c0 = lanes[DURATION + i], lanes[SINE + i], lanes[COSINE + i]
        x, y1 = d * tau, lanes[RATE + i]
        ds, dc = lanes[SINE_CHANGE + i], lanes[COSINE_CHANGE + i]
        s, c = s0 + ds, c0 + dc
        inverse = 1.0 / y1
        y2 = plus(harmonics, FOUR_PI * d - d * y1 - TWO_PI * e * (TWO_PI * c + d * s), lanes[RATE_1 + i])
        y3 = plus(harmonics, TWO_PI * TWO_PI * e * (TWO_PI * s - d * c) - d * y2, lanes[RATE_2 + i])
        y4 = plus(harmonics, TWO_PI * TWO_PI * TWO_PI * e * (TWO_PI * c + d * s) - d * y3, lanes[RATE_3 + i])
        step_, last = fifth_order_step(lanes[MISS + i] * inverse, y2 * inverse, y3 * inverse, y4 * inverse)
        # Three selects instead of one condition, whose short circuit would be a branch. NaN ends up unsure.
        unsure = lanes[UNSURE + i]
        doubtful = doubt(harmonics, 1.0, (unsure, last, tau))
        unsure = unsure if abs(last) <= LAST_TERM * tau else doubtful
        unsure = unsure if abs(step_) * highest <= _LARGEST_STEP else doubtful
        lanes[UNSURE + i] = unsure if x <= 1.0 else 1.0
        lanes[MISS + i] = step_
    # A loop of its own: in one, so few iterations fit the processor's window that it waits for their chain.
    for i in range(LANES):
        tau, w, s0, c0 = lanes[DURATION + i], lanes[VELOCITY + i], lanes[SINE + i], lanes[COSINE + i]
        target, step_ = lanes[TARGET + i], lanes[MISS + i]
        ds, dc = lanes[SINE_CHANGE + i], lanes[COSINE_CHANGE + i]
        s, c = s0 + ds, c0 + dc
        # The step turns the phase by a small angle; its sine and cosine to rounding for |step| <= 4e-3.
        angle = TWO_PI * step_
        z = angle * angle
        turn = angle * (1.0 - z * (1.0 / 6.0) * (1.0 - z * (1.0 / 20.0)))
        versine = 0.5 * z * (1.0 - z * (1.0 / 12.0) * (1.0 - z * (1.0 / 30.0)))
        ds, dc = ds + (c * turn - s * versine), dc - (s * turn + c * versine)
        tau += step_
        phase = lanes[PHASE + i] + tau
        lanes[DURATION + i] = tau
        lanes[END_PHASE + i] = wrap(phase)
        velocity = w + d * (FOUR_PI * tau - target) + e * (d * dc - TWO_PI * ds)
        acceleration = FOUR_PI * d - TWO_PI * e * (TWO_PI * (c0 + dc) + d * (s0 + ds))
        # An elastic impact is the product with 1, which changes no bit.
        lanes[END_VELOCITY + i] = -restitution * plus_rate_after(harmonics, velocity, (lanes, i, step_))
        lanes[END_ACCELERATION + i] = plus_acceleration_after(harmonics, acceleration, (lanes, i, step_))
    return count_set(lanes, UNSURE)


@inlined
def _polished(lanes, i, oscillator):
    """End of a flight that is nearly known, by Newton's method."""
    flight = start_flight(oscillator, lanes[PHASE + i], lanes[VELOCITY + i])
    tau, target, found = lanes[DURATION + i], lanes[TARGET + i], False
    for _ in range(_NEWTON_STEPS):
        displacement = tau * displacement_rate(flight, tau)
        change = (target - displacement) / velocity_after(flight, tau, displacement)
        tau += change
        found = abs(change) <= _ROUNDING * tau
        if found:
            break
    wall = LOWER if target < 0.0 else UPPER
    return FlightEnd(wall, lanes[PHASE + i] + tau, tau, velocity_after(flight, tau, target), found)


@inlined
def fly_carefully(lanes, oscillator):
    """Third pass: the lanes that are not sure, by the scalar path; the end is NaN where no root was found."""
    for i in range(LANES):
        if lanes[UNSURE + i] == 0.0:
            continue
        velocity = lanes[VELOCITY + i]
        end = _polished(lanes, i, oscillator) if lanes[UNSURE + i] == NEARLY else _NOT_FOUND
        if not end.found:
            end = next_contact(oscillator, LOWER if velocity > 0.0 else UPPER, lanes[PHASE + i], velocity, 1.0)
        phase = wrap(end.phase)
        lanes[DURATION + i] = end.duration
        lanes[END_PHASE + i] = phase if end.found else math.nan
        # The sign gives the wall that is left, even after an exact graze.
        leaves = -oscillator.restitution * end.velocity
        lanes[END_VELOCITY + i] = max(leaves, _NO_SPEED) if end.wall == LOWER else leaves
        lanes[DROPS + i] = 1.0 if end.wall == LOWER else 0.0
        angle = TWO_PI * phase
        forcing = TWO_PI * math.cos(angle) + oscillator.damping * math.sin(angle)
        first = FOUR_PI * oscillator.damping - TWO_PI * oscillator.eccentricity * forcing
        acceleration = add_rest_acceleration(oscillator.harmonics, first, (oscillator.damping, phase))
        lanes[END_ACCELERATION + i] = acceleration
