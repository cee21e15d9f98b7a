"""One contact in closed form: linear contact (side UPPER) or torque reversal (side LOWER), and its first end for sure.

With x >= 0 the depth beyond the wall, omega^2 = 2 kappa and s = +1 above, -1 below, Eqs. (1, 2) read

    x'' + delta x' + omega^2 x = s a(t),    a the acceleration at rest in freeplay, Eq. (7),

whose solution is a slow part p of the forcing's period plus a ringing E r cos(q tau + zeta), E = e^{-delta tau/2},
q^2 = omega^2 - delta^2/4 (Eqs. 33-37 with their errata). From x(0) = d, x'(0) = u it is evaluated as

    x = d + u S + (p(0) - d) C + p(tau) - p(0) - p'(0) S,    S = E sin(q tau)/q,    C = 1 - S' - delta S,

whose terms other than d all vanish with tau: short and gentle contacts keep their digits. A contact begins at the wall
(d = 0). One that is met inside (d > 0) is the same motion from there on.

The end is the first zero of x after 0. It is reached by steps that provably jump over none: from a point with x > 0, x
stays positive while Taylor's polynomial less a bound on its remainder does. Over all the rest of the contact, the
derivatives of p and the ringing that is left bound those of x: |x''| by (2 pi)^2 P + omega^2 E r, |x'''| by (2 pi)^3 P
+ omega^3 E r, P the swing of p. No zero is possible where p exceeds E r, so whole oscillations are skipped until p
falls to it. Where even the least p exceeds E r, contact is permanent. Below epsilon_crit1 (Eq. 3) that least p is
positive; above it every contact ends.
"""

import math
from typing import NamedTuple

from rattle_kernels.model.flight import FOUR_PI, TWO_PI
from rattle_kernels.model.outcome import OUTCOME_NOT_CONVERGED, OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import part_turn

# A step as short as this, in radians of the ringing, leaves Taylor's cubic exact to rounding.
_SHORT = 1e-5
# How far beyond the second-order step the third-order step looks; 1.5 to 3 take the same number of steps.
_LOOK_AHEAD = 2.0
# Most contacts take 4 to 6 steps; 4e5 random ones at damping 1e-4 to 1 and kappa 10 to 1e7 took 3,903 at most.
_ALL_STEPS = 2_000_000


class Contact(NamedTuple):
    """A contact, from entering a wall to leaving it: duration, speed of leaving, outcome code; NaN without an end."""

    duration: float
    speed: float
    outcome: int


_ENDLESS = Contact(math.nan, math.nan, OUTCOME_PERMANENT_CONTACT)


class ContactMotion(NamedTuple):
    """A contact as its root-finder sees it: p = mean + here cos(2 pi tau) + quarter sin(2 pi tau), and ringing."""

    damping: float
    square: float
    frequency: float
    depth: float
    speed: float
    mean: float
    here: float
    quarter: float
    swing: float
    ringing: float


class ContactState(NamedTuple):
    """State of a contact: depth, its derivatives, the slow part less its mean, its rate, the ringing left."""

    depth: float
    rate: float
    acceleration: float
    jerk: float
    slow: float
    slow_rate: float
    ringing: float


class SlowPart(NamedTuple):
    """Slow part of a contact above: mean + cosine cos(2 pi t) + sine sin(2 pi t), and the ringing's frequency q.

    ``square`` is omega^2 = 2 kappa. Below, the slow part has the opposite sign.
    """

    square: float
    frequency: float
    mean: float
    cosine: float
    sine: float


@inlined
def slow_part(oscillator):
    """Amplitudes of the slow part, (34-37) without their angles; all 0 for infinite stiffness."""
    damping = oscillator.damping
    square = 2.0 * oscillator.stiffness
    if math.isinf(square):
        return SlowPart(square, square, 0.0, 0.0, 0.0)
    detuning, drag = square - TWO_PI * TWO_PI, TWO_PI * damping
    strength = -TWO_PI * oscillator.eccentricity / (detuning * detuning + drag * drag)
    return SlowPart(
        square,
        math.sqrt(square - 0.25 * damping * damping),
        FOUR_PI * damping / square,
        strength * (TWO_PI * detuning - damping * drag),
        strength * (damping * detuning + TWO_PI * drag),
    )


