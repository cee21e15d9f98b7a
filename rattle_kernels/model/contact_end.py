"""The first end of a contact, for sure.

The end is the first zero of x after 0. It is reached by steps that provably jump over none: from a point with x > 0, x
stays positive while Taylor's polynomial less a bound on its remainder does. Over all the rest of the contact, the
derivatives of p and the ringing that is left bound those of x: |x''| by (2 pi)^2 P + omega^2 E r, |x'''| by (2 pi)^3 P
+ omega^3 E r, P the swing of p; other orders of the forcing add their own. No zero is possible where p exceeds E r, so
whole oscillations are skipped until p falls to it. Contact is permanent where even the least p exceeds E r. With other
orders of the forcing this least p has no formula: contact is permanent where p exceeds the present E r, which only
falls, all through a period. Below epsilon_crit1 (Eq. 3) the least p is positive; above it every contact ends.
"""

import math
from typing import NamedTuple

from rattle_kernels.model.contact import bend_bound, enter_contact, jerk_bound, state_in_contact
from rattle_kernels.model.flight import TWO_PI
from rattle_kernels.model.outcome import OUTCOME_NOT_CONVERGED, OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.model.slow_harmonics import add_swing
from rattle_kernels.numerics.jit import inlined

# A step as short as this, in radians of the ringing, leaves Taylor's cubic exact to rounding.
_SHORT = 1e-5
# How far beyond the second-order step the third-order step looks; 1.5 to 3 take the same number of steps.
_LOOK_AHEAD = 2.0
# Most contacts take 4 to 6 steps; 4e5 random ones at damping 1e-4 to 1 and kappa 10 to 1e7 took 3,903 at most.
_ALL_STEPS = 2_000_000
# With harmonics a whole period of the slow part is looked at when a contact has lasted half a period, and then each
# time that it has lasted twice as long. So many steps reach past a minimum of a millionth of its swing.
_FIRST_LOOK = 0.5
_CLEAR_STEPS = 4000


class Contact(NamedTuple):
    """A contact, from entering a wall to leaving it: duration, speed of leaving, outcome code; NaN without an end."""

    duration: float
    speed: float
    outcome: int


_ENDLESS = Contact(math.nan, math.nan, OUTCOME_PERMANENT_CONTACT)


@inlined
def _step_from_wall(contact, rate, acceleration, ringing):
    """Step from x = 0, x' >= 0: x/h is at least x' + x'' h/2 - M h^2/6, positive up to its one positive root."""
    third = jerk_bound(contact, ringing) / 6.0
    half = 0.5 * acceleration
    root = math.sqrt(half * half + 4.0 * third * rate)
    if half > 0.0:
        return 0.5 * (half + root) / third
    return 2.0 * rate / (root - half) if rate > 0.0 else 0.0


@inlined
def first_zero(depth, rate, acceleration):
    """First zero ahead of the parabola with these values at 0, for depth > 0; infinite where there is none."""
    square = rate * rate - 2.0 * depth * acceleration
    if square < 0.0 or (rate >= 0.0 and acceleration >= 0.0):
        return math.inf
    root = math.sqrt(square)
    if rate > 0.0:
        return -(rate + root) / acceleration
    return 2.0 * depth / (root - rate)


@inlined
def _sure_step(contact, state):
    """Step within which x stays positive; near a zero it leaves a remainder of third order.

    While h <= H, x''/2 - M h/6 is at least x''/2 - M H/6: a parabola, that of second order or a better one.
    """
    second = first_zero(state.depth, state.rate, -bend_bound(contact, state.ringing))
    horizon = _LOOK_AHEAD * second
    bend = state.acceleration - jerk_bound(contact, state.ringing) * horizon / 3.0
    return max(second, min(horizon, first_zero(state.depth, state.rate, bend)))


@inlined
def _clear_of_parabola(contact, state, ringing):
    """Time for which the slow part exceeds a ringing for sure: it lies above a parabola."""
    above = contact.mean + state.slow - ringing
    bend = add_swing(contact.harmonics, TWO_PI * TWO_PI * contact.swing, 2)
    return first_zero(above, state.slow_rate, -bend) if above > 0.0 else 0.0


@inlined
def _is_clear_for_good(contact, tau, ringing):
    """Whether the slow part exceeds this ringing all through the period that begins at tau."""
    ends = tau + 1.0
    for _ in range(_CLEAR_STEPS):
        ahead = _clear_of_parabola(contact, state_in_contact(contact, tau), ringing)
        tau += ahead
        if ahead == 0.0 or tau > ends:
            return ahead > 0.0
    return False


@inlined
def time_above_ringing(contact, state, ringing):
    """Time for which the slow part exceeds a ringing from here on: there is no zero before it falls to that."""
    if contact.mean + state.slow <= ringing:
        return 0.0
    if len(contact.harmonics) > 0:
        return _clear_of_parabola(contact, state, ringing)
    angle = math.atan2(-state.slow_rate, TWO_PI * state.slow)
    falls = math.acos(min(max((ringing - contact.mean) / contact.swing, -1.0), 1.0))
    return (falls - angle) / TWO_PI


