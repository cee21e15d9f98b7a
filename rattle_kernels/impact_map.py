"""The impact map P of the impacting model (Eqs. 4, 5; Sec. 2), flight by flight.

Conventions, said once: the section is a departure from ``Phi = +beta`` into freeplay at phase t (forcing periods, [0, 1)) with
speed v > 0. In the elastic limit v is also the speed of arrival. P goes to the next departure from +beta, either directly (case a)
or by way of -beta (case b); above the grazing curve v*(t) it is case b.

All that is used of the oscillator is Eq. (8): the acceleration at rest is positive at every phase, hence every turning point in
freeplay is a minimum, and flights cross as the paper's monotonicity argument (Sec. 2) says.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.flight import (
    displacement_rate,
    part_turn,
    rest_acceleration,
    start_flight,
    velocity_after,
)
from rattle_kernels.grazing_curve import ARRIVING, LEAVING, grazing_flight
from rattle_kernels.jit import kernel, step
from rattle_kernels.oscillator import Oscillator, check_domain
from rattle_kernels.outcome import Outcome
from rattle_kernels.roots import find_root

RETURNED = int(Outcome.RETURNED)
NOT_CONVERGED = int(Outcome.NOT_CONVERGED)
OUTSIDE_SECTION = int(Outcome.OUTSIDE_SECTION)


class Impact(NamedTuple):
    """One application of P to one point: next departure, contacts with -beta on the way, and how it ended."""

    t: float
    v: float
    lower_impacts: int
    outcome: int


class Impacts(NamedTuple):
    """Applications of P to many points, arrays of one shape.

    ``t`` in [0, 1) and ``v`` > 0 describe the departures reached (NaN where `outcome` is neither returned nor captured),
    ``lower_impacts`` counts contacts with -beta on the way, ``outcome`` holds `Outcome` codes.
    """

    t: np.ndarray
    v: np.ndarray
    lower_impacts: np.ndarray
    outcome: np.ndarray


@step
def _return_residual(flight, tau):
    """y/tau, whose only root is the return to the wall that was left, and its slope."""
    rate = displacement_rate(flight, tau)
    return rate, (velocity_after(flight, tau, rate * tau) - rate) / tau


@step
def _reach_residual(problem, tau):
    """Displacement less the target, and its slope."""
    flight, target = problem
    displacement = tau * displacement_rate(flight, tau)
    return displacement - target, velocity_after(flight, tau, displacement)


@step
def _fly_back(flight, acceleration, direction):
    """Signed time until the wall that was left is met again; `direction` +1 forwards, -1 backwards in time.

    y starts downwards, has one minimum and then grows without bound, so y/tau has one sign change, which doubling brackets.
    Backwards the same holds for speeds below the one that grazes -beta, for which alone it is asked.
    """
    near = 0.0
    far = 2.0 * abs(flight.velocity) / acceleration
    while direction * displacement_rate(flight, direction * far) < 0.0:
        near = far
        far *= 2.0
    below, above = direction * near, direction * far
    if direction < 0.0:  # y/tau has the other sign at tau < 0
        below, above = above, below
    return find_root(_return_residual, flight, below, above, direction * (near if near > 0.0 else far))


@step
def _fly_down(flight, two_beta, graze_duration, direction):
    """Signed time from +beta to -beta, for a flight faster than the grazing one through the same point.

    At the time of the slower flight's graze this one lies below -beta (monotonicity), and it crosses -beta once before.
    """
    lands = direction * graze_duration
    start = direction * min(two_beta / abs(flight.velocity), graze_duration)
    return find_root(_reach_residual, (flight, -two_beta), lands, 0.0, start)


@step
def _fly_up(flight, two_beta, acceleration, direction):
    """Signed time from -beta to +beta: y grows strictly, so doubling brackets the one crossing."""
    speed = abs(flight.velocity)
    near = 0.0
    far = 2.0 * two_beta / (speed + math.sqrt(speed * speed + 2.0 * acceleration * two_beta))
    while direction * far * displacement_rate(flight, direction * far) < two_beta:
        near = far
        far *= 2.0
    return find_root(_reach_residual, (flight, two_beta), direction * near, direction * far, direction * far)


@step
def _leave_lower_wall(oscillator, phase, velocity, lower_speed_found, direction):
    """Second piece of case b, from -beta up to +beta: phase and speed there."""
    flight = start_flight(oscillator, phase, velocity)
    two_beta = 2.0 * oscillator.half_backlash
    rise, found = _fly_up(flight, two_beta, rest_acceleration(oscillator, phase), direction)
    return phase + rise, velocity_after(flight, rise, two_beta), found and lower_speed_found


@step
def _apply(oscillator, t, v, direction):
    """P forwards (direction +1) or backwards (-1): unreduced time is not needed, so phases are reduced as they come."""
    if not (math.isfinite(t) and math.isfinite(v) and v > 0.0):
        return Impact(math.nan, math.nan, 0, OUTSIDE_SECTION)
    side = LEAVING if direction > 0.0 else ARRIVING
    two_beta = 2.0 * oscillator.half_backlash
    phase = part_turn(t)
    graze_speed, graze_duration, found = grazing_flight(oscillator, phase, side)
    flight = start_flight(oscillator, phase, -direction * v)
    if v <= graze_speed:
        tau, found_tau = _fly_back(flight, rest_acceleration(oscillator, phase), direction)
        reached = phase + tau
        arrival = velocity_after(flight, tau, 0.0)
        lower_impacts = 0
        found = found and found_tau
    else:
        drop, found_drop = _fly_down(flight, two_beta, graze_duration, direction)
        # Elastic: it leaves -beta with the velocity reversed. At a graze round-off may leave the wrong sign of nothing.
        rebound = -direction * min(direction * velocity_after(flight, drop, -two_beta), 0.0)
        reached, arrival, found = _leave_lower_wall(
            oscillator, part_turn(phase + drop), rebound, found and found_drop, direction
        )
        lower_impacts = 1
    if not found:
        return Impact(math.nan, math.nan, lower_impacts, NOT_CONVERGED)
    wrapped = reached - math.floor(reached)
    return Impact(wrapped if wrapped < 1.0 else 0.0, abs(arrival), lower_impacts, RETURNED)


@step
def next_impact(oscillator, t, v):
    """One application of P, the careful scalar path (Secs. 2.2, 2.3).

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        Phase and speed of a departure from +beta.

    Returns
    -------
    Impact
    """
    return _apply(oscillator, t, v, 1.0)


@step
def previous_impact(oscillator, t, v):
    """One application of the inverse of P: the departure whose next departure is (t, v) (time reversed, Sec. 6.1)."""
    return _apply(oscillator, t, v, -1.0)


@kernel
def _apply_to_all(oscillator, direction, t, v, lower_impacts, outcome):
    for i in range(t.size):
        impact = _apply(oscillator, t[i], v[i], direction)
        t[i], v[i], lower_impacts[i], outcome[i] = impact


def previous_impacts(oscillator: Oscillator, t: np.typing.ArrayLike, v: np.typing.ArrayLike) -> Impacts:
    """Apply the inverse of P once to every point (impacting model).

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model (infinite stiffness).
    t, v : array_like, broadcast together
        Phase (forcing periods) and speed of departures from +beta.

    Returns
    -------
    Impacts
        The departures one application of P earlier.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    """
    checked = check_domain(oscillator)
    phase, speed = (np.array(a, dtype=np.float64) for a in np.broadcast_arrays(t, v))
    lower_impacts, outcome = np.zeros(phase.shape, np.int64), np.zeros(phase.shape, np.int8)
    _apply_to_all(checked, -1.0, phase.ravel(), speed.ravel(), lower_impacts.ravel(), outcome.ravel())
    return Impacts(phase, speed, lower_impacts, outcome)
