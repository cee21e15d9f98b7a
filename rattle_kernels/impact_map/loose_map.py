"""P of a loose gear, beyond the bound of Eq. (8): any number of contacts with -beta, rest and release on both walls.

P leads from a departure from +beta to the next one, as everywhere. On the way -beta may be met any number of times.

*The piecewise linear model.* Each contact is followed to its first end (`contact_end`), which asks for no sign of a(t).
None with -beta is permanent: the slow part there has the mean ``-4 pi delta/(2 kappa)``, and the ringing dies away. One
with +beta may be, where quiet solutions exist. Nothing rests: a contact takes the time that its spring needs.

*The impacting model.* Where bounces on -beta accumulate before their arc ends (`complete_chatter`), the gear rests
there and leaves when the arc ends, with no speed. All bounces of such a chatter count as one contact.

Where bounces on +beta accumulate, the next departure is the release, at the end of the arc: a chatter is one contact
there, too. So all motions that have come to rest on one arc leave as one. A release has no speed, and departures have
one: it is written as RELEASED, the square of which is 0. `contact_by_contact` is P without that: it leads to the next
bounce.
"""

import math
from typing import NamedTuple

from rattle_kernels.impact_map.arc_flights import next_loose_contact
from rattle_kernels.impact_map.complete_chatter import accumulates
from rattle_kernels.impact_map.flights import BACKWARDS, LOWER, UPPER
from rattle_kernels.impact_map.variations import Jacobian, by_speeds, contact_jacobian, flight_jacobian, multiply
from rattle_kernels.model.arcs import is_pressed, phase_of_release, time_to_release
from rattle_kernels.model.contact_end import Contact, follow_contact
from rattle_kernels.model.outcome import (
    OUTCOME_NOT_CONVERGED,
    OUTCOME_OUTSIDE_SECTION,
    OUTCOME_PERMANENT_CONTACT,
    OUTCOME_RETURNED,
)
from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import part_turn, wrap

RELEASED = 1e-300
"""Speed of a departure that is a release: no other is as slow."""

MOST_CONTACTS = 100_000
"""On -beta within one application. Elastic bounces that start with no speed never end."""


class Impact(NamedTuple):
    """One application of P to one point: the next departure, contacts with -beta on the way, how it ended, how long.

    ``t``, ``v`` and ``duration`` (forcing periods) are NaN unless the outcome is RETURNED.
    """

    t: float
    v: float
    lower_impacts: int
    outcome: int
    duration: float


class LooseImpact(NamedTuple):
    """An application of P to a loose gear: the impact, and whether the gear has come to rest on -beta on the way."""

    impact: Impact
    rests_below: bool


class Departure(NamedTuple):
    """What comes of a contact: a departure after some time.

    ``after`` is 0 for an impact, until the release for a rest, infinite where the contact never ends, and NaN where its
    end was not found.
    """

    phase: float
    speed: float
    after: float
    rests: bool


@inlined
def leave(oscillator, wall, phase, speed, jumps_below):
    """What comes of an impact; of finite stiffness, how a flight has ended, before the contact.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    wall, phase, speed : float
        UPPER or LOWER, the phase (any value), and the speed that the impact leaves.
    jumps_below : float
        Of a lower speed, a gear whose bounces accumulate departs next at its release.

    Returns
    -------
    Departure
    """
    phase = wrap(phase)
    rests = speed < jumps_below and accumulates(oscillator, wall, phase, speed)
    # Less than the speed of a release is none.
    if not speed >= RELEASED:
        speed, rests = RELEASED, math.isinf(oscillator.stiffness) and is_pressed(oscillator.arcs, wall, phase)
    if not rests:
        return Departure(phase, speed, 0.0, False)
    return Departure(phase_of_release(oscillator.arcs, phase), RELEASED, time_to_release(oscillator.arcs, phase), True)


@inlined
def leave_contact(oscillator, wall, phase, speed):
    """What comes of a contact of finite stiffness.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    wall, phase, speed : float
        UPPER or LOWER, the phase (any value), and the speed of entering.

    Returns
    -------
    Departure
        One that rounding has left without a speed has RELEASED.
    """
    contact = follow_contact(oscillator, wall, phase, speed)
    after = math.inf if contact.outcome == OUTCOME_PERMANENT_CONTACT else contact.duration
    return Departure(wrap(part_turn(phase) + contact.duration), max(contact.speed, RELEASED), after, False)


@inlined
def _variation(oscillator, wall, phase, velocity, end, departure):
    """Derivative over a flight and the contact after it, by (time, signed velocity); a rest forgets both."""
    if departure.rests:
        return Jacobian(0.0, 0.0, 0.0, 0.0)
    ended = Contact(departure.after, departure.speed, OUTCOME_RETURNED)
    contact = contact_jacobian(oscillator, wall, end.phase, abs(end.velocity), ended)
    return multiply(contact, flight_jacobian(oscillator, phase, velocity, end))


@inlined
def _lost(lower_impacts, outcome):
    return LooseImpact(Impact(math.nan, math.nan, lower_impacts, outcome, math.nan), False)


