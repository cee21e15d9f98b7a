"""Grazes of a loose gear's orbit: a minimum on -beta, or a maximum on +beta, from below.

Where a flight just touches a wall, the gear is on it without velocity, at a phase tau at which it is pressed away from
it: a > 0 on -beta, a < 0 on +beta. From there it is followed through the other contacts of the orbit. A time m after
the touch it is there again, with displacement and velocity 0 from that wall:

    y(tau + m) = 0,    y'(tau + m) = 0.

These are two equations in (tau, p). The last flight is evaluated at that time, not followed to a wall. So they are
smooth on both sides: that of the orbits that miss the wall and that of those that meet it, which have one contact more.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.flights import LOWER, UPPER, FlightEnd
from rattle_kernels.impact_map.variations import Jacobian, by_speeds, contact_jacobian, flight_jacobian, multiply
from rattle_kernels.model.contact_end import Contact
from rattle_kernels.model.flight import displacement_rate, rest_acceleration, start_flight, velocity_after
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.phase import wrap
from rattle_kernels.numerics.pseudo_arclength import solve
from rattle_kernels.orbits.bifurcation_point import SpecialPoint
from rattle_kernels.orbits.orbit_contacts import Contacts, contacts_from
from rattle_kernels.orbits.orbit_equations import SpecialKind, unknowns, with_differences

# Samples of a flight among which its turning points are sought, as a first guess.
_SAMPLES = 200
# Where a branch stalls, the flight that grazes is as near to a wall as this part of the backlash, or nearer.
_NEAR = 1e-4
# Distance in scaled unknowns within which such a graze explains the stall. It is a multiple of the speed u of a contact
# that ceases; turns of a shorter orbit merge like a root.
_REACH, _MERGED = 1e-3, 1e-2


class _Touch(NamedTuple):
    """A guess: the wall, the phase, how far from a touch it is, and whether it is one of the contacts."""

    wall: float
    phase: float
    distance: float
    met: bool


@kernel
def _state_after(oscillator, phase, velocity, tau):
    """Displacement from the wall that was left, and velocity."""
    flight = start_flight(oscillator, phase, velocity)
    displacement = tau * displacement_rate(flight, tau)
    return displacement, velocity_after(flight, tau, displacement)


@kernel
def _fill_turns(oscillator, phase, velocity, tau, turns):
    """Fill in time and displacement of the turning points of a flight, roughly, and the acceleration's sign there."""
    flight, number, before = start_flight(oscillator, phase, velocity), 0, velocity
    for i in range(1, _SAMPLES + 1):
        here = tau * i / _SAMPLES
        rate = velocity_after(flight, here, here * displacement_rate(flight, here))
        if before * rate < 0.0 and number < turns.shape[0]:
            there = here - rate * tau / _SAMPLES / (rate - before)
            turns[number, 0], turns[number, 1] = there, there * displacement_rate(flight, there)
            turns[number, 2] = rate - before
            number += 1
        before = rate
    return number


@kernel
def _fill_jacobian(oscillator, contacts, periods, first, derivative):
    """DP^p from the departure after one contact on; the touch is passed over."""
    total, number = Jacobian(1.0, 0.0, 0.0, 1.0), contacts.shape[0]
    for k in range(number):
        here, there = contacts[(first + k) % number], contacts[(first + k + 1) % number]
        duration = there[1] - here[1]
        if duration <= 0.0:
            duration += periods
        velocity = -here[0] * here[5]
        end = FlightEnd(there[0], there[3], duration, there[2], True)
        total = multiply(flight_jacobian(oscillator, here[4], velocity, end), total)
        left = Contact(0.0, there[5], OUTCOME_RETURNED)
        total = multiply(contact_jacobian(oscillator, there[0], there[3], abs(there[2]), left), total)
    one = by_speeds(total)
    derivative[0, 0], derivative[0, 1], derivative[1, 0], derivative[1, 1] = one.tt, one.tv, one.vt, one.vv


@kernel
def _acceleration(oscillator, phase):
    return rest_acceleration(oscillator, phase)


def _touches(oscillator: Oscillator, contacts: Contacts, periods: int) -> list[_Touch]:
    """What nearly is a touch: slow contacts, and turning points of flights next to a wall."""
    found, two_beta, turns = list[_Touch](), 2.0 * oscillator.half_backlash, np.empty((_SAMPLES, 3))
    for i in range(contacts.wall.size):
        after = (i + 1) % contacts.wall.size
        felt = abs(_acceleration(oscillator, contacts.at[i]))
        found.append(_Touch(contacts.wall[i], contacts.at[i], 0.5 * contacts.arrival[i] ** 2 / felt, True))
        duration = (contacts.after[after] - contacts.after[i]) + (periods if after <= i else 0)
        number = _fill_turns(oscillator, contacts.phase[i], contacts.velocity[i], duration, turns)
        for tau, displacement, bend in turns[:number]:
            wall = LOWER if bend > 0.0 else UPPER
            away = displacement if wall == contacts.wall[i] else displacement - wall * two_beta
            found.append(_Touch(wall, contacts.phase[i] + tau, abs(away), False))
    return [touch for touch in found if touch.distance <= _NEAR * two_beta]