@inlined
def enter_contact(oscillator, side, phase, depth, speed):
    """Contact that is met at `phase`, `depth` beyond the wall of `side`, with signed `speed` into the wall."""
    damping = oscillator.damping
    square, frequency, mean, cosine, sine = slow_part(oscillator)
    mean, cosine, sine = side * mean, side * cosine, side * sine
    angle = TWO_PI * part_turn(phase)
    sine_here, cosine_here = math.sin(angle), math.cos(angle)
    here = cosine * cosine_here + sine * sine_here
    quarter = sine * cosine_here - cosine * sine_here
    lag = mean + here - depth
    quadrature = (speed - TWO_PI * quarter - 0.5 * damping * lag) / frequency
    ringing = math.hypot(lag, quadrature)
    swing = math.hypot(cosine, sine)
    return ContactMotion(damping, square, frequency, depth, speed, mean, here, quarter, swing, ringing)


@inlined
def state_in_contact(contact, tau):
    """State of the contact at tau."""
    damping = contact.damping
    half_angle = math.pi * part_turn(tau)
    sine_half, cosine_half = math.sin(half_angle), math.cos(half_angle)
    slow_change = 2.0 * sine_half * (contact.quarter * cosine_half - contact.here * sine_half)
    slow_rate_change = -TWO_PI * 2.0 * sine_half * (contact.here * cosine_half + contact.quarter * sine_half)
    half_ring = 0.5 * contact.frequency * tau
    sine_ring, cosine_ring = math.sin(half_ring), math.cos(half_ring)
    lost = -math.expm1(-0.5 * damping * tau)
    left = 1.0 - lost
    pulse = 2.0 * left * sine_ring * cosine_ring / contact.frequency
    lag = lost + 2.0 * left * sine_ring * sine_ring  # 1 - E cos
    settled = lag - 0.5 * damping * pulse
    pulse_drop = lag + 0.5 * damping * pulse  # 1 - S'
    level, slow_rate_here = contact.mean + contact.here - contact.depth, TWO_PI * contact.quarter
    depth = contact.speed * pulse + level * settled + (slow_change - slow_rate_here * pulse) + contact.depth
    rate = contact.speed * (1.0 - pulse_drop) + level * contact.square * pulse
    rate += slow_rate_change + slow_rate_here * pulse_drop
    slow, slow_rate = contact.here + slow_change, slow_rate_here + slow_rate_change
    bend = TWO_PI * TWO_PI * slow
    acceleration = contact.square * (contact.mean + slow - depth) + damping * (slow_rate - rate) - bend
    jerk = contact.square * (slow_rate - rate) - damping * (bend + acceleration) - TWO_PI * TWO_PI * slow_rate
    return ContactState(depth, rate, acceleration, jerk, slow, slow_rate, contact.ringing * left)


@inlined
def bend_bound(contact, ringing):
    """Bound on the second derivative of x over the rest of a contact with this ringing left."""
    return TWO_PI * TWO_PI * contact.swing + contact.square * ringing


@inlined
def jerk_bound(contact, ringing):
    """Bound on the third derivative of x over the rest of a contact with this ringing left."""
    return TWO_PI * TWO_PI * TWO_PI * contact.swing + contact.square * math.sqrt(contact.square) * ringing


@inlined
def _step_from_wall(contact, rate, acceleration, ringing):
    """Step from x = 0, x' >= 0: x/h is at least x' + x'' h/2 - M h^2/6, positive up to its one positive root."""
    third = jerk_bound(contact, ringing) / 6.0
    half = 0.5 * acceleration
    root = math.sqrt(half * half + 4.0 * third * rate)
    if half > 0.0:
        return 0.5 * (half + root) / third
    return 2.0 * rate / (root - half) if rate > 0.0 else 0.0


@inlined
def first_zero(depth, rate, acceleration):
    """First zero ahead of the parabola with these values at 0, for depth > 0; infinite where there is none."""
    square = rate * rate - 2.0 * depth * acceleration
    if square < 0.0 or (rate >= 0.0 and acceleration >= 0.0):
        return math.inf
    root = math.sqrt(square)
    if rate > 0.0:
        return -(rate + root) / acceleration
    return 2.0 * depth / (root - rate)


@inlined
def _sure_step(contact, state):
    """Step within which x stays positive; near a zero it leaves a remainder of third order.

    While h <= H, x''/2 - M h/6 is at least x''/2 - M H/6: a parabola, that of second order or a better one.
    """
    second = first_zero(state.depth, state.rate, -bend_bound(contact, state.ringing))
    horizon = _LOOK_AHEAD * second
    bend = state.acceleration - jerk_bound(contact, state.ringing) * horizon / 3.0
    return max(second, min(horizon, first_zero(state.depth, state.rate, bend)))


