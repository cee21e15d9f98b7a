"""The equations of an orbit of finite stiffness in the touches of its flights that meet -beta gently.

Let the flights i, j, ... of an orbit meet -beta at phases tau with small speeds u. From each touch the motion is
followed forwards through the contact and the departures after it, up to the one before the next touch, which is also
reached backwards from that touch:

    (departure reached forwards from touch i) = (departure reached backwards from touch j),

and the last one a time m later. These are two equations for each touch, in (tau, u) of all touches and the parameter.
They are smooth through u = 0, where a flight grazes. In terms of a departure from +beta, P turns within 1/kappa of the
graze: u is like the root of the distance from it, and the contact changes DP by about kappa u, so that a trace may pass
its critical values within 1/kappa^2.

DP^p is the product of all pieces. Its trace is known to about 1e-15/u, the smallest u.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.flights import LOWER, UPPER, next_contact
from rattle_kernels.impact_map.jacobian import Jacobian, multiply
from rattle_kernels.impact_map.sensitivity import carry, next_impact_with_sensitivity
from rattle_kernels.impact_map.touch import way_from_touch, way_to_touch
from rattle_kernels.model.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.phase import wrap
from rattle_kernels.orbits.closure import OrbitShape


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
