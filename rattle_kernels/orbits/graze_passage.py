"""How a branch of finite stiffness passes a graze: from one chart to another, by way of the graze itself.

The graze is the limit u = 0 of the touch. It is solved for at a speed so small that the orbit, which differs by u^2, is
that at the graze to rounding. Next to it the trace is linear in u: all the way to the first touch that is followed, no
critical value is passed twice.

Where a branch does not get through, Newton's method looks for orbits of the same forcing and impact period, but of
another number of contacts with -beta, at two values of the parameter beside that of the graze: next to it an orbit that
touches -beta is too steep to be followed, a little further off it is not. Those found exist. Whether they lie on the
branch is not known.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.domain import OutsideDomain, check_domain
from rattle_kernels.model.flight import range_at_rest
from rattle_kernels.numerics.pseudo_arclength import LEAST_COSINE, WIDEST, solve, unit_tangent
from rattle_kernels.orbits.chart import GENTLE, Chart, chart_of
from rattle_kernels.orbits.near_graze import approach_above
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit
from rattle_kernels.orbits.station import BranchTask, Station, level_of, station_at
from rattle_kernels.orbits.touching_orbit import touches_of

# Speed of the touch that stands for the graze, in units of a fall through the backlash.
_NOTHING = 1e-10
# A contact shorter than this part of a radian of the ringing changes DP in proportion to its speed.
_LINEAR = 0.1
_WEAKEST = 0.01
# Greatest change of the trace, on its scale, between the graze and the first touch.
_FIRST_CHANGE = 0.2
# Accuracy of a station in scaled unknowns.
_BLUR = 1e-12


class Graze(NamedTuple):
    """A flight's graze: the station of the side that misses, and that of the side that meets -beta."""

    flight: int
    missing: Station
    touching: Station


def _bits(flights: np.ndarray) -> int:
    return sum(1 << int(i) for i in np.flatnonzero(flights))


def due_chart(task: BranchTask, station: Station) -> Chart:
    """The chart in which to go on from a station that is not at a graze."""
    met = station.margin > 0.0
    gentle = met & (station.lower_speed < GENTLE * task.space.scales[1])
    return chart_of(task.space, task.shape, tuple(np.flatnonzero(gentle).tolist()), _bits(~met))


def _write(task: BranchTask, station: Station, chart: Chart) -> np.ndarray:
    """Unknowns of a station's orbit in another chart."""
    value = station.oscillator.value_of(task.parameter)
    if not chart.gentle:
        return task.space.write(station.oscillator, float(station.t[0]), float(station.v[0]))
    touches = touches_of(station.oscillator, station.t, station.v)
    known = (
        dict(zip(station.chart.gentle, station.chart.touches(station.z), strict=True)) if station.chart.gentle else {}
    )
    for flight, (phase, speed) in known.items():
        touches[flight] = phase + round(touches[flight, 0] - phase), speed
    return np.append(touches[list(chart.gentle)], value) / chart.space.scales


def _settled(task: BranchTask, chart: Chart, z: np.ndarray, like: np.ndarray | None = None) -> Station | None:
    """Station at a solution in a chart; its tangent is one of two ways, the one like a motion if one is given."""
    evaluated = chart.system()(z)
    if evaluated is None:
        return None
    tangent = unit_tangent(evaluated[1], np.eye(z.size)[-1])
    station = station_at(task, chart, z, tangent)
    if station is None or like is None:
        return station
    common = 2 * task.shape.upper_contacts
    along = station.motion[:common] @ like[:common] + station.motion[-1] * like[-1]
    return station if along >= 0.0 else turned(station)


def turned(station: Station) -> Station:
    """The station with the other way along the branch."""
    return station._replace(tangent=-station.tangent, motion=-station.motion)


def in_chart(task: BranchTask, station: Station, chart: Chart) -> Station | None:
    """The same orbit in another chart, with the same way along the branch; None if it is not found there."""
    first = _settled(task, chart, _write(task, station, chart), station.motion)
    landed = None if first is None else solve(chart.system(), first.z, first.tangent)
    return None if landed is None else _settled(task, chart, landed.z, station.motion)


