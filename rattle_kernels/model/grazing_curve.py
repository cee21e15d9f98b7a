"""The grazing curve v*(t): the speed with which a flight from +beta just touches -beta (Sec. 2.1), also backwards.

A flight that touches -beta at phase t_hat with zero speed is, seen from there, a flight with w = 0 on either side of
the touch. It left +beta the time sigma before the touch, where ``y(-sigma) = 2 beta``. It comes back to +beta the time
sigma' after the touch, where ``y(sigma') = 2 beta``. For a given phase on +beta the unknown is sigma. With t_hat = t0 +
sigma, moving the touch later moves the flight at t0 by ``a(t_hat) (e^{delta sigma} - 1)/delta`` > 0, since the
variation obeys eta'' + delta eta' = 0. So the residual grows strictly with sigma: there is one root, which doubling
brackets. The same holds for sigma' with e^{-delta sigma'}.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.arcs import arcs_of
from rattle_kernels.model.domain import check_domain
from rattle_kernels.model.flight import (
    acceleration_range,
    mean_acceleration,
    rest_acceleration,
    second_phi,
    start_flight,
    velocity_after,
)
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.phase import part_turn
from rattle_kernels.numerics.roots import root_finder

MESH = 2048
"""Intervals of the mesh on which lanes look up v*, and the largest is searched for."""

LEAVING = -1.0
ARRIVING = 1.0


class _Touch(NamedTuple):
    """The search for a grazing flight through +beta at `phase`; `side` is LEAVING or ARRIVING there."""

    oscillator: Oscillator
    phase: float
    side: float


@inlined
def _flight_from_touch(touch, sigma):
    return start_flight(touch.oscillator, part_turn(touch.phase) - touch.side * sigma, 0.0)


@inlined
def _touch_residual(touch, sigma):
    """Displacement at +beta less 2 beta, and its derivative in sigma."""
    tau = touch.side * sigma
    flight = _flight_from_touch(touch, sigma)
    x = touch.oscillator.damping * tau
    value = sigma * sigma * mean_acceleration(flight, tau) - 2.0 * touch.oscillator.half_backlash
    phase = part_turn(touch.phase) - tau
    # (1 - e^-x)/delta = tau phi1(x): positive on both sides when multiplied by the side.
    slope = rest_acceleration(touch.oscillator, phase) * sigma * (1.0 - x * second_phi(x))
    return value, slope


_find_touch = root_finder(_touch_residual)


@inlined
def grazing_flight(oscillator, phase, side):
    """Speed at +beta and duration of the flight that touches -beta, through +beta at `phase`.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller (Eq. 8 holds).
    phase : float
        Phase at +beta, forcing periods.
    side : float
        LEAVING for the flight that leaves +beta at that phase, ARRIVING for the one that comes back to it.

    Returns
    -------
    (float, float, bool)
        Speed v*, time between +beta and the touch, and whether the root was found.
    """
    touch = _Touch(oscillator, phase, side)
    two_beta = 2.0 * oscillator.half_backlash
    _, strongest = acceleration_range(oscillator)
    # sigma^2 a phi2 = 2 beta with phi2 about 1/2 and the strongest a; then doubled until +beta lies below the flight.
    low = 0.0
    high = math.sqrt(2.0 * two_beta / strongest)
    while _touch_residual(touch, high)[0] < 0.0:
        low = high
        high *= 2.0
    sigma, found = _find_touch(touch, low, high, 0.5 * (low + high))
    tau = side * sigma
    return abs(velocity_after(_flight_from_touch(touch, sigma), tau, two_beta)), sigma, found


@kernel
def fill_grazing_velocities(oscillator, phase, velocity):
    """Fill an array with v*(t) at phases of departure, NaN where no root is found.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller (Eq. 8 holds), of infinite stiffness.
    phase, velocity : ndarray of float64, one shape (n,)
    """
    for i in range(phase.size):
        speed, _, found = grazing_flight(oscillator, phase[i], LEAVING)
        velocity[i] = speed if found else np.nan


@lru_cache(maxsize=32)
def grazing_speeds(oscillator: Oscillator) -> np.ndarray:
    """v*(t) on a mesh over a period, kept for the last 32 oscillators.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.

    Returns
    -------
    ndarray of float64, shape (MESH + 1,)
        Both ends of the period included. Not to be written.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    """
    speeds = np.empty(MESH + 1)
    fill_grazing_velocities(check_domain(oscillator)._replace(stiffness=math.inf), np.arange(MESH + 1) / MESH, speeds)
    speeds.setflags(write=False)
    return speeds


@lru_cache(maxsize=32)
def largest_grazing_speed(oscillator: Oscillator) -> float:
    """Largest v*(t) on a mesh of 2049 phases: the natural scale of an oscillator's speeds.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.

    Returns
    -------
    float
        Beyond the bound of Eq. (8), where v*(t) is no function, the speed of a fall from +beta to -beta under a bound
        on the acceleration at rest.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    """
    arcs = arcs_of(oscillator)
    if arcs is not None:
        return math.sqrt(4.0 * oscillator.half_backlash * arcs.strongest)
    return float(grazing_speeds(oscillator).max())
