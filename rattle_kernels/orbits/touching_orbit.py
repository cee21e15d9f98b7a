"""The equations of an orbit of finite stiffness in the touches of its flights that meet -beta gently.

Let the flights i, j, ... of an orbit meet -beta at phases tau with small speeds u. From each touch the motion is
followed forwards through the contact and the departures after it, up to the one before the next touch, which is also
reached backwards from that touch:

    (departure reached forwards from touch i) = (departure reached backwards from touch j),

and the last one a time m later. These are two equations for each touch, in (tau, u) of all touches and the parameter.
They are smooth through u = 0, where a flight grazes. In terms of a departure from +beta, P turns within 1/kappa of the
graze: u is like the root of the distance from it, and the contact changes DP by about kappa u, so that a trace may pass
its critical values within 1/kappa^2.

The flight up from a touch and the flight backwards in time to the departure before are smooth down to u = 0. So is a
contact of finite stiffness, which lasts about 2 u/a at an acceleration a.

DP^p is the product of all pieces. Its trace is known to about 1e-15/u, the smallest u.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.flights import LOWER, UPPER, FlightEnd, next_contact
from rattle_kernels.impact_map.sensitivity import (
    carry,
    contact_sensitivity,
    flight_sensitivity,
    next_impact_with_sensitivity,
)
from rattle_kernels.impact_map.variations import Jacobian, contact_jacobian, flight_jacobian, multiply
from rattle_kernels.model.contact_end import follow_contact
from rattle_kernels.model.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_NOT_CONVERGED, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.phase import wrap
from rattle_kernels.orbits.closure import OrbitShape


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


class TouchingOrbit(NamedTuple):
    """An orbit seen from k touches; the unknowns are (tau_1, u_1, ..., tau_k, u_k, p).

    ``gap`` (shape (2 k,)) are differences in time and speed of the departures before the touches, ``slopes`` (2 k, 2 k
    + 1) their derivatives by the unknowns. ``t``, ``v`` (n,) are all departures, ``moves`` (n, 2, 2 k + 1) their
    derivatives. ``jacobian`` is a matrix of the trace and the determinant of DP^p, and so of its multipliers.
    """

    gap: np.ndarray
    slopes: np.ndarray
    t: np.ndarray
    v: np.ndarray
    moves: np.ndarray
    jacobian: np.ndarray


@inlined
def _put(matrix, row, column, jacobian):
    matrix[row, column], matrix[row, column + 1] = jacobian.tt, jacobian.tv
    matrix[row + 1, column], matrix[row + 1, column + 1] = jacobian.vt, jacobian.vv


@kernel
def _touching_orbit(oscillator, parameter, shape, flights, touches, gap, slopes, t, v, moves, companion):
    """Fill in the arrays of a `TouchingOrbit`; False where a way does not lead to a departure."""
    number, n, last = flights.size, shape.upper_contacts, slopes.shape[1] - 1
    total, area = Jacobian(1.0, 0.0, 0.0, 1.0), 1.0
    for s in range(number):
        after = (s + 1) % number
        apart = (flights[after] - flights[s] - 1) % n + 1
        tau, u, next_tau, next_u = touches[s, 0], touches[s, 1], touches[after, 0], touches[after, 1]
        way = way_from_touch(oscillator, parameter, tau, u)
        if way.outcome != OUTCOME_RETURNED or not way.v > 0.0:
            return False
        area *= way.area
        here, speed, elapsed, jacobian, change = way.t, way.v, way.duration, way.jacobian, way.sensitivity
        for c in range(1, apart):
            i = (flights[s] + c) % n
            t[i], v[i] = wrap(here), speed
            _put(moves[i], 0, 2 * s, jacobian)
            moves[i, 0, last], moves[i, 1, last] = change
            over = (shape.over >> i) & 1 == 1
            impact, one, own = next_impact_with_sensitivity(oscillator, parameter, here, speed, over)
            if impact.outcome != OUTCOME_RETURNED or not impact.v > 0.0:
                return False
            change, jacobian = carry(one, change, own), multiply(one, jacobian)
            area *= one.tt * one.vv - one.tv * one.vt
            here, speed = impact.t, impact.v
            elapsed += impact.duration
        back, fall = way_to_touch(oscillator, parameter, next_tau, next_u)
        if back.outcome != OUTCOME_RETURNED or not back.v > 0.0:
            return False
        area *= back.area
        i = flights[after]
        t[i], v[i] = wrap(back.t), back.v
        _put(moves[i], 0, 2 * after, back.jacobian)
        moves[i, 0, last], moves[i, 1, last] = back.sensitivity
        later = shape.forcing_periods if after <= s else 0
        gap[2 * s], gap[2 * s + 1] = (tau - next_tau) + (elapsed - back.duration - later), speed - back.v
        for row in range(2):
            slopes[2 * s + row, last] = change[row] - back.sensitivity[row]
            for column in range(2):
                slopes[2 * s + row, 2 * after + column] -= moves[i, row, 2 * after + column]
        slopes[2 * s, 2 * s] += jacobian.tt
        slopes[2 * s, 2 * s + 1] += jacobian.tv
        slopes[2 * s + 1, 2 * s] += jacobian.vt
        slopes[2 * s + 1, 2 * s + 1] += jacobian.vv
        total = multiply(fall, multiply(jacobian, total))
    companion[0, 0], companion[0, 1], companion[1, 0], companion[1, 1] = total.tt + total.vv, -area, 1.0, 0.0
    return True


def touching_orbit(
    oscillator: Oscillator, parameter: str, shape: OrbitShape, flights: tuple[int, ...], touches: np.ndarray
) -> TouchingOrbit | None:
    """Evaluate the equations of an orbit at its touches.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller; of finite stiffness.
    parameter : str
        Field of `Oscillator` to differentiate by.
    shape : OrbitShape
        Bits of flights that pass over -beta are those of other flights.
    flights : tuple of int
        The flights that touch, in order.
    touches : ndarray, shape (k, 2)
        Phases, which grow from touch to touch by the time between, and speeds.

    Returns
    -------
    TouchingOrbit or None
        None if a speed is not positive, or a contact becomes permanent on the way.
    """
    number, size = len(flights), shape.upper_contacts
    if not (touches[:, 1] > 0.0).all():
        return None
    gap, slopes = np.zeros(2 * number), np.zeros((2 * number, 2 * number + 1))
    t, v, moves, companion = np.empty(size), np.empty(size), np.zeros((size, 2, 2 * number + 1)), np.empty((2, 2))
    place, order = oscillator.parameters.index(parameter), np.array(flights, np.int64)
    if not _touching_orbit(oscillator, place, shape, order, touches, gap, slopes, t, v, moves, companion):
        return None
    if not (np.isfinite(slopes).all() and np.isfinite(companion).all()):
        return None
    return TouchingOrbit(gap, slopes, t, v, moves, companion)


@kernel
def _touches(oscillator, t, v, phases, speeds):
    begins = t[0]
    for i in range(t.size):
        fall = next_contact(oscillator, UPPER, t[i], -v[i], 1.0)
        met = fall.wall == LOWER
        phases[i] = begins + (fall.duration if met else grazing_flight(oscillator, t[i], LEAVING)[1])
        speeds[i] = -fall.velocity if met else 0.0
        begins += next_impact(oscillator, t[i], v[i]).duration


def touches_of(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Touches of -beta by the flights of an orbit; for a flight that misses it, by the flight that grazes.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : ndarray, shape (n,)
        All departures of the orbit, in order of time.

    Returns
    -------
    ndarray, shape (n, 2)
        Phases, which grow along the orbit, and speeds, 0 for a flight that misses.
    """
    phases, speeds = np.empty(t.size), np.empty(t.size)
    _touches(oscillator, t, v, phases, speeds)
    return np.column_stack([phases, speeds])
