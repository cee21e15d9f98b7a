"""DP, the derivative of the impact map, in closed form.

In freeplay a variation (eta, eta') obeys eta'' + delta eta' = 0. A flight that leaves a wall dt later, with velocity
changed by dw, carries at the original times the variation eta = -w dt, eta' = dw - Phi'' dt; the wall is met later by
-eta/Phi', in which time the velocity changes by the acceleration there (saltation). The reflection turns the sign of
the velocity. Near grazing Phi' at -beta tends to zero and DP grows without bound: the map has a square root there.
"""

import math
from typing import NamedTuple

from rattle_kernels.flight import rest_acceleration, second_phi
from rattle_kernels.impact_map import LOWER, RETURNED, UPPER, Impact, next_contact
from rattle_kernels.jit import step


class Jacobian(NamedTuple):
    """Rows d(t1, v1)/d(t0, v0)."""

    tt: float
    tv: float
    vt: float
    vv: float


@step
def multiply(left, right):
    """Matrix product ``left @ right``."""
    return Jacobian(
        left.tt * right.tt + left.tv * right.vt,
        left.tt * right.tv + left.tv * right.vv,
        left.vt * right.tt + left.vv * right.vt,
        left.vt * right.tv + left.vv * right.vv,
    )


@step
def _flight_jacobian(oscillator, phase, velocity, contact):
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


@step
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
    (Impact, Jacobian, float)
        The impact, DP, and the time that passed (forcing periods).
    """
    contact = next_contact(oscillator, UPPER, t, -v, 1.0)
    jacobian = _flight_jacobian(oscillator, t, -v, contact)
    elapsed, lower_impacts = contact.duration, 0
    if contact.wall == LOWER:
        start, velocity = contact.phase, -contact.velocity
        contact = next_contact(oscillator, LOWER, start, velocity, 1.0)
        jacobian = multiply(_flight_jacobian(oscillator, start, velocity, contact), jacobian)
        elapsed, lower_impacts = elapsed + contact.duration, 1
    # The section counts speeds: v = -w on both sides.
    signed = Jacobian(jacobian.tt, -jacobian.tv, -jacobian.vt, jacobian.vv)
    phase = contact.phase - math.floor(contact.phase)
    return Impact(phase, contact.velocity, lower_impacts, RETURNED), signed, elapsed
