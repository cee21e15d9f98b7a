"""The motion before and after a touch of -beta, with derivatives by the touch: smooth where a flight grazes.

Seen from +beta, a flight that grazes -beta meets it with a speed u like the square root of its distance from grazing,
so that DP is singular (impacting model) or turns within about 1/kappa of the graze. Seen from the touch, at phase tau
with speed u, the flight up from there and the flight backwards in time to the departure before are smooth down to
u = 0. So is a contact of finite stiffness, which lasts about 2 u/a at an acceleration a.
"""

import math
from typing import NamedTuple

from rattle_kernels.impact_map.flights import LOWER, UPPER, FlightEnd, next_contact
from rattle_kernels.impact_map.jacobian import Jacobian, contact_jacobian, flight_jacobian, multiply
from rattle_kernels.impact_map.sensitivity import carry, contact_sensitivity, flight_sensitivity
from rattle_kernels.model.contact_end import follow_contact
from rattle_kernels.model.outcome import OUTCOME_NOT_CONVERGED, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import inlined


class Way(NamedTuple):
    """A way between a touch and a departure from +beta.

    ``t`` (not reduced) and ``v`` are the departure, ``duration`` the signed time from the touch to it, ``jacobian`` and
    ``sensitivity`` the derivatives of (t, v) by (tau, u) and by a parameter. ``area`` is the determinant of the way in
    the direction of time, free of the differences that cancel in that of a Jacobian for small u. ``outcome`` is a code
    of `Outcome`.
    """

    t: float
    v: float
    duration: float
    jacobian: Jacobian
    sensitivity: tuple[float, float]
    area: float
    outcome: int


@inlined
def _determinant(jacobian):
    return jacobian.tt * jacobian.vv - jacobian.tv * jacobian.vt


@inlined
def way_from_touch(oscillator, parameter, tau, u):
    """Way from a touch of -beta through the contact there to the next departure from +beta.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller; of finite stiffness.
    parameter : int
        Place in `Oscillator.parameters` of the one to differentiate by.
    tau, u : float
        Phase and speed with which -beta is met; u > 0.

    Returns
    -------
    Way
    """
    lower = follow_contact(oscillator, LOWER, tau, u)
    rises_at = tau + lower.duration
    rise = next_contact(oscillator, LOWER, rises_at, lower.speed, 1.0)
    upper = follow_contact(oscillator, UPPER, rise.phase, max(rise.velocity, 0.0))
    jacobian = contact_jacobian(oscillator, LOWER, tau, u, lower)
    change = contact_sensitivity(oscillator, parameter, LOWER, tau, u, lower)
    # A flight shrinks v dv dt by e^{-delta tau}.
    area = _determinant(jacobian) * math.exp(-oscillator.damping * rise.duration) * lower.speed / rise.velocity
    one = flight_jacobian(oscillator, rises_at, lower.speed, rise)
    own = flight_sensitivity(oscillator, parameter, LOWER, rises_at, lower.speed, rise)
    change, jacobian = carry(one, change, own), multiply(one, jacobian)
    one = contact_jacobian(oscillator, UPPER, rise.phase, rise.velocity, upper)
    own = contact_sensitivity(oscillator, parameter, UPPER, rise.phase, rise.velocity, upper)
    change, jacobian = carry(one, change, own), multiply(one, jacobian)
    area *= _determinant(one)
    speeds = Jacobian(jacobian.tt, jacobian.tv, -jacobian.vt, -jacobian.vv)
    outcome = upper.outcome if rise.found else OUTCOME_NOT_CONVERGED
    duration = lower.duration + rise.duration + upper.duration
    return Way(tau + duration, upper.speed, duration, speeds, (change[0], -change[1]), area, outcome)


@inlined
def way_to_touch(oscillator, parameter, tau, u):
    """Way backwards in time from a touch of -beta to the departure from +beta before it, and the flight's derivative.

    Parameters
    ----------
    oscillator, parameter, tau, u
        As for `way_from_touch`.

    Returns
    -------
    (Way, Jacobian)
        The way, and d(tau, u)/d(t, v), which grows like 1/u.
    """
    back = next_contact(oscillator, LOWER, tau, -u, -1.0)
    one = flight_jacobian(oscillator, tau, -u, back)
    change = flight_sensitivity(oscillator, parameter, LOWER, tau, -u, back)
    jacobian = Jacobian(one.tt, -one.tv, one.vt, -one.vv)
    fall = flight_jacobian(
        oscillator, tau + back.duration, back.velocity, FlightEnd(LOWER, tau, -back.duration, -u, True)
    )
    there = Jacobian(fall.tt, -fall.tv, fall.vt, -fall.vv)
    area = math.exp(oscillator.damping * back.duration) * -back.velocity / u
    outcome = OUTCOME_RETURNED if back.found else OUTCOME_NOT_CONVERGED
    return Way(tau + back.duration, -back.velocity, back.duration, jacobian, change, area, outcome), there
