"""The impact map P of both models (Eqs. 1, 2, 4, 5; Secs. 2, 3): flights and stays in contact, in turn.

Conventions, said once: the section is a departure from ``Phi = +beta`` into freeplay at phase t (forcing periods, [0,
1)) with speed v > 0. In the impacting model v is also the speed of arrival. P goes to the next departure from +beta,
either directly (case a) or by way of -beta (case b); above the grazing curve v*(t) it is case b.

Freeplay is the same in both models, and so are the flights. Where the impacting model reverses the velocity at a wall,
in the piecewise linear one the gears stay beyond it for a while (`contact_flight`), beyond +beta perhaps for ever.

All that is used of the oscillator is Eq. (8): the acceleration at rest is positive at every phase, hence every turning
point in freeplay is a minimum, and flights cross as the paper's monotonicity argument (Sec. 2) says. By Eq. (31) the
same holds beyond -beta: every stay there ends, the flight after it reaches +beta, and one application meets -beta at
most once.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.contact import Stay, stay_in_contact
from rattle_kernels.model.flight import (
    displacement_rate,
    part_turn,
    rest_acceleration,
    start_flight,
    velocity_after,
)
from rattle_kernels.model.grazing_curve import ARRIVING, LEAVING, grazing_flight
from rattle_kernels.model.oscillator import Oscillator, check_impacting
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.roots import root_finder

RETURNED = int(Outcome.RETURNED)
PERMANENT_CONTACT = int(Outcome.PERMANENT_CONTACT)
NOT_CONVERGED = int(Outcome.NOT_CONVERGED)
OUTSIDE_SECTION = int(Outcome.OUTSIDE_SECTION)
UPPER = 1.0
LOWER = -1.0


class Contact(NamedTuple):
    """End of one flight: the wall met (UPPER or LOWER), phase (not reduced), signed duration and velocity there."""

    wall: float
    phase: float
    duration: float
    velocity: float
    found: bool


class Impact(NamedTuple):
    """One application of P to one point: next departure, contacts with -beta on the way, how it ended, how long.

    ``t``, ``v`` and ``duration`` (forcing periods) are NaN unless the outcome is RETURNED.
    """

    t: float
    v: float
    lower_impacts: int
    outcome: int
    duration: float


class Impacts(NamedTuple):
    """Applications of P to many points, arrays of one shape.

    ``t`` in [0, 1) and ``v`` > 0 describe the departures reached (NaN where there is none), ``lower_impacts`` counts
    contacts with -beta on the way, ``outcome`` holds `Outcome` codes.
    """

    t: np.ndarray
    v: np.ndarray
    lower_impacts: np.ndarray
    outcome: np.ndarray


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


_find_return = root_finder(_return_residual)
_find_crossing = root_finder(_reach_residual)


@inlined
def fly_back(flight, acceleration, direction):
    """Signed time until the wall that was left is met again; `direction` +1 forwards, -1 backwards in time.

    y starts downwards, has one minimum and then grows without bound, so y/tau has one sign change, which doubling
    brackets. Backwards the same holds for speeds below the one that grazes -beta, for which alone it is asked.
    """
    near = 0.0
    far = 2.0 * abs(flight.velocity) / acceleration
    while direction * displacement_rate(flight, direction * far) < 0.0:
        near = far
        far *= 2.0
    below, above = direction * near, direction * far
    if direction < 0.0:  # y/tau has the other sign at tau < 0
        below, above = above, below
    return _find_return(flight, below, above, direction * (near if near > 0.0 else far))


@inlined
def _fly_down(flight, two_beta, graze_duration, direction):
    """Signed time from +beta to -beta, for a flight faster than the grazing one through the same point.

    At the time of the slower flight's graze this one lies below -beta (monotonicity), and it crosses -beta once before.
    """
    lands = direction * graze_duration
    start = direction * min(two_beta / abs(flight.velocity), graze_duration)
    return _find_crossing((flight, -two_beta), lands, 0.0, start)


@inlined
def _fly_up(flight, two_beta, acceleration, direction):
    """Signed time from -beta to +beta: y grows strictly, so doubling brackets the one crossing."""
    speed = abs(flight.velocity)
    near = 0.0
    far = 2.0 * two_beta / (speed + math.sqrt(speed * speed + 2.0 * acceleration * two_beta))
    while direction * far * displacement_rate(flight, direction * far) < two_beta:
        near = far
        far *= 2.0
    return _find_crossing((flight, two_beta), direction * near, direction * far, direction * far)


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
        +1 forwards in time, -1 backwards.

    Returns
    -------
    Contact
    """
    start = part_turn(phase)
    two_beta = 2.0 * oscillator.half_backlash
    flight = start_flight(oscillator, start, velocity)
    if wall == LOWER:
        tau, found = _fly_up(flight, two_beta, rest_acceleration(oscillator, start), direction)
        return Contact(UPPER, start + tau, tau, velocity_after(flight, tau, two_beta), found)
    side = LEAVING if direction > 0.0 else ARRIVING
    graze_speed, graze_duration, graze_found = grazing_flight(oscillator, start, side)
    if abs(velocity) <= graze_speed:
        tau, found = fly_back(flight, rest_acceleration(oscillator, start), direction)
        return Contact(UPPER, start + tau, tau, velocity_after(flight, tau, 0.0), found and graze_found)
    tau, found = _fly_down(flight, two_beta, graze_duration, direction)
    # At a graze round-off may leave the wrong sign of nothing.
    arrival = direction * min(direction * velocity_after(flight, tau, -two_beta), 0.0)
    return Contact(LOWER, start + tau, tau, arrival, found and graze_found)


