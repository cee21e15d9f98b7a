"""Continuation of periodic orbits in one parameter, through folds, locating every special point on the way.

The orbit's two equations in (t, v, p) are followed by pseudo-arclength (`pseudo_arclength`) with exact derivatives
(`impact_map.sensitivity`). The tests of `bifurcation_point` are watched from point to point. Where the trace passes one
of its two critical values, a saddle-node or period doubling is located and the branch goes on. Where a flight begins or
ceases to meet -beta, the orbit grazes. In the impacting model DP has a square-root singularity there and the branch
ends: what continues it has another itinerary, another tangent and perhaps the other direction. With finite stiffness
the contact begins so softly (its duration grows with its speed) that DP is continuous, and the branch passes.

A branch that can go no further keeps what it has and reports where it ended and why (`BranchEnd`).
"""

import math
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.oscillator import PARAMETERS, Oscillator, check_domain
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.pseudo_arclength import Steps, System, follow_curve, solve
from rattle_kernels.orbits.bifurcation_point import SpecialPoint, nears_edge_of_domain
from rattle_kernels.orbits.branch_points import (
    BranchTask,
    Station,
    contact_loss_near,
    critical_between,
    distance_to,
    graze_near,
    grazes_between,
    halved_between,
    repeated_graze_near,
    station_at,
)
from rattle_kernels.orbits.closure import OrbitShape
from rattle_kernels.orbits.orbit_equations import closing_system, unknowns
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit


class BranchEnd(StrEnum):
    """Why a branch of orbits ends."""

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
    """Why a branch ends, the parameter's value there, and a message that states both."""

    reason: BranchEnd
    value: float
    message: str


class Branch(NamedTuple):
    """A branch of orbits P(m, n+, .), in order along it.

    ``values`` (shape (n,)) are the parameter's values. ``t``, ``v``, ``grazing_margin`` and ``lower_speed`` (shape (n,
    upper_contacts)) are as in `FoundOrbit`, in order of time from the same departure on. ``trace`` is the trace of DP^p
    and ``area`` its determinant e^{-delta m}. ``special_points`` are in order along the branch. ``ends`` belong to its
    first and its last point.
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


_Side = tuple[list[Station], list[SpecialPoint], End]


def _why_it_stalls(task: BranchTask, station: Station) -> tuple[End, list[SpecialPoint]]:
    """The nearest graze or contact loss that explains the stall, else the edge of the domain, else a plain stall."""
    merged = repeated_graze_near(task, station)
    if merged is not None:
        return _end(task, BranchEnd.GRAZING, merged.value), [merged]
    grazes = [(graze_near(task, station, i), i) for i in range(station.t.size)]
    near = [(distance_to(task, point, station, i), point, BranchEnd.GRAZING) for point, i in grazes if point]
    value = getattr(station.oscillator, task.parameter)
    for point in contact_loss_near(task, station):
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


def _end(task: BranchTask, reason: BranchEnd, value: float) -> End:
    return End(reason, value, f"{reason.value}, at {task.parameter} = {value:.12g}")


def _land(task: BranchTask, before: np.ndarray, beyond: np.ndarray, system: System) -> np.ndarray | None:
    """The branch's point on the bound that lies between two points, if there is one."""
    scale = task.space.scales[-1]
    for bound in task.bounds:
        if (before[-1] * scale - bound) * (beyond[-1] * scale - bound) < 0.0:
            part = (bound / scale - before[-1]) / (beyond[-1] - before[-1])
            landed = solve(system, before + part * (beyond - before), np.array([0.0, 0.0, 1.0]))
            return None if landed is None else landed.z
    return None


def _one_way(task: BranchTask, start: np.ndarray, along: np.ndarray) -> _Side:
    """Follow the branch one way until it ends."""
    stations, points = [station_at(task, start)], list[SpecialPoint]()
    lower = sum(1 << int(i) for i in np.flatnonzero(stations[0].margin > 0)) if task.infinitely_stiff else None
    system = closing_system(task.space, task.shape, lower)
    for point in follow_curve(system, start, along, task.steps):
        task.pause()
        before = stations[-1]
        landed = _land(task, before.z, point.z, system)
        here = station_at(task, point.z if landed is None else landed)
        halved = halved_between(task, before, here)
        if halved is not None:
            return stations, [*points, halved], _end(task, BranchEnd.HALVED, halved.value)
        stations.append(here)
        passed = [*critical_between(task, before, here), *grazes_between(task, before, here)]
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
        From `find_orbits` or `find_periodic_orbit`.
    parameter : str
        ``damping``, ``eccentricity``, ``half_backlash`` or ``stiffness``.
    bounds : (float, float)
        Values of the parameter at which to stop.
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
        If `parameter` or `direction` is not one of those named, or `bounds` exclude the orbit.
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
    task = BranchTask(space, shape, bounds, steps, most_points, pause)
    start = space.write(checked, float(orbit.t[0]), float(orbit.v[0]))
    sides = []
    for name, way in (("down", -1.0), ("up", 1.0)):
        if direction in (name, "both"):
            sides.append(_one_way(task, start, np.array([0.0, 0.0, way])))
        else:
            sides.append(([station_at(task, start)], [], _end(task, BranchEnd.START, value)))
    return _join(task, sides[0], sides[1])


def _join(task: BranchTask, down: _Side, up: _Side) -> Branch:
    """Join the two sides of a branch."""
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
