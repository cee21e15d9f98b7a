"""Long chaotic transients: cells that end in a periodic orbit but have not reached it within k applications.

The paper takes the landing point of ``P^k`` as the end of a motion. But just after a chaotic attractor is destroyed
(its remnant is a chaotic saddle) or a periodic window opens, motions move as on the attractor for thousands of impacts
before they settle. A picture at k = 1499 then shows chaos, while the solution of the cell is a periodic orbit. Both are
true, and figures show both. At a bifurcation an orbit attracts so slowly that k applications may not be enough either.
There, a motion that has not settled is not chaotic.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from rattle_kernels import (
    Attractor,
    AttractorKind,
    Oscillator,
    largest_grazing_speed,
    next_impacts,
    tangent_growth,
)

# An orbit's multipliers bring a motion this close within some tens of impacts. By chance, a transient lands this close
# to an orbit of n points about once in 1e6/n landings.
_ON_ORBIT = 1e-3
_LEGS = 8
_LEG_IMPACTS = 1499
_FOLLOWED = 2000
_MEASURED = 100


@dataclass(frozen=True)
class Transient:
    """How motions leave a chaotic transient for an orbit.

    ``left`` counts the motions still on it after 0, 1, 2, ... legs of ``leg_impacts`` impacts each. ``mean_life`` is
    the maximum likelihood estimate in impacts for an exponential law, ``error`` its standard error. ``exponent`` is the
    mean Lyapunov exponent per forcing period along motions that stay on it for a leg, NaN if none does.
    """

    left: tuple[int, ...]
    leg_impacts: int
    mean_life: float
    error: float
    exponent: float


def is_on_orbit(oscillator: Oscillator, orbit: Attractor, t: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Whether departures are within 1e-3 of those of a periodic orbit, in forcing periods and natural speeds."""
    scale = largest_grazing_speed(oscillator)
    on = np.zeros(t.shape, bool)
    for time, velocity in zip(orbit.time, orbit.velocity, strict=True):
        apart = t - time
        on |= np.hypot(apart - np.rint(apart), (v - velocity) / scale) < _ON_ORBIT
    return on


def on_transient(basin: xr.Dataset) -> np.ndarray:
    """Cells shown whose landing point is not yet on the periodic orbit that they end in."""
    shown, oscillator = basin.rattle.shown, basin.rattle.oscillator
    solution = shown.solution.values
    wandering = np.zeros(solution.shape, bool)
    for index, attractor in enumerate(basin.rattle.catalogue()):
        if attractor.kind == AttractorKind.PERIODIC:
            cells = solution == index
            landed = shown.landing_time.values[cells], shown.landing_velocity.values[cells]
            wandering[cells] = ~is_on_orbit(oscillator, attractor, *landed)
    return wandering


def measure_transient(oscillator: Oscillator, orbit: Attractor, t: np.ndarray, v: np.ndarray) -> Transient:
    """Follow departures until they are on the orbit that they end in, and measure how long that takes.

    Parameters
    ----------
    oscillator : Oscillator
    orbit : Attractor
        Periodic.
    t, v : ndarray of float64, shape (n,)
        Departures on the transient. At most 2000 of them, evenly chosen, are followed.
    """
    chosen = np.unique(np.linspace(0, t.size - 1, min(t.size, _FOLLOWED)).astype(np.int64))
    t, v = t[chosen], v[chosen]
    left, exponent = [t.size], np.nan
    for leg in range(_LEGS):
        later_t, later_v, _, _ = next_impacts(oscillator, t, v, _LEG_IMPACTS)
        going = np.isfinite(later_t) & ~is_on_orbit(oscillator, orbit, later_t, later_v)
        exponent = _exponent(oscillator, t[going], v[going]) if leg == 0 else exponent
        t, v = later_t[going], later_v[going]
        left.append(t.size)
    return Transient(tuple(left), _LEG_IMPACTS, *_mean_life(left), exponent)


def _exponent(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> float:
    """Mean Lyapunov exponent along one leg, from some of the departures."""
    growth = tangent_growth(oscillator, t[:_MEASURED], v[:_MEASURED], _LEG_IMPACTS)
    there = growth.of(np.isfinite(growth.growth))
    return there.exponent if there.t.size else np.nan


def _mean_life(left: list[int]) -> tuple[float, float]:
    """Mean life in impacts and its standard error. Every leg is survived with the same probability."""
    begun, survived = sum(left[:-1]), sum(left[1:])
    if not survived or survived == begun:
        return np.nan, np.nan
    probability = survived / begun
    life = -_LEG_IMPACTS / np.log(probability)
    # Relative standard error of the probability, by the binomial law.
    spread = np.sqrt((1.0 - probability) / (probability * begun))
    return float(life), float(life * life / _LEG_IMPACTS * spread)