@inlined
def _no_departure(lower_impacts, outcome):
    return Impact(math.nan, math.nan, lower_impacts, outcome, math.nan)


@inlined
def _beyond(oscillator, contact, direction):
    """What happens beyond the wall that a flight has met: an elastic impact, or a stay (forwards in time only)."""
    if direction < 0.0:
        return Stay(0.0, abs(contact.velocity), RETURNED)
    speed = max(contact.wall * contact.velocity, 0.0)
    return stay_in_contact(oscillator, contact.wall, contact.phase, speed)


@inlined
def _apply(oscillator, t, v, direction):
    """P forwards (direction +1) or backwards (-1, impacting model): one flight, or two by way of -beta."""
    if not (math.isfinite(t) and math.isfinite(v) and v > 0.0):
        return _no_departure(0, OUTSIDE_SECTION)
    contact = next_contact(oscillator, UPPER, t, -direction * v, direction)
    lower_impacts, duration = 0, contact.duration
    if contact.wall == LOWER:
        lower_impacts = 1
        stay = _beyond(oscillator, contact, direction)
        if not (contact.found and stay.outcome == RETURNED):
            return _no_departure(lower_impacts, NOT_CONVERGED)
        phase = part_turn(contact.phase) + stay.duration
        contact = next_contact(oscillator, LOWER, phase, direction * stay.speed, direction)
        duration += stay.duration + contact.duration
    if not contact.found:
        return _no_departure(lower_impacts, NOT_CONVERGED)
    stay = _beyond(oscillator, contact, direction)
    if stay.outcome != RETURNED:
        return _no_departure(lower_impacts, stay.outcome)
    phase = part_turn(contact.phase) + stay.duration
    wrapped = phase - math.floor(phase)
    return Impact(wrapped if wrapped < 1.0 else 0.0, stay.speed, lower_impacts, RETURNED, duration + stay.duration)


@inlined
def next_impact(oscillator, t, v):
    """One application of P, the careful scalar path.

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


@inlined
def previous_impact(oscillator, t, v):
    """One application of the inverse of P: the departure whose next departure is (t, v) (time reversed, Sec. 6.1)."""
    return _apply(oscillator, t, v, -1.0)


@kernel
def _apply_to_all(oscillator, direction, t, v, lower_impacts, outcome):
    for i in range(t.size):
        impact = _apply(oscillator, t[i], v[i], direction)
        t[i], v[i], lower_impacts[i], outcome[i] = impact.t, impact.v, impact.lower_impacts, impact.outcome


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
    checked = check_impacting(oscillator)
    phase, speed = (np.array(a, dtype=np.float64) for a in np.broadcast_arrays(t, v))
    lower_impacts, outcome = np.zeros(phase.shape, np.int64), np.zeros(phase.shape, np.int8)
    _apply_to_all(checked, -1.0, phase.ravel(), speed.ravel(), lower_impacts.ravel(), outcome.ravel())
    return Impacts(phase, speed, lower_impacts, outcome)
