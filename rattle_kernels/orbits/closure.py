"""The equations of a periodic orbit, P^p(t, v) = (t + m, v), with the derivatives that continuation needs."""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.sensitivity import next_impact_with_sensitivity
from rattle_kernels.impact_map.variations import Jacobian, multiply
from rattle_kernels.model.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.phase import wrap


class OrbitShape(NamedTuple):
    """Shape of an orbit, P(m, n+, .), constant along a branch.

    If bit i of ``over`` is set, flight i passes -beta as if it were not there. The equations of an orbit that grazes
    there are then smooth, since a grazing flight belongs both to the flights that meet -beta and to those that miss it.
    """

    forcing_periods: int
    upper_contacts: int
    over: int = 0


class Closure(NamedTuple):
    """Closing error of a departure, and the derivatives of P^p.

    ``gap`` = (elapsed time - m, change of speed); ``jacobian`` = DP^p; ``sensitivity`` = dP^p/dp, shape (2,); ``lower``
    counts the contacts with -beta on each of its p ways from +beta to +beta.
    """

    gap: np.ndarray
    jacobian: np.ndarray
    sensitivity: np.ndarray
    lower: tuple[int, ...]


@kernel
def _closure(oscillator, parameter, shape, t, v, gap, derivative, sensitivity, lower):
    jacobian = Jacobian(1.0, 0.0, 0.0, 1.0)
    later, faster = 0.0, 0.0
    here, speed, elapsed = t, v, 0.0
    for i in range(shape.upper_contacts):
        over = (shape.over >> i) & 1 == 1
        impact, one, own = next_impact_with_sensitivity(oscillator, parameter, here, speed, over)
        if impact.outcome != OUTCOME_RETURNED or not impact.v > 0.0:
            return False
        later, faster = one.tt * later + one.tv * faster + own[0], one.vt * later + one.vv * faster + own[1]
        jacobian = multiply(one, jacobian)
        here, speed = impact.t, impact.v
        elapsed += impact.duration
        lower[i] = impact.lower_impacts
    gap[0], gap[1] = elapsed - shape.forcing_periods, speed - v
    derivative[0, 0], derivative[0, 1] = jacobian.tt, jacobian.tv
    derivative[1, 0], derivative[1, 1] = jacobian.vt, jacobian.vv
    sensitivity[0], sensitivity[1] = later, faster
    return True


def closure(oscillator: Oscillator, parameter: str, shape: OrbitShape, t: float, v: float) -> Closure | None:
    """Evaluate the equations of an orbit at a departure.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    parameter : str
        Field of `Oscillator` to differentiate by.
    shape : OrbitShape
    t, v : float
        Phase (any value) and speed of the departure.

    Returns
    -------
    Closure or None
        None if v is not positive, or contact becomes permanent or a loose gear comes to rest on the way.
    """
    if not v > 0.0:
        return None
    gap, derivative, sensitivity = np.empty(2), np.empty((2, 2)), np.empty(2)
    lower, number = np.empty(shape.upper_contacts, np.int64), oscillator.parameters.index(parameter)
    closes = _closure(oscillator, number, shape, t, v, gap, derivative, sensitivity, lower)
    if not (closes and np.isfinite(derivative).all() and np.isfinite(sensitivity).all()):
        return None
    return Closure(gap, derivative, sensitivity, tuple(lower.tolist()))


class Departures(NamedTuple):
    """All departures of an orbit.

    ``t``, ``v`` (shape (n,)) are phases in [0, 1) and speeds; ``jacobian`` (n, 2, 2) and ``sensitivity`` (n, 2) their
    derivatives by the first departure and by a parameter; ``lower_contacts`` the number of contacts with -beta.
    """

    t: np.ndarray
    v: np.ndarray
    jacobian: np.ndarray
    sensitivity: np.ndarray
    lower_contacts: int


@kernel
def _departures(oscillator, parameter, shape, t, v, derivative, sensitivity):
    """Fill in all departures after the first. Count the contacts with -beta, without those that are passed over."""
    lower = 0
    jacobian = Jacobian(1.0, 0.0, 0.0, 1.0)
    later, faster = 0.0, 0.0
    for i in range(t.size):
        derivative[i, 0, 0], derivative[i, 0, 1] = jacobian.tt, jacobian.tv
        derivative[i, 1, 0], derivative[i, 1, 1] = jacobian.vt, jacobian.vv
        sensitivity[i, 0], sensitivity[i, 1] = later, faster
        over = (shape.over >> i) & 1 == 1
        impact, one, own = next_impact_with_sensitivity(oscillator, parameter, t[i], v[i], over)
        later, faster = one.tt * later + one.tv * faster + own[0], one.vt * later + one.vv * faster + own[1]
        jacobian = multiply(one, jacobian)
        lower += impact.lower_impacts
        if i + 1 < t.size:
            t[i + 1], v[i + 1] = impact.t, impact.v
    return lower


def departures_from(oscillator: Oscillator, parameter: str, shape: OrbitShape, t: float, v: float) -> Departures:
    """All departures of an orbit, from one of them.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    parameter : str
        Field of `Oscillator` to differentiate by.
    shape : OrbitShape
    t, v : float
        Phase (any value) and speed of the first departure.

    Returns
    -------
    Departures
        A flight that passes over -beta does not meet it.
    """
    size = shape.upper_contacts
    times, speeds = np.full(size, wrap(t)), np.full(size, v)
    jacobian, sensitivity = np.empty((size, 2, 2)), np.empty((size, 2))
    number = oscillator.parameters.index(parameter)
    lower = _departures(oscillator, number, shape, times, speeds, jacobian, sensitivity)
    return Departures(times, speeds, jacobian, sensitivity, int(lower))


@kernel
def grazing_speed_at(oscillator, t):
    """v*(t) at one phase, without the cost of arrays.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t : float

    Returns
    -------
    float
    """
    return grazing_flight(oscillator, t, LEAVING)[0]


def area_factor(oscillator: Oscillator, shape: OrbitShape, jacobian: np.ndarray) -> float:
    """Determinant of DP^p of a closed orbit: e^{-delta m} exactly, unless contacts lose energy, too.

    Parameters
    ----------
    oscillator : Oscillator
    shape : OrbitShape
    jacobian : ndarray, shape (2, 2)
        DP^p.

    Returns
    -------
    float
        With restitution r it is ``e^{-delta m} r^(2 (n+ + n-))``, with damping in contact it depends on the times spent
        there; either is taken from the derivative itself.
    """
    if oscillator.restitution == 1.0 and oscillator.contact_damping == 0.0:
        return math.exp(-oscillator.damping * shape.forcing_periods)
    return float(np.linalg.det(jacobian))


def stability_gap(oscillator: Oscillator, shape: OrbitShape, jacobian: np.ndarray, multiplier: float) -> float:
    """Trace of DP^p minus the trace at which `multiplier` is an eigenvalue.

    Parameters
    ----------
    oscillator : Oscillator
    shape : OrbitShape
    jacobian : ndarray, shape (2, 2)
        DP^p.
    multiplier : float
        +1.0 (saddle-node) or -1.0 (period doubling).

    Returns
    -------
    float
    """
    area = area_factor(oscillator, shape, jacobian)
    return float(np.trace(jacobian)) - multiplier * (1.0 + area)