@inlined
def _is_within_reach(contact, state, ahead):
    """Whether the slope stays negative down to a zero (Kantorovich), a step as short as Taylor's cubic allows."""
    if state.depth <= 0.0:
        return True
    steep = state.rate < 0.0 and 2.0 * bend_bound(contact, state.ringing) * state.depth <= state.rate * state.rate
    return steep and ahead * contact.frequency <= _SHORT


@inlined
def _land(tau, state):
    """End of a contact at the zero of Taylor's cubic a short step from `state`, or just before it by rounding."""
    reach = math.sqrt(max(state.rate * state.rate - 2.0 * state.depth * state.acceleration, 0.0)) - state.rate
    ahead = 2.0 * state.depth / reach if reach > 0.0 else 0.0
    slope = state.rate + ahead * (state.acceleration + 0.5 * ahead * state.jerk)
    if slope < 0.0:
        bend = state.acceleration + ahead * state.jerk / 3.0
        change = -(state.depth + ahead * (state.rate + 0.5 * ahead * bend)) / slope
        ahead += change
        slope += change * state.acceleration
    # Rounding may give contacts of hardly any speed the wrong sign of nothing.
    return Contact(max(tau + ahead, 0.0), max(-slope, 0.0), OUTCOME_RETURNED)


@inlined
def end_near(contact, tau):
    """End of a contact that is known to be the zero next to tau; NOT_CONVERGED if it takes more than a short step.

    Parameters
    ----------
    contact : ContactMotion
    tau : float
        Before the end or after it.

    Returns
    -------
    Contact
    """
    state = state_in_contact(contact, tau)
    steep = 2.0 * bend_bound(contact, state.ringing) * abs(state.depth) <= state.rate * state.rate
    if state.rate < 0.0 and steep and abs(state.depth) * contact.frequency <= -_SHORT * state.rate:
        return _land(tau, state)
    return Contact(math.nan, math.nan, OUTCOME_NOT_CONVERGED)


@inlined
def follow_contact(oscillator, side, phase, speed):
    """Follow one contact from its beginning at the wall to its first end.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller. Where its stiffness is infinite, the contact is an impact.
    side : float
        UPPER for linear contact (Phi >= +beta), LOWER for torque reversal (Phi <= -beta).
    phase, speed : float
        Phase (any value) of entering, and speed into the wall, not negative.

    Returns
    -------
    Contact
        Outcome RETURNED, PERMANENT_CONTACT or NOT_CONVERGED.
    """
    if math.isinf(oscillator.stiffness):
        return Contact(0.0, oscillator.restitution * speed, OUTCOME_RETURNED)
    return follow_contact_from(oscillator, side, phase, 0.0, speed)


@inlined
def follow_contact_from(oscillator, side, phase, depth, speed):
    """Follow one contact from anywhere inside it to its first end.

    The bounds on the derivatives of x come from the motion itself, not from where it began. So the steps are as sure
    from inside as from the wall.

    Parameters
    ----------
    oscillator, side, phase
        As in `follow_contact`.
    depth, speed : float
        Depth beyond the wall, not negative, and signed speed into the wall; where the depth is 0, not negative.

    Returns
    -------
    Contact
        As in `follow_contact`. Its duration counts from here, also against ``permanent_after``.
    """
    contact = enter_contact(oscillator, side, phase, depth, speed)
    # Torque reversal always ends (Eq. 31), however long it takes.
    permanent_after = oscillator.permanent_after if side > 0.0 else math.inf
    least = contact.mean - add_swing(contact.harmonics, contact.swing, 0)
    tau, look = 0.0, _FIRST_LOOK
    for steps in range(_ALL_STEPS):
        state = state_in_contact(contact, tau)
        if state.ringing < least:
            break
        if len(contact.harmonics) > 0 and tau >= look:
            if _is_clear_for_good(contact, tau, state.ringing):
                break
            look = 2.0 * tau
        begins = steps == 0 and depth <= 0.0
        if begins or (state.depth <= 0.0 and state.rate >= 0.0 and state.acceleration > 0.0):
            # The start, or a graze from inside that rounding put on the wall: contact goes on.
            ahead = _step_from_wall(contact, state.rate, state.acceleration, state.ringing)
        else:
            ahead = max(_sure_step(contact, state), time_above_ringing(contact, state, state.ringing))
            if _is_within_reach(contact, state, ahead):
                ended = _land(tau, state)
                return ended if ended.duration <= permanent_after else _ENDLESS
        tau += ahead
        if tau > permanent_after:
            break
    else:
        return Contact(math.nan, math.nan, OUTCOME_NOT_CONVERGED)
    return _ENDLESS
