"""Least disturbance: the smallest change of velocity that leads from quiet to rattle, at each phase.

In permanent contact the teeth touch at every phase. A disturbance at phase t that separates them with speed v is a
departure (t, v). If v is small, they bounce ever lower and are quiet again. The least disturbance v_q(t) is the lowest
speed from which they do not become quiet:

    v_q(t) = inf {v > 0 : (t, v) does not end in permanent contact}

In each column of a picture, v_q lies between the centre of the lowest cell of another motion and that of the quiet cell
below it. Bisection with P itself then narrows this bracket. The result is certainly an end of the quiet basin: quiet on
one side, rattling on the other, less than the tolerance apart. That it is the lowest holds only at the resolution of
the picture: a tongue of rattle thinner than a cell may lie below.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.attractors.classify import name_solutions
from rattle_kernels.basin_measures.arrays import check_basins
from rattle_kernels.cell_mapping.cell_grid import CellGrid, check_grid
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.phase import wrap_all

# Index of permanent contact in every catalogue.
_QUIET = 0


class LeastDisturbance(NamedTuple):
    """Least disturbance of permanent contact at each phase, arrays of shape (time cells,).

    ``time`` holds the phases, in [0, 1). ``velocity`` (float64) is the least speed found that leads to another motion,
    at most the tolerance above a quiet one. ``solution`` (int16) is that motion, or UNASSIGNED if bisection met one
    that the catalogue lacks. If every cell of the column is quiet, they are NaN and 0.
    """

    time: np.ndarray
    velocity: np.ndarray
    solution: np.ndarray


def _lowest_rattle(array: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns with a rattling cell, and the row of the lowest one."""
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
        Either model.
    attractors : sequence of Attractor
        The catalogue that ``solution`` indexes: permanent contact first.
    solution : array_like of int, shape (velocity cells, time cells)
        Index of the motion that each cell ends in; none negative.
    grid : CellGrid
        The window. Its speeds must begin at 0, so that no rattle lies below it.
    tolerance : float
        Largest final width of each bracket.

    Returns
    -------
    LeastDisturbance

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If the grid does not fit, or the tolerance is not positive.

    Notes
    -----
    ``v_q(t) = inf {v > 0 : (t, v) does not end in permanent contact}``, or an upper bound if the basin has parts
    thinner than a cell. Its minimum over all phases is the local integrity measure of permanent contact times the
    velocity scale, at a resolution finer than the cells.
    """
    checked, array, grid = check_oscillator(oscillator), check_basins(solution), check_grid(grid)
    if array.shape != grid.shape or grid.velocity_start > 0.0:
        raise ValueError(f"the picture of shape {array.shape} must be that of a grid from velocity 0 up, not {grid}")
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise ValueError(f"tolerance must be positive and finite, not {tolerance}")
    columns, rows = _lowest_rattle(array)
    time = wrap_all(grid.time_centres())
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
    """Narrow brackets from a quiet speed (or 0) to one that leads to `motion`; return the upper ends and motions."""
    quiet, rattling = bracket
    while True:
        middle = 0.5 * (quiet + rattling)
        # Adjacent floating-point numbers have none between them.
        wide = (rattling - quiet > tolerance) & (quiet < middle) & (middle < rattling)
        if not wide.any():
            return rattling, motion
        found = np.full(time.size, _QUIET, np.int16)
        found[wide] = name_solutions(oscillator, attractors, time[wide], middle[wide])
        rattles = wide & (found != _QUIET)
        rattling, motion = np.where(rattles, middle, rattling), np.where(rattles, found, motion)
        quiet = np.where(wide & ~rattles, middle, quiet)
