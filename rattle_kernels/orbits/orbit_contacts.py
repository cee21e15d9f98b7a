"""The contacts of a loose gear one after another, from a departure, from a release or from a touch of either wall."""

from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.arc_flights import next_loose_contact
from rattle_kernels.impact_map.loose_map import leave
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel

# Bounces of this duration, in periods, are told apart no more.
_SHORTEST = 1e-15


class Contacts(NamedTuple):
    """Contacts in order of time, arrays of one shape.

    ``wall`` is UPPER or LOWER, ``after`` the time from the beginning to the contact, ``arrival`` the signed velocity
    there and ``at`` the phase. ``phase`` and ``speed`` are those of the departure that follows. Where bounces
    accumulate and the gear comes to rest, that is its release, and ``chatter`` the time until then, else 0.
    """

    wall: np.ndarray
    after: np.ndarray
    arrival: np.ndarray
    at: np.ndarray
    phase: np.ndarray
    speed: np.ndarray
    chatter: np.ndarray

    @property
    def velocity(self) -> np.ndarray:
        """Signed velocities of the departures."""
        return -self.wall * self.speed

    @property
    def rests(self) -> np.ndarray:
        """Whether the gear comes to rest after each."""
        return self.chatter > 0.0

    @property
    def upper(self) -> np.ndarray:
        """Places of the contacts with +beta."""
        return np.flatnonzero(self.wall > 0.0)

    @property
    def departures(self) -> tuple[np.ndarray, np.ndarray]:
        """Phases and speeds of the departures from +beta."""
        return self.phase[self.upper], self.speed[self.upper]

    def without(self, place: int) -> "Contacts":
        """All contacts but one."""
        return Contacts(*(np.delete(each, place) for each in self))


@kernel
def _fill_contacts(oscillator, wall, phase, velocity, rows):
    """Fill in one row for each contact, of the fields of `Contacts`; how many there are before time is infinite."""
    elapsed = 0.0
    for i in range(rows.shape[0]):
        end = next_loose_contact(oscillator, wall, phase, velocity)
        leaves = leave(oscillator, end.wall, end.phase, oscillator.restitution * abs(end.velocity), np.inf)
        if not (end.found and np.isfinite(leaves.after)):
            return i
        elapsed += end.duration
        row = rows[i]
        row[0], row[1], row[2], row[3] = end.wall, elapsed, end.velocity, end.phase
        row[4], row[5], row[6] = leaves.phase, leaves.speed, leaves.after
        elapsed += leaves.after
        wall, phase, velocity = end.wall, leaves.phase, -end.wall * leaves.speed
    return rows.shape[0]


@kernel
def _rest_left(oscillator, wall, phase, speed, left):
    """Follow bounces until they are as short as rounding: what is then left of a time."""
    while left > 0.0:
        end = next_loose_contact(oscillator, wall, phase, -wall * speed)
        if not (end.found and end.wall == wall and end.duration > _SHORTEST):
            break
        left -= end.duration
        phase, speed = end.phase, oscillator.restitution * abs(end.velocity)
    return left


def rest_after(oscillator: Oscillator, contacts: Contacts, place: int) -> float:
    """How long a gear rests after one of its contacts: from where its bounces accumulate to its release.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller: loose.
    contacts : Contacts
    place : int
        Of a contact after which it rests.

    Returns
    -------
    float
        Forcing periods; at a release rounding leaves some 1e-10, of either sign.
    """
    wall, phase = float(contacts.wall[place]), float(contacts.at[place])
    speed = oscillator.restitution * abs(float(contacts.arrival[place]))
    return float(_rest_left(oscillator, wall, phase, speed, float(contacts.chatter[place])))


def contacts_from(oscillator: Oscillator, wall: float, phase: float, velocity: float, number: int) -> Contacts:
    """Follow a loose gear through a number of contacts; a complete chatter is one.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller: loose.
    wall : float
        UPPER or LOWER, the wall that is left.
    phase, velocity : float
        Phase (any value) and signed velocity; 0 where the gear is pressed away from the wall.
    number : int

    Returns
    -------
    Contacts
        Fewer where the gear stays at rest for ever.
    """
    rows = np.empty((number, len(Contacts._fields)))
    found = _fill_contacts(oscillator, wall, phase, velocity, rows)
    return Contacts(*rows[:found].T)
