"""Continuation of periodic orbits in one parameter, through folds, locating every special point on the way.

The orbit's two equations in (t, v, p) are followed by pseudo-arclength (`pseudo_arclength`) with exact derivatives
(`impact_map.sensitivity`). The tests of `bifurcation_point` are watched from point to point. Where the trace passes one
of its two critical values, a saddle-node or period doubling is located and the branch goes on. Where a flight begins or
ceases to meet -beta, the orbit grazes. In the impacting model DP has a square-root singularity there and the branch
ends: what continues it has another itinerary, another tangent and perhaps the other direction. With finite stiffness
the contact begins so softly (its duration grows with its speed) that DP is continuous, and the branch passes. But DP
turns within 1/kappa of the graze, and the trace may pass its critical values within 1/kappa^2. So the branch stops at
the graze itself and goes on from there, in unknowns in which it is smooth on either side (`chart`, `graze_passage`).

A branch that can go no further keeps what it has and reports where it ended and why (`BranchEnd`). At a graze of finite
stiffness the message says from where on it is not seen, and which orbits exist on the other side.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.pseudo_arclength import CORNER, CurvePoint, Steps, follow_curve, solve, unit_tangent
from rattle_kernels.orbits.bifurcation_point import SpecialPoint, nears_edge_of_domain
from rattle_kernels.orbits.branch import Branch, BranchEnd, End
from rattle_kernels.orbits.branch_points import (
    coincide,
    contact_loss_near,
    distance_to,
    graze_near,
    halved_between,
    point_at,
    points_between,
    repeated_graze_near,
)
from rattle_kernels.orbits.chart import Chart
from rattle_kernels.orbits.closure import OrbitShape, area_factor, closure
from rattle_kernels.orbits.graze_passage import (
    Graze,
    due_chart,
    first_touch,
    graze_of,
    graze_reached,
    in_chart,
    is_between,
    leaving,
    orbits_beside,
    turned,
    values_beside,
)
from rattle_kernels.orbits.loose_graze import loose_graze_near
from rattle_kernels.orbits.orbit_equations import SpecialKind, check_followed, unknowns
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit
from rattle_kernels.orbits.resting_branch import follow_resting_orbit
from rattle_kernels.orbits.station import BranchTask, Station, are_neighbours, on_edge, station_at

# Least step next to a graze, as a part of the least step elsewhere.
_LEAST_TOUCHING = 1e-3
# Corrected points that are less apart are the same, in least steps: a thousand times the corrector's tolerance.
_SAME = 100.0


_Side = tuple[list[Station], list[SpecialPoint], End]


def _why_it_stalls(task: BranchTask, station: Station) -> tuple[End, list[SpecialPoint]]:
    """The nearest graze or contact loss that explains the stall, else the edge of the domain, else a plain stall."""
    value = station.oscillator.value_of(task.parameter)
    if station.oscillator.is_loose:
        lower = sum(station.chart.lower or ())
        graze = loose_graze_near(
            station.oscillator, task.parameter, task.shape.forcing_periods, station.t, station.v, lower
        )
        if graze is not None:
            on_lower = graze.kind == SpecialKind.GRAZING
            return _end(task, BranchEnd.GRAZING if on_lower else BranchEnd.UPPER_GRAZING, graze.value), [graze]
        return _stall(task, station), []
    merged = repeated_graze_near(task, station)
    if merged is not None:
        return _graze_end(task, station, merged.value), [merged]
    grazes = [(graze_near(task, station, i), i) for i in range(station.t.size)]
    near = [(distance_to(task, point, station, i), point, BranchEnd.GRAZING) for point, i in grazes if point]
    for point in contact_loss_near(task, station):
        near.append((abs(point.value - value) / task.space.scales[-1], point, BranchEnd.CONTACT_LOSS))
    if near:
        _, point, reason = min(near, key=lambda candidate: candidate[0])
        end = _end(task, reason, point.value)
        return _graze_end(task, station, point.value) if reason == BranchEnd.GRAZING else end, [point]
    if not task.infinitely_stiff and nears_edge_of_domain(station.oscillator):
        return _end(task, BranchEnd.DOMAIN, value), []
    return _stall(task, station), []


def _stall(task: BranchTask, station: Station) -> End:
    value = station.oscillator.value_of(task.parameter)
    message = (
        f"no step longer than {task.steps.least:g} succeeds at {task.parameter} = {value:.12g}, "
        f"where the trace is {np.trace(station.jacobian):.6g} and the least distance from grazing "
        f"{np.abs(station.margin).min():.3g}"
    )
    return End(BranchEnd.STALLED, value, message)


def _end(task: BranchTask, reason: BranchEnd, value: float) -> End:
    return End(reason, value, f"{reason.value}, at {task.parameter} = {value:.12g}")


def _graze_end(task: BranchTask, last: Station, value: float) -> End:
    """End at a graze: in the impacting model a branch does end there, else the message tells what is known beyond."""
    end = _end(task, BranchEnd.GRAZING, value)
    if task.infinitely_stiff:
        return end
    reached, trace = last.oscillator.value_of(task.parameter), float(np.trace(last.jacobian))
    unseen = (
        f"the branch is followed only to {task.parameter} = {reached:.12g}, where the trace is "
        f"{trace:.6g}; special points from there to the graze and beyond it are not listed"
    )
    return end._replace(message=f"{end.message}: {unseen}; {_beside(task, last, value)}")


def _beside(task: BranchTask, last: Station, value: float) -> str:
    """What is known of the other side of a graze."""
    found = orbits_beside(task, last, value)
    if not found:
        places = " and ".join(f"{there:.12g}" for there in values_beside(task, value))
        return (
            f"no orbit of these periods that meets -beta another number of times is found next to it, at "
            f"{task.parameter} = {places}"
        )
    orbits = ", ".join(
        f"{orbit.name} at {task.parameter} = {there:.12g}, of trace {np.trace(orbit.jacobians[0]):.6g}"
        for there, orbit in found
    )
    return f"next to it there is {orbits}; whether that lies on this branch is not known"


class _Walk:
    """One way along a branch: the stations and special points so far, and those of the step that is tried.

    ``last`` is the last station in the chart in which the branch goes on.
    """

    def __init__(self, task: BranchTask, start: Station) -> None:
        self.task = task
        self.stations, self.points = [start], list[SpecialPoint]()
        self.last = start
        self.tried = _Stretch(start, (), ())

    def accepts(self, _: CurvePoint, point: CurvePoint) -> bool:
        """Whether a point is the next one of the branch, and all that lies on the way to it is located."""
        here = station_at(self.task, self.last.chart, point.z, point.tangent)
        if here is None:
            return False
        graze = None
        if not self.task.infinitely_stiff:
            met = [i for i in range(here.t.size) if here.chart.is_missing(i) and here.margin[i] > 0.0]
            if met:
                graze = graze_of(self.task, here, met[0])
                if len(met) > 1 or graze is None or not is_between(graze, self.last, here):
                    return False
                here = graze.missing if graze.missing.tangent @ point.tangent > 0.0 else turned(graze.missing)
        at_a_corner = self.task.infinitely_stiff and point.step <= CORNER * self.task.steps.least
        if not (at_a_corner or are_neighbours(self.task, self.last, here)):
            return False
        self.tried = self.stretch_to(here)._replace(graze=graze)
        return self.tried.is_located

    def stretch_to(self, here: Station) -> "_Stretch":
        """What lies between the last station and another one of its chart."""
        ends = self.task, self.last, here
        return _Stretch(here, halved_between(*ends), points_between(*ends))

    def goes_to(self, stretch: "_Stretch") -> None:
        """Add a stretch; one that begins on a bound and leads beyond it is empty."""
        if stretch.end is not self.stations[-1]:
            self.stations.append(stretch.end)
            self.last = stretch.end
        self.points.extend(stretch.points or ())

    def turns(self, graze: Graze | None) -> "_Stretch | None":
        """The stretch that leads on from a graze of one's own chart, or to one; None if there is none, or it is lost.

        ``last`` is then the station that it begins with.
        """
        if graze is not None:
            touch = first_touch(self.task, graze)
            if touch is None:
                return None
            self.points.append(self._grazing(graze))
            self.last = graze.touching
            return self.stretch_to(touch)
        reached = graze_reached(self.task, self.last)
        return None if reached is None else self.stretch_to(reached.touching)._replace(graze=reached)

    def leaves(self, graze: Graze) -> bool:
        """Go on from a graze with a flight that misses; False if that is not found."""
        there = leaving(self.task, graze)
        if there is None:
            return False
        self.points.append(self._grazing(graze))
        self.stations[-1] = self.last = there
        return True

    def changes_chart(self) -> bool:
        """Go on in the chart that is due, if it is another one."""
        due = due_chart(self.task, self.last)
        if due.is_like(self.last.chart):
            return False
        there = in_chart(self.task, self.last, due)
        if there is not None:
            self.last = there
        return there is not None

    def _grazing(self, graze: Graze) -> SpecialPoint:
        return point_at(SpecialKind.GRAZING, self.task, graze.missing, 0.0, graze.flight)


class _Stretch(NamedTuple):
    """The next station, the doubling in between where the branch began, and the special points; None if not located.

    ``graze`` is the one that it ends at, if it does.
    """

    end: Station
    halved: tuple[SpecialPoint, ...] | None
    points: tuple[SpecialPoint, ...] | None
    graze: Graze | None = None

    @property
    def is_located(self) -> bool:
        """Whether everything in it is located."""
        return self.halved is not None and self.points is not None


def _land(walk: _Walk, beyond: Station) -> Station | None:
    """The branch's station on the bound that a station lies beyond, if there is one."""
    task, last = walk.task, walk.last
    reached = float(beyond.z[-1] * task.space.scales[-1])
    bound = min(max(reached, task.bounds[0]), task.bounds[1])
    before = last.oscillator.value_of(task.parameter)
    if bound == reached or bound == before:
        return None if bound == reached else last
    guess = last.z + (bound - before) / (reached - before) * (beyond.z - last.z)
    landed = solve(last.chart.system(), guess, np.eye(guess.size)[-1])
    there = None if landed is None else station_at(task, last.chart, landed.z, beyond.tangent)
    # Scaled and back, the bound may be rounded.
    return None if there is None else there._replace(oscillator=there.oscillator.at(**{task.parameter: bound}))


