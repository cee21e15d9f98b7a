"""Departures from which a search for periodic orbits starts.

1. A grid over the region.
2. Recurrences: on each trajectory from this grid, the point that P^p brings back closest to itself. Trajectories pass
   close to saddles that few grid points would lead Newton's method to.
3. Departures just above the grazing curve v*(t). An orbit that meets -beta slowly is a saddle with a large multiplier,
   which Newton's method finds from close by only: beyond the curve P is a function of the root of v - v*(t), and from
   too high above it the method leads to the other side. From below it does not: a root is concave, and the steps
   towards the orbit fall short of it. So the lowest of these seeds leads to all of them.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.model.grazing_curve import grazing_velocity
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.numerics.phase import part_turn

_RECURRENCE_APPLICATIONS = 200
# Trajectories between two pauses: milliseconds, but in the softest contacts most of a second.
_TRAJECTORIES_A_LEG = 4
_CLOSE = 0.1
# Heights above the grazing curve, relative to it, and phases for each column of cells.
_ABOVE = 1e-2, 1e-4, 1e-6
_PHASES = 4


@kernel
def _recurrences(oscillator, t, v, longest, applications, best_t, best_v, best):
    """For each trajectory and period, the departure that returns closest to itself, and its distance."""
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


class SearchSeeds(NamedTuple):
    """Departures, arrays of shape (n,): phase, speed, the impact period p to search for, the kind of seed (1 to 3)."""

    t: np.ndarray
    v: np.ndarray
    period: np.ndarray
    kind: np.ndarray


def _above_the_grazing_curve(
    oscillator: Oscillator, time: tuple[float, float], cells: int, rows: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Departures just above v*(t); each row of cells has its part of the phases."""
    phases = (np.arange(*(_PHASES * row for row in rows)) + 0.5) / (_PHASES * cells)
    t = time[0] + (time[1] - time[0]) * phases
    v = np.multiply.outer(1.0 + np.array(_ABOVE), grazing_velocity(oscillator, t))
    return np.tile(t, len(_ABOVE)), v.ravel()


def orbit_seeds(
    oscillator: Oscillator,
    region: tuple[float, float, float, float],
    cells: int,
    rows: tuple[int, int],
    longest: int,
    pause: Pause,
) -> SearchSeeds:
    """Departures from which Newton's method on P^p starts.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    region : (float, float, float, float)
        First and last phase, lowest and highest speed.
    cells, rows, longest, pause
        As for `find_orbits`.

    Returns
    -------
    SearchSeeds
    """
    middles = (np.arange(cells) + 0.5) / cells
    middle_t, middle_v = np.meshgrid(
        region[0] + (region[1] - region[0]) * middles,
        region[2] + (region[3] - region[2]) * middles[slice(*rows)],
    )
    t, v = middle_t.ravel(), middle_v.ravel()
    shape = t.size, longest
    best_t, best_v, best = np.zeros(shape), np.zeros(shape), np.full(shape, _CLOSE)
    for first in range(0, t.size, _TRAJECTORIES_A_LEG):
        pause()
        leg = slice(first, first + _TRAJECTORIES_A_LEG)
        _recurrences(oscillator, t[leg], v[leg], longest, _RECURRENCE_APPLICATIONS, best_t[leg], best_v[leg], best[leg])
    period = np.broadcast_to(np.arange(1, longest + 1), shape)
    near = best < _CLOSE
    above_t, above_v = _above_the_grazing_curve(oscillator, (region[0], region[1]), cells, rows)
    periods = period.ravel(), period[near], np.tile(np.arange(1, longest + 1), above_t.size)
    return SearchSeeds(
        np.concatenate([np.repeat(t, longest), best_t[near], np.repeat(above_t, longest)]),
        np.concatenate([np.repeat(v, longest), best_v[near], np.repeat(above_v, longest)]),
        np.concatenate(periods),
        np.repeat([1, 2, 3], [part.size for part in periods]),
    )
