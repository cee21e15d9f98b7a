"""Systematic search for the periodic orbits of a region, stable or not.

For each impact period p up to a given n+, Newton's method on P^p starts from the departures of `orbit_seeds`.
Each orbit found is reduced to its own period and kept once. For short orbits Newton's method converges from about a
cell around the orbit. For longer ones this distance shrinks like 1/|multiplier|, so a finer grid finds more. What is
found is certain: the map returns to it. Nothing says what is missed. The indices of all fixed points of P^p with the
same number of forcing periods, the signs of det(DP^p - 1), add up to 0: if those found do not, one is missed.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.model.departures import check_departures
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.flight import fall_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.orbits.orbit_seeds import SearchSeeds, orbit_seeds
from rattle_kernels.orbits.periodic_orbit import (
    NEWTON_ROUNDS,
    PeriodicOrbit,
    find_periodic_orbit,
    newton_orbit,
    newton_rounds,
)

_SEED_DISTANCE = 1e-9
# Impacts of a round of Newton's method that need no pause: milliseconds in all rounds. In the softest contacts, where
# an impact may take one, 16 are more than a second. So seeds are taken together up to half as many.
_IMPACTS_A_ROUND = 16
_IMPACTS_A_LEG = 8
# Orbits closer than this are one. Near a fold, where two orbits part like a square root, Newton's error is 1e-8.
_SAME = 1e-6


class FoundOrbit(NamedTuple):
    """A periodic orbit and how close it passes to grazing.

    ``grazing_margin`` (shape (upper_contacts,)) is v - v*(t) of each departure, positive if the flight meets -beta.
    ``lower_speed`` (same shape) is the speed at which it does, else NaN. Its minimum tends to zero at a graze.
    """

    orbit: PeriodicOrbit
    grazing_margin: np.ndarray
    lower_speed: np.ndarray

    @property
    def grazing_distance(self) -> float:
        """Smallest ``|v - v*|`` of the departures: 0 where the orbit grazes."""
        return float(np.abs(self.grazing_margin).min())


@kernel
def _newton_all(oscillator, t, v, period, scale, distance):
    """Newton's method from all seeds, which become where it leads. The distances from orbits show if it converged."""
    for i in range(t.size):
        t[i], v[i], distance[i], _ = newton_rounds(oscillator, t[i], v[i], period[i], scale, NEWTON_ROUNDS)


