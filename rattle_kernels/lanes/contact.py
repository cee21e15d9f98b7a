"""One contact of every lane at once, after the flight that ended on a wall (piecewise linear model).

Every flight ends on a wall, and one contact follows: so a pass of the lanes is a flight and a contact. The contact
starts from the flight's end and replaces it with its own end. The passes are those of `flight`: a first guess from a
table, one evaluation, one step of fifth order, and the careful path for lanes that are not sure. A contact whose
number of swings is not certain is never sure: its guess in the table is NaN.

The formulas are those of `model.contact`. The sign of the velocity after an elastic impact gives the wall.
"""

import math

import numpy as np

from rattle_kernels.impact_map.flights import LOWER, UPPER
from rattle_kernels.lanes.flight import fifth_order_step, look_up, turn_phases
from rattle_kernels.lanes.harmonics import (
    CHANGE,
    CHANGE_1,
    HERE,
    HERE_1,
    SLOW_2,
    SLOW_3,
    SLOW_4,
    SLOW_5,
    plus,
    sum_over_contacts,
)
from rattle_kernels.lanes.lane_fields import (
    COLUMN_PART,
    COSINE,
    DURATION,
    END_ACCELERATION,
    END_PHASE,
    END_VELOCITY,
    HALF_COSINE,
    HALF_SINE,
    HIGH_PAIR,
    LANES,
    LAST_TERM,
    LOW_PAIR,
    MISS,
    NEAR,
    NEARLY,
    PHI2,
    RATE,
    RING_COSINE,
    RING_SINE,
    ROW_PART,
    SINE,
    UNSURE,
    count_set,
)
from rattle_kernels.lanes.tables import ABSCISSAE, BLOCK, CONTACT_ABOVE, CONTACT_BELOW, ENDLESS, PHASES, ROW
from rattle_kernels.model.contact import enter_contact
from rattle_kernels.model.contact_end import Contact, end_near, follow_contact
from rattle_kernels.model.flight import TWO_PI, rest_acceleration
from rattle_kernels.model.outcome import OUTCOME_NOT_CONVERGED, OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import always_inlined, inlined
from rattle_kernels.numerics.phase import part_turn, wrap
from rattle_kernels.numerics.polynomials import cosine_of_half_turns, second_phi_of_part, sine_of_half_turns

# The speed at the end is Taylor's polynomial of x' to fourth order, exact to 3e-16 for steps this long.
_LARGEST_TURN = 2e-3
# Derivatives at the guess. They lie where the nodes of the guess were, which are not read again.
_SECOND, _THIRD = LOW_PAIR, LOW_PAIR + LANES
_FOURTH, _FIFTH = HIGH_PAIR, HIGH_PAIR + LANES
_NOT_FOUND = Contact(math.nan, math.nan, OUTCOME_NOT_CONVERGED)


@always_inlined
def guess_contacts(lanes, corners, tables):
    """First pass: wall and first guess of every contact."""
    turn_phases(lanes, END_PHASE)
    for i in range(LANES):
        velocity = lanes[END_VELOCITY + i]
        speed, below = abs(velocity), velocity > 0.0
        abscissa = speed / (speed + tables.contact_speed)
        lanes[DURATION + i] = abscissa if below else 1.0
        row, column = lanes[END_PHASE + i] * PHASES, abscissa * ABSCISSAE
        m, n = min(np.floor(row), PHASES - 1.0), min(np.floor(column), ABSCISSAE - 1.0)
        m, n = (m if m >= 0.0 else 0.0), (n if n >= 0.0 else 0.0)  # NaN: a flight whose end was not found
        block = CONTACT_BELOW * BLOCK if below else CONTACT_ABOVE * BLOCK
        lanes[ROW_PART + i], lanes[COLUMN_PART + i] = row - m, column - n
        corners[i] = int(block + m * ROW + n)
    look_up(lanes, corners, tables.contact)