def _one_way(task: BranchTask, start: Station) -> _Side:
    """Follow the branch one way until it ends."""
    walk = _Walk(task, start)
    steps = task.steps
    if not task.infinitely_stiff:
        walk.changes_chart()
        start = walk.last
    while True:
        for point in follow_curve(walk.last.chart.system(), walk.last.z, walk.last.tangent, steps, walk.accepts):
            task.pause()
            stretch = walk.tried
            ended = _goes_on(walk, start, stretch, point)
            if ended is not None:
                return walk.stations, walk.points, ended
            going = _passes(walk, start, stretch, point.step)
            if isinstance(going, End):
                return walk.stations, walk.points, going
            if going is not None:
                steps = going
                break
        else:
            break
    if (edge := on_edge(task, walk.last)) is not None:
        if edge is not walk.last:
            walk.goes_to(walk.stretch_to(edge))
        return walk.stations, walk.points, _end(task, BranchEnd.BOUND, edge.oscillator.value_of(task.parameter))
    end, last = _why_it_stalls(task, walk.last)
    new = [point for point in last if not any(coincide(task, point, passed) for passed in walk.points)]
    return walk.stations, walk.points + new, end


def _goes_on(walk: _Walk, start: Station, stretch: _Stretch, point: CurvePoint) -> End | None:
    """Add a stretch to a branch, as far as its end if that lies on it; the end, if it does."""
    task, before = walk.task, walk.last
    landed = _land(walk, stretch.end)
    if landed is not None:
        stretch = walk.stretch_to(landed)
    if stretch.halved:
        (halved,) = stretch.halved
        walk.points.append(halved)
        return _end(task, BranchEnd.HALVED, halved.value)
    walk.goes_to(stretch)
    value = stretch.end.oscillator.value_of(task.parameter)
    if landed is not None:
        return _end(task, BranchEnd.BOUND, value)
    if len(walk.stations) > 3 and _is_back(task, start, before, walk.last, point.step):
        return _end(task, BranchEnd.CLOSED, value)
    if len(walk.stations) >= task.most_points:
        return _end(task, BranchEnd.POINTS, value)
    return None


