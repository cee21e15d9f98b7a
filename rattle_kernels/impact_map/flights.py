"""Flights from wall to wall: the next contact after any departure (Secs. 2, 3).

Freeplay is the same in both models, and so are the flights. They rest on Eq. (8) alone: the acceleration at rest is
positive at every phase. Hence every turning point in freeplay is a minimum, and flights cross as the paper's
monotonicity argument (Sec. 2) says.
"""

import math
from typing import NamedTuple

from rattle_kernels.model.flight import displacement_rate, rest_acceleration, start_flight, velocity_after
from rattle_kernels.model.grazing_curve import ARRIVING, LEAVING, grazing_flight
from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import part_turn
from rattle_kernels.numerics.roots import root_finder

UPPER = 1.0
LOWER = -1.0

# Which way in time a flight is followed.
FORWARDS = 1.0
BACKWARDS = -1.0


class FlightEnd(NamedTuple):
    """End of a flight: the wall met (UPPER or LOWER), phase (not reduced), signed duration and velocity there."""

    wall: float
    phase: float
    duration: float
    velocity: float
    found: bool


@inlined
def _return_residual(flight, tau):
    """y/tau, whose only root is the return to the wall that was left, and its slope."""
    rate = displacement_rate(flight, tau)
    return rate, (velocity_after(flight, tau, rate * tau) - rate) / tau


@inlined
def _reach_residual(problem, tau):
    """Displacement less the target, and its slope."""
    flight, target = problem
    displacement = tau * displacement_rate(flight, tau)
    return displacement - target, velocity_after(flight, tau, displacement)


find_return = root_finder(_return_residual)
find_crossing = root_finder(_reach_residual)


@inlined
def _fly_back(flight, acceleration, direction):
    """Signed time until the wall that was left is met again; `direction` is +1 forwards in time, -1 backwards.

    y starts downwards, has one minimum and then grows without bound, so y/tau has one sign change, which doubling
    brackets. Backwards the same holds for speeds below the one that grazes -beta; no other is asked for.
    """
    near = 0.0
    far = 2.0 * abs(flight.velocity) / acceleration
    while direction * displacement_rate(flight, direction * far) < 0.0:
        near = far
        far *= 2.0
    below, above = direction * near, direction * far
    if direction < 0.0:  # y/tau has the other sign at tau < 0
        below, above = above, below
    return find_return(flight, below, above, direction * (near if near > 0.0 else far))


@inlined
def _fly_down(flight, two_beta, graze_duration, direction):
    """Signed time from +beta to -beta, for a flight faster than the grazing one through the same point.

    When the slower flight grazes, this one lies below -beta (monotonicity), and it crosses -beta once before.
    """
    lands = direction * graze_duration
    start = direction * min(two_beta / abs(flight.velocity), graze_duration)
    return find_crossing((flight, -two_beta), lands, 0.0, start)


@inlined
def _fly_up(flight, two_beta, acceleration, direction):
    """Signed time from -beta to +beta: y grows strictly, so doubling brackets the one crossing."""
    speed = abs(flight.velocity)
    near = 0.0
    far = 2.0 * two_beta / (speed + math.sqrt(speed * speed + 2.0 * acceleration * two_beta))
    while direction * far * displacement_rate(flight, direction * far) < two_beta:
        near = far
        far *= 2.0
    return find_crossing((flight, two_beta), direction * near, direction * far, direction * far)


@inlined
def next_contact(oscillator, wall, phase, velocity, direction):
    """Follow one flight from a wall to the next contact with either.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller (Eq. 8 holds).
    wall : float
        UPPER or LOWER: the wall that is left.
    phase, velocity : float
        Phase (any value) and signed velocity Phi' of the departure.
    direction : float
        FORWARDS or BACKWARDS in time.

    Returns
    -------
    FlightEnd
    """
    start = part_turn(phase)
    two_beta = 2.0 * oscillator.half_backlash
    flight = start_flight(oscillator, start, velocity)
    if wall == LOWER:
        tau, found = _fly_up(flight, two_beta, rest_acceleration(oscillator, start), direction)
        return FlightEnd(UPPER, start + tau, tau, velocity_after(flight, tau, two_beta), found)
    side = LEAVING if direction > 0.0 else ARRIVING
    return leave_upper(oscillator, start, velocity, direction, grazing_flight(oscillator, start, side))


@inlined
def leave_upper(oscillator, start, velocity, direction, graze):
    """Follow one flight from +beta, as `next_contact`; `graze` is the grazing flight (`grazing_flight`) at its phase.

    Many flights from one phase need it once: finding it takes as long as the flight.
    """
    two_beta = 2.0 * oscillator.half_backlash
    flight = start_flight(oscillator, start, velocity)
    graze_speed, graze_duration, graze_found = graze
    if abs(velocity) <= graze_speed:
        tau, found = _fly_back(flight, rest_acceleration(oscillator, start), direction)
        return FlightEnd(UPPER, start + tau, tau, velocity_after(flight, tau, 0.0), found and graze_found)
    tau, found = _fly_down(flight, two_beta, graze_duration, direction)
    # At a graze rounding may leave the wrong sign of nothing.
    arrival = direction * min(direction * velocity_after(flight, tau, -two_beta), 0.0)
    return FlightEnd(LOWER, start + tau, tau, arrival, found and graze_found)


@inlined
def fly_over(oscillator, phase, velocity):
    """Flight from +beta back to +beta as if there were no -beta: smooth across the grazing curve."""
    start = part_turn(phase)
    flight = start_flight(oscillator, start, velocity)
    tau, found = _fly_back(flight, rest_acceleration(oscillator, start), 1.0)
    return FlightEnd(UPPER, start + tau, tau, velocity_after(flight, tau, 0.0), found)