def _touching(oscillator: Oscillator, wall: float, tau: float, number: int) -> Contacts | None:
    """The other contacts of an orbit that touches a wall; None where it is pressed to it there, or comes to rest."""
    if wall * _acceleration(oscillator, tau) >= 0.0:
        return None
    contacts = contacts_from(oscillator, wall, tau, 0.0, number)
    return None if contacts.wall.size < number or contacts.rests.any() else contacts


def _solved(
    oscillator: Oscillator, parameter: str, periods: int, touch: _Touch, number: int
) -> tuple[SpecialPoint, Contacts] | None:
    """The graze near a touch of an orbit with so many other contacts, and these; None if there is none."""
    space = unknowns(oscillator, (parameter,), with_speed=False)
    scale = float(unknowns(oscillator, (parameter,)).scales[1])
    two_beta = 2.0 * oscillator.half_backlash

    def gap(z: np.ndarray) -> np.ndarray | None:
        read = space.read(z)
        contacts = None if read is None or not read[0].is_loose else _touching(read[0], touch.wall, read[1], number)
        if read is None or contacts is None or not contacts.after[-1] < periods:
            return None
        rest = periods - float(contacts.after[-1])
        displacement, velocity = _state_after(read[0], contacts.phase[-1], contacts.velocity[-1], rest)
        crossed = 0.5 * (touch.wall - contacts.wall[-1])
        return np.array([(displacement - 2.0 * crossed * read[0].half_backlash) / two_beta, velocity / scale])

    solution = solve(with_differences(gap, space), space.write(oscillator, touch.phase, 0.0))
    read, residual = (None, None) if solution is None else (space.read(solution.z), gap(solution.z))
    contacts = None if read is None else _touching(read[0], touch.wall, read[1], number)
    if solution is None or read is None or residual is None or contacts is None:
        return None
    first, derivative = int(contacts.upper[-1]), np.empty((2, 2))
    _fill_jacobian(read[0], np.column_stack(contacts), float(periods), first, derivative)
    order = np.roll(contacts.upper, 1)
    kind = SpecialKind.GRAZING if touch.wall == LOWER else SpecialKind.UPPER_GRAZING
    point = SpecialPoint(
        kind, parameter, read[0].value_of(parameter), read[0], periods, order.size, number - order.size,
        contacts.phase[order], contacts.speed[order], np.linalg.eigvals(derivative).astype(complex),
        float(np.abs(residual).max()), float(solution.last_step * space.scales[-1]),
    )  # fmt: skip
    return point, contacts


def _distance(
    point: SpecialPoint, touching: Contacts, oscillator: Oscillator, contacts: Contacts, scales: np.ndarray
) -> float:
    """Distance of a graze from an orbit, in scaled unknowns: all its contacts are contacts of the orbit, too."""
    late = np.subtract.outer(touching.at, contacts.at)
    fast = np.subtract.outer(touching.arrival, contacts.arrival) / scales[1]
    others = np.where(touching.wall[:, None] == contacts.wall, 0.0, np.inf)
    apart = np.maximum(np.maximum(np.abs(late - np.rint(late)), np.abs(fast)), others).min(axis=1).max()
    further = abs(point.value - oscillator.value_of(point.parameter)) / scales[2]
    return float(max(apart, further))


def loose_graze_near(
    oscillator: Oscillator, parameter: str, periods: int, t: np.ndarray, v: np.ndarray, lower_contacts: int
) -> SpecialPoint | None:
    """The graze, on either wall, to which an orbit that does not rest is close.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller: loose.
    parameter : str
        Field of `Oscillator` to solve for.
    periods : int
        m, the forcing periods of the orbit.
    t, v : ndarray of float64, shape (n,)
        All its departures.
    lower_contacts : int
        How often it meets -beta.

    Returns
    -------
    SpecialPoint or None
        A graze of several turns of a shorter orbit is that of the shorter one. The first departure is the one after
        which the orbit touches the wall; the touch is not counted among its contacts.
    """
    scales = unknowns(oscillator, (parameter,)).scales
    number = t.size + lower_contacts
    contacts = contacts_from(oscillator, UPPER, float(wrap(t[0])), -float(v[0]), number)
    if contacts.wall.size < number or contacts.rests.any():
        return None
    touches = _touches(oscillator, contacts, periods)
    for turns in range(number, 0, -1):
        near = list[tuple[float, SpecialPoint]]()
        for touch in touches:
            # Of turns that merge some meet the wall, and others just miss it.
            least, most = number - turns + (not touch.met), number - touch.met
            others = most - most % turns
            if periods % turns or others < max(least, turns):
                continue
            found = _solved(oscillator, parameter, periods // turns, touch, others // turns)
            if found is not None:
                near.append((_distance(*found, oscillator, contacts, scales), found[0]))
        distance, point = min(near, key=lambda each: each[0], default=(np.inf, None))
        if distance < (_REACH if turns == 1 else _MERGED):
            return point
    return None
