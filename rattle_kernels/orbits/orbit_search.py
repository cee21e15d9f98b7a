"""All periodic orbits of a region, stable or not, by a systematic search.

For each impact period p up to n+, Newton's method on P^p starts

1. from a grid of departures over the region, and
2. from recurrences: along the trajectories of the same departures, where P^p comes closest to where it was. A
   trajectory passes close to saddles that few grid points would lead Newton to.

What converges is reduced to its own period and kept once. Newton's basins are of the size of a cell or so for short
orbits and shrink like 1/|multiplier| for longer ones: a finer grid finds more, and what is found is certain (its
residual says so), not what is missed.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.model.flight import fall_speed, part_turn
from rattle_kernels.model.oscillator import Oscillator, check_domain
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit, newton_orbit

_SEED_RESIDUAL = 1e-9
_RECURRENCE_APPLICATIONS = 200
_CLOSE = 0.1
# Two orbits closer than this are one. Near a fold, which splits them like a square root, Newton's own error is 1e-8.
_SAME = 1e-6


class FoundOrbit(NamedTuple):
    """A periodic orbit and how close it passes to grazing.

    ``grazing_margin`` (shape (upper_contacts,)) is v - v*(t) of each departure: positive where the flight meets -beta.
    ``lower_speed`` (same shape) is the speed with which it does, NaN where it does not; the least of them tends to zero
    where the orbit grazes.
    """

    orbit: PeriodicOrbit
    grazing_margin: np.ndarray
    lower_speed: np.ndarray

    @property
    def grazing_distance(self) -> float:
        """Least |v - v*| of its departures: 0 where the orbit grazes."""
        return float(np.abs(self.grazing_margin).min())


@kernel
def _newton_all(oscillator, t, v, period, scale, residual):
    for i in range(t.size):
        t[i], v[i], residual[i] = newton_orbit(oscillator, t[i], v[i], period[i], scale)


@kernel
def _recurrences(oscillator, t, v, longest, applications, best_t, best_v, best):
    """Closest return after each period along each trajectory: departure and distance."""
    past_t, past_v = np.empty(applications + 1), np.empty(applications + 1)
    for i in range(t.size):
        past_t[0], past_v[0] = t[i], v[i]
        for n in range(1, applications + 1):
            impact = next_impact(oscillator, past_t[n - 1], past_v[n - 1])
            if impact.outcome != OUTCOME_RETURNED:
                break
            past_t[n], past_v[n] = impact.t, impact.v
            for period in range(1, min(longest, n) + 1):
                apart = part_turn(impact.t - past_t[n - period])
                distance = math.hypot(apart, (impact.v - past_v[n - period]) / impact.v)
                if distance < best[i, period - 1]:
                    best[i, period - 1] = distance
                    best_t[i, period - 1], best_v[i, period - 1] = past_t[n - period], past_v[n - period]


def describe_orbit(oscillator: Oscillator, orbit: PeriodicOrbit) -> FoundOrbit:
    """How close an orbit passes to grazing.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    orbit : PeriodicOrbit

    Returns
    -------
    FoundOrbit
    """
    return FoundOrbit(orbit, *grazing_distances(oscillator, orbit.t, orbit.v))


def _seeds(
    oscillator: Oscillator,
    region: tuple[float, float, float, float],
    cells: int,
    rows: tuple[int, int],
    longest: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Departures to start from, with the period to look for."""
    middles = (np.arange(cells) + 0.5) / cells
    middle_t, middle_v = np.meshgrid(
        region[0] + (region[1] - region[0]) * middles,
        region[2] + (region[3] - region[2]) * middles[slice(*rows)],
    )
    t, v = middle_t.ravel(), middle_v.ravel()
    shape = t.size, longest
    best_t, best_v, best = np.zeros(shape), np.zeros(shape), np.full(shape, _CLOSE)
    _recurrences(oscillator, t, v, longest, _RECURRENCE_APPLICATIONS, best_t, best_v, best)
    period = np.broadcast_to(np.arange(1, longest + 1), shape)
    near = best < _CLOSE
    return (
        np.concatenate([np.repeat(t, longest), best_t[near]]),
        np.concatenate([np.repeat(v, longest), best_v[near]]),
        np.concatenate([period.ravel(), period[near]]),
    )


