"""Special points on a branch: between two neighbouring stations, and near the point where it stalls.

Between neighbours a test function changes sign: the distance of the trace from a critical value, or the difference
between an orbit's halves. Newton's method on the equations of the special point starts from where the sign is expected
to change. Its result counts only if it lies between the two stations. Otherwise the stretch of the branch is halved,
and so on. Where the branch is followed from touches of -beta, next to a graze of finite stiffness, the departures are
alike to rounding all along a stretch: there it is always halved.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.numerics.pseudo_arclength import WIDEST, solve
from rattle_kernels.orbits.bifurcation_point import (
    SpecialPoint,
    describe_point,
    point_near,
    shallowest_in_contact,
)
from rattle_kernels.orbits.chart import Chart, chart_of
from rattle_kernels.orbits.closure import OrbitShape, stability_gap
from rattle_kernels.orbits.orbit_equations import SpecialKind
from rattle_kernels.orbits.station import BranchTask, Station, station_at, station_between

# Near a graze the trace is like the inverse of the distance to it. It multiplies the errors of a corrected point, some
# 1e-13. So a branch comes as close as their root, 1e-6 or less, and stalls.
_REACH = 1e-5
# A contact that splits does so far from all departures. Its parameter lies within this part of that of the stall.
_REACH_OF_LOSS = 0.05
# Departures that all lie within this distance of one graze have merged there.
_MERGED = 1e-3
# At a saddle-node the departure is known to the root of rounding only.
_BLUR = 1e-7
# A stretch of a branch of this length is a point.
_NARROW = 1e-15
# The corrector errs by no more than that, seen from touches.
_ERRING = 1e-10
# Steps of the secant method along the speed of a touch, of which the trace is nearly a linear function.
_MOST_SECANTS = 30


class _Test(NamedTuple):
    """A test function, and the special point that its change of sign shows, with one departure of its orbit."""

    kind: SpecialKind
    shape: OrbitShape
    departure: int
    value: Callable[[Station], float]


def _departure(task: BranchTask, station: Station, number: int) -> np.ndarray:
    """Phase and speed of a departure and the parameter, in scaled unknowns."""
    values = [station.t[number], station.v[number], station.oscillator.value_of(task.parameter)]
    return np.array(values) / task.space.scales


class _Place(NamedTuple):
    """Where a special point lies: its distances along and across the chord between stations, and the chord's length."""

    along: float
    across: float
    length: float

    @property
    def between(self) -> bool:
        """Whether it lies in the cones that contain the branch between the stations."""
        return -_BLUR <= self.along <= self.length + _BLUR and self.across <= WIDEST * self.length + _BLUR


def _place(task: BranchTask, test: _Test, before: Station, after: Station, point: SpecialPoint) -> _Place:
    here, there = (_departure(task, at, test.departure) for at in (before, after))
    chord = there - here
    chord[0] -= np.rint(chord[0])
    length = float(np.linalg.norm(chord))
    apart = np.array([point.t[0], point.v[0], point.value]) / task.space.scales - here
    apart[0] -= np.rint(apart[0])
    along = float(apart @ chord) / length
    return _Place(along, float(np.linalg.norm(apart - along * chord / length)), length)


def _crossing(task: BranchTask, before: Station, after: Station, test: _Test) -> SpecialPoint | None:
    """Special point between two stations between which a test function changes sign; None if the branch is lost."""
    if before.chart.gentle:
        return _bisected(task, before, after, test)
    while True:
        values = test.value(before), test.value(after)
        part = min(max(values[0] / (values[0] - values[1]), 0.01), 0.99)
        here, there = (_departure(task, at, test.departure) for at in (before, after))
        there[0] -= np.rint(there[0] - here[0])
        guess = task.space.read(here + part * (there - here))
        point = None if guess is None else point_near(test.kind, guess[0], task.parameter, test.shape, *guess[1:])
        if point is not None:
            place = _place(task, test, before, after, point)
            if place.between:
                return point
        middle = station_between(task, before, after, 0.5)
        if middle is None:
            return None
        value = test.value(middle)
        if (value < 0.0) == (values[0] < 0.0):
            before = middle
        else:
            after = middle
        width = np.abs(after.z - before.z).max()
        if width <= _NARROW:
            t, v = float(middle.t[test.departure]), float(middle.v[test.departure])
            error = float(width * task.space.scales[2])
            return describe_point(
                test.kind, task.parameter, test.shape, middle.oscillator, t, v, residual=abs(value), error=error
            )