def _is_back(task: BranchTask, start: Station, before: Station, here: Station, step: float) -> bool:
    """Whether a step of a branch leads through its start. Another part of the branch may pass close by."""
    if not here.chart.is_like(start.chart) or np.abs(here.z - start.z).max() > step:
        return False
    part = start.tangent @ (start.z - before.z) / (start.tangent @ (here.z - before.z))
    if not 0.0 <= part <= 1.0:
        return False
    there = solve(start.chart.system(), before.z + part * (here.z - before.z), start.tangent)
    return there is not None and bool(np.abs(there.z - start.z).max() <= _SAME * task.steps.least)


def _passes(walk: _Walk, start: Station, stretch: _Stretch, step: float) -> "Steps | End | None":
    """Pass a graze that a branch has come to, or change its chart: the steps with which to go on, or where it ends."""
    task = walk.task
    if task.infinitely_stiff:
        return None
    on = walk.turns(stretch.graze)
    if on is None and stretch.graze is not None:
        return _graze_end(task, walk.last, _value_at(stretch.graze.missing, task))
    if on is None:
        return task.steps._replace(first=step, least=_least(walk, task)) if walk.changes_chart() else None
    if not on.is_located:
        return _graze_end(task, walk.last, _value_at(on.end, task))
    first = float(np.linalg.norm(on.end.z - walk.last.z))
    ended = _goes_on(walk, start, on, CurvePoint(on.end.z, on.end.tangent, first))
    if ended is not None:
        return ended
    if on.graze is not None:
        if not walk.leaves(on.graze):
            return _graze_end(task, walk.last, _value_at(on.end, task))
        first = task.steps.first
    return task.steps._replace(first=first, least=_least(walk, task))