def graze_of(task: BranchTask, station: Station, flight: int) -> Graze | None:
    """Graze of a flight, from a station near it on either side; None if Newton's method does not find it."""
    chart = station.chart
    gentle = tuple(sorted({*chart.gentle, flight}))
    touching = chart_of(task.space, task.shape, gentle, chart.shape.over & ~(1 << flight))
    place = 2 * gentle.index(flight) + 1
    guess = _write(task, station, touching)
    guess[place] = _NOTHING
    landed = solve(touching.system(), guess, np.eye(guess.size)[place])
    here = None if landed is None else _settled(task, touching, landed.z)
    if here is None:
        return None
    missing = chart_of(task.space, task.shape, tuple(i for i in gentle if i != flight), chart.shape.over | 1 << flight)
    there = _settled(task, missing, _write(task, here, missing))
    if there is None:
        return None
    margin, lower_speed = there.margin.copy(), there.lower_speed.copy()
    margin[flight] = lower_speed[flight] = 0.0
    there = there._replace(margin=margin, lower_speed=lower_speed)
    way = here if here.tangent[place] > 0.0 else turned(here)
    return Graze(flight, there, way._replace(margin=margin, lower_speed=lower_speed, jacobian=there.jacobian))


def is_between(graze: Graze, before: Station, after: Station) -> bool:
    """Whether a graze lies on the branch between two stations of the chart that misses."""
    chord, apart = after.z - before.z, graze.missing.z - before.z
    if graze.missing.z.shape != chord.shape:
        return False
    apart[:-1:2] -= np.rint(apart[:-1:2] - chord[:-1:2])
    length = float(np.linalg.norm(chord))
    along = float(apart @ chord) / length
    across = float(np.linalg.norm(apart - along * chord / length))
    return -_BLUR <= along <= length + _BLUR and across <= WIDEST * length + _BLUR


def leaving(task: BranchTask, graze: Graze) -> Station | None:
    """The station of the graze from which the branch goes on with a flight that misses -beta."""
    there = graze.missing
    ahead = list[tuple[float, Station]]()
    for way in (there, turned(there)):
        at = station_at(task, there.chart, there.z + 1e-6 * way.tangent, way.tangent)
        if at is not None:
            ahead.append((float(at.margin[graze.flight]), way))
    # Off the branch, as both are, the margin may be negative either way.
    margin, way = min(ahead, key=lambda each: each[0], default=(math.inf, there))
    return way if margin < 0.0 else None


def _layer(task: BranchTask, station: Station) -> float:
    """Speed of a touch, scaled, below which the trace is linear in it."""
    weakest, strongest = range_at_rest(station.oscillator)
    # With harmonics these are bounds only, and the lower one may not be positive.
    weakest = max(weakest, _WEAKEST * strongest)
    return _LINEAR * weakest / math.sqrt(2.0 * station.oscillator.stiffness) / float(task.space.scales[1])


def first_touch(task: BranchTask, graze: Graze) -> Station | None:
    """The first station of the branch that meets -beta beyond a graze; None if it is not found."""
    here = graze.touching
    place = 2 * here.chart.gentle.index(graze.flight) + 1
    speed = _layer(task, here)
    while speed > _NOTHING:
        guess = here.z + here.tangent * (speed - here.z[place]) / here.tangent[place]
        landed = solve(here.chart.system(), guess, np.eye(guess.size)[place])
        there = None if landed is None else _settled(task, here.chart, landed.z)
        if there is not None and abs(level_of(task, there) - level_of(task, graze.missing)) <= _FIRST_CHANGE:
            return there if there.tangent[place] > 0.0 else turned(there)
        speed *= 0.25
    return None


