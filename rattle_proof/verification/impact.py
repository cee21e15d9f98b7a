"""Enclosures of the impact map P: images of all departures from +beta of a box, and DP over it.

Flights are simple because a(t) > 0. Where y' = 0, y'' > 0: so every turning point is a minimum. A flight downwards has
one, falls until then and rises for ever after; a flight upwards rises for ever. Hence the return to +beta has one root,
a root of y = -2 beta with y' < 0 is the first, and that of y = 2 beta upwards is the only one.
"""

from enum import Enum
from functools import partial
from typing import NamedTuple

from flint import arb

from rattle_proof.verification.flight import Arrivals, Departures, Flight, Slope, Turn, arrive, turning
from rattle_proof.verification.machine import Machine, ball
from rattle_proof.verification.rough import Rough


class Way(Enum):
    """What the flights of a box do."""

    CLEAR = "keep clear of -beta"
    LOWER = "meet -beta"
    GRAZING = "may do either"


class Image(NamedTuple):
    """Images of the middle and of all; the derivative, None where the flights may do either."""

    way: Way
    t: arb
    v: arb
    all_t: arb
    all_v: arb
    slope: Slope | None


def image(machine: Machine, t: arb, v: arb, all_t: arb, all_v: arb) -> Image | None:
    """Enclose the image of a box of departures from +beta.

    Parameters
    ----------
    machine : Machine
        a(t) > 0.
    t, v : arb
        Time and speed of a point in the box.
    all_t, all_v : arb
        The box.

    Returns
    -------
    Image or None
        None where nothing is proven. Times are not reduced.
    """
    if not all_v > 0:
        return None
    box = Departures(t, -v, all_t, -all_v)
    rough = Rough(machine, t, -v)
    turn_guess = rough.turn()
    turn = turning(machine, box, turn_guess)
    if turn is None:
        return None
    if turn.height > -machine.gap:
        return _return(machine, box, rough, turn_guess)
    if turn.height < -machine.gap:
        return _by_way_of_lower(machine, box, rough, turn_guess)
    return _either(machine, box, rough, turn_guess, turn)


def _after(machine: Machine, way: Way, arrivals: Arrivals, before: Slope | None = None) -> Image:
    """Departures from +beta, by speeds, after an impact with it; `before` is the slope of what came before."""
    kept = machine.restitution
    slope = arrivals.slope
    slope = Slope(slope.tt, slope.tv, kept * slope.vt, kept * slope.vv)
    if before is not None:
        slope = slope.times(before)
    # Departures were by their velocities: minus the speeds.
    slope = Slope(slope.tt, -slope.tv, slope.vt, -slope.vv)
    return Image(way, arrivals.t, kept * arrivals.w, arrivals.all_t, kept * arrivals.all_w, slope)


def _return(machine: Machine, box: Departures, rough: Rough, turn: float) -> Image | None:
    arrivals = arrive(partial(Flight, machine), box, arb(0), rough.reach(0.0, turn, turn), upwards=True)
    return None if arrivals is None else _after(machine, Way.CLEAR, arrivals)


def _rise(machine: Machine, box: Departures) -> Arrivals | None:
    """From -beta to +beta."""
    gap = float(machine.gap.mid())
    rough = Rough(machine, box.t, box.w)
    guess = rough.reach(gap, 0.0, rough.scale + gap)
    return arrive(partial(Flight, machine), box, machine.gap, guess, upwards=True)


def _by_way_of_lower(machine: Machine, box: Departures, rough: Rough, turn: float) -> Image | None:
    gap = float(machine.gap.mid())
    if rough.height(turn) >= -gap:
        return None
    fall = arrive(partial(Flight, machine), box, -machine.gap, rough.fall(-gap, turn), upwards=False)
    if fall is None:
        return None
    kept = -machine.restitution
    slope = Slope(fall.slope.tt, fall.slope.tv, kept * fall.slope.vt, kept * fall.slope.vv)
    rise = _rise(machine, Departures(fall.t, kept * fall.w, fall.all_t, kept * fall.all_w))
    return None if rise is None else _after(machine, Way.LOWER, rise, slope)


def _either(machine: Machine, box: Departures, rough: Rough, turn_guess: float, turn: Turn) -> Image | None:
    """The hull of both: those that clear -beta fly as if it were not there, those that meet it do so slowly."""
    over = _return(machine, box, rough, turn_guess)
    if over is None:
        return None
    met = _slow_impacts(machine, box, turn)
    if met is None:
        return None
    rise = _rise(machine, Departures(met.all_t.mid(), met.all_w.mid(), met.all_t, met.all_w))
    if rise is None:
        return None
    below = _after(machine, Way.GRAZING, rise)
    return Image(Way.GRAZING, over.t, over.v, over.all_t.union(below.all_t), over.all_v.union(below.all_v), None)


def _slow_impacts(machine: Machine, box: Departures, turn: Turn) -> Departures | None:
    """Departures from -beta of those flights that meet it.

    A flight would fall further from there by no more than some depth d, had -beta not been there. On that way y'' =
    a - delta y' and y' <= 0. So from ``(y'^2)' = 2 y'' y'`` the speed u there has ``u^2 <= 2 d (max a + delta u)``, and
    the way takes no longer than ``sqrt(2 d/min a)``.
    """
    depth = (-machine.gap - turn.height).upper().nonnegative_part()
    least = arb(machine.least_acceleration)
    for _ in range(2):
        before = (2 * depth / least).sqrt()
        times = ball((turn.t - before).lower().max(box.all_t.lower()), turn.t.upper())
        felt = machine.acceleration(times)
        least = felt.lower().max(least)
    drag = machine.damping * depth
    fastest = (drag + (drag * drag + 2 * depth * felt).sqrt()).upper()
    if not fastest.is_finite():
        return None
    speeds = machine.restitution * ball(0, fastest)
    return Departures(times.mid(), speeds.mid(), times, speeds)
