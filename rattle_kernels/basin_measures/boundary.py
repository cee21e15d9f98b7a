"""Basin boundaries in a picture, and their share on given curves, such as stable manifolds (Sec. 6.2)."""

from collections.abc import Iterable

import numpy as np

from rattle_kernels.basin_measures.arrays import check_basins
from rattle_kernels.cell_mapping.cell_grid import CellGrid, check_grid
from rattle_kernels.manifolds.polyline import Piece
from rattle_kernels.numerics.phase import wrap_all

# Samples per cell along a curve. A cell that it crosses for less than a quarter of a cell may be missed.
_SAMPLES = 4


def boundary_cells(solution: np.typing.ArrayLike, wraps: bool = True) -> np.ndarray:
    """Cells with a neighbour, along time or velocity, that ends in a different motion.

    Parameters
    ----------
    solution : array_like of int, shape (velocity cells, time cells)
        Index of the motion that each cell ends in; none negative.
    wraps : bool
        Whether the window spans a whole period.

    Returns
    -------
    ndarray of bool, that shape
    """
    array = check_basins(solution)
    boundary = np.zeros(array.shape, np.bool_)
    above = array[1:] != array[:-1]
    boundary[1:] |= above
    boundary[:-1] |= above
    beside = array != np.roll(array, 1, axis=1)
    beside[:, 0] &= wraps
    return boundary | beside | np.roll(beside, -1, axis=1)


def cells_along(pieces: Iterable[Piece], grid: CellGrid) -> np.ndarray:
    """Cells that curves pass through.

    Parameters
    ----------
    pieces : iterable of Piece
    grid : CellGrid

    Returns
    -------
    ndarray of bool, shape (velocity cells, time cells)
    """
    grid = check_grid(grid)
    marked = np.zeros(grid.shape, np.bool_)
    per_t = grid.time_cells / (grid.time_stop - grid.time_start)
    per_v = grid.velocity_cells / (grid.velocity_stop - grid.velocity_start)
    for piece in pieces:
        chords = np.maximum(np.abs(np.diff(piece.t)) * per_t, np.abs(np.diff(piece.v)) * per_v)
        samples = np.ceil(chords * _SAMPLES).astype(np.int64) + 1
        along = np.concatenate([[0.0], np.cumsum(np.repeat(1.0 / samples, samples))])
        t, v = (np.interp(along, np.arange(values.size), values) for values in piece)
        column = np.floor(wrap_all(t - grid.time_start) * per_t).astype(np.int64)
        row = np.floor((v - grid.velocity_start) * per_v).astype(np.int64)
        inside = (column < grid.time_cells) & (row >= 0) & (row < grid.velocity_cells)
        marked[row[inside], column[inside]] = True
    return marked


def widened(cells: np.ndarray, wraps: bool = True) -> np.ndarray:
    """Marked cells and the eight neighbours of each."""
    wide = cells.copy()
    wide[1:] |= cells[:-1]
    wide[:-1] |= cells[1:]
    left, right = np.roll(wide, -1, axis=1), np.roll(wide, 1, axis=1)
    left[:, -1] &= wraps
    right[:, 0] &= wraps
    return wide | left | right


def boundary_share(solution: np.typing.ArrayLike, grid: CellGrid, pieces: Iterable[Piece]) -> float:
    """Share of the boundary cells that lie within one cell of given curves.

    Parameters
    ----------
    solution : array_like of int, shape (velocity cells, time cells)
        Index of the motion that each cell ends in; none negative.
    grid : CellGrid
        The window.
    pieces : iterable of Piece
        Curves, such as all pieces of a stable manifold.

    Returns
    -------
    float
        NaN if the picture has no boundary.

    Raises
    ------
    ValueError
        If the shapes of solutions and grid differ.
    """
    grid = check_grid(grid)
    boundary = boundary_cells(solution, grid.wraps)
    if boundary.shape != grid.shape:
        raise ValueError(f"solutions of shape {boundary.shape} are not those of a grid of {grid.shape} cells")
    near = widened(cells_along(pieces, grid), grid.wraps)
    return float((boundary & near).sum() / boundary.sum()) if boundary.any() else float("nan")
