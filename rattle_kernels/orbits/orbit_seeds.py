"""Departures from which a search for periodic orbits starts.

1. A grid over the region.
2. Recurrences: on each trajectory from this grid, the point that P^p brings back closest to itself. Trajectories pass
   close to saddles that few grid points would lead Newton's method to.
3. Departures on both sides of the grazing curve v*(t). An orbit with a flight that nearly touches -beta is a saddle of
   a large multiplier, which Newton's method finds from close by only. Every such orbit has a departure next to v*(t),
   that of this flight: its other departures lie next to pre-images of the curve, and need no seeds of their own. Above
   the curve P is a function of the root of v - v*(t), so the first steps are taken in this root (`near_graze`).
4. Departures of a grid ten times as fine, whose first step of Newton's method is no longer than a few of its cells. It
   costs one impact for each period to find out. They lead to orbits in the thin strips between pre-images of v*(t).
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.grazing_velocity import grazing_velocity
from rattle_kernels.impact_map.jacobian import next_impact_with_jacobian
from rattle_kernels.impact_map.variations import Jacobian, multiply
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.numerics.phase import part_turn
from rattle_kernels.orbits.near_graze import approach_above

_RECURRENCE_APPLICATIONS = 200
# Trajectories between two pauses: milliseconds, but in the softest contacts most of a second.
_TRAJECTORIES_A_LEG = 4
_CLOSE = 0.1
# Heights above and below the grazing curve, relative to it, and phases for each column of cells.
_ABOVE, _BELOW = (1e-2, 1e-4, 1e-6), (-5e-2, -1e-2, -1e-3)
_PHASES = 8
# The roots in which the first steps are taken may be large: these heights, and this many rounds of Newton's method.
_FAR_ABOVE, _ROUNDS_ABOVE = (1e-1, 1e-2, 1e-3), 12
# A finer grid: so many times as fine, and the longest first step in its cells. Its points between two pauses.
_FINER, _LONGEST_STEP = 10, 3.0
_POINTS_A_LEG = 16


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
    """Departures, arrays of shape (n,): phase, speed, the impact period p to search for, the kind of seed (1 to 4)."""

    t: np.ndarray
    v: np.ndarray
    period: np.ndarray
    kind: np.ndarray


def _beside_the_grazing_curve(
    oscillator: Oscillator, time: tuple[float, float], cells: int, rows: tuple[int, int], longest: int, pause: Pause
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Departures next to v*(t) and their periods; each row of cells has its part of the phases."""
    phases = (np.arange(*(_PHASES * row for row in rows)) + 0.5) / (_PHASES * cells)
    t = time[0] + (time[1] - time[0]) * phases
    touching = grazing_velocity(oscillator, t)
    heights = np.array(_ABOVE + _BELOW)
    beside = np.multiply.outer(1.0 + heights, touching).ravel()
    t_beside = np.repeat(np.tile(t, heights.size), longest)
    v_beside, periods = np.repeat(beside, longest), np.tile(np.arange(1, longest + 1), beside.size)
    if oscillator.is_loose:  # the curve may jump, and P need not be a function of the root
        moves = v_beside > 0.0
        return t_beside[moves], v_beside[moves], periods[moves]
    roots = np.sqrt(np.multiply.outer(np.array(_FAR_ABOVE), touching)).ravel()
    above = approach_above(oscillator, np.tile(t, len(_FAR_ABOVE)), roots, longest, _ROUNDS_ABOVE, pause)
    joined = (np.concatenate(each) for each in zip((t_beside, v_beside, periods), above, strict=True))
    times, speeds, turns = joined
    return times, speeds, turns


@kernel
def _first_steps(oscillator, t, v, longest, limit_t, limit_v, short):
    """Whether the first step of Newton's method on P^p is short, for each departure and p = 1 to `longest`."""
    for i in range(t.size):
        jacobian = Jacobian(1.0, 0.0, 0.0, 1.0)
        here, speed = t[i], v[i]
        for p in range(longest):
            impact, one = next_impact_with_jacobian(oscillator, here, speed)
            here, speed = impact.t, impact.v
            if not (math.isfinite(here) and speed > 0.0):
                break
            jacobian = multiply(one, jacobian)
            f, g = part_turn(here - t[i]), speed - v[i]
            a, b, c, d = jacobian.tt - 1.0, jacobian.tv, jacobian.vt, jacobian.vv - 1.0
            determinant = a * d - b * c
            short[i, p] = (
                abs((b * g - d * f) / determinant) <= limit_t and abs((c * f - a * g) / determinant) <= limit_v
            )


def _middles(
    region: tuple[float, float, float, float], cells: int, rows: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Centres of the cells of some rows of a grid over the region."""
    middles = (np.arange(cells) + 0.5) / cells
    t, v = np.meshgrid(
        region[0] + (region[1] - region[0]) * middles, region[2] + (region[3] - region[2]) * middles[slice(*rows)]
    )
    return t.ravel(), v.ravel()


def _between_preimages(
    oscillator: Oscillator,
    region: tuple[float, float, float, float],
    cells: int,
    rows: tuple[int, int],
    longest: int,
    pause: Pause,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Departures of the finer grid whose first step is short, and their periods."""
    finer = _FINER * cells
    t, v = _middles(region, finer, (_FINER * rows[0], _FINER * rows[1]))
    limits = (_LONGEST_STEP * (last - first) / finer for first, last in (region[:2], region[2:]))
    limit_t, limit_v = limits
    short = np.zeros((t.size, longest), np.bool_)
    for first in range(0, t.size, _POINTS_A_LEG):
        pause()
        leg = slice(first, first + _POINTS_A_LEG)
        _first_steps(oscillator, t[leg], v[leg], longest, limit_t, limit_v, short[leg])
    which, period = np.nonzero(short)
    return t[which], v[which], period + 1


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
    t, v = _middles(region, cells, rows)
    shape = t.size, longest
    best_t, best_v, best = np.zeros(shape), np.zeros(shape), np.full(shape, _CLOSE)
    for first in range(0, t.size, _TRAJECTORIES_A_LEG):
        pause()
        leg = slice(first, first + _TRAJECTORIES_A_LEG)
        _recurrences(oscillator, t[leg], v[leg], longest, _RECURRENCE_APPLICATIONS, best_t[leg], best_v[leg], best[leg])
    period = np.broadcast_to(np.arange(1, longest + 1), shape)
    near = best < _CLOSE
    beside = _beside_the_grazing_curve(oscillator, (region[0], region[1]), cells, rows, longest, pause)
    between = _between_preimages(oscillator, region, cells, rows, longest, pause)
    kinds = (
        (np.repeat(t, longest), np.repeat(v, longest), period.ravel()),
        (best_t[near], best_v[near], period[near]),
        beside,
        between,
    )
    times, speeds, periods = (np.concatenate(part) for part in zip(*kinds, strict=True))
    return SearchSeeds(times, speeds, periods, np.repeat([1, 2, 3, 4], [kind[0].size for kind in kinds]))
