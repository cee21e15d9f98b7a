"""DP, the derivative of the impact map, in closed form.

In freeplay a variation (eta, eta') obeys eta'' + delta eta' = 0. A flight that leaves a wall dt later, with velocity
changed by dw, carries at the original times the variation eta = -w dt, eta' = dw - Phi'' dt; the wall is met later by
-eta/Phi', in which time the velocity changes by the acceleration there (saltation). A stay in contact is the same with
the ringing equation eta'' + delta eta' + 2 kappa eta = 0; an elastic impact turns the sign of the velocity. Near
grazing Phi' at -beta tends to zero and DP grows without bound: the map has a square root there.
"""

import math
from typing import NamedTuple

from rattle_kernels.impact_map.apply import LOWER, UPPER, Impact, next_contact
from rattle_kernels.model.contact import stay_in_contact
from rattle_kernels.model.flight import rest_acceleration, second_phi
from rattle_kernels.numerics.jit import inlined


class Jacobian(NamedTuple):
    """Rows d(t1, v1)/d(t0, v0)."""

    tt: float
    tv: float
    vt: float
    vv: float


@inlined
def multiply(left, right):
    """Matrix product ``left @ right``."""
    return Jacobian(
        left.tt * right.tt + left.tv * right.vt,
        left.tt * right.tv + left.tv * right.vv,
        left.vt * right.tt + left.vv * right.vt,
        left.vt * right.tv + left.vv * right.vv,
    )


@inlined
def flight_jacobian(oscillator, phase, velocity, contact):
    """Derivative of (time of contact, velocity after it) by (time of departure, velocity)."""
    damping = oscillator.damping
    x = damping * contact.duration
    stretch = contact.duration * (1.0 - x * second_phi(x))
    decay = math.exp(-x)
    leaving = rest_acceleration(oscillator, phase) - damping * velocity
    arriving = rest_acceleration(oscillator, contact.phase) - damping * contact.velocity
    tt = (velocity + stretch * leaving) / contact.velocity
    tw = -stretch / contact.velocity
    return Jacobian(tt, tw, decay * leaving - arriving * tt, -decay - arriving * tw)


@inlined
def stay_jacobian(oscillator, side, phase, speed, stay):
    """Derivative of (time of leaving, signed velocity then) by those of entering as an elastic impact would turn it."""
    if stay.duration == 0.0:
        return Jacobian(1.0, 0.0, 0.0, 1.0)
    damping, square = oscillator.damping, 2.0 * oscillator.stiffness
    frequency = math.sqrt(square - 0.25 * damping * damping)
    left = math.exp(-0.5 * damping * stay.duration)
    # The answer to a unit of velocity, its rate, and the answer to a unit of depth.
    pulse = left * math.sin(frequency * stay.duration) / frequency
    pulse_rate = left * math.cos(frequency * stay.duration) - 0.5 * damping * pulse
    lag = pulse_rate + damping * pulse
    entering = side * rest_acceleration(oscillator, phase) - damping * speed
    leaving = side * rest_acceleration(oscillator, phase + stay.duration) + damping * stay.speed
    # Depth and its rate at the end, by time and speed of entering.
    depth_t, depth_u = -speed * lag - entering * pulse, pulse
    rate_t, rate_u = speed * square * pulse - entering * pulse_rate, pulse_rate
    tt, tu = depth_t / stay.speed, depth_u / stay.speed
    # Depths count away from freeplay: signed velocities are -side times speeds on both sides of the stay.
    return Jacobian(tt, -side * tu, side * (rate_t + leaving * tt), -(rate_u + leaving * tu))


@inlined
def next_impact_with_jacobian(oscillator, t, v):
    """One application of P and its derivative.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        A departure from +beta: finite, v > 0.

    Returns
    -------
    (Impact, Jacobian)
        The impact, and DP; of no meaning where contact is permanent.
    """
    contact = next_contact(oscillator, UPPER, t, -v, 1.0)
    jacobian = flight_jacobian(oscillator, t, -v, contact)
    lower_impacts, elapsed = 0, contact.duration
    if contact.wall == LOWER:
        lower_impacts = 1
        stay = stay_in_contact(oscillator, LOWER, contact.phase, -contact.velocity)
        jacobian = multiply(stay_jacobian(oscillator, LOWER, contact.phase, -contact.velocity, stay), jacobian)
        start = contact.phase + stay.duration
        contact = next_contact(oscillator, LOWER, start, stay.speed, 1.0)
        jacobian = multiply(flight_jacobian(oscillator, start, stay.speed, contact), jacobian)
        elapsed += stay.duration + contact.duration
    stay = stay_in_contact(oscillator, UPPER, contact.phase, contact.velocity)
    jacobian = multiply(stay_jacobian(oscillator, UPPER, contact.phase, contact.velocity, stay), jacobian)
    # The section counts speeds: v = -w on both sides.
    signed = Jacobian(jacobian.tt, -jacobian.tv, -jacobian.vt, jacobian.vv)
    phase = contact.phase + stay.duration
    elapsed += stay.duration
    return Impact(phase - math.floor(phase), stay.speed, lower_impacts, stay.outcome, elapsed), signed