@inlined
def _follow(oscillator, t, v, jumps_below, most_contacts=MOST_CONTACTS):
    """P and DP; of a lower speed, a motion that chatters to rest on +beta departs next at its release."""
    jacobian = Jacobian(1.0, 0.0, 0.0, 1.0)
    if not (math.isfinite(t) and math.isfinite(v) and v > 0.0):
        return _lost(0, OUTCOME_OUTSIDE_SECTION), jacobian
    wall, phase, velocity, elapsed, rests_below = UPPER, t, -v, 0.0, False
    for lower_impacts in range(most_contacts + 1):
        end = next_loose_contact(oscillator, wall, phase, velocity)
        if not end.found:
            return _lost(lower_impacts, OUTCOME_NOT_CONVERGED), jacobian
        upper = end.wall == UPPER
        speed = oscillator.restitution * abs(end.velocity)
        if math.isinf(oscillator.stiffness):
            leaves = leave(oscillator, end.wall, end.phase, speed, jumps_below if upper else math.inf)
        else:
            leaves = leave_contact(oscillator, end.wall, end.phase, speed)
        elapsed += end.duration + leaves.after
        if not math.isfinite(elapsed):
            outcome = OUTCOME_PERMANENT_CONTACT if elapsed == math.inf else OUTCOME_NOT_CONVERGED
            return _lost(lower_impacts, outcome), jacobian
        jacobian = multiply(_variation(oscillator, end.wall, phase, velocity, end, leaves), jacobian)
        if upper:
            impact = Impact(leaves.phase, leaves.speed, lower_impacts, OUTCOME_RETURNED, elapsed)
            return LooseImpact(impact, rests_below), jacobian
        rests_below = rests_below or leaves.rests
        wall, phase, velocity = LOWER, leaves.phase, leaves.speed
    return _lost(most_contacts, OUTCOME_NOT_CONVERGED), jacobian


@inlined
def contact_by_contact(oscillator, t, v, most_contacts=MOST_CONTACTS):
    """One application of P, to the next departure from +beta, however low the bounce.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    t, v : float
        Phase and speed of a departure from +beta.
    most_contacts : int
        With -beta; after more the outcome is NOT_CONVERGED.

    Returns
    -------
    LooseImpact
    """
    loose, _ = _follow(oscillator, t, v, 0.0, most_contacts)
    return loose


@inlined
def next_loose_impact(oscillator, t, v):
    """One application of P: to the next departure from +beta, or to the release where the motion comes to rest.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    t, v : float
        Phase and speed of a departure from +beta.

    Returns
    -------
    Impact
    """
    loose, _ = _follow(oscillator, t, v, math.inf)
    return loose.impact


@inlined
def next_loose_impact_with_jacobian(oscillator, t, v):
    """One application of P as `next_loose_impact`, and its derivative.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    t, v : float
        Phase and speed of a departure from +beta.

    Returns
    -------
    (Impact, Jacobian)
        DP is 0 where the motion comes to rest: what it was is forgotten.
    """
    loose, jacobian = _follow(oscillator, t, v, math.inf)
    return loose.impact, by_speeds(jacobian)


@inlined
def _undo(oscillator, wall, phase, velocity, most_contacts):
    """The last departure from +beta before a wall was left, met or touched, by the way back."""
    elapsed = 0.0
    for lower_impacts in range(most_contacts + 1):
        end = next_loose_contact(oscillator, wall, phase, velocity, BACKWARDS)
        if not end.found:
            break
        phase, elapsed = wrap(end.phase), elapsed + end.duration
        if end.wall == UPPER:
            return Impact(phase, abs(end.velocity), lower_impacts, OUTCOME_RETURNED, elapsed)
        wall, velocity = LOWER, -abs(end.velocity) / oscillator.restitution
    return _lost(0, OUTCOME_NOT_CONVERGED).impact


@inlined
def previous_loose_impact(oscillator, t, v, most_contacts=MOST_CONTACTS):
    """One application of the inverse of `contact_by_contact`, by the way back.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    t, v : float
        Phase and speed of a departure from +beta. Before a release there are infinitely many: it is refused.
    most_contacts : int
        With -beta; after more the outcome is NOT_CONVERGED.

    Returns
    -------
    Impact
        Its duration is negative.
    """
    if not (math.isfinite(t) and math.isfinite(v) and v > RELEASED):
        return _lost(0, OUTCOME_OUTSIDE_SECTION).impact
    # Backwards a departure is first the arrival before its impact.
    return _undo(oscillator, UPPER, t, v / oscillator.restitution, most_contacts)


@inlined
def departure_before_touch(oscillator, wall, phase, most_contacts):
    """The last departure before a flight just touches a wall, from between the walls.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    wall, phase : float
        UPPER or LOWER, and a phase (any value) at which a(t) presses away from between: negative on +beta, positive on
        -beta.
    most_contacts : int
        With -beta on the way; after more the outcome is NOT_CONVERGED.

    Returns
    -------
    Impact
        Its duration is negative.
    """
    return _undo(oscillator, wall, phase, 0.0, most_contacts)
