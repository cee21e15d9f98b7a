"""Curves of special points in two parameters: of saddle-nodes, period doublings, grazes or contact losses.

If a second parameter q is free, the equations of `bifurcation_point` in (t, v, p) have one more unknown. Their
solutions then form a curve, which `pseudo_arclength` follows. Such curves bound the regions of the (p, q) plane in
which a motion exists or attracts. Where two of them meet (a flight grazes at a saddle-node, say), the impacting model's
map is not smooth and the curve stalls. The stall marks a point of codimension two.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.phase import wrap
from rattle_kernels.numerics.pseudo_arclength import CurvePoint, Steps, System, follow_curve, solve
from rattle_kernels.orbits.bifurcation_point import SpecialPoint, nears_edge_of_domain
from rattle_kernels.orbits.closure import OrbitShape, closure, departures_from
from rattle_kernels.orbits.orbit_equations import SpecialKind, Unknowns, special_system, unknowns

# Turns of an orbit may come closer to each other by this factor a step, and as close as the corrector tells apart.
_LEAST_PART, _TOLD_APART = 0.5, 1e-9

_NOT_FOLLOWED = "curves of grazes and releases are not followed beyond Eq. (8)"


class SpecialCurve(NamedTuple):
    """A curve of special points, in order along it.

    ``values`` (shape (n, 2)) are the values of the two ``parameters``. ``t``, ``v`` (shape (n,)) are the first
    departure, as in `SpecialPoint` (v = 0 for contact loss). ``residual`` (shape (n,)) is the residual of the
    equations. ``ends`` state why the curve ends at its first and last point.
    """

    kind: SpecialKind
    parameters: tuple[str, str]
    values: np.ndarray
    t: np.ndarray
    v: np.ndarray
    residual: np.ndarray
    ends: tuple[str, str]


class _Plane(NamedTuple):
    """The equations, their unknowns, and where to stop."""

    system: System
    space: Unknowns
    shape: OrbitShape
    bounds: np.ndarray
    steps: Steps
    most_points: int
    pause: Pause

    def values(self, z: np.ndarray) -> np.ndarray:
        """The two parameters."""
        pair: np.ndarray = z[-2:] * self.space.scales[-2:]
        return pair

    def where(self, z: np.ndarray) -> str:
        """The two parameters in words."""
        pairs = zip(self.space.parameters, self.values(z), strict=True)
        return ", ".join(f"{name} = {value:.12g}" for name, value in pairs)


def on_bound(system: System, bounds: np.ndarray, before: np.ndarray, beyond: np.ndarray) -> np.ndarray | None:
    """Point of a curve on the bound that lies between two of its points.

    Parameters
    ----------
    system : callable
        The equations of the curve; the two parameters are the last unknowns.
    bounds : ndarray, shape (2, 2)
        Of each parameter, in scaled unknowns.
    before, beyond : ndarray

    Returns
    -------
    ndarray or None
        That which is met first, if both parameters leave their bounds. `before` if Newton's method does not find it.
        None if no bound lies between.
    """
    met = [
        ((bound - before[at]) / (beyond[at] - before[at]), at)
        for at, pair in zip((len(before) - 2, len(before) - 1), bounds, strict=True)
        for bound in pair
        if (before[at] - bound) * (beyond[at] - bound) < 0.0
    ]
    if not met:
        return None
    part, at = min(met)
    landed = solve(system, before + part * (beyond - before), np.eye(len(before))[at])
    return before if landed is None else landed.z


def _stall(plane: _Plane, z: np.ndarray) -> str:
    message = f"no step succeeds at {plane.where(z)}"
    apart = _turns_apart(plane, z)
    if apart < 2.0 * _TOLD_APART:
        return (
            f"{message}; the orbit differs from turns of a shorter one by {apart:.3g} only, too little to be followed"
        )
    read = plane.space.read(z)
    if read is not None and _ends_at_eq_8(plane, read[0]) and nears_edge_of_domain(read[0]):
        return f"the edge of the domain (Eq. 8), at {plane.where(z)}"
    if read is None or not plane.space.with_speed:
        return message
    orbit = departures_from(read[0], plane.space.parameters[0], plane.shape, read[1], read[2])
    margin, _ = grazing_distances(read[0], orbit.t, orbit.v)
    others = np.abs(margin[1:] if plane.shape.over else margin)
    return f"{message}; the other flights are {others.min():.3g} from grazing" if others.size else message


def _ends_at_eq_8(plane: _Plane, oscillator: Oscillator) -> bool:
    """Whether the equations hold below the bound of Eq. (8) alone: those of grazes, and of contacts that last."""
    return bool(plane.shape.over) or not math.isinf(oscillator.stiffness)


def _turns_apart(plane: _Plane, z: np.ndarray) -> float:
    """Least distance, in scaled unknowns, between departures that are one if the orbit is turns of a shorter one."""
    read, (periods, contacts, *_) = plane.space.read(z), plane.shape
    turns = [k for k in range(2, contacts + 1) if contacts % k == periods % k == 0]
    if read is None or not turns or not plane.space.with_speed:
        return math.inf
    orbit = departures_from(read[0], plane.space.parameters[0], plane.shape, read[1], read[2])
    apart = np.array([orbit.t - orbit.t[0], (orbit.v - orbit.v[0]) / plane.space.scales[1]])[
        :, [contacts // k for k in turns]
    ]
    apart[0] -= np.rint(apart[0])
    return float(np.hypot(*apart).min())


def _one_way(plane: _Plane, start: np.ndarray, way: float) -> tuple[list[np.ndarray], str]:
    along = np.zeros(start.size)
    along[-1] = way
    points = [start]

    def accepts(before: CurvePoint, after: CurvePoint) -> bool:
        # Next to a graze of a shorter orbit, longer ones are so close to it that a step could lead there.
        return _turns_apart(plane, after.z) >= max(_TOLD_APART, _LEAST_PART * _turns_apart(plane, before.z))

    for point in follow_curve(plane.system, start, along, plane.steps, accepts):
        plane.pause()
        landed = on_bound(plane.system, plane.bounds / plane.space.scales[-2:, None], points[-1], point.z)
        points.append(point.z if landed is None else landed)
        if landed is not None:
            return points, f"a bound, at {plane.where(landed)}"
        if len(points) > 3 and np.abs(point.z - start).max() < 0.5 * point.step:
            return points, f"back where it began, at {plane.where(start)}"
        if len(points) >= plane.most_points:
            return points, f"as many points as were asked for, at {plane.where(point.z)}"
    found = plane.space.edge_near(points[-1])
    edge = None if found is None else solve(plane.system, *found)
    if edge is not None:
        return [*points, edge.z], f"a bound, at {plane.where(edge.z)}"
    return points, _stall(plane, points[-1])


def smooth_side(point: SpecialPoint, shape: OrbitShape) -> tuple[int, ...] | None:
    """How often -beta must be met on each way, if the map is not smooth across a graze.

    Parameters
    ----------
    point : SpecialPoint
    shape : OrbitShape
        Of the equations that are continued from it.

    Returns
    -------
    tuple of int or None
        None with finite stiffness.
    """
    if not math.isinf(point.oscillator.stiffness):
        return None
    closed = closure(point.oscillator, point.parameter, shape, float(point.t[0]), float(point.v[0]))
    return None if closed is None else closed.lower


def continue_special_point(
    point: SpecialPoint,
    second: str,
    bounds: tuple[float, float],
    second_bounds: tuple[float, float],
    most_points: int = 1000,
    steps: Steps = Steps(),  # noqa: B008 (immutable)
    pause: Pause = never_stopped,
) -> SpecialCurve:
    """Follow a special point as a second parameter varies, in both directions.

    Parameters
    ----------
    point : SpecialPoint
        A special point of a branch.
    second : str
        The second parameter. The first is the point's own.
    bounds, second_bounds : (float, float)
        Values of the first and the second parameter at which to stop.
    most_points : int
        Largest number of points in each direction.
    steps : Steps
        Step sizes in scaled unknowns, as for `continue_orbit`.
    pause : callable
        Called at every point. To stop the work, raise an exception there.

    Returns
    -------
    SpecialCurve
        The part on which the second parameter falls at first, reversed, then the part on which it grows at first. Of a
        graze or a release of loose gears the point alone, with the reason.

    Raises
    ------
    ValueError
        If ``second`` is not a parameter, or is the first one.
    """
    parameters = point.oscillator.parameters
    if second not in parameters or second == point.parameter:
        raise ValueError(f"the second parameter must be another of {', '.join(parameters)}, not {second!r}")
    space = unknowns(point.oscillator, (point.parameter, second), point.kind != SpecialKind.CONTACT_LOSS)
    if point.oscillator.is_loose and point.kind not in (SpecialKind.SADDLE_NODE, SpecialKind.PERIOD_DOUBLING):
        values = np.array([[point.oscillator.value_of(name) for name in space.parameters]])
        there, residual = (point.t[:1], point.v[:1]), np.array([point.residual])
        return SpecialCurve(point.kind, (point.parameter, second), values, *there, residual, (_NOT_FOLLOWED,) * 2)
    shape = OrbitShape(point.forcing_periods, point.upper_contacts, int(point.kind == SpecialKind.GRAZING))
    lower = smooth_side(point, shape) if space.with_speed else None
    system = special_system(point.kind, space, shape, lower)
    plane = _Plane(system, space, shape, np.array([bounds, second_bounds]), steps, most_points, pause)
    start = space.write(point.oscillator, float(point.t[0]), float(point.v[0]))
    falling, growing = (_one_way(plane, start, way) for way in (-1.0, 1.0))
    return _curve(plane, point.kind, falling[0][:0:-1] + growing[0], (falling[1], growing[1]))


def _curve(plane: _Plane, kind: SpecialKind, points: list[np.ndarray], ends: tuple[str, str]) -> SpecialCurve:
    residual = []
    for z in points:
        evaluated = plane.system(z)
        residual.append(np.nan if evaluated is None else float(np.abs(evaluated[0]).max()))
    speeds = [float(z[1] * plane.space.scales[1]) if plane.space.with_speed else 0.0 for z in points]
    return SpecialCurve(
        kind, (plane.space.parameters[0], plane.space.parameters[1]), np.array([plane.values(z) for z in points]),
        np.array([wrap(z[0]) for z in points]), np.array(speeds), np.array(residual), ends,
    )  # fmt: skip
