"""The impact map P of both models (Eqs. 1, 2, 4, 5; Secs. 2, 3): flights and contacts in turn.

The conventions hold everywhere. The section is a departure from ``Phi = +beta`` into freeplay at phase t (forcing
periods, [0, 1)) with speed v > 0. In an elastic impact v is also the speed of arrival. P leads to the next departure
from +beta, either directly (case a) or by way of -beta (case b); above the grazing curve v*(t) it is case b.

Both models have the same flights (`flights`). The impacting model reverses the velocity at a wall, and multiplies it by
the restitution. In the piecewise linear model the gears stay beyond the wall for a while (`model.contact`), beyond
+beta perhaps for ever.

By Eq. (31) turning points beyond -beta are minima, too: every contact there ends, the flight after it reaches +beta,
and one application of P meets -beta at most once. All this holds below the bound of Eq. (8); beyond it `loose_map` has
P of both models, and `next_impact` chooses by the oscillator.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.flights import BACKWARDS, FORWARDS, LOWER, UPPER, FlightEnd, fly_over, next_contact
from rattle_kernels.impact_map.loose_map import Impact, next_loose_impact, previous_loose_impact
from rattle_kernels.model.contact_end import Contact, follow_contact
from rattle_kernels.model.departures import check_departures
from rattle_kernels.model.domain import check_invertible
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import (
    OUTCOME_NOT_CONVERGED,
    OUTCOME_OUTSIDE_SECTION,
    OUTCOME_RETURNED,
)
from rattle_kernels.numerics.jit import chosen_by_field, inlined, kernel
from rattle_kernels.numerics.phase import part_turn, wrap


class Impacts(NamedTuple):
    """Applications of P to many points, arrays of one shape.

    ``t`` in [0, 1) and ``v`` > 0 are the departures reached, NaN where there is none. ``lower_impacts`` counts contacts
    with -beta on the way. ``outcome`` holds `Outcome` codes.
    """

    t: np.ndarray
    v: np.ndarray
    lower_impacts: np.ndarray
    outcome: np.ndarray


class Passage(NamedTuple):
    """The way from a departure to the next one, piece by piece.

    ``fall`` ends on either wall. If on -beta, ``lower`` is the contact there and ``rise`` the flight from it, which
    begins at phase ``rises_at``; else ``rise`` is ``fall``. ``upper`` is the contact with +beta at the end.
    ``lower_impacts`` is 0 or 1. ``flown`` is the time up to that last contact.
    """

    fall: FlightEnd
    lower: Contact
    rises_at: float
    rise: FlightEnd
    upper: Contact
    lower_impacts: int
    flown: float


@inlined
def _cross(oscillator, end, direction):
    """What happens beyond the wall that a flight has met: backwards in time an impact undone, else a contact."""
    if direction < 0.0:
        return Contact(0.0, abs(end.velocity) / oscillator.restitution, OUTCOME_RETURNED)
    return follow_contact(oscillator, end.wall, end.phase, max(end.wall * end.velocity, 0.0))


@inlined
def walk(oscillator, t, v, direction, over, reduces):
    """Follow a motion from a departure to the next contact with +beta, and through it.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        A departure from +beta: finite, v > 0.
    direction : float
        FORWARDS, or BACKWARDS (impacting model only).
    over : bool
        Whether the first flight passes -beta as if it were not there (`fly_over`).
    reduces : bool
        Whether the phase on -beta is reduced before the contact's duration is added. Both are right to rounding.
        P itself reduces, the walk of its derivatives does not: stored orbits have the last bits of the latter.

    Returns
    -------
    Passage
        The outcome of ``upper`` says how it ended.
    """
    # Backwards a departure is first the arrival before its impact.
    speed = v if direction > 0.0 else v / oscillator.restitution
    fall = fly_over(oscillator, t, -v) if over else next_contact(oscillator, UPPER, t, -direction * speed, direction)
    lower, rises_at, rise = Contact(0.0, 0.0, OUTCOME_RETURNED), fall.phase, fall
    lower_impacts, flown = 0, fall.duration
    if fall.wall == LOWER:
        lower_impacts = 1
        lower = _cross(oscillator, fall, direction)
        if not (fall.found and lower.outcome == OUTCOME_RETURNED):
            lost = Contact(math.nan, math.nan, OUTCOME_NOT_CONVERGED)
            return Passage(fall, lower, rises_at, rise, lost, lower_impacts, flown)
        rises_at = (part_turn(fall.phase) if reduces else fall.phase) + lower.duration
        rise = next_contact(oscillator, LOWER, rises_at, direction * lower.speed, direction)
        flown += lower.duration + rise.duration
    backwards = Contact(0.0, abs(rise.velocity), OUTCOME_RETURNED)
    upper = _cross(oscillator, rise, direction) if direction > 0.0 else backwards
    if not rise.found:
        upper = Contact(math.nan, math.nan, OUTCOME_NOT_CONVERGED)
    return Passage(fall, lower, rises_at, rise, upper, lower_impacts, flown)


@inlined
def _no_departure(lower_impacts, outcome):
    return Impact(math.nan, math.nan, lower_impacts, outcome, math.nan)


@inlined
def _apply(oscillator, t, v, direction):
    """P forwards (direction +1) or backwards (-1, impacting model)."""
    if not (math.isfinite(t) and math.isfinite(v) and v > 0.0):
        return _no_departure(0, OUTCOME_OUTSIDE_SECTION)
    passage = walk(oscillator, t, v, direction, over=False, reduces=True)
    upper = passage.upper
    if upper.outcome != OUTCOME_RETURNED:
        return _no_departure(passage.lower_impacts, upper.outcome)
    phase = wrap(part_turn(passage.rise.phase) + upper.duration)
    return Impact(phase, upper.speed, passage.lower_impacts, OUTCOME_RETURNED, passage.flown + upper.duration)


@chosen_by_field("arcs", next_loose_impact)
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
    return _apply(oscillator, t, v, FORWARDS)


@chosen_by_field("arcs", previous_loose_impact)
def previous_impact(oscillator, t, v):
    """One application of the inverse of P: the departure whose next departure is (t, v) (time reversed, Sec. 6.1)."""
    return _apply(oscillator, t, v, BACKWARDS)


@kernel
def _undo_all(oscillator, t, v, lower_impacts, outcome):
    for i in range(t.size):
        impact = previous_impact(oscillator, t[i], v[i])
        t[i], v[i], lower_impacts[i], outcome[i] = impact.t, impact.v, impact.lower_impacts, impact.outcome


def previous_impacts(oscillator: Oscillator, t: np.typing.ArrayLike, v: np.typing.ArrayLike) -> Impacts:
    """Apply the inverse of P once to every point (impacting model).

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model (infinite stiffness), also beyond the bound of Eq. (8).
    t, v : array_like, broadcast together
        Phase (forcing periods) and speed of departures from +beta.

    Returns
    -------
    Impacts
        The departures one application of P earlier. Beyond Eq. (8) P goes from bounce to bounce here. A release has
        infinitely many departures before it: there is none to give, and its outcome is OUTSIDE_SECTION.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    ValueError
        Where a point is no departure: not finite, or without a positive speed.
    """
    checked = check_invertible(oscillator)
    phase, speed = (np.array(a) for a in np.broadcast_arrays(*check_departures(t, v, ended=True)))
    lower_impacts, outcome = np.zeros(phase.shape, np.int64), np.zeros(phase.shape, np.int8)
    _undo_all(checked, phase.ravel(), speed.ravel(), lower_impacts.ravel(), outcome.ravel())
    return Impacts(phase, speed, lower_impacts, outcome)