def graze_reached(task: BranchTask, station: Station) -> Graze | None:
    """The graze that a branch has come to with a flight that touches ever more gently; None if it has not."""
    for k, flight in enumerate(station.chart.gentle):
        speed = station.z[2 * k + 1]
        if station.tangent[2 * k + 1] >= 0.0 or speed > _layer(task, station):
            continue
        graze = graze_of(task, station, flight)
        if graze is None:
            continue
        change = abs(level_of(task, station) - level_of(task, graze.missing))
        apart = graze.touching.z - station.z
        apart[:-1:2] -= np.rint(apart[:-1:2])
        # u falls to 0 along the tangent, or nearly so.
        reach = 4.0 * speed / abs(station.tangent[2 * k + 1]) + _BLUR
        # Another graze, of an orbit close by, lies in another direction.
        steady = -float(station.motion @ graze.touching.motion) >= LEAST_COSINE
        if steady and change <= _FIRST_CHANGE and np.abs(apart).max() <= reach:
            return graze
    return None


# Distance of the parameter from that of the graze, scaled. Touches have speeds of some 1e-3 there.
_ASIDE = 1e-6
# Roots of heights above v*(t) to begin with, and rounds of Newton's method.
_ROOTS, _ROUNDS = (1e-3, 1e-2, 1e-1), 20
# Departures of one orbit on both sides: they part like the root of the parameter's distance.
_NEAR = 0.05


class OrbitBeside(NamedTuple):
    """An orbit and the value of the parameter at which it exists."""

    value: float
    orbit: PeriodicOrbit


def values_beside(task: BranchTask, value: float) -> tuple[float, float]:
    """Values of the parameter on both sides of that of a graze.

    Parameters
    ----------
    task : BranchTask
    value : float
        That of the graze.

    Returns
    -------
    (float, float)
    """
    aside = _ASIDE * float(task.space.scales[2])
    return value - aside, value + aside


def orbits_beside(task: BranchTask, last: Station, value: float) -> list[OrbitBeside]:
    """Orbits of the same periods that meet -beta another number of times, next to a graze.

    Parameters
    ----------
    task : BranchTask
    last : Station
        The branch's last one before the graze.
    value : float
        The parameter at the graze.

    Returns
    -------
    list of OrbitBeside
        In order of the parameter; it may be empty.
    """
    scale, contacts = float(task.space.scales[1]), task.shape.upper_contacts
    found = list[OrbitBeside]()
    for there in values_beside(task, value):
        try:
            oscillator = check_domain(last.oscillator.at(**{task.parameter: there}))
        except OutsideDomain:
            continue
        roots = np.repeat(np.sqrt(scale) * np.array(_ROOTS), contacts)
        t, v, period = approach_above(oscillator, np.tile(last.t, len(_ROOTS)), roots, contacts, _ROUNDS, task.pause)
        own = period == contacts
        here = list[PeriodicOrbit]()
        for seed in zip(np.append(t[own], last.t), np.append(v[own], last.v), strict=True):
            orbit = find_periodic_orbit(oscillator, float(seed[0]), float(seed[1]), contacts, scale, pause=task.pause)
            if (
                orbit is not None
                and _is_beside(task, last, orbit)
                and not any(_are_one(orbit, other) for other in here)
            ):
                here.append(orbit)
        found.extend(OrbitBeside(there, orbit) for orbit in here)
    return found


def _is_beside(task: BranchTask, last: Station, orbit: PeriodicOrbit) -> bool:
    same = (orbit.forcing_periods, orbit.upper_contacts) == task.shape[:2]
    if not same or orbit.lower_contacts == int((last.margin > 0.0).sum()):
        return False
    apart = np.subtract.outer(orbit.t, last.t)
    faster = np.subtract.outer(orbit.v, last.v) / task.space.scales[1]
    return bool((np.hypot(apart - np.rint(apart), faster).min(axis=1) < _NEAR).all())


def _are_one(one: PeriodicOrbit, other: PeriodicOrbit) -> bool:
    return one.lower_contacts == other.lower_contacts and bool(np.abs(one.v - other.v).max() < 1e-9)
