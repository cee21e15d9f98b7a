"""The impact map P of the piecewise linear model (Eqs. 1, 2; Sec. 3): flights and stays in contact, in turn.

The section is that of `impact_map`: a departure from ``Phi = +beta`` into freeplay at phase t with speed v > 0.
Freeplay is the same in both models, and so are the flights. Where the impacting model reverses the velocity at a wall,
here the gears stay beyond it for a while (`contact_flight`), beyond +beta perhaps for ever.

Every stay beyond -beta ends, and the flight after it reaches +beta: between them the acceleration at every turning
point is positive (Eqs. 8, 31), so one application meets -beta at most once.
"""

import math

from rattle_kernels.contact_flight import stay_in_contact
from rattle_kernels.flight import part_turn
from rattle_kernels.impact_map import LOWER, NOT_CONVERGED, OUTSIDE_SECTION, RETURNED, UPPER, Impact, next_contact
from rattle_kernels.jit import step


@step
def _no_departure(lower_impacts, outcome):
    return Impact(math.nan, math.nan, lower_impacts, outcome)


@step
def next_departure(oscillator, t, v):
    """One application of P, the careful scalar path.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller; finite stiffness. Its ``permanent_after`` says when a stay in linear contact counts as
        permanent.
    t, v : float
        Phase and speed of a departure from +beta.

    Returns
    -------
    Impact
        Outcome RETURNED, PERMANENT_CONTACT, NOT_CONVERGED or OUTSIDE_SECTION; t and v are NaN unless it is the first.
    """
    if not (math.isfinite(t) and math.isfinite(v) and v > 0.0):
        return _no_departure(0, OUTSIDE_SECTION)
    contact = next_contact(oscillator, UPPER, t, -v, 1.0)
    found = contact.found
    lower_impacts = 0
    if contact.wall == LOWER:
        lower_impacts = 1
        reversal = stay_in_contact(oscillator, LOWER, contact.phase, -contact.velocity)
        found = found and reversal.outcome == RETURNED
        if found:
            phase = part_turn(contact.phase) + reversal.duration
            contact = next_contact(oscillator, LOWER, phase, reversal.speed, 1.0)
    if not (found and contact.found):
        return _no_departure(lower_impacts, NOT_CONVERGED)
    stay = stay_in_contact(oscillator, UPPER, contact.phase, max(contact.velocity, 0.0))
    if stay.outcome != RETURNED:
        return _no_departure(lower_impacts, stay.outcome)
    phase = part_turn(contact.phase) + stay.duration
    wrapped = phase - math.floor(phase)
    return Impact(wrapped if wrapped < 1.0 else 0.0, stay.speed, lower_impacts, RETURNED)
