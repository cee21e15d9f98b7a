"""Flights of a loose gear, beyond the bound of Eq. (8): from arc to arc, each contact bracketed.

On an arc a flight turns at most once (`model.arcs`), and the arc brackets where. So it is cut at the ends of arcs and
at its turning points into pieces on which it moves one way only. If the end of a piece lies beyond the wall ahead, the
wall is met on that piece, and once. Otherwise it is not met. There is no step size, and no contact is missed.

The mean of a(t) is positive, so every flight ends. Backwards in time the same holds: there a velocity has the other
sign and grows with ``e^(delta s)``, and the pieces are the same ones.
"""

import math

from rattle_kernels.impact_map.flights import FORWARDS, LOWER, UPPER, FlightEnd, find_crossing, find_return
from rattle_kernels.model.arcs import next_end, sign_before, time_of_end
from rattle_kernels.model.flight import displacement_rate, rest_acceleration, start_flight, velocity_after
from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import part_turn, wrap
from rattle_kernels.numerics.roots import root_finder

# A flight between walls under the mean acceleration takes sqrt(4 beta/(4 pi delta)) periods, of some tens of arcs each.
_MOST_ARCS = 10_000_000


@inlined
def _displacement(flight, tau):
    return tau * displacement_rate(flight, tau) if tau != 0.0 else 0.0


@inlined
def _turning_residual(problem, tau):
    """Velocity, and the acceleration there."""
    oscillator, flight, start = problem
    velocity = velocity_after(flight, tau, _displacement(flight, tau))
    return velocity, rest_acceleration(oscillator, start + tau) - flight.damping * velocity


_find_turning_point = root_finder(_turning_residual)


@inlined
def _beyond(flight, ahead, gap, tau):
    """How far a flight is beyond the wall ahead; if that is the wall that it left, y/tau stands for y."""
    if gap == 0.0:
        return ahead * math.copysign(1.0, tau) * displacement_rate(flight, tau)
    return ahead * _displacement(flight, tau) - gap


@inlined
def _met_on_piece(flight, ahead, gap, begin, end, guess):
    """Time at which a piece meets the wall ahead, and whether it was found: the piece ends beyond that wall."""
    if gap == 0.0:
        grows = ahead * math.copysign(1.0, end) == UPPER  # y/tau has the other sign at tau < 0
        return find_return(flight, begin if grows else end, end if grows else begin, guess)
    negative, positive = (begin, end) if ahead == UPPER else (end, begin)
    return find_crossing((flight, ahead * gap), negative, positive, guess)


@inlined
def _along(arcs, number, direction):
    """Number of the end of an arc that comes after one with this number, and the sign of a(t) on the arc before it."""
    return (number + 1, sign_before(arcs, number)) if direction > 0.0 else (number - 1, sign_before(arcs, number + 1))


@inlined
def next_loose_contact(oscillator, wall, phase, velocity, direction=FORWARDS):
    """Follow one flight of a loose gear from a wall to the next contact with either.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    wall : float
        UPPER or LOWER: the wall that is left.
    phase, velocity : float
        Phase (any value) and signed velocity of the departure: away from the wall, backwards in time towards it.
    direction : float
        FORWARDS or BACKWARDS in time.

    Returns
    -------
    FlightEnd
    """
    two_beta = 2.0 * oscillator.half_backlash
    above, below = (0.0, two_beta) if wall == UPPER else (two_beta, 0.0)
    return next_loose_contact_from(oscillator, above, below, phase, velocity, direction)


@inlined
def next_loose_contact_from(oscillator, above, below, phase, velocity, direction=FORWARDS):
    """Follow one flight of a loose gear from anywhere between the walls to the next contact with either.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    above, below : float
        Distances to +beta and -beta, at least 0; 0 is the wall that is left.
    phase, velocity : float
        Phase (any value) and signed velocity of the beginning: away from a wall that is left, backwards towards it.
    direction : float
        FORWARDS or BACKWARDS in time.

    Returns
    -------
    FlightEnd
        Backwards its duration is negative, and its velocity is that with which the gear left the wall.
    """
    arcs = oscillator.arcs
    start, first = part_turn(phase), wrap(phase)
    flight = start_flight(oscillator, start, velocity)
    begin, number = 0.0, next_end(arcs, first)
    if direction < 0.0:
        number -= 1
        if time_of_end(arcs, number) == first:
            number -= 1
    # The gear moves as it is seen in that direction: backwards a velocity has the other sign, an acceleration has not.
    way, ahead = direction * velocity, _along(arcs, number, direction)[1]
    speed = abs(way)
    if way != 0.0:
        ahead = UPPER if way > 0.0 else LOWER
    for _ in range(_MOST_ARCS):
        end = time_of_end(arcs, number) - first
        number, sign = _along(arcs, number, direction)
        arrives = direction * velocity_after(flight, end, _displacement(flight, end))
        turns = sign != ahead and sign * arrives > 0.0
        stop, found = end, True
        if turns:
            before, after = (begin, end) if sign * direction > 0.0 else (end, begin)
            guess = begin + direction * speed / abs(rest_acceleration(oscillator, start + begin))
            stop, found = _find_turning_point((oscillator, flight, start), before, after, guess)
        gap = above if ahead == UPPER else below
        meets = found and _beyond(flight, ahead, gap, stop) >= 0.0
        guess = begin + direction * gap / speed
        if not meets and found and turns:
            ahead, begin, guess = -ahead, stop, 2.0 * stop
            stop, gap = end, above if ahead == UPPER else below
            meets = _beyond(flight, ahead, gap, stop) >= 0.0
        if meets:
            tau, found = _met_on_piece(flight, ahead, gap, begin, stop, guess)
            # Where the wall is just touched rounding may leave the wrong sign of nothing.
            arrival = ahead * max(ahead * direction * velocity_after(flight, tau, ahead * gap), 0.0)
            return FlightEnd(ahead, start + tau, tau, direction * arrival, found)
        if not found:
            break
        begin, speed = end, abs(arrives)
        if arrives != 0.0:
            ahead = UPPER if arrives > 0.0 else LOWER
    return FlightEnd(UPPER, math.nan, math.nan, math.nan, False)