@inlined
def _clear_ahead(contact, state):
    """Time for which the slow part exceeds the ringing that is left now: there is no zero before it falls to that."""
    if contact.mean + state.slow <= state.ringing:
        return 0.0
    angle = math.atan2(-state.slow_rate, TWO_PI * state.slow)
    falls = math.acos(min(max((state.ringing - contact.mean) / contact.swing, -1.0), 1.0))
    return (falls - angle) / TWO_PI


@inlined
def _is_within_reach(contact, state, ahead):
    """Whether the slope stays negative down to a zero (Kantorovich), a step as short as Taylor's cubic allows."""
    if state.depth <= 0.0:
        return True
    steep = state.rate < 0.0 and 2.0 * bend_bound(contact, state.ringing) * state.depth <= state.rate * state.rate
    return steep and ahead * contact.frequency <= _SHORT


@inlined
def _land(tau, state):
    """End of a contact at the zero of Taylor's cubic a short step from `state`, or just before it by rounding."""
    reach = math.sqrt(max(state.rate * state.rate - 2.0 * state.depth * state.acceleration, 0.0)) - state.rate
    ahead = 2.0 * state.depth / reach if reach > 0.0 else 0.0
    slope = state.rate + ahead * (state.acceleration + 0.5 * ahead * state.jerk)
    if slope < 0.0:
        bend = state.acceleration + ahead * state.jerk / 3.0
        change = -(state.depth + ahead * (state.rate + 0.5 * ahead * bend)) / slope
        ahead += change
        slope += change * state.acceleration
    # Rounding may give contacts of hardly any speed the wrong sign of nothing.
    return Contact(max(tau + ahead, 0.0), max(-slope, 0.0), OUTCOME_RETURNED)


@inlined
def follow_contact(oscillator, side, phase, speed):
    """Follow one contact from its beginning at the wall to its first end.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller. Where its stiffness is infinite, the contact is an elastic impact.
    side : float
        UPPER for linear contact (Phi >= +beta), LOWER for torque reversal (Phi <= -beta).
    phase, speed : float
        Phase (any value) of entering, and speed into the wall, not negative.

    Returns
    -------
    Contact
        Outcome RETURNED, PERMANENT_CONTACT or NOT_CONVERGED.
    """
    if math.isinf(oscillator.stiffness):
        return Contact(0.0, speed, OUTCOME_RETURNED)
    return follow_contact_from(oscillator, side, phase, 0.0, speed)


@inlined
def follow_contact_from(oscillator, side, phase, depth, speed):
    """Follow one contact from anywhere inside it to its first end.

    The bounds on the derivatives of x come from the motion itself, not from where it began. So the steps are as sure
    from inside as from the wall.

    Parameters
    ----------
    oscillator, side, phase
        As in `follow_contact`.
    depth, speed : float
        Depth beyond the wall, not negative, and signed speed into the wall; where the depth is 0, not negative.

    Returns
    -------
    Contact
        As in `follow_contact`. Its duration counts from here, also against ``permanent_after``.
    """
    contact = enter_contact(oscillator, side, phase, depth, speed)
    # Torque reversal always ends (Eq. 31), however long it takes.
    permanent_after = oscillator.permanent_after if side > 0.0 else math.inf
    least = contact.mean - contact.swing
    tau = 0.0
    for steps in range(_ALL_STEPS):
        state = state_in_contact(contact, tau)
        if state.ringing < least:
            break
        begins = steps == 0 and depth <= 0.0
        if begins or (state.depth <= 0.0 and state.rate >= 0.0 and state.acceleration > 0.0):
            # The start, or a graze from inside that rounding put on the wall: contact goes on.
            ahead = _step_from_wall(contact, state.rate, state.acceleration, state.ringing)
        else:
            ahead = max(_sure_step(contact, state), _clear_ahead(contact, state))
            if _is_within_reach(contact, state, ahead):
                ended = _land(tau, state)
                return ended if ended.duration <= permanent_after else _ENDLESS
        tau += ahead
        if tau > permanent_after:
            break
    else:
        return Contact(math.nan, math.nan, OUTCOME_NOT_CONVERGED)
    return _ENDLESS
