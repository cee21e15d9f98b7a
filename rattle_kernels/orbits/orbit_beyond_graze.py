"""The orbit on the other side of a graze (impacting model): one flight meets -beta instead of missing it.

Seen from +beta, the orbits that meet the wall begin at a graze with an infinite DP, where Newton's method fails. Seen
from the touch they begin smoothly. Let -beta be met at phase t with speed u. The flight up from there, then n+ - 1
applications of P, lead to the departure before the next contact. The flight backwards in time from that contact leads
to the same departure:

    (departure reached forwards from (t, r u)) = (departure reached backwards from (t + m, u)).

These are two equations in (t, u, p), smooth through u = 0, where the graze is. Solved at a small given u, they give the
other orbit and the side of the graze on which it exists. If the orbit that misses is on the opposite side, a motion
merely changes its name. If it is on the same side, the two meet and vanish (a nonsmooth fold).

Where a graze is neutral or resonant of order p (`codimension_two`), the orbit of p turns that hits in one of them folds
and doubles: curves of its saddle-nodes and doublings leave that point, quadratically tangent to the curve of grazes
(Simpson and Ghosh, 2026). Along them the condition, in (t, u) and two parameters, is

    u (trace of DP^(p n+) -+ (1 + its determinant)) = 0,

smooth through u = 0: the trace grows like 1/u. The other turns pass -beta as if it were not there, and a curve is of
orbits that exist where they do miss it.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.flights import LOWER, next_contact
from rattle_kernels.impact_map.sensitivity import next_impact_with_sensitivity
from rattle_kernels.model.domain import check_impacting
from rattle_kernels.model.flight import fall_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.phase import wrap_all
from rattle_kernels.numerics.pseudo_arclength import Steps, follow_curve, solve
from rattle_kernels.orbits.bifurcation_curve import SpecialCurve, on_bound
from rattle_kernels.orbits.bifurcation_point import SpecialPoint
from rattle_kernels.orbits.closure import OrbitShape, closure, departures_from, grazing_speed_at, stability_gap
from rattle_kernels.orbits.codimension_two import CodimensionTwo, CodimensionTwoPoint
from rattle_kernels.orbits.graze_kind import touch_after
from rattle_kernels.orbits.orbit_equations import SpecialKind, Unknowns, unknowns, with_differences
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit


@kernel
def _meeting(oscillator, shape, t, u):
    """Gap in time and speed between the forward and the backward departure, then the backward one."""
    up = next_contact(oscillator, LOWER, t, oscillator.restitution * u, 1.0)
    back = next_contact(oscillator, LOWER, t, -u, -1.0)
    here, speed, elapsed = up.phase, oscillator.restitution * up.velocity, up.duration
    for i in range(1, shape.upper_contacts):
        over = (shape.over >> i) & 1 == 1
        impact, _, _ = next_impact_with_sensitivity(oscillator, 0, here, speed, over)
        if impact.outcome != OUTCOME_RETURNED:
            return np.nan, np.nan, np.nan, np.nan
        here, speed = impact.t, impact.v
        elapsed += impact.duration
    before = abs(back.velocity)
    return elapsed - back.duration - shape.forcing_periods, speed - before, t + back.duration, before


def _touch_phase(oscillator: Oscillator, t: float) -> float:
    return t + touch_after(oscillator, t)[1]


def orbit_beyond_graze(point: SpecialPoint, lower_speed: float = 0.01) -> tuple[Oscillator, PeriodicOrbit] | None:
    """Orbit that meets -beta where the orbit of a graze just touches it.

    Parameters
    ----------
    point : SpecialPoint
        A graze of the impacting model.
    lower_speed : float
        Small speed at which to meet -beta, relative to a fall through the backlash.

    Returns
    -------
    (Oscillator, PeriodicOrbit) or None
        The oscillator that has this orbit, and the orbit. None if Newton's method does not find it.

    Raises
    ------
    OutsideDomain
        If the stiffness is finite: there `continue_orbit` passes the graze by itself.
    ValueError
        If the point is not a graze.
    """
    if point.kind != SpecialKind.GRAZING:
        raise ValueError(f"the point must be a graze, not a {point.kind}")
    oscillator = check_impacting(point.oscillator)
    scale = float(fall_speed(oscillator))
    space = unknowns(oscillator, (point.parameter,))
    shape = OrbitShape(point.forcing_periods, point.upper_contacts)

    def gap(z: np.ndarray) -> np.ndarray | None:
        read = space.read(z)
        if read is None:
            return None
        time, speed, _, _ = _meeting(read[0], shape, read[1], read[2])
        return np.array([time, speed / scale]) if np.isfinite(time) else None

    touch = _touch_phase(oscillator, float(point.t[0]))
    guess = space.write(oscillator, touch, lower_speed * scale)
    solution = solve(with_differences(gap, space), guess, np.array([0.0, 1.0, 0.0]))
    read = None if solution is None else space.read(solution.z)
    if read is None:
        return None
    _, _, t, v = _meeting(read[0], shape, read[1], read[2])
    orbit = find_periodic_orbit(read[0], t, v, shape.upper_contacts, scale)
    return None if orbit is None or orbit.lower_contacts != point.lower_contacts + 1 else (read[0], orbit)


# Speeds at -beta, relative to a fall through the backlash, at which a curve begins.
_GENTLE = (1e-3, 3e-4, 3e-3)
_MULTIPLIERS = {SpecialKind.SADDLE_NODE: 1.0, SpecialKind.PERIOD_DOUBLING: -1.0}


class _Beside(NamedTuple):
    """Orbits of several turns, one of which hits, in z = (t, u/scale, p/scale, q/scale)."""

    multiplier: float
    shape: OrbitShape
    space: Unknowns

    def before(self, z: np.ndarray) -> tuple[float, float]:
        """The departure before the hit."""
        read = self.space.read(z)
        assert read is not None  # it was solved there
        t, v = _meeting(read[0], self.shape, read[1], read[2])[2:]
        return float(t), float(v)

    def equations(self, z: np.ndarray) -> np.ndarray | None:
        """The orbit closes, and one of its multipliers is +1 or -1."""
        read = self.space.read(z)
        if read is None or read[0].is_loose or not read[2] > 0.0:
            return None
        time, faster, t, v = _meeting(read[0], self.shape, read[1], read[2])
        closed = closure(read[0], self.space.parameters[0], self.shape, t, v) if np.isfinite(time) else None
        if closed is None:
            return None
        gap = stability_gap(read[0], self.shape, closed.jacobian, self.multiplier)
        return np.array([time, faster / self.space.scales[1], z[1] * gap])

    def is_admissible(self, z: np.ndarray) -> bool:
        """Whether the flights that pass -beta as if it were not there do miss it."""
        read = self.space.read(z)
        assert read is not None  # it was solved there
        orbit = departures_from(read[0], self.space.parameters[0], self.shape, *self.before(z))
        passing = [i for i in range(self.shape.upper_contacts) if (self.shape.over >> i) & 1]
        return all(orbit.v[i] < grazing_speed_at(read[0], float(orbit.t[i])) for i in passing)


def curve_beside_graze(
    point: CodimensionTwoPoint,
    kind: SpecialKind,
    bounds: tuple[float, float],
    second_bounds: tuple[float, float],
    most_points: int = 1000,
    steps: Steps = Steps(),  # noqa: B008 (immutable)
    pause: Pause = never_stopped,
) -> SpecialCurve | None:
    """Curve of saddle-nodes or doublings that leaves a neutral or a resonant graze (impacting model).

    Parameters
    ----------
    point : CodimensionTwoPoint
        A neutral or a resonant graze.
    kind : SpecialKind
        Saddle-node or period doubling.
    bounds, second_bounds : (float, float)
        Values of the two parameters at which to stop.
    most_points : int
        Largest number of points.
    steps : Steps
        Step sizes in scaled unknowns, as for `continue_orbit`.
    pause : callable
        Called at every point. To stop the work, raise an exception there.

    Returns
    -------
    SpecialCurve or None
        From the point on, of an orbit of so many turns as the order is, one of which hits. It ends where another of
        its turns hits, too. None where the orbits beside the graze are not admissible: where a later turn after an
        impact is thrown below -beta, it hits again.

    Raises
    ------
    OutsideDomain
        If the stiffness is finite.
    ValueError
        If the point is neither neutral nor resonant, or the kind is another.
    """
    if kind not in _MULTIPLIERS:
        raise ValueError(f"curves of saddle-nodes and period doublings leave a graze, none of the kind {kind}")
    if point.kind not in (CodimensionTwo.NEUTRAL_GRAZE, CodimensionTwo.RESONANT_GRAZE):
        raise ValueError(f"the point must be a neutral or a resonant graze, not a {point.kind}")
    oscillator, turns, contacts = check_impacting(point.oscillator), point.order, point.upper_contacts
    others = sum(1 << (turn * contacts) for turn in range(1, turns))
    shape = OrbitShape(turns * point.forcing_periods, turns * contacts, others)
    space = unknowns(oscillator, point.parameters)
    beside = _Beside(_MULTIPLIERS[kind], shape, space)
    system = with_differences(beside.equations, space)
    begin = space.write(oscillator, _touch_phase(oscillator, float(point.t[0])), 0.0)
    speed = np.eye(4)[1]
    tried = (solve(system, begin + gentle * speed, speed) for gentle in _GENTLE)
    first = next((each.z for each in tried if each is not None), None)
    if first is None or not beside.is_admissible(first):
        return None
    window = np.array([bounds, second_bounds]) / space.scales[2:, None]
    points, why = [first], "no step succeeds"
    for each in follow_curve(system, first, first - begin, steps):
        pause()
        if not beside.is_admissible(each.z):
            why = "another turn of the orbit hits -beta"
            break
        landed = on_bound(system, window, points[-1], each.z)
        points.append(each.z if landed is None else landed)
        if landed is not None or len(points) >= most_points:
            why = "as many points as were asked for" if landed is None else "a bound"
            break
    values = np.array([begin, *points])[:, 2:] * space.scales[2:]
    t, v = np.array([(float(point.t[0]), float(point.v[0])), *map(beside.before, points)]).T
    evaluated = [value for z in points if (value := beside.equations(z)) is not None]
    residual = np.array([point.residual, *(float(np.abs(value).max()) for value in evaluated)])
    where = ", ".join(f"{name} = {value:.12g}" for name, value in zip(space.parameters, values[-1], strict=True))
    ends = f"the {point.kind} that it leaves", f"{why}, at {where}"
    return SpecialCurve(kind, point.parameters, values, wrap_all(t), v, residual, ends)
