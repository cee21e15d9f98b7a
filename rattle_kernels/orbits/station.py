"""Stations of a branch: the orbit at one value of the parameter, and whether two of them are neighbours.

The corrector can land on another orbit of the same impact period, close by. A branch is continuous, so between
neighbours

- every departure moves along its tangent: the chord of all departures and the parameter lies within 18 degrees of the
  tangents at both ends, as in `pseudo_arclength`;
- the multipliers change little. Their sum, the trace, decides. In units of its critical value 1 + e^{-delta m} its
  inverse hyperbolic sine changes by at most asinh 1: from the middle to a critical value, or, where the trace is
  large, by a factor of 2.4. So no step passes both critical values.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.model.domain import closed_edges
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.numerics.pseudo_arclength import LEAST_COSINE, Steps, System, solve
from rattle_kernels.orbits.closure import OrbitShape, area_factor, closure, departures_from
from rattle_kernels.orbits.orbit_equations import Unknowns

_MOST_TRACE = math.asinh(1.0)
# Slowest departure, relative to a fall through the backlash. Rounding moves the trace by 1e-16 over its square: here by
# 1e-4, and for slower ones until it changes sign by chance.
_SLOWEST = 1e-6


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
    """A point of a branch: the oscillator, the orbit's departures and their distances from grazing.

    ``tangent`` is that of the branch in the unknowns z, ``motion`` (shape (2 n + 1,)) that of all departures' phases
    and speeds and of the parameter. Both have length 1.
    """

    z: np.ndarray
    oscillator: Oscillator
    t: np.ndarray
    v: np.ndarray
    margin: np.ndarray
    lower_speed: np.ndarray
    jacobian: np.ndarray
    tangent: np.ndarray
    motion: np.ndarray


def station_at(task: BranchTask, z: np.ndarray, tangent: np.ndarray) -> Station | None:
    """Station at a point of a branch; None where the orbit's equations are not defined, or a departure is at rest."""
    read = task.space.read(z)
    closed = None if read is None else closure(read[0], task.parameter, task.shape, read[1], read[2])
    if read is None or closed is None:
        return None
    orbit = departures_from(read[0], task.parameter, task.shape, read[1], read[2])
    if orbit.v.min() < _SLOWEST * task.space.scales[1]:
        return None
    margin, lower_speed = grazing_distances(read[0], orbit.t, orbit.v)
    here = tangent * task.space.scales
    moves = orbit.jacobian @ here[:2] + orbit.sensitivity * here[2]
    motion = np.concatenate([moves[:, 0], moves[:, 1] / task.space.scales[1], tangent[2:]])
    return Station(
        z, read[0], orbit.t, orbit.v, margin, lower_speed, closed.jacobian, tangent, motion / np.linalg.norm(motion)
    )


def station_between(task: BranchTask, system: System, before: Station, after: Station, part: float) -> Station | None:
    """Station at a part of the way between two; None if Newton's method does not find it there."""
    chord = after.z - before.z
    length = float(np.linalg.norm(chord))
    landed = solve(system, before.z + part * chord, chord / length)
    if landed is None or np.linalg.norm(landed.z - before.z - part * chord) > length:
        return None
    return station_at(task, landed.z, before.tangent)


def _level(task: BranchTask, station: Station) -> float:
    area = area_factor(station.oscillator, task.shape, station.jacobian)
    return math.asinh(float(np.trace(station.jacobian)) / (1.0 + area))


def are_neighbours(task: BranchTask, before: Station, after: Station) -> bool:
    """Whether departures and multipliers of two stations differ as little as those of neighbours on one branch."""
    apart = after.t - before.t
    faster = (after.v - before.v) / task.space.scales[1]
    chord = np.concatenate([apart - np.rint(apart), faster, after.z[2:] - before.z[2:]])
    along = min(float(chord @ before.motion), float(chord @ after.motion))
    steady = abs(_level(task, after) - _level(task, before)) <= _MOST_TRACE
    return steady and along >= LEAST_COSINE * float(np.linalg.norm(chord))


def on_edge(task: BranchTask, system: System, last: Station) -> Station | None:
    """The station on a closed edge of the domain, such as restitution 1, if a branch has come to one.

    Parameters
    ----------
    task : BranchTask
    system : callable
        The equations of the branch.
    last : Station
        Of the branch; it is the answer if it lies on the edge itself.

    Returns
    -------
    Station or None
    """
    found = task.space.edge_near(last.z)
    if found is None or found[0][-1] == last.z[-1]:
        return None if found is None else last
    landed = solve(system, *found)
    there = None if landed is None else station_at(task, landed.z, last.tangent)
    edge = next(edge for edge in closed_edges(task.parameter) if math.isfinite(edge))
    # Scaled and back, the edge may be rounded.
    return None if there is None else there._replace(oscillator=there.oscillator.at(**{task.parameter: edge}))
