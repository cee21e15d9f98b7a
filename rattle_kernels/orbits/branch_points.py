"""Special points on a branch: between two neighbouring stations, and near the point where it stalls."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.numerics.pseudo_arclength import Steps
from rattle_kernels.orbits.bifurcation_point import (
    SpecialPoint,
    locate,
    shallowest_in_contact,
)
from rattle_kernels.orbits.closure import OrbitShape, closure, orbit_from, stability_gap
from rattle_kernels.orbits.orbit_equations import SpecialKind, Unknowns

# A special point located further away than this, in scaled unknowns, is a different one.
_REACH = 0.05
# Departures that all lie within this distance of one graze have merged there.
_MERGED = 1e-3


class BranchTask(NamedTuple):
    """Quantities that are constant along a branch."""

    space: Unknowns
    shape: OrbitShape
    bounds: tuple[float, float]
    steps: Steps
    most_points: int
    pause: Pause

    @property
    def parameter(self) -> str:
        """Name of the parameter that varies."""
        return self.space.parameters[0]

    @property
    def infinitely_stiff(self) -> bool:
        """Whether the model is the impacting one."""
        return math.isinf(self.space.oscillator.stiffness)


class Station(NamedTuple):
    """A point of a branch: the oscillator, the orbit's departures and their distances from grazing."""

    z: np.ndarray
    oscillator: Oscillator
    t: np.ndarray
    v: np.ndarray
    margin: np.ndarray
    lower_speed: np.ndarray
    jacobian: np.ndarray


def station_at(task: BranchTask, z: np.ndarray) -> Station:
    """Station at a point that the corrector has accepted."""
    read = task.space.read(z)
    assert read is not None
    oscillator, t, v = read
    closed = closure(oscillator, task.parameter, task.shape, t, v)
    assert closed is not None
    times, speeds, _ = orbit_from(oscillator, task.shape, t, v)
    margin, lower_speed = grazing_distances(oscillator, times, speeds)
    return Station(z, oscillator, times, speeds, margin, lower_speed, closed.jacobian)


def critical_between(task: BranchTask, before: Station, after: Station) -> Iterator[SpecialPoint | None]:
    """Saddle-nodes and period doublings between neighbouring points; None for one that was not located."""
    for kind, multiplier in ((SpecialKind.SADDLE_NODE, 1.0), (SpecialKind.PERIOD_DOUBLING, -1.0)):
        gaps = [stability_gap(at.oscillator, task.shape, at.jacobian, multiplier) for at in (before, after)]
        if gaps[0] * gaps[1] < 0.0:
            part = gaps[0] / (gaps[0] - gaps[1])
            read = task.space.read(before.z + part * (after.z - before.z))
            point = None if read is None else locate(kind, read[0], task.parameter, task.shape, *read[1:])
            near = 2.0 * float(np.abs(after.z - before.z).max()) + 1e-6
            yield point if point is not None and distance_to(task, point, before, 0) < near else None


def grazes_between(task: BranchTask, before: Station, after: Station) -> Iterator[SpecialPoint | None]:
    """Grazes between neighbouring points: a flight begins or ceases to meet -beta. Impacting branches end there."""
    if task.infinitely_stiff:
        return
    for i in np.flatnonzero((before.margin > 0) != (after.margin > 0)):
        yield graze_near(task, before, int(i))


def _half_turn(task: BranchTask, station: Station) -> np.ndarray:
    """Vector from the first departure to the one half a turn later, in scaled unknowns."""
    half = task.shape.upper_contacts // 2
    apart = station.t[half] - station.t[0]
    return np.array([apart - np.rint(apart), (station.v[half] - station.v[0]) / task.space.scales[1]])


def halved_between(task: BranchTask, before: Station, after: Station) -> SpecialPoint | None:
    """Period doubling at which the branch was born, if it lies between the points: there the orbit's halves swap."""
    if task.shape.upper_contacts % 2 or task.shape.forcing_periods % 2:
        return None
    halves = _half_turn(task, before), _half_turn(task, after)
    if halves[0] @ halves[1] >= 0.0:
        return None
    shape = OrbitShape(task.shape.forcing_periods // 2, task.shape.upper_contacts // 2)
    read = task.space.read(0.5 * (before.z + after.z))
    point = None if read is None else locate(SpecialKind.PERIOD_DOUBLING, read[0], task.parameter, shape, *read[1:])
    near = 2.0 * float(np.abs(after.z - before.z).max()) + 1e-6
    return point if point is not None and distance_to(task, point, before, 0) < near else None


def distance_to(task: BranchTask, point: SpecialPoint, station: Station, departure: int) -> float:
    """Distance between a special point's first departure and one of a station, in scaled unknowns."""
    apart = float(point.t[0]) - float(station.t[departure])
    faster = (float(point.v[0]) - float(station.v[departure])) / task.space.scales[-2]
    further = (point.value - getattr(station.oscillator, task.parameter)) / task.space.scales[-1]
    return max(abs(apart - round(apart)), abs(faster), abs(further))


def graze_near(task: BranchTask, station: Station, departure: int) -> SpecialPoint | None:
    """Graze of one flight, if it lies on the branch: it is near, and no other flight is on another side of grazing."""
    shape = task.shape._replace(over=True)
    t, v = float(station.t[departure]), float(station.v[departure])
    point = locate(SpecialKind.GRAZING, station.oscillator, task.parameter, shape, t, v)
    if point is None or distance_to(task, point, station, departure) > _REACH:
        return None
    others = np.roll(station.margin > 0, -departure)[1:]
    margin, _ = grazing_distances(point.oscillator, point.t, point.v)
    return point if ((margin[1:] > 0) == others).all() else None


def repeated_graze_near(task: BranchTask, station: Station) -> SpecialPoint | None:
    """Graze where the orbit becomes several turns of a shorter one, so that several of its flights graze at once."""
    for turns in range(task.shape.upper_contacts, 1, -1):
        shape = OrbitShape(task.shape.forcing_periods // turns, task.shape.upper_contacts // turns, True)
        if (shape.forcing_periods * turns, shape.upper_contacts * turns) != task.shape[:2]:
            continue
        for i in range(shape.upper_contacts):
            t, v = float(station.t[i]), float(station.v[i])
            point = locate(SpecialKind.GRAZING, station.oscillator, task.parameter, shape, t, v)
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
            point = locate(SpecialKind.CONTACT_LOSS, station.oscillator, task.parameter, shape, t, 0.0)
            value = getattr(station.oscillator, task.parameter)
            if point is not None and abs(point.value - value) < _REACH * task.space.scales[-1]:
                yield point
