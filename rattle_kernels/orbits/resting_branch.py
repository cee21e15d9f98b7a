"""Branches of superstable orbits: those of loose gears that come to rest on a wall in every turn.

What the motion was is forgotten at the rest. It leaves at the end t* of its arc without speed, and so the orbit is the
motion from the state of release (t*, 0), whatever the parameter. It is followed once for each value: where it comes to
rest on the same arc after as many contacts, with the same ones on the way, it is the orbit. There are no folds and no
equations to solve. The parameter alone is stepped, and steps are halved where contacts move by much. What happens in a
window of the parameter that is narrower than a step is not seen.

The branch ends where the contacts change. That value is enclosed by halving, down to neighbouring numbers: on one side
the orbit is there, on the other it is not. The first contact in which the two sides differ tells why.

- It is a complete chatter on one side, and on the other its bounces go on beyond the arc's end: *release*. At the value
  itself they accumulate at t*, and the rest has shrunk to nothing (`docs/theory/beyond.md`).
- It is there on one side alone, and slow: a graze of its wall. So may a bounce of a chatter graze the other wall.
- It lies on the arc of the rest on one side alone: there the rest begins with it, and the motion's name changes. It
  may move across an end of the arc, or two arcs become one.
- The arc itself is gone: the gear is held. At Gamma = 1 that is where rattle ends.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.flights import LOWER, UPPER
from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.model.arcs import arcs_of
from rattle_kernels.model.domain import OutsideDomain, check_oscillator, closed_edges
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.phase import wrap
from rattle_kernels.orbits.bifurcation_point import SpecialPoint
from rattle_kernels.orbits.branch import Branch, BranchEnd, End
from rattle_kernels.orbits.orbit_contacts import Contacts, contacts_from, rest_after
from rattle_kernels.orbits.orbit_equations import SpecialKind
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit
from rattle_kernels.orbits.station import BranchTask

# Contacts of neighbours differ by less, in periods and falls through the backlash.
_NEAR = 0.05
_GROWTH = 1.5
# A contact that is about to vanish is slower, in falls through the backlash, and a rest shorter, in periods: at
# neighbouring numbers they are some 1e-7.
_SLOW = 1e-3
# A gear that is thrown for a shorter time than this, in periods, moves by less than rounding.
_SHORT = 1e-5
# Bounces of a chatter that fails; later ones are too low to reach the other wall.
_MOST_BOUNCES = 64
_GRAZES = {
    LOWER: (SpecialKind.GRAZING, BranchEnd.GRAZING), UPPER: (SpecialKind.UPPER_GRAZING, BranchEnd.UPPER_GRAZING),
}  # fmt: skip


class _Resting(NamedTuple):
    """An orbit from the release that follows its last contact: its wall and phase, and all its contacts."""

    oscillator: Oscillator
    wall: float
    release: float
    contacts: Contacts


class _Comparison(NamedTuple):
    """An orbit, and its motion at a value of the parameter at which it is none any more."""

    task: BranchTask
    orbit: _Resting
    beyond: float

    @property
    def value(self) -> float:
        """Value of the parameter of the orbit, next to which it is none."""
        return self.orbit.oscillator.value_of(self.task.parameter)


def _release_near(oscillator: Oscillator, wall: float, phase: float) -> float | None:
    """Phase near another one at which a gear on a wall is released; None if there is none within reach."""
    arcs = arcs_of(oscillator)
    if arcs is None or arcs.begin.size < 2:
        return None
    ends = arcs.begin[arcs.sign == -wall]
    apart = ends - phase
    return float(ends[np.abs(apart - np.rint(apart)).argmin()])


def _motion(task: BranchTask, like: _Resting, value: float) -> tuple[Oscillator, float, Contacts] | None:
    """The oscillator at a value, the release there and the contacts after it; None where nothing is released."""
    try:
        oscillator = check_oscillator(like.oscillator.at(**{task.parameter: value}))
    except OutsideDomain:
        return None
    release = _release_near(oscillator, like.wall, like.release)
    if release is None:
        return None
    return oscillator, release, contacts_from(oscillator, like.wall, release, 0.0, like.contacts.wall.size)


def _orbit_at(task: BranchTask, like: _Resting, value: float) -> _Resting | None:
    """The orbit at a value close to that of another one of the branch; None if it is none, or not close to it."""
    motion = _motion(task, like, value)
    if motion is None:
        return None
    oscillator, release, contacts = motion
    known, late = like.contacts, release - like.release
    if contacts.wall.size < known.wall.size or (contacts.wall != known.wall).any():
        return None
    if (contacts.rests != known.rests).any() or contacts.phase[-1] != wrap(release):
        return None
    ends = contacts.after + contacts.chatter
    moved = np.abs([*(contacts.after - known.after), *(ends - known.after - known.chatter), late - np.rint(late)])
    faster = np.abs([*(contacts.arrival - known.arrival), *(contacts.speed - known.speed)]) / task.space.scales[1]
    closes = round(float(ends[-1])) == task.shape.forcing_periods
    near = moved.max() <= _NEAR and faster.max() <= _NEAR
    return _Resting(oscillator, like.wall, release, contacts) if closes and near else None


def _first(oscillator: Oscillator, orbit: PeriodicOrbit) -> _Resting | None:
    """The orbit from its release."""
    number = orbit.upper_contacts + orbit.lower_contacts
    contacts = contacts_from(oscillator, UPPER, float(orbit.t[0]), -float(orbit.v[0]), number)
    rests = np.flatnonzero(contacts.rests)
    if contacts.wall.size < number or not rests.size:
        return None
    wall, release = float(contacts.wall[rests[-1]]), float(contacts.phase[rests[-1]])
    return _Resting(oscillator, wall, release, contacts_from(oscillator, wall, release, 0.0, number))


def _one_way(task: BranchTask, start: _Resting, way: float) -> tuple[list[_Resting], list[SpecialPoint], End]:
    """Follow the branch towards higher or lower values."""
    orbits, scale, step = [start], float(task.space.scales[-1]), task.steps.first
    low, high = closed_edges(task.parameter)
    bound = min(task.bounds[1], high) if way > 0.0 else max(task.bounds[0], low)
    value = start.oscillator.value_of(task.parameter)
    while value != bound:
        task.pause()
        beyond = value + way * step * scale
        if way * (beyond - bound) >= 0.0:
            beyond = bound
        found = _orbit_at(task, orbits[-1], beyond)
        if found is None:
            step *= 0.5
            if step < task.steps.least:
                last, comparison = _enclosed(task, orbits[-1], beyond)
                if last is not orbits[-1]:
                    orbits.append(last)
                return orbits, *_why(comparison)
            continue
        orbits.append(found)
        value, step = beyond, min(_GROWTH * step, task.steps.most)
        if len(orbits) >= task.most_points and value != bound:
            return orbits, [], _end(task, BranchEnd.POINTS, value)
    return orbits, [], _end(task, BranchEnd.BOUND, value)


def _end(task: BranchTask, reason: BranchEnd, value: float) -> End:
    return End(reason, value, f"{reason.value}, at {task.parameter} = {value:.12g}")


def _enclosed(task: BranchTask, last: _Resting, beyond: float) -> tuple[_Resting, _Comparison]:
    """The last orbit of a branch, and the next value of the parameter, at which it is none."""
    while True:
        here = last.oscillator.value_of(task.parameter)
        middle = 0.5 * (here + beyond)
        if middle in (here, beyond):
            return last, _Comparison(task, last, beyond)
        found = _orbit_at(task, last, middle)
        if found is None:
            beyond = middle
        else:
            last = found


def _why(comparison: _Comparison) -> tuple[list[SpecialPoint], End]:
    """What the first contact in which both sides differ says."""
    task, orbit, value = comparison.task, comparison.orbit, comparison.value
    motion = _motion(task, orbit, comparison.beyond)
    late = np.inf if motion is None else abs(motion[1] - orbit.release)
    _, thrown = _arc_at(orbit.oscillator, orbit.release)
    if motion is None or min(late, 1.0 - late) > _NEAR or thrown < _SHORT:
        return [], _end(task, BranchEnd.HELD, value)
    oscillator, _, there = motion
    here = orbit.contacts
    for i in range(min(here.wall.size, there.wall.size)):
        same = here.wall[i] == there.wall[i] and abs(here.after[i] - there.after[i]) <= _NEAR
        if not same:
            return _grazed(comparison, i, here, there)
        if here.rests[i] != there.rests[i]:
            sides = (orbit.oscillator, here), (oscillator, there)
            (own, left), (other, left_there) = (_arc_at(each, float(contacts.at[i])) for each, contacts in sides)
            if own != other or abs(left - left_there) > _NEAR:
                return [], _end(task, BranchEnd.RENAMED, value)
            return _unfinished(comparison, i, *(sides if here.rests[i] else sides[::-1]))
    return _unknown(comparison)


def _arc_at(oscillator: Oscillator, phase: float) -> tuple[float, float]:
    """Sign of a(t) on the arc at a phase, and the time until it ends, as the kernels of chatter see them."""
    arcs, here = arcs_of(oscillator), wrap(phase)
    assert arcs is not None
    number = int(np.searchsorted(arcs.begin, here, side="right"))
    return float(arcs.sign[number - 1]), float(arcs.begin[number % arcs.begin.size] - here) % 1.0


def _unfinished(
    comparison: _Comparison, i: int, whole: tuple[Oscillator, Contacts], part: tuple[Oscillator, Contacts]
) -> tuple[list[SpecialPoint], End]:
    """Why a chatter that is complete on one side is not on the other: the arc ends first, or a bounce grazes a wall."""
    wall, phase, velocity = (float(each[i]) for each in (part[1].wall, part[1].phase, part[1].velocity))
    bounces = contacts_from(part[0], wall, phase, velocity, _MOST_BOUNCES)
    across = np.flatnonzero(bounces.wall != wall)
    slow = across.size and abs(bounces.arrival[across[0]]) <= _SLOW * comparison.task.space.scales[1]
    if slow:
        return _end_at_graze(comparison, i + 1, -wall, comparison.orbit.contacts, float(bounces.arrival[across[0]]))
    left = abs(rest_after(*whole, i))
    if left > _SLOW:
        return _unknown(comparison)
    point = _point(comparison, SpecialKind.RELEASE, comparison.orbit.contacts, left, i)
    return [point], _end(comparison.task, BranchEnd.RELEASE, comparison.value)


def _grazed(comparison: _Comparison, i: int, here: Contacts, there: Contacts) -> tuple[list[SpecialPoint], End]:
    """A graze by the contact that is missing on one side, if it is a slow one."""
    is_own = here.after[i] < there.after[i]
    touch = here if is_own else there
    if abs(touch.arrival[i]) > _SLOW * comparison.task.space.scales[1]:
        return _unknown(comparison)
    missing = here.without(i) if is_own else here
    return _end_at_graze(comparison, i, float(touch.wall[i]), missing, float(touch.arrival[i]))


def _end_at_graze(
    comparison: _Comparison, i: int, wall: float, missing: Contacts, arrival: float
) -> tuple[list[SpecialPoint], End]:
    kind, reason = _GRAZES[wall]
    slow = abs(arrival) / float(comparison.task.space.scales[1])
    return [_point(comparison, kind, missing, slow, i)], _end(comparison.task, reason, comparison.value)


def _unknown(comparison: _Comparison) -> tuple[list[SpecialPoint], End]:
    task, value = comparison.task, comparison.value
    message = (
        f"the orbit is not found beyond {task.parameter} = {value:.17g}, and its contacts there do not tell why: "
        f"{task.parameter} = {comparison.beyond:.17g} is the next number"
    )
    return [], End(BranchEnd.STALLED, value, message)


def _point(comparison: _Comparison, kind: SpecialKind, contacts: Contacts, residual: float, place: int) -> SpecialPoint:
    """A special point; its first departure is the last one before a contact."""
    task, oscillator, upper = comparison.task, comparison.orbit.oscillator, contacts.upper
    order = np.roll(upper, -int(np.searchsorted(upper, place)) + 1)
    return SpecialPoint(
        kind, task.parameter, comparison.value, oscillator, task.shape.forcing_periods, upper.size,
        contacts.wall.size - upper.size, contacts.phase[order], contacts.speed[order], np.zeros(2, complex), residual,
        abs(comparison.beyond - comparison.value),
    )  # fmt: skip


def follow_resting_orbit(
    task: BranchTask, oscillator: Oscillator, orbit: PeriodicOrbit, ways: tuple[float, ...]
) -> Branch:
    """Branch of an orbit that comes to rest.

    Parameters
    ----------
    task : BranchTask
    oscillator : Oscillator
        Checked by the caller: that of the orbit.
    orbit : PeriodicOrbit
    ways : tuple of float
        -1.0 for lower values of the parameter, 1.0 for higher ones, or both.

    Returns
    -------
    Branch
        From its lowest value to its highest.
    """
    start = _first(oscillator, orbit)
    if start is None:
        raise ValueError("the orbit is none of this oscillator: it does not come to rest")
    began = _end(task, BranchEnd.START, oscillator.value_of(task.parameter))
    sides = [_one_way(task, start, way) if way in ways else ([start], [], began) for way in (-1.0, 1.0)]
    (down, before, low), (up, after, high) = sides
    orbits = down[:0:-1] + up
    departures = [each.contacts.departures for each in orbits]
    t, v = (np.array([each[i] for each in departures]) for i in (0, 1))
    distances = [grazing_distances(each.oscillator, *leaving) for each, leaving in zip(orbits, departures, strict=True)]
    margin, lower_speed = (np.array([each[i] for each in distances]) for i in (0, 1))
    values, nothing = np.array([each.oscillator.value_of(task.parameter) for each in orbits]), np.zeros(len(orbits))
    return Branch(
        task.parameter, task.shape.forcing_periods, task.shape.upper_contacts, values, t, v, margin, lower_speed,
        nothing, nothing, tuple(before[::-1] + after), (low, high),
    )  # fmt: skip