def _bisected(task: BranchTask, before: Station, after: Station, test: _Test) -> SpecialPoint | None:
    """Special point between two stations seen from touches: the stretch is halved until the corrector errs by as much.

    With several touches at once, it errs by far more than rounding.
    """
    low = test.value(before) < 0.0
    while True:
        width = float(np.abs(after.z - before.z).max())
        middle = None if width <= _NARROW else station_between(task, before, after, 0.5)
        if middle is None:
            error = width * float(task.space.scales[2])
            return point_at(test.kind, task, before, error) if width <= _ERRING else None
        if (test.value(middle) < 0.0) == low:
            before = middle
        else:
            after = middle


def point_at(kind: SpecialKind, task: BranchTask, station: Station, error: float, first: int = 0) -> SpecialPoint:
    """Special point at a station, with one of its departures as the first."""
    t, v = np.roll(station.t, -first), np.roll(station.v, -first)
    evaluated = station.chart.system()(station.z)
    residual = math.nan if evaluated is None else float(np.abs(evaluated[0]).max())
    return SpecialPoint(
        kind, task.parameter, station.oscillator.value_of(task.parameter), station.oscillator,
        task.shape.forcing_periods, task.shape.upper_contacts, int((station.margin > 0.0).sum()), t, v,
        np.linalg.eigvals(station.jacobian).astype(complex), residual, error,
    )  # fmt: skip


def _changes(test: _Test, before: Station, after: Station) -> bool:
    return (test.value(before) < 0.0) != (test.value(after) < 0.0)


def _tests(task: BranchTask, chart: Chart) -> Iterator[_Test]:
    """Test functions of saddle-nodes and doublings."""
    for kind, multiplier in ((SpecialKind.SADDLE_NODE, 1.0), (SpecialKind.PERIOD_DOUBLING, -1.0)):

        def gap(at: Station, multiplier: float = multiplier) -> float:
            return stability_gap(at.oscillator, task.shape, at.jacobian, multiplier)

        yield _Test(kind, chart.shape, 0, gap)


def points_between(task: BranchTask, before: Station, after: Station) -> tuple[SpecialPoint, ...] | None:
    """Special points between neighbouring stations, in their order; None if one of them cannot be located.

    On the side of a graze that meets -beta the trace may pass both critical values within 1/kappa^2 of the graze, where
    the departures tell nothing: there the test functions, linear in the speed of the touch, give the order.
    """
    points = []
    for test in _tests(task, before.chart):
        if _changes(test, before, after):
            point = _crossing(task, before, after, test)
            if point is None:
                return None
            if before.chart.gentle:
                value = test.value(before)
                part = value / (value - test.value(after))
            else:
                place = _place(task, test, before, after, point)
                part = place.along / place.length
            points.append((part, point))
    return tuple(point for _, point in sorted(points, key=lambda each: each[0]))


def _half_turn(task: BranchTask, station: Station) -> np.ndarray:
    """Vector from the first departure to the one half a turn later, in scaled unknowns."""
    half = task.shape.upper_contacts // 2
    apart = station.t[half] - station.t[0]
    return np.array([apart - np.rint(apart), (station.v[half] - station.v[0]) / task.space.scales[1]])


