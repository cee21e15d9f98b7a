"""Stations of a branch: the orbit at one value of the parameter, and whether two of them are neighbours.

The corrector can land on another orbit of the same impact period, close by. A branch is continuous, so between
neighbours

- every departure moves along its tangent: the chord of all departures and the parameter lies within 18 degrees of the
  tangents at both ends, as in `pseudo_arclength`;
- the multipliers change little. Their sum, the trace, decides. In units of its critical value 1 + e^{-delta m} its
  inverse hyperbolic sine changes by at most asinh 1: from the middle to a critical value, or, where the trace is
  large, by a factor of 2.4. So no step passes both critical values. But the trace may rise and fall again in one step,
  next to a graze of finite stiffness. So small speeds at -beta change by at most a factor of 2, too.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.domain import closed_edges
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.numerics.pseudo_arclength import LEAST_COSINE, Steps, solve
from rattle_kernels.orbits.chart import GENTLE, Chart
from rattle_kernels.orbits.closure import OrbitShape, area_factor
from rattle_kernels.orbits.orbit_equations import Unknowns

_MOST_TRACE = math.asinh(1.0)
# Greatest factor between small speeds at -beta of neighbours.
_MOST_FACTOR = 2.0
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

    ``tangent`` is that of the branch in the unknowns z of the ``chart``. ``motion`` is that of all departures' phases
    and speeds (2 n), of the speeds of gentle touches, and of the parameter. Both have length 1.
    """

    z: np.ndarray
    chart: Chart
    oscillator: Oscillator
    t: np.ndarray
    v: np.ndarray
    margin: np.ndarray
    lower_speed: np.ndarray
    jacobian: np.ndarray
    tangent: np.ndarray
    motion: np.ndarray


def station_at(task: BranchTask, chart: Chart, z: np.ndarray, tangent: np.ndarray) -> Station | None:
    """Station at a point of a branch; None where the orbit's equations are not defined, or a departure is at rest."""
    orbit = chart.orbit_at(z)
    if orbit is None or orbit.v.min() < _SLOWEST * task.space.scales[1]:
        return None
    moves = orbit.moves @ tangent
    last = tangent[1::2] if chart.gentle else tangent[:0]
    motion = np.concatenate([moves[:, 0], moves[:, 1] / task.space.scales[1], last, tangent[-1:]])
    return Station(
        z, chart, orbit.oscillator, orbit.t, orbit.v, orbit.margin, orbit.lower_speed, orbit.jacobian, tangent,
        motion / np.linalg.norm(motion),
    )  # fmt: skip


def station_between(task: BranchTask, before: Station, after: Station, part: float) -> Station | None:
    """Station at a part of the way between two of one chart; None if Newton's method does not find it there."""
    chord = after.z - before.z
    length = float(np.linalg.norm(chord))
    landed = solve(before.chart.system(), before.z + part * chord, chord / length)
    if landed is None or np.linalg.norm(landed.z - before.z - part * chord) > length:
        return None
    return station_at(task, before.chart, landed.z, before.tangent)


def level_of(task: BranchTask, station: Station) -> float:
    """Trace of a station in units of its critical value, as an inverse hyperbolic sine."""
    area = area_factor(station.oscillator, task.shape, station.jacobian)
    return math.asinh(float(np.trace(station.jacobian)) / (1.0 + area))


def are_neighbours(task: BranchTask, before: Station, after: Station) -> bool:
    """Whether departures and multipliers of two stations of one chart differ as little as those of neighbours do."""
    apart = after.t - before.t
    faster = (after.v - before.v) / task.space.scales[1]
    last = (after.z - before.z)[1::2] if after.chart.gentle else after.z[:0]
    chord = np.concatenate([apart - np.rint(apart), faster, last, after.z[-1:] - before.z[-1:]])
    along = min(float(chord @ before.motion), float(chord @ after.motion))
    steady = abs(level_of(task, after) - level_of(task, before)) <= _MOST_TRACE
    return steady and along >= LEAST_COSINE * float(np.linalg.norm(chord)) and _grazes_as_much(task, before, after)


def _grazes_as_much(task: BranchTask, before: Station, after: Station) -> bool:
    """Whether no speed at -beta that is small changes by more than a factor (finite stiffness).

    The trace rises and falls again within any factor of the speed: from 1/kappa^2 to 1/kappa of the graze, and beyond.
    """
    if task.infinitely_stiff:
        return True
    met = ~np.isnan(before.lower_speed)
    # A flight that misses passes over -beta, and only a graze ends that.
    if any(met[i] != ~np.isnan(after.lower_speed[i]) and not after.chart.is_missing(i) for i in range(met.size)):
        return False
    both = met & ~np.isnan(after.lower_speed)
    here, there = before.lower_speed[both], after.lower_speed[both]
    low, high = np.minimum(here, there), np.maximum(here, there)
    return bool(((high <= _MOST_FACTOR * low) | (low >= GENTLE * task.space.scales[1])).all())


def on_edge(task: BranchTask, last: Station) -> Station | None:
    """The station on a closed edge of the domain, such as restitution 1, if a branch has come to one.

    Parameters
    ----------
    task : BranchTask
    last : Station
        Of the branch; it is the answer if it lies on the edge itself.

    Returns
    -------
    Station or None
    """
    found = last.chart.space.edge_near(last.z)
    if found is None or found[0][-1] == last.z[-1]:
        return None if found is None else last
    landed = solve(last.chart.system(), *found)
    there = None if landed is None else station_at(task, last.chart, landed.z, last.tangent)
    edge = next(edge for edge in closed_edges(task.parameter) if math.isfinite(edge))
    # Scaled and back, the edge may be rounded.
    return None if there is None else there._replace(oscillator=there.oscillator.at(**{task.parameter: edge}))