def _newton_from(
    oscillator: Oscillator, seeds: SearchSeeds, scale: float, pause: Pause
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where Newton's method leads from each seed: phase, speed and distance from an orbit."""
    t, v, distance = seeds.t.copy(), seeds.v.copy(), np.empty(seeds.t.size)
    legs = np.cumsum(seeds.period) // _IMPACTS_A_LEG
    for leg in np.split(np.arange(t.size), np.flatnonzero(np.diff(legs)) + 1):
        pause()
        part = slice(leg[0], leg[-1] + 1)
        if seeds.period[part].max() <= _IMPACTS_A_ROUND:
            _newton_all(oscillator, t[part], v[part], seeds.period[part], scale, distance[part])
            continue
        for i in leg.tolist():
            t[i], v[i], distance[i] = newton_orbit(oscillator, t[i], v[i], int(seeds.period[i]), scale, pause)
    return t, v, distance


def describe_orbit(oscillator: Oscillator, orbit: PeriodicOrbit) -> FoundOrbit:
    """Measure how close an orbit passes to grazing.

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


class _Catalogue:
    """Orbits found so far, with a test whether a point lies on one."""

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
    *,
    pause: Pause = never_stopped,
) -> tuple[FoundOrbit, ...]:
    """Periodic orbits of impact period up to ``longest`` with a departure in a region of the (t, v) plane.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    longest : int
        Largest n+ to search for.
    time, velocity : (float, float)
        The region; phases within [0, 1].
    cells : int
        The search starts from the centres of ``cells x cells`` cells over it.
    rows : (int, int), optional
        Range of rows of cells to start from, the last excluded: a part of the search. ``merge_orbits`` combines the
        parts. All rows by default.
    pause : callable
        Called several times a second; an exception raised there ends the search.

    Returns
    -------
    tuple of FoundOrbit
        Ordered by (n+, m, n-) and lowest speed.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If ``longest`` or ``cells`` is not positive, or the region is none.
    """
    checked = check_oscillator(oscillator)
    if longest < 1 or cells < 1:
        raise ValueError(f"longest and cells must be positive, not {longest} and {cells}")
    if not (0.0 <= time[0] < time[1] <= 1.0):
        raise ValueError(f"time must be two phases within 0 and 1, the lower first, not {time}")
    if not (0.0 <= velocity[0] < velocity[1] < math.inf):
        raise ValueError(f"velocity must be two speeds from 0 on, the lower first, not {velocity}")
    scale = float(fall_speed(checked))
    seeds = orbit_seeds(checked, (*time, *velocity), cells, rows or (0, cells), longest, pause)
    t, v, distance = _newton_from(checked, seeds, scale, pause)
    catalogue = _Catalogue(scale)
    # Shortest first, so that a multiple of an orbit's period leads to an orbit already known. Those next to the grazing
    # curve and of the finer grid last: of orbits that other seeds lead to, they give another last digit.
    for i in np.lexsort((v, t, seeds.kind >= 3, seeds.period)):
        if distance[i] <= _SEED_DISTANCE and not catalogue.holds(t[i], v[i]):
            pause()
            orbit = find_periodic_orbit(checked, t[i], v[i], int(seeds.period[i]), scale, pause=pause)
            if orbit is not None and not catalogue.holds(orbit.t[0], orbit.v[0]):
                catalogue.add(orbit)
    found = [describe_orbit(checked, orbit) for orbit in catalogue.orbits if _enters(orbit, time, velocity)]
    return tuple(sorted(found, key=_order))


def merge_orbits(oscillator: Oscillator, found: Iterable[FoundOrbit]) -> tuple[FoundOrbit, ...]:
    """Merge the orbits of several searches, each kept once.

    Parameters
    ----------
    oscillator : Oscillator
        The oscillator of the orbits.
    found : iterable of FoundOrbit
        Of duplicates the first is kept.

    Returns
    -------
    tuple of FoundOrbit
        In the order of `find_orbits`.
    """
    catalogue, kept = _Catalogue(float(fall_speed(check_oscillator(oscillator)))), []
    for each in found:
        if not catalogue.holds(each.orbit.t[0], each.orbit.v[0]):
            catalogue.add(each.orbit)
            kept.append(each)
    return tuple(sorted(kept, key=_order))


def find_orbit(
    oscillator: Oscillator, t: float, v: float, period: int = 1, *, pause: Pause = never_stopped
) -> FoundOrbit | None:
    """Periodic orbit near a departure, stable or not, by Newton's method on P^p.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : float
        Phase and speed of the departure.
    period : int
        Impact period p, at least 1. The orbit's own period may be a divisor of it.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    FoundOrbit or None
        None if Newton's method finds none.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If the seed is no departure: not finite, or without a positive speed; or ``period`` is below 1.
    """
    checked = check_oscillator(oscillator)
    check_departures(t, v)
    if period < 1:
        raise ValueError(f"period must be at least 1, the number of impacts with +beta in one turn, not {period}")
    orbit = find_periodic_orbit(checked, float(t), float(v), period, float(fall_speed(checked)), pause=pause)
    return None if orbit is None else describe_orbit(checked, orbit)


def _enters(orbit: PeriodicOrbit, time: tuple[float, float], velocity: tuple[float, float]) -> bool:
    inside = (time[0] <= orbit.t) & (orbit.t <= time[1]) & (velocity[0] <= orbit.v) & (orbit.v <= velocity[1])
    return bool(inside.any())


def _order(found: FoundOrbit) -> tuple[float, ...]:
    orbit = found.orbit
    return (orbit.upper_contacts, orbit.forcing_periods, orbit.lower_contacts, float(orbit.v[0]), float(orbit.t[0]))