@always_inlined
def refine_contacts(lanes, permanent_after, slow_part):
    """Second pass: one evaluation of every contact, one step of fifth order, and the state at its end.

    Returns
    -------
    int
        Number of lanes that are not sure.
    """
    square, frequency, mean_above, cosine_above, sine_above, damping, harmonics = slow_part
    sum_over_contacts(harmonics, 0.0, lanes)
    turns = frequency / TWO_PI
    for i in range(LANES):
        tau = lanes[DURATION + i]
        r = part_turn(tau)
        lanes[HALF_SINE + i] = sine_of_half_turns(r)
        lanes[HALF_COSINE + i] = cosine_of_half_turns(r)
        # Only products of two of these are used, so a half turn more or less does not matter.
        ring = part_turn(turns * tau)
        lanes[RING_SINE + i] = sine_of_half_turns(ring)
        lanes[RING_COSINE + i] = cosine_of_half_turns(ring)
        lanes[PHI2 + i] = second_phi_of_part(0.5 * damping * tau)
    for i in range(LANES):
        tau, velocity = lanes[DURATION + i], lanes[END_VELOCITY + i]
        speed, side = abs(velocity), (-1.0 if velocity > 0.0 else 1.0)
        s0, c0 = lanes[SINE + i], lanes[COSINE + i]
        sh, ch, rs, rc = lanes[HALF_SINE + i], lanes[HALF_COSINE + i], lanes[RING_SINE + i], lanes[RING_COSINE + i]
        here = side * (cosine_above * c0 + sine_above * s0)
        quarter = side * (sine_above * c0 - cosine_above * s0)
        mean = side * mean_above
        change = 2.0 * sh * (quarter * ch - here * sh)
        rate_change = -TWO_PI * 2.0 * sh * (here * ch + quarter * sh)
        own2, own3 = -TWO_PI * TWO_PI * (here + change), -TWO_PI * TWO_PI * (TWO_PI * quarter + rate_change)
        slow4, slow5 = -TWO_PI * TWO_PI * own2, -TWO_PI * TWO_PI * own3
        slow2 = plus(harmonics, own2, side * lanes[SLOW_2 + i])
        slow3 = plus(harmonics, own3, side * lanes[SLOW_3 + i])
        slow4 = plus(harmonics, slow4, side * lanes[SLOW_4 + i])
        slow5 = plus(harmonics, slow5, side * lanes[SLOW_5 + i])
        change = plus(harmonics, change, side * lanes[CHANGE + i])
        rate_change = plus(harmonics, rate_change, side * lanes[CHANGE_1 + i])
        here = plus(harmonics, here, side * lanes[HERE + i])
        rate_here = plus(harmonics, TWO_PI * quarter, side * lanes[HERE_1 + i])
        fading = 0.5 * damping * tau
        lost = fading * (1.0 - fading * lanes[PHI2 + i])
        left = 1.0 - lost
        pulse = 2.0 * left * rs * rc / frequency
        lag = lost + 2.0 * left * rs * rs
        settled, pulse_drop = lag - 0.5 * damping * pulse, lag + 0.5 * damping * pulse
        level = mean + here
        x = speed * pulse + level * settled + (change - rate_here * pulse)
        x1 = speed * (1.0 - pulse_drop) + level * square * pulse + rate_change + rate_here * pulse_drop
        slow, slow1 = here + change, rate_here + rate_change
        x2 = square * (mean + slow - x) + damping * (slow1 - x1) + slow2
        x3 = square * (slow1 - x1) + damping * (slow2 - x2) + slow3
        x4 = square * (slow2 - x2) + damping * (slow3 - x3) + slow4
        x5 = square * (slow3 - x3) + damping * (slow4 - x4) + slow5
        lanes[MISS + i], lanes[RATE + i] = -x, x1
        lanes[_SECOND + i], lanes[_THIRD + i], lanes[_FOURTH + i], lanes[_FIFTH + i] = x2, x3, x4, x5
    # A loop of its own, as in `flight.refine_durations`.
    for i in range(LANES):
        tau, velocity = lanes[DURATION + i], lanes[END_VELOCITY + i]
        side = -1.0 if velocity > 0.0 else 1.0
        miss, x1 = lanes[MISS + i], lanes[RATE + i]
        x2, x3, x4, x5 = lanes[_SECOND + i], lanes[_THIRD + i], lanes[_FOURTH + i], lanes[_FIFTH + i]
        fading = 0.5 * damping * tau
        inverse = 1.0 / x1
        step_, last = fifth_order_step(miss * inverse, x2 * inverse, x3 * inverse, x4 * inverse)
        leaving = -(x1 + step_ * (x2 + step_ * (0.5 * x3 + step_ * (x4 * (1.0 / 6.0) + step_ * x5 * (1.0 / 24.0)))))
        # Selects instead of one condition, whose short circuit would be a branch. NaN ends up unsure.
        near = NEARLY if abs(last) <= NEAR * tau else 1.0
        unsure = 0.0 if abs(last) <= LAST_TERM * tau else near
        unsure = unsure if abs(step_) * frequency <= _LARGEST_TURN else near
        unsure = unsure if x1 < 0.0 else 1.0
        unsure = unsure if leaving > 0.0 else 1.0
        unsure = unsure if fading <= 1.0 else 1.0
        lasting = (side > 0.0) & (tau + step_ > permanent_after)
        unsure = 1.0 if lasting else unsure
        endless = tau == ENDLESS
        lanes[UNSURE + i] = 0.0 if endless else unsure
        sure = unsure == 0.0
        phase = lanes[END_PHASE + i] + tau + step_
        lanes[DURATION + i] = tau + step_
        bend = x2 + step_ * (x3 + 0.5 * step_ * x4)
        lanes[END_PHASE + i] = wrap(phase) if sure else lanes[END_PHASE + i]
        stays = 0.0 if endless else velocity
        lanes[END_VELOCITY + i] = -side * leaving if sure else stays
        acceleration = side * (bend - damping * leaving)
        lanes[END_ACCELERATION + i] = acceleration if sure else lanes[END_ACCELERATION + i]
    return count_set(lanes, UNSURE)