class _Catalogue:
    """Orbits found so far, and whether a point lies on one of them."""

    def __init__(self, scale: float) -> None:
        self.orbits: list[PeriodicOrbit] = []
        self._points = np.empty((0, 2))
        self._scale = scale

    def holds(self, t: float, v: float) -> bool:
        apart = self._points[:, 0] - t
        return bool((np.hypot(apart - np.rint(apart), (self._points[:, 1] - v) / self._scale) < _SAME).any())

    def add(self, orbit: PeriodicOrbit) -> None:
        self.orbits.append(orbit)
        self._points = np.vstack([self._points, np.column_stack([orbit.t, orbit.v])])


def find_orbits(
    oscillator: Oscillator,
    longest: int = 4,
    time: tuple[float, float] = (0.0, 1.0),
    velocity: tuple[float, float] = (0.0, 7.0),
    cells: int = 40,
    rows: tuple[int, int] | None = None,
) -> tuple[FoundOrbit, ...]:
    """Periodic orbits of impact period up to `longest` with a departure in a region of the (t, v) plane.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    longest : int
        Greatest n+ looked for.
    time, velocity : (float, float)
        The region; phases within [0, 1].
    cells : int
        The search starts from the centres of ``cells x cells`` cells over it.
    rows : (int, int), optional
        Start from these rows of cells only, the first included, the last not: a part of the search, of which
        `merge_orbits` makes the whole. All rows by default.

    Returns
    -------
    tuple of FoundOrbit
        By (n+, m, n-) and lowest speed.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If `longest` or `cells` is not positive.
    """
    checked = check_domain(oscillator)
    if longest < 1 or cells < 1:
        raise ValueError(f"longest and cells must be positive, not {longest} and {cells}")
    scale = float(fall_speed(checked))
    t, v, period = _seeds(checked, (*time, *velocity), cells, rows or (0, cells), longest)
    residual = np.empty(t.size)
    _newton_all(checked, t, v, period, scale, residual)
    catalogue = _Catalogue(scale)
    # Shortest first, so that a multiple of an orbit's period leads to an orbit already known.
    for i in np.lexsort((v, t, period)):
        if residual[i] <= _SEED_RESIDUAL and not catalogue.holds(t[i], v[i]):
            orbit = find_periodic_orbit(checked, t[i], v[i], int(period[i]), scale)
            if orbit is not None and not catalogue.holds(orbit.t[0], orbit.v[0]):
                catalogue.add(orbit)
    found = [describe_orbit(checked, orbit) for orbit in catalogue.orbits if _enters(orbit, time, velocity)]
    return tuple(sorted(found, key=_order))


def merge_orbits(oscillator: Oscillator, found: Iterable[FoundOrbit]) -> tuple[FoundOrbit, ...]:
    """Orbits that several searches have found, each once.

    Parameters
    ----------
    oscillator : Oscillator
        Theirs.
    found : iterable of FoundOrbit
        Of two that are one, the first is kept.

    Returns
    -------
    tuple of FoundOrbit
        In the order of `find_orbits`.
    """
    catalogue, kept = _Catalogue(float(fall_speed(check_domain(oscillator)))), []
    for each in found:
        if not catalogue.holds(each.orbit.t[0], each.orbit.v[0]):
            catalogue.add(each.orbit)
            kept.append(each)
    return tuple(sorted(kept, key=_order))


def find_orbit(oscillator: Oscillator, t: float, v: float, period: int = 1) -> FoundOrbit | None:
    """Periodic orbit near a departure, stable or not, by Newton's method on P^p.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : float
        Phase and speed of the departure.
    period : int
        Impact period p, at least 1; the orbit's own may be a divisor of it.

    Returns
    -------
    FoundOrbit or None
        None where Newton's method finds none.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    """
    checked = check_domain(oscillator)
    orbit = find_periodic_orbit(checked, float(t), float(v), period, float(fall_speed(checked)))
    return None if orbit is None else describe_orbit(checked, orbit)


def _enters(orbit: PeriodicOrbit, time: tuple[float, float], velocity: tuple[float, float]) -> bool:
    inside = (time[0] <= orbit.t) & (orbit.t <= time[1]) & (velocity[0] <= orbit.v) & (orbit.v <= velocity[1])
    return bool(inside.any())


def _order(found: FoundOrbit) -> tuple[float, ...]:
    orbit = found.orbit
    return (orbit.upper_contacts, orbit.forcing_periods, orbit.lower_contacts, float(orbit.v[0]), float(orbit.t[0]))
