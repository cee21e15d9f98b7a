"""Branches of periodic orbits in one parameter, through folds, with every special point on the way located.

The orbit's two equations in (t, v, p) are followed by pseudo-arclength (`pseudo_arclength`) with exact derivatives
(`impact_sensitivity`). Between neighbouring points the tests of `special_point` are watched: where the trace passes one
of its two critical values a saddle-node or period doubling is located, and the branch goes on. Where a flight begins or
ceases to meet -beta the orbit grazes. In the impacting model DP has a square root there and the branch ends: what
continues it has another itinerary, another tangent, perhaps the other direction. With finite stiffness the stay at
-beta begins so softly (its duration grows with its speed) that DP is continuous, and the branch passes.

A branch that can go no further says why, as one of `BranchEnd`, and where, and keeps what it has.
"""

import math
from collections.abc import Iterator
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.model.oscillator import PARAMETERS, Oscillator, check_domain
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.pseudo_arclength import Steps, System, follow_curve, solve
from rattle_kernels.orbits.bifurcation_point import (
    SpecialKind,
    SpecialPoint,
    Unknowns,
    closing_system,
    locate,
    nears_edge_of_domain,
    shallowest_in_contact,
    unknowns,
)
from rattle_kernels.orbits.closure import OrbitShape, closure, orbit_from, stability_gap
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit

# A special point that Newton's method finds further away than this, in scaled unknowns, is another one.
_REACH = 0.05
# Departures as close as this to one graze, all of them, have merged there.
_MERGED = 1e-3


class BranchEnd(StrEnum):
    """Why a branch ends, in words."""

    START = "the orbit it began with"
    BOUND = "a bound of the parameter"
    CLOSED = "back where it began"
    GRAZING = "the orbit grazes -beta"
    CONTACT_LOSS = "a stay beyond +beta touches it"
    HALVED = "the orbit is one of half the period, gone through twice"
    DOMAIN = "the edge of the domain (Eq. 8)"
    POINTS = "as many points as were asked for"
    STALLED = "no step succeeds"


class End(NamedTuple):
    """Why a branch ends, at which value of the parameter, and a sentence that says both."""

    reason: BranchEnd
    value: float
    message: str


class Branch(NamedTuple):
    """A branch of orbits P(m, n+, .), in order along it.

    ``values`` (shape (n,)) are the parameter's; ``t``, ``v``, ``grazing_margin`` and ``lower_speed`` (shape (n,
    upper_contacts)) as in `FoundOrbit`, in order of time from the same departure on; ``trace`` is that of DP^p and
    ``area`` its determinant e^{-delta m}. ``special_points`` are in order along the branch, ``ends`` those of its first
    and its last point.
    """

    parameter: str
    forcing_periods: int
    upper_contacts: int
    values: np.ndarray
    t: np.ndarray
    v: np.ndarray
    grazing_margin: np.ndarray
    lower_speed: np.ndarray
    trace: np.ndarray
    area: np.ndarray
    special_points: tuple[SpecialPoint, ...]
    ends: tuple[End, End]

    @property
    def multipliers(self) -> np.ndarray:
        """Eigenvalues of DP^p, complex, shape (n, 2)."""
        root = np.sqrt(self.trace**2 - 4.0 * self.area + 0j)
        large = 0.5 * (self.trace + np.where(self.trace < 0, -root, root))
        return np.column_stack([large, self.area / large])

    @property
    def attracts(self) -> np.ndarray:
        """Whether both multipliers lie inside the unit circle, shape (n,)."""
        return np.abs(self.trace) < 1.0 + self.area


class _Task(NamedTuple):
    """What stays the same along a branch."""

    space: Unknowns
    shape: OrbitShape
    bounds: tuple[float, float]
    steps: Steps
    most_points: int
    pause: Pause

    @property
    def parameter(self) -> str:
        return self.space.parameters[0]

    @property
    def infinitely_stiff(self) -> bool:
        return math.isinf(self.space.oscillator.stiffness)


class _Station(NamedTuple):
    """A point of a branch: the oscillator there, the orbit's departures and their distance from grazing."""

    z: np.ndarray
    oscillator: Oscillator
    t: np.ndarray
    v: np.ndarray
    margin: np.ndarray
    lower_speed: np.ndarray
    jacobian: np.ndarray


