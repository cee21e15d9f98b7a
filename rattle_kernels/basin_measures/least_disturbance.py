"""Least disturbance: the smallest change of velocity that leads from quiet to rattle, at each phase.

In permanent contact the teeth touch at every phase. A disturbance at phase t that parts them with speed v is a
departure (t, v); if v is small they bounce ever lower and are quiet again. The least disturbance v_q(t) is the lowest
speed from which they are not:

    v_q(t) = inf {v > 0 : (t, v) does not end in permanent contact}

In each column of a picture the lowest cell of another motion brackets it, between the centre of the quiet cell below
and its own; bisection with P itself then narrows the bracket. What is found is an end of the quiet basin for certain:
quiet on one side, rattling on the other, less than the tolerance apart. That it is the lowest is seen at the resolution
of the picture only: a tongue of rattle thinner than a cell may lie below.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.attractors.classify import name_solutions
from rattle_kernels.basin_measures.arrays import check_basins
from rattle_kernels.cell_mapping.cell_grid import CellGrid, check_grid
from rattle_kernels.model.oscillator import Oscillator, check_domain

# Permanent contact's place in every catalogue.
_QUIET = 0


class LeastDisturbance(NamedTuple):
    """Least disturbance of permanent contact at each phase, arrays of shape (time cells,).

    ``time`` are the phases, in [0, 1); ``velocity`` (float64) the least speed found that leads to another motion, at
    most the tolerance above one that does not; ``solution`` (int16) is that motion, UNASSIGNED where bisection met one
    that the catalogue lacks. NaN and 0 where every cell of the column is quiet.
    """

    time: np.ndarray
    velocity: np.ndarray
    solution: np.ndarray


def _lowest_rattle(array: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns in which anything rattles, and the row of the lowest cell that does."""
    rattles = array != _QUIET
    columns = np.flatnonzero(rattles.any(axis=0))
    return columns, rattles[:, columns].argmax(axis=0)


def least_disturbance(
    oscillator: Oscillator,
    attractors: Sequence[Attractor],
    solution: np.typing.ArrayLike,
    grid: CellGrid,
    tolerance: float = 1e-6,
) -> LeastDisturbance:
    """Smallest speed that leads from permanent contact to another motion, at the phase of each column of a picture.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    attractors : sequence of Attractor
        The catalogue that `solution` points into: permanent contact first.
    solution : array_like of int, shape (velocity cells, time cells)
        Index of the motion that each cell ends in; none negative.
    grid : CellGrid
        The window; its speeds must begin at 0, so that nothing rattles unseen below it.
    tolerance : float
        Width of the bracket to which each speed is narrowed.

    Returns
    -------
    LeastDisturbance

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    ValueError
        Where the grid does not fit, or the tolerance is not positive.

    Notes
    -----
    ``v_q(t) = inf {v > 0 : (t, v) does not end in permanent contact}``, an upper bound of it where the basin has parts
    thinner than a cell. Its least value over all phases is the local integrity measure of permanent contact, times the
    velocity scale, beyond the resolution of the cells.
    """
    checked, array, grid = check_domain(oscillator), check_basins(solution), check_grid(grid)
    if array.shape != grid.shape or grid.velocity_start > 0.0:
        raise ValueError(f"the picture of shape {array.shape} must be that of a grid from velocity 0 up, not {grid}")
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise ValueError(f"tolerance must be positive and finite, not {tolerance}")
    columns, rows = _lowest_rattle(array)
    time = grid.time_centres() % 1.0
    speeds = np.concatenate([[0.0], grid.velocity_centres()])
    bracket = speeds[rows], speeds[rows + 1]
    velocity, motion = np.full(time.size, np.nan), np.full(time.size, _QUIET, np.int16)
    velocity[columns], motion[columns] = _bisect(
        checked, attractors, time[columns], bracket, array[rows, columns].astype(np.int16), tolerance
    )
    return LeastDisturbance(time, velocity, motion)


def _bisect(
    oscillator: Oscillator,
    attractors: Sequence[Attractor],
    time: np.ndarray,
    bracket: tuple[np.ndarray, np.ndarray],
    motion: np.ndarray,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Narrow brackets between a speed that is quiet (or 0) and one that leads to `motion`; return the upper ends."""
    quiet, rattling = bracket
    while True:
        middle = 0.5 * (quiet + rattling)
        # Neighbouring numbers have none between them.
        wide = (rattling - quiet > tolerance) & (quiet < middle) & (middle < rattling)
        if not wide.any():
            return rattling, motion
        found = np.full(time.size, _QUIET, np.int16)
        found[wide] = name_solutions(oscillator, attractors, time[wide], middle[wide])
        rattles = wide & (found != _QUIET)
        rattling, motion = np.where(rattles, middle, rattling), np.where(rattles, found, motion)
        quiet = np.where(wide & ~rattles, middle, quiet)
