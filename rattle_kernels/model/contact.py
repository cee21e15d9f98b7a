"""One contact in closed form: linear contact (side UPPER) or torque reversal (side LOWER).

With x >= 0 the depth beyond the wall, omega^2 = 2 kappa and s = +1 above, -1 below, Eqs. (1, 2) read

    x'' + delta x' + omega^2 x = s a(t),    a the acceleration at rest in freeplay, Eq. (7),

where damping in contact adds 2 zeta omega to this delta, not to that in a. The solution is a slow part p of the
forcing's period plus a ringing E r cos(q tau + angle), E = e^{-delta tau/2}, q^2 = omega^2 - delta^2/4 (Eqs. 33-37 with
their errata; `model.slow_harmonics` adds other orders to p). From x(0) = d, x'(0) = u it is evaluated as

    x = d + u S + (p(0) - d) C + p(tau) - p(0) - p'(0) S,    S = E sin(q tau)/q,    C = 1 - S' - delta S,

whose terms other than d all vanish with tau: short and gentle contacts keep their digits. A contact begins at the wall
(d = 0). One that is met inside (d > 0) is the same motion from there on.
"""

import math
from typing import NamedTuple

from rattle_kernels.model.flight import FOUR_PI, TWO_PI
from rattle_kernels.model.slow_harmonics import (
    add_change,
    add_start,
    add_swing,
    response,
    slow_harmonics,
    slow_states_at,
)
from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import part_turn


class ContactMotion(NamedTuple):
    """A contact as its root-finder sees it: p = mean + here cos(2 pi tau) + quarter sin(2 pi tau), and ringing.

    ``damping`` is that in contact. ``harmonics`` are the slow parts of other orders; ``slow`` and ``slow_rate`` are p
    less its mean, and its rate, at the beginning, with all orders.
    """

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
    slow: float
    slow_rate: float
    harmonics: tuple


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

    ``square`` is omega^2 = 2 kappa, ``drag`` the damping in contact. Below, the slow part has the opposite sign.
    """

    square: float
    frequency: float
    mean: float
    cosine: float
    sine: float
    drag: float
    harmonics: tuple


@inlined
def slow_part(oscillator):
    """Amplitudes of the slow part, (34-37) without their angles; all 0 for infinite stiffness."""
    damping = oscillator.damping
    square = 2.0 * oscillator.stiffness
    if math.isinf(square):
        return SlowPart(square, square, 0.0, 0.0, 0.0, damping, slow_harmonics(oscillator.harmonics, (0.0, 1.0, 0.0)))
    drag = damping + 2.0 * oscillator.contact_damping * math.sqrt(square)
    cosine, sine = response(oscillator.eccentricity, TWO_PI, damping, square, drag)
    return SlowPart(
        square,
        math.sqrt(square - 0.25 * drag * drag),
        FOUR_PI * damping / square,
        cosine,
        sine,
        drag,
        slow_harmonics(oscillator.harmonics, (damping, square, drag)),
    )


@inlined
def enter_contact(oscillator, side, phase, depth, speed):
    """Contact that is met at `phase`, `depth` beyond the wall of `side`, with signed `speed` into the wall."""
    square, frequency, mean, cosine, sine, damping, harmonics = slow_part(oscillator)
    mean, cosine, sine = side * mean, side * cosine, side * sine
    angle = TWO_PI * part_turn(phase)
    sine_here, cosine_here = math.sin(angle), math.cos(angle)
    here = cosine * cosine_here + sine * sine_here
    quarter = sine * cosine_here - cosine * sine_here
    states = slow_states_at(harmonics, (side, phase))
    slow, slow_rate = add_start(states, (here, TWO_PI * quarter), None)
    lag = mean + slow - depth
    quadrature = (speed - slow_rate - 0.5 * damping * lag) / frequency
    ringing = math.hypot(lag, quadrature)
    swing = math.hypot(cosine, sine)
    return ContactMotion(
        damping, square, frequency, depth, speed, mean, here, quarter, swing, ringing, slow, slow_rate, states
    )


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
    bend = TWO_PI * TWO_PI * (contact.here + slow_change)
    bend_rate = TWO_PI * TWO_PI * (TWO_PI * contact.quarter + slow_rate_change)
    changes = slow_change, slow_rate_change, bend, bend_rate
    slow_change, slow_rate_change, bend, bend_rate = add_change(contact.harmonics, changes, tau)
    level, slow_rate_here = contact.mean + contact.slow - contact.depth, contact.slow_rate
    depth = contact.speed * pulse + level * settled + (slow_change - slow_rate_here * pulse) + contact.depth
    rate = contact.speed * (1.0 - pulse_drop) + level * contact.square * pulse
    rate += slow_rate_change + slow_rate_here * pulse_drop
    slow, slow_rate = contact.slow + slow_change, slow_rate_here + slow_rate_change
    acceleration = contact.square * (contact.mean + slow - depth) + damping * (slow_rate - rate) - bend
    jerk = contact.square * (slow_rate - rate) - damping * (bend + acceleration) - bend_rate
    return ContactState(depth, rate, acceleration, jerk, slow, slow_rate, contact.ringing * left)


@inlined
def bend_bound(contact, ringing):
    """Bound on the second derivative of x over the rest of a contact with this ringing left."""
    swing = add_swing(contact.harmonics, TWO_PI * TWO_PI * contact.swing, 2)
    return swing + contact.square * ringing


@inlined
def jerk_bound(contact, ringing):
    """Bound on the third derivative of x over the rest of a contact with this ringing left."""
    swing = add_swing(contact.harmonics, TWO_PI * TWO_PI * TWO_PI * contact.swing, 3)
    return swing + contact.square * math.sqrt(contact.square) * ringing