_Side = tuple[list[_Station], list[SpecialPoint], End]


def _station(task: _Task, z: np.ndarray) -> _Station:
    read = task.space.read(z)
    assert read is not None  # a point that the system has accepted
    oscillator, t, v = read
    closed = closure(oscillator, task.parameter, task.shape, t, v)
    assert closed is not None
    times, speeds, _ = orbit_from(oscillator, task.shape, t, v)
    margin, lower_speed = grazing_distances(oscillator, times, speeds)
    return _Station(z, oscillator, times, speeds, margin, lower_speed, closed.jacobian)


def _critical_between(task: _Task, before: _Station, after: _Station) -> Iterator[SpecialPoint | None]:
    """Saddle-nodes and doublings between neighbouring points; None for one that was not located."""
    for kind, multiplier in ((SpecialKind.SADDLE_NODE, 1.0), (SpecialKind.PERIOD_DOUBLING, -1.0)):
        gaps = [stability_gap(at.oscillator, task.shape, at.jacobian, multiplier) for at in (before, after)]
        if gaps[0] * gaps[1] < 0.0:
            part = gaps[0] / (gaps[0] - gaps[1])
            read = task.space.read(before.z + part * (after.z - before.z))
            point = None if read is None else locate(kind, read[0], task.parameter, task.shape, *read[1:])
            near = 2.0 * float(np.abs(after.z - before.z).max()) + 1e-6
            yield point if point is not None and _distance(task, point, before, 0) < near else None


def _grazes_between(task: _Task, before: _Station, after: _Station) -> Iterator[SpecialPoint | None]:
    """Flights that began or ceased to meet -beta between neighbouring points (finite stiffness; else branches end)."""
    if task.infinitely_stiff:
        return
    for i in np.flatnonzero((before.margin > 0) != (after.margin > 0)):
        yield _graze_near(task, before, int(i))


def _half_turn(task: _Task, station: _Station) -> np.ndarray:
    """From the first departure to the one half a turn later, in scaled unknowns."""
    half = task.shape.upper_contacts // 2
    apart = station.t[half] - station.t[0]
    return np.array([apart - np.rint(apart), (station.v[half] - station.v[0]) / task.space.scales[1]])