@inlined
def _polished(lanes, i, oscillator, side):
    """End of a contact that is nearly known."""
    contact = enter_contact(oscillator, side, lanes[END_PHASE + i], 0.0, abs(lanes[END_VELOCITY + i]))
    return end_near(contact, lanes[DURATION + i])


@inlined
def follow_contacts_carefully(lanes, oscillator):
    """Third pass: the lanes that are not sure, by the scalar path.

    A lane in permanent contact ends with velocity 0; one whose end was not found with a phase of NaN.
    """
    for i in range(LANES):
        if lanes[UNSURE + i] == 0.0 or not math.isfinite(lanes[END_PHASE + i]):
            continue
        velocity = lanes[END_VELOCITY + i]
        side = LOWER if velocity > 0.0 else UPPER
        contact = _polished(lanes, i, oscillator, side) if lanes[UNSURE + i] == NEARLY else _NOT_FOUND
        if contact.outcome != OUTCOME_RETURNED:
            contact = follow_contact(oscillator, side, lanes[END_PHASE + i], abs(velocity))
        if contact.outcome == OUTCOME_PERMANENT_CONTACT:
            lanes[END_VELOCITY + i] = 0.0
            continue
        phase = lanes[END_PHASE + i] + contact.duration
        lanes[DURATION + i] = contact.duration
        lanes[END_PHASE + i] = wrap(phase) if contact.outcome == OUTCOME_RETURNED else math.nan
        lanes[END_VELOCITY + i] = -side * contact.speed
        lanes[END_ACCELERATION + i] = rest_acceleration(oscillator, phase)