def halved_between(task: BranchTask, before: Station, after: Station) -> tuple[SpecialPoint, ...] | None:
    """Period doubling at which the branch was born, if it lies between: there the orbit's halves swap.

    None if it cannot be located.
    """
    if task.shape.upper_contacts % 2 or task.shape.forcing_periods % 2:
        return ()
    shape = OrbitShape(task.shape.forcing_periods // 2, task.shape.upper_contacts // 2)
    first = _half_turn(task, before)

    def half_turns(at: Station) -> float:
        there = _half_turn(task, at)
        # Halves may be half a period apart, where the difference of phases begins anew.
        there[0] -= np.rint(there[0] - first[0])
        return float(there @ first)

    test = _Test(SpecialKind.PERIOD_DOUBLING, shape, 0, half_turns)
    if not _changes(test, before, after):
        return ()
    point = _halved_at_touches(task, before, shape) if before.chart.gentle else _crossing(task, before, after, test)
    if point is None or not _place(task, test, before, after, point).between:
        return None
    return (point,)


def _halved_at_touches(task: BranchTask, near: Station, shape: OrbitShape) -> SpecialPoint | None:
    """Period doubling of the orbit of half the period, sought along the speed of a touch (finite stiffness)."""
    size = shape.upper_contacts
    gentle = tuple(i for i in near.chart.gentle if i < size)
    if [*gentle, *(i + size for i in gentle)] != list(near.chart.gentle):
        return None
    half = task._replace(shape=shape)
    chart = chart_of(task.space, shape, gentle, near.chart.shape.over & ((1 << size) - 1))
    touches = near.chart.touches(near.z)
    # The speeds of both halves tend to that of the orbit they become.
    guess = np.append(0.5 * (touches[: len(gentle)] + touches[len(gentle) :]), near.z[-1] * task.space.scales[2])
    guess[:-1:2] = touches[: len(gentle), 0]
    z, speeds, gaps = guess / chart.space.scales, list[float](), list[float]()
    speed = z[1]
    for _ in range(_MOST_SECANTS):
        z = np.concatenate([z[:1], [speed], z[2:]])
        landed = solve(chart.system(), z, np.eye(z.size)[1])
        there = None if landed is None else station_at(half, chart, landed.z, np.eye(z.size)[-1])
        if there is None:
            return None
        z = there.z
        speeds.append(float(z[1]))
        gaps.append(stability_gap(there.oscillator, shape, there.jacobian, -1.0))
        step = 1e-3 * speed if len(gaps) == 1 else -gaps[-1] * (speeds[-1] - speeds[-2]) / (gaps[-1] - gaps[-2])
        if not abs(step) > _NARROW:
            return point_at(SpecialKind.PERIOD_DOUBLING, half, there, abs(step) * float(task.space.scales[2]))
        speed += step
        if not speed > 0.0:
            return None
    return None


def distance_to(task: BranchTask, point: SpecialPoint, station: Station, departure: int) -> float:
    """Distance between a special point's first departure and one of a station, in scaled unknowns."""
    apart = float(point.t[0]) - float(station.t[departure])
    faster = (float(point.v[0]) - float(station.v[departure])) / task.space.scales[1]
    further = (point.value - station.oscillator.value_of(task.parameter)) / task.space.scales[2]
    return max(abs(apart - round(apart)), abs(faster), abs(further))


def graze_near(task: BranchTask, station: Station, departure: int) -> SpecialPoint | None:
    """Graze of one flight, if it lies on the branch: it is near, and no other flight is on another side of grazing."""
    shape = task.shape._replace(over=1)
    t, v = float(station.t[departure]), float(station.v[departure])
    point = point_near(SpecialKind.GRAZING, station.oscillator, task.parameter, shape, t, v)
    if point is None or distance_to(task, point, station, departure) > _REACH:
        return None
    others = np.roll(station.margin > 0, -departure)[1:]
    margin, _ = grazing_distances(point.oscillator, point.t, point.v)
    return point if ((margin[1:] > 0) == others).all() else None


def coincide(task: BranchTask, one: SpecialPoint, other: SpecialPoint) -> bool:
    """Whether two special points of a branch are one."""
    if one.kind != other.kind or one.t.size != other.t.size:
        return False
    apart = np.array([one.t[0] - other.t[0], one.v[0] - other.v[0], one.value - other.value]) / task.space.scales
    return bool(np.abs(apart - np.rint(apart) * [1.0, 0.0, 0.0]).max() <= _BLUR)


def repeated_graze_near(task: BranchTask, station: Station) -> SpecialPoint | None:
    """Graze where the orbit becomes several turns of a shorter one, so that several of its flights graze at once."""
    for turns in range(task.shape.upper_contacts, 1, -1):
        shape = OrbitShape(task.shape.forcing_periods // turns, task.shape.upper_contacts // turns, 1)
        if (shape.forcing_periods * turns, shape.upper_contacts * turns) != task.shape[:2]:
            continue
        for i in range(shape.upper_contacts):
            t, v = float(station.t[i]), float(station.v[i])
            point = point_near(SpecialKind.GRAZING, station.oscillator, task.parameter, shape, t, v)
            again = range(i, task.shape.upper_contacts, shape.upper_contacts)
            if point is not None and max(distance_to(task, point, station, j) for j in again) < _MERGED:
                return point
    return None


def contact_loss_near(task: BranchTask, station: Station) -> Iterator[SpecialPoint]:
    """Contact losses near a point: a departure about to vanish, or a contact about to split."""
    if task.infinitely_stiff:
        return
    slowest = float(station.t[int(np.argmin(station.v))])
    shallow = shallowest_in_contact(station.oscillator, station.t, station.v)
    for more, t in ((0, slowest), (1, shallow)):
        shape = task.shape._replace(upper_contacts=task.shape.upper_contacts + more)
        if shape.upper_contacts > 1 and math.isfinite(t):
            point = point_near(SpecialKind.CONTACT_LOSS, station.oscillator, task.parameter, shape, t, 0.0)
            value = station.oscillator.value_of(task.parameter)
            if point is not None and abs(point.value - value) < _REACH_OF_LOSS * task.space.scales[2]:
                yield point