def _halved_between(task: _Task, before: _Station, after: _Station) -> SpecialPoint | None:
    """The doubling at which the branch was born, if it lies between: there both halves of the orbit change places."""
    if task.shape.upper_contacts % 2 or task.shape.forcing_periods % 2:
        return None
    halves = _half_turn(task, before), _half_turn(task, after)
    if halves[0] @ halves[1] >= 0.0:
        return None
    shape = OrbitShape(task.shape.forcing_periods // 2, task.shape.upper_contacts // 2)
    read = task.space.read(0.5 * (before.z + after.z))
    point = None if read is None else locate(SpecialKind.PERIOD_DOUBLING, read[0], task.parameter, shape, *read[1:])
    near = 2.0 * float(np.abs(after.z - before.z).max()) + 1e-6
    return point if point is not None and _distance(task, point, before, 0) < near else None


def _distance(task: _Task, point: SpecialPoint, station: _Station, departure: int) -> float:
    """Distance of a special point's first departure from one of a station's, in scaled unknowns."""
    apart = float(point.t[0]) - float(station.t[departure])
    faster = (float(point.v[0]) - float(station.v[departure])) / task.space.scales[-2]
    further = (point.value - getattr(station.oscillator, task.parameter)) / task.space.scales[-1]
    return max(abs(apart - round(apart)), abs(faster), abs(further))


def _graze_near(task: _Task, station: _Station, departure: int) -> SpecialPoint | None:
    """Graze of one flight, if the orbit there is the branch's: near, and no other flight of it on another side."""
    shape = task.shape._replace(over=True)
    t, v = float(station.t[departure]), float(station.v[departure])
    point = locate(SpecialKind.GRAZING, station.oscillator, task.parameter, shape, t, v)
    if point is None or _distance(task, point, station, departure) > _REACH:
        return None
    others = np.roll(station.margin > 0, -departure)[1:]
    margin, _ = grazing_distances(point.oscillator, point.t, point.v)
    return point if ((margin[1:] > 0) == others).all() else None


def _repeated_graze_near(task: _Task, station: _Station) -> SpecialPoint | None:
    """Graze of a shorter orbit that the branch's becomes several turns of, so that several of its flights graze."""
    for turns in range(task.shape.upper_contacts, 1, -1):
        shape = OrbitShape(task.shape.forcing_periods // turns, task.shape.upper_contacts // turns, True)
        if (shape.forcing_periods * turns, shape.upper_contacts * turns) != task.shape[:2]:
            continue
        for i in range(shape.upper_contacts):
            t, v = float(station.t[i]), float(station.v[i])
            point = locate(SpecialKind.GRAZING, station.oscillator, task.parameter, shape, t, v)
            again = range(i, task.shape.upper_contacts, shape.upper_contacts)
            if point is not None and max(_distance(task, point, station, j) for j in again) < _MERGED:
                return point
    return None


def _contact_loss_near(task: _Task, station: _Station) -> Iterator[SpecialPoint]:
    """Contact losses near a point: a departure about to vanish, or a stay about to split."""
    if task.infinitely_stiff:
        return
    slowest = float(station.t[int(np.argmin(station.v))])
    shallow = shallowest_in_contact(station.oscillator, station.t, station.v)
    for more, t in ((0, slowest), (1, shallow)):
        shape = task.shape._replace(upper_contacts=task.shape.upper_contacts + more)
        if shape.upper_contacts > 1 and math.isfinite(t):
            point = locate(SpecialKind.CONTACT_LOSS, station.oscillator, task.parameter, shape, t, 0.0)
            value = getattr(station.oscillator, task.parameter)
            if point is not None and abs(point.value - value) < _REACH * task.space.scales[-1]:
                yield point


def _why_it_stalls(task: _Task, station: _Station) -> tuple[End, list[SpecialPoint]]:
    """The nearest graze or contact loss that explains why no further step succeeds, else a plain stall."""
    merged = _repeated_graze_near(task, station)
    if merged is not None:
        return _end(task, BranchEnd.GRAZING, merged.value), [merged]
    grazes = [(_graze_near(task, station, i), i) for i in range(station.t.size)]
    near = [(_distance(task, point, station, i), point, BranchEnd.GRAZING) for point, i in grazes if point]
    value = getattr(station.oscillator, task.parameter)
    for point in _contact_loss_near(task, station):
        near.append((abs(point.value - value) / task.space.scales[-1], point, BranchEnd.CONTACT_LOSS))
    if near:
        _, point, reason = min(near, key=lambda candidate: candidate[0])
        return _end(task, reason, point.value), [point]
    if nears_edge_of_domain(station.oscillator):
        return _end(task, BranchEnd.DOMAIN, value), []
    message = (
        f"no step longer than {task.steps.least:g} succeeds at {task.parameter} = {value:.12g}, "
        f"where the trace is {np.trace(station.jacobian):.6g} and the least distance from grazing "
        f"{np.abs(station.margin).min():.3g}"
    )
    return End(BranchEnd.STALLED, value, message), []


def _end(task: _Task, reason: BranchEnd, value: float) -> End:
    return End(reason, value, f"{reason.value}, at {task.parameter} = {value:.12g}")


def _land(task: _Task, before: np.ndarray, beyond: np.ndarray, system: System) -> np.ndarray | None:
    """The branch's point on the bound that was passed between two points, if any was."""
    scale = task.space.scales[-1]
    for bound in task.bounds:
        if (before[-1] * scale - bound) * (beyond[-1] * scale - bound) < 0.0:
            part = (bound / scale - before[-1]) / (beyond[-1] - before[-1])
            landed = solve(system, before + part * (beyond - before), np.array([0.0, 0.0, 1.0]))
            return None if landed is None else landed.z
    return None


def _one_way(task: _Task, start: np.ndarray, along: np.ndarray) -> _Side:
    """Follow the branch one way until it ends."""
    stations, points = [_station(task, start)], list[SpecialPoint]()
    lower = sum(1 << int(i) for i in np.flatnonzero(stations[0].margin > 0)) if task.infinitely_stiff else None
    system = closing_system(task.space, task.shape, lower)
    for point in follow_curve(system, start, along, task.steps):
        task.pause()
        before = stations[-1]
        landed = _land(task, before.z, point.z, system)
        here = _station(task, point.z if landed is None else landed)
        halved = _halved_between(task, before, here)
        if halved is not None:
            return stations, [*points, halved], _end(task, BranchEnd.HALVED, halved.value)
        stations.append(here)
        passed = [*_critical_between(task, before, here), *_grazes_between(task, before, here)]
        points.extend(one for one in passed if one is not None)
        value = getattr(here.oscillator, task.parameter)
        if landed is not None:
            return stations, points, _end(task, BranchEnd.BOUND, value)
        if len(stations) > 3 and np.abs(point.z - start).max() < 0.5 * point.step:
            return stations, points, _end(task, BranchEnd.CLOSED, value)
        if len(stations) >= task.most_points:
            return stations, points, _end(task, BranchEnd.POINTS, value)
    end, last = _why_it_stalls(task, stations[-1])
    return stations, points + last, end


def continue_orbit(
    oscillator: Oscillator,
    orbit: PeriodicOrbit,
    parameter: str,
    bounds: tuple[float, float],
    direction: str = "both",
    most_points: int = 2000,
    steps: Steps = Steps(),  # noqa: B008 (immutable)
    pause: Pause = never_stopped,
) -> Branch:
    """Follow a periodic orbit as one parameter varies, through folds, and locate its special points.

    Parameters
    ----------
    oscillator : Oscillator
        Either model, the one whose orbit is given.
    orbit : PeriodicOrbit
        From `find_orbits` or `find_periodic_orbit`.
    parameter : str
        ``damping``, ``eccentricity``, ``half_backlash`` or ``stiffness``.
    bounds : (float, float)
        Where to stop.
    direction : {"up", "down", "both"}
        Which way the parameter changes first; a fold may turn it.
    most_points : int
        For each way.
    steps : Steps
        In scaled unknowns: periods, falls through the backlash, multiples of the parameter's value.
    pause : callable
        Called at every point; whoever wants the work to stop raises an exception there.

    Returns
    -------
    Branch
        Up from its first point to its last where both ways were asked for.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    ValueError
        Where an argument is none of those named.
    """
    checked = check_domain(oscillator)
    if parameter not in PARAMETERS:
        raise ValueError(f"parameter must be one of {', '.join(PARAMETERS)}, not {parameter!r}")
    if direction not in ("up", "down", "both"):
        raise ValueError(f"direction must be up, down or both, not {direction!r}")
    value = getattr(checked, parameter)
    if not bounds[0] <= value <= bounds[1]:
        raise ValueError(f"{parameter} = {value:g} lies outside the bounds {bounds[0]:g} and {bounds[1]:g}")
    space = unknowns(checked, (parameter,))
    shape = OrbitShape(orbit.forcing_periods, orbit.upper_contacts)
    task = _Task(space, shape, bounds, steps, most_points, pause)
    start = space.write(checked, float(orbit.t[0]), float(orbit.v[0]))
    sides = []
    for name, way in (("down", -1.0), ("up", 1.0)):
        if direction in (name, "both"):
            sides.append(_one_way(task, start, np.array([0.0, 0.0, way])))
        else:
            sides.append(([_station(task, start)], [], _end(task, BranchEnd.START, value)))
    return _join(task, sides[0], sides[1])


def _join(task: _Task, down: _Side, up: _Side) -> Branch:
    """One branch from its two sides."""
    stations = down[0][:0:-1] + up[0]
    return Branch(
        task.parameter, task.shape.forcing_periods, task.shape.upper_contacts,
        np.array([getattr(at.oscillator, task.parameter) for at in stations]),
        np.array([at.t for at in stations]), np.array([at.v for at in stations]),
        np.array([at.margin for at in stations]), np.array([at.lower_speed for at in stations]),
        np.array([np.trace(at.jacobian) for at in stations]),
        np.array([math.exp(-at.oscillator.damping * task.shape.forcing_periods) for at in stations]),
        tuple(down[1][::-1] + up[1]), (down[2], up[2]),
    )  # fmt: skip
