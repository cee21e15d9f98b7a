"""Variations of flights and contacts in closed form: what DP, the derivative of the impact map, is put together from.

In freeplay a variation (eta, eta') obeys eta'' + delta eta' = 0. Let a flight leave a wall dt later, with velocity
changed by dw. At the original times it carries the variation eta = -w dt, eta' = dw - Phi'' dt. The wall is met later
by -eta/Phi', and in that time the velocity changes by the acceleration there (saltation). A contact is the same with
the ringing equation eta'' + delta eta' + 2 kappa eta = 0, delta with the damping in contact. An impact turns the sign
of the velocity and multiplies it by the restitution, which is 1 to the bit where it is elastic. Near grazing Phi' at
-beta tends to zero and DP grows without bound: the map has a square root there.
"""

import math
from typing import NamedTuple

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
def flight_jacobian(oscillator, phase, velocity, end):
    """Derivative of (time of contact, velocity after it) by (time of departure, velocity)."""
    damping = oscillator.damping
    x = damping * end.duration
    stretch = end.duration * (1.0 - x * second_phi(x))
    decay = math.exp(-x)
    leaving = rest_acceleration(oscillator, phase) - damping * velocity
    arriving = rest_acceleration(oscillator, end.phase) - damping * end.velocity
    tt = (velocity + stretch * leaving) / end.velocity
    tw = -stretch / end.velocity
    return Jacobian(tt, tw, decay * leaving - arriving * tt, -decay - arriving * tw)


@inlined
def contact_jacobian(oscillator, side, phase, speed, contact):
    """Derivative of (time of leaving, signed velocity then) by those of entering as an elastic impact would turn it."""
    if contact.duration == 0.0:
        return Jacobian(1.0, 0.0, 0.0, oscillator.restitution)
    square = 2.0 * oscillator.stiffness
    damping = oscillator.damping + 2.0 * oscillator.contact_damping * math.sqrt(square)
    frequency = math.sqrt(square - 0.25 * damping * damping)
    left = math.exp(-0.5 * damping * contact.duration)
    # The answer to a unit of velocity, its rate, and the answer to a unit of depth.
    pulse = left * math.sin(frequency * contact.duration) / frequency
    pulse_rate = left * math.cos(frequency * contact.duration) - 0.5 * damping * pulse
    lag = pulse_rate + damping * pulse
    entering = side * rest_acceleration(oscillator, phase) - damping * speed
    leaving = side * rest_acceleration(oscillator, phase + contact.duration) + damping * contact.speed
    # Depth and its rate at the end, by time and speed of entering.
    depth_t, depth_u = -speed * lag - entering * pulse, pulse
    rate_t, rate_u = speed * square * pulse - entering * pulse_rate, pulse_rate
    tt, tu = depth_t / contact.speed, depth_u / contact.speed
    # Depths count away from freeplay: signed velocities are -side times speeds at both ends of the contact.
    return Jacobian(tt, -side * tu, side * (rate_t + leaving * tt), -(rate_u + leaving * tu))


@inlined
def by_speeds(jacobian):
    """The derivative in (t, v) of one in (t, w): the section counts speeds, v = -w at both ends."""
    return Jacobian(jacobian.tt, -jacobian.tv, -jacobian.vt, jacobian.vv)
