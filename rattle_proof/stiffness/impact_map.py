"""P of the piecewise linear model in Arb balls: flights as those of the impacting model, contacts between them.

A flight that leaves a wall is the same in both models. Where a(t) > 0 each turning point in freeplay is a minimum, so
arrivals are enclosed as there. A contact takes the place of an impact: it is proven not to end early.
"""

from functools import partial
from typing import NamedTuple

from flint import arb

from rattle_proof.stiffness.contact import Contact, Side, StiffMachine, first_end, lasts
from rattle_proof.verification.flight import Arrivals, Departures, Flight, Slope, arrive, turning
from rattle_proof.verification.impact import Image, Way
from rattle_proof.verification.rough import Rough


class NotProven(Exception):
    """Why something is not proven."""


class Passage(NamedTuple):
    """The image of a set, by speeds, and the slowest speed at which any of it crosses a wall."""

    image: Image
    slowest: arb


def passage(machine: StiffMachine, t: arb, v: arb, all_t: arb, all_v: arb) -> Passage:
    """Enclose the images of departures from +beta: of a point, and of a box that holds it.

    Parameters
    ----------
    machine : StiffMachine
        a(t) > 0.
    t, v : arb
        The point.
    all_t, all_v : arb
        The box.

    Returns
    -------
    Passage
        Times are not reduced.

    Raises
    ------
    NotProven
        Where it cannot be told whether flights meet -beta, or where they or contacts end.
    """
    if not all_v > 0:
        raise NotProven("it reaches down to no speed")
    freeplay = machine.freeplay
    box = Departures(t, -v, all_t, -all_v)
    rough = Rough(freeplay, t, -v)
    turns_at = rough.turn()
    turn = turning(freeplay, box, turns_at)
    if turn is None:
        raise NotProven("a flight's turning point is not enclosed")
    slowest = all_v.lower()
    if turn.height > -freeplay.gap:
        way, slope = Way.CLEAR, None
        rise = _flight(machine, box, arb(0), rough.reach(0.0, turns_at, turns_at), Side.UPPER)
    elif turn.height < -freeplay.gap:
        way = Way.LOWER
        gap = float(freeplay.gap.mid())
        fall = _flight(machine, box, -freeplay.gap, rough.fall(-gap, turns_at), Side.LOWER)
        lower, slope = _contact(machine, Side.LOWER, fall)
        slope = slope.times(fall.slope)
        box = Departures(lower.t, -lower.w, lower.all_t, -lower.all_w)
        rough = Rough(freeplay, box.t, box.w)
        rise = _flight(machine, box, freeplay.gap, rough.reach(gap, 0.0, rough.scale + gap), Side.UPPER)
        slope = rise.slope.times(_signed(slope))
        slowest = slowest.min(fall.all_w.abs_lower()).min(lower.all_w.abs_lower())
    else:
        raise NotProven("it meets the grazing curve")
    upper, after = _contact(machine, Side.UPPER, rise)
    slope = after.times(rise.slope if slope is None else slope)
    # By speeds at both ends, where it has velocities: minus these.
    slope = Slope(slope.tt, -slope.tv, -slope.vt, slope.vv)
    slowest = slowest.min(rise.all_w.abs_lower()).min(upper.all_w.abs_lower())
    return Passage(Image(way, upper.t, -upper.w, upper.all_t, -upper.all_w, slope), slowest)


def _flight(machine: StiffMachine, box: Departures, height: arb, guess: float, at: Side) -> Arrivals:
    found = arrive(partial(Flight, machine.freeplay), box, height, guess, upwards=at is Side.UPPER)
    if found is None:
        raise NotProven("a flight's arrival is not enclosed")
    return found


def _contact(machine: StiffMachine, side: Side, arrivals: Arrivals) -> tuple[Arrivals, Slope]:
    """Ends of contacts that begin with arrivals: the rate of depth, and the slope from velocities of arrival.

    At -beta the speed into the wall is minus the velocity.
    """
    sign = side.value
    box = Departures(arrivals.t, sign * arrivals.w, arrivals.all_t, sign * arrivals.all_w)
    motion = partial(Contact, machine, side)
    guess = first_end(motion(box.t, box.w))
    if guess is None:
        raise NotProven("a contact lasts for longer than a period")
    ends = arrive(motion, box, arb(0), guess, upwards=False)
    if ends is None:
        raise NotProven("the end of a contact is not enclosed")
    if not lasts(motion(box.all_t, box.all_w), ends.tau):
        raise NotProven("a contact may end early")
    slope = ends.slope
    return ends, Slope(slope.tt, sign * slope.tv, slope.vt, sign * slope.vv)


def _signed(slope: Slope) -> Slope:
    """By the velocity of leaving -beta, which is minus the rate of depth."""
    return Slope(slope.tt, slope.tv, -slope.vt, -slope.vv)