def _value_at(station: Station, task: BranchTask) -> float:
    return station.oscillator.value_of(task.parameter)


def _least(walk: _Walk, task: BranchTask) -> float:
    """Least step: next to a graze speeds of touches count, which are small."""
    return _LEAST_TOUCHING * task.steps.least if walk.last.chart.gentle else task.steps.least


def continue_orbit(
    oscillator: Oscillator,
    orbit: PeriodicOrbit,
    parameter: str,
    bounds: tuple[float, float],
    *,
    direction: str = "both",
    most_points: int = 2000,
    steps: Steps = Steps(),  # noqa: B008 (immutable)
    pause: Pause = never_stopped,
) -> Branch:
    """Follow a periodic orbit as one parameter varies, through folds, and locate its special points.

    Parameters
    ----------
    oscillator : Oscillator
        Either model: the oscillator of the given orbit.
    orbit : PeriodicOrbit
        From `find_orbits` or ``find_periodic_orbit``.
    parameter : str
        One of `Oscillator.parameters`.
    bounds : (float, float)
        Values of the parameter at which to stop; it stops on a closed edge of the domain, too, such as restitution 1.
    direction : {"up", "down", "both"}
        Direction in which the parameter changes first. A fold may reverse it.
    most_points : int
        Largest number of points in each direction.
    steps : Steps
        Step sizes in scaled unknowns: periods, speeds of a fall through the backlash, multiples of the parameter.
    pause : callable
        Called at every point. To stop the work, raise an exception there.

    Returns
    -------
    Branch
        From the end of its downward part to the end of its upward part if both directions are followed.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If ``parameter`` or ``direction`` is not one of those named, ``bounds`` exclude the orbit, or it grazes.
    """
    checked = check_followed(oscillator)
    value = checked.value_of(parameter)
    if direction not in ("up", "down", "both"):
        raise ValueError(f"direction must be up, down or both, not {direction!r}")
    if not bounds[0] <= value <= bounds[1]:
        raise ValueError(f"{parameter} = {value:g} lies outside the bounds {bounds[0]:g} and {bounds[1]:g}")
    space = unknowns(checked, (parameter,))
    shape = OrbitShape(orbit.forcing_periods, orbit.upper_contacts)
    task = BranchTask(space, shape, bounds, steps, most_points, pause)
    if orbit.rests:
        ways = {"down": (-1.0,), "up": (1.0,), "both": (-1.0, 1.0)}[direction]
        return follow_resting_orbit(task, checked, orbit, ways)
    sides = list[_Side]()
    for name, way in (("down", -1.0), ("up", 1.0)):
        start = _first_station(task, space.write(checked, float(orbit.t[0]), float(orbit.v[0])), way)
        closed = bool(sides) and sides[0][2].reason == BranchEnd.CLOSED
        if direction in (name, "both") and not closed:
            sides.append(_one_way(task, start))
        else:
            sides.append(([start], [], sides[0][2] if closed else _end(task, BranchEnd.START, value)))
    return _join(task, sides[0], sides[1])


def _first_station(task: BranchTask, z: np.ndarray, way: float) -> Station:
    """Station of the orbit to begin with; its tangent points to higher or lower values of the parameter.

    Raises
    ------
    ValueError
        If P is not differentiable there.
    """
    chart = Chart(task.space, task.shape)
    evaluated = chart.system()(z)
    tangent = None if evaluated is None else unit_tangent(evaluated[1], np.array([0.0, 0.0, way]))
    start = None if tangent is None else station_at(task, chart, z, tangent)
    if start is not None and task.infinitely_stiff:
        closed = closure(start.oscillator, task.parameter, task.shape, float(start.t[0]), float(start.v[0]))
        start = None if closed is None else start._replace(chart=chart._replace(lower=closed.lower))
    if start is None:
        raise ValueError("the orbit grazes -beta, where P has no derivative: begin a little further along its branch")
    return start


def _join(task: BranchTask, down: _Side, up: _Side) -> Branch:
    """Join the two sides of a branch."""
    stations = down[0][:0:-1] + up[0]
    return Branch(
        task.parameter, task.shape.forcing_periods, task.shape.upper_contacts,
        np.array([at.oscillator.value_of(task.parameter) for at in stations]),
        np.array([at.t for at in stations]), np.array([at.v for at in stations]),
        np.array([at.margin for at in stations]), np.array([at.lower_speed for at in stations]),
        np.array([np.trace(at.jacobian) for at in stations]),
        np.array([area_factor(at.oscillator, task.shape, at.jacobian) for at in stations]),
        tuple(down[1][::-1] + up[1]), (down[2], up[2]),
    )  # fmt: skip
