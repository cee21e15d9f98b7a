"""Integrity of one motion's basin: its share of the plane, and the largest safe disturbance.

Three measures, for the basin of motion number `index`:

- The *global integrity measure* GIM is the basin's share of the window.
- The *local integrity measure* LIM is the radius of the largest disc about the attractor's states inside the basin: the
  least distance from a state to the end of the basin. It is the largest disturbance that is safe in every direction.
- The *integrity factor* IF is the radius of the largest disc inside the basin that is centred on one of its cells.
  Unlike the share, it does not count fractal parts, where no state is safe. With a free centre a disc could be larger,
  by half the diagonal of a cell at most.

Distances are measured in the scaled plane (t, v/velocity_scale), with time in forcing periods. If the window spans a
whole period, they are taken round the cylinder. Each cell is a rectangle that belongs to one basin. Nothing is known
beyond the window, so no disc leaves it.

Permanent contact has no departures. Its states are v -> 0 at every phase. Its LIM is the largest speed, scaled, below
which every departure of the window ends in permanent contact again. The line v = 0 is not an end of its basin.

Thompson, Chaotic phenomena triggering the escape from a potential well, Proc. R. Soc. A 421, 195 (1989); Soliman and
Thompson, Integrity measures quantifying the erosion of smooth and fractal basins of attraction, J. Sound Vib. 135, 453
(1989); Rega and Lenci, Identifying, evaluating, and controlling dynamical integrity measures in non-linear mechanical
oscillators, Nonlinear Anal. 63, 902 (2005).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.basin_measures.arrays import check_basins
from rattle_kernels.cell_mapping.cell_grid import CellGrid, cell_number, check_grid
from rattle_kernels.numerics.distance_transform import distance_outside
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.phase import wrap_all


class LargestDisc(NamedTuple):
    """A disc inside a basin: its radius in the scaled plane, and the cell's centre that it has, as phase and speed.

    If the basin has no cell, the radius is 0 and the centre NaN.
    """

    radius: float
    time: float
    velocity: float


def _check(solution: np.typing.ArrayLike, grid: CellGrid, velocity_scale: float) -> tuple[np.ndarray, CellGrid]:
    array, checked = check_basins(solution), check_grid(grid)
    if array.shape != checked.shape:
        raise ValueError(f"solutions of shape {array.shape} are not those of a grid of shape {checked.shape}")
    if not (math.isfinite(velocity_scale) and velocity_scale > 0.0):
        raise ValueError(f"velocity_scale must be positive and finite, not {velocity_scale}")
    return array, checked


def _scaled_cell(grid: CellGrid, velocity_scale: float) -> tuple[float, float]:
    """Width and height of a cell in the scaled plane."""
    width = (grid.time_stop - grid.time_start) / grid.time_cells
    return width, (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells / velocity_scale


def global_integrity_measure(solution: np.typing.ArrayLike, index: int = 0) -> float:
    """Share of the cells that end in a motion (GIM).

    Parameters
    ----------
    solution : array_like of int, shape (velocity cells, time cells)
        Index of the motion that each cell ends in; none negative.
    index : int
        The motion; 0 is permanent contact.

    Returns
    -------
    float

    Notes
    -----
    ``GIM = (cells of the basin)/(cells of the window)``, as in Soliman and Thompson (1989) but for a window instead of
    all safe states. So it depends on the window.
    """
    return float((check_basins(solution) == index).mean())


def integrity_factor(
    solution: np.typing.ArrayLike, grid: CellGrid, index: int = 0, *, velocity_scale: float
) -> LargestDisc:
    """Largest disc about the centre of a cell that stays inside a motion's basin and the window (IF).

    Parameters
    ----------
    solution : array_like of int, shape (velocity cells, time cells)
        Index of the motion that each cell ends in; none negative.
    grid : CellGrid
        The window. If it spans a whole period, discs reach round the cylinder.
    index : int
        The motion; 0 is permanent contact.
    velocity_scale : float
        Speed that counts as much as one forcing period.

    Returns
    -------
    LargestDisc
        If several are largest, the one with the lowest cell number.

    Notes
    -----
    ``IF = max_x min_y |x - y|`` over centres x of the basin's cells and points y outside it, computed by an exact
    distance transform. Rega and Lenci (2005) allow any x. As the least distance changes by no more than x moves, that
    disc is larger by half the diagonal of a cell at most.
    """
    array, grid = _check(solution, grid, velocity_scale)
    if not (array == index).any():
        return LargestDisc(0.0, math.nan, math.nan)
    distance = distance_outside(array == index, *_scaled_cell(grid, velocity_scale), wraps=grid.wraps)
    row, column = np.unravel_index(np.argmax(distance), distance.shape)
    centre = float(grid.time_centres()[column]), float(grid.velocity_centres()[row])
    return LargestDisc(float(distance[row, column]), *centre)


@inlined
def _gap(cell, at):
    """Distance, in cells, from the coordinate `at` to the cell that spans [cell, cell + 1]; 0 inside it."""
    return max(cell - at, at - (cell + 1), 0.0)


@inlined
def _row_gap(outside, row, at, wraps, most):
    """Least gap from the column coordinate `at` to a cell of a row outside the basin, but at most `most`."""
    columns = outside.shape[1]
    middle = int(at)
    for away in range(columns):
        if away - 1.0 >= most:
            break
        for side in (-1, 1):
            column = middle + side * away
            if wraps:
                column %= columns
            elif not 0 <= column < columns:
                continue
            if outside[row, column]:
                most = min(most, _gap(middle + side * away, at))
    return most


@kernel
def _least_distance(outside, row, column, wraps, width, height, ends_below):
    """Distance from a point to the outside of the basin; its coordinates (row, column) are in cells."""
    rows, columns = outside.shape
    best = min((rows - row) * height, row * height if ends_below else math.inf)
    if not wraps:
        best = min(best, column * width, (columns - column) * width)
    middle = int(row)
    for away in range(rows):
        if (away - 1.0) * height >= best:
            break
        for other in (middle - away, middle + away):
            if not 0 <= other < rows:
                continue
            up = _gap(other, row) * height
            if up < best:
                most = math.sqrt(best * best - up * up) / width
                best = min(best, math.hypot(_row_gap(outside, other, column, wraps, most) * width, up))
    return best


def _distance_of_contact(outside: np.ndarray, grid: CellGrid, velocity_scale: float) -> float:
    """Scaled height of the rows, from v = 0 up, that lie entirely inside."""
    if grid.velocity_start > 0.0:
        return math.nan
    rows = np.flatnonzero(outside.any(axis=1))
    return float(rows[0] if rows.size else outside.shape[0]) * _scaled_cell(grid, velocity_scale)[1]


@kernel
def _holds(grid, t, v):
    return cell_number(grid, t, v) >= 0


def local_integrity_measure(
    solution: np.typing.ArrayLike,
    grid: CellGrid,
    attractors: Sequence[Attractor],
    index: int = 0,
    *,
    velocity_scale: float,
) -> float:
    """Radius of the largest disc about a motion's own states that stays inside its basin (LIM).

    Parameters
    ----------
    solution : array_like of int, shape (velocity cells, time cells)
        Index of the motion that each cell ends in; none negative.
    grid : CellGrid
        The window. If it spans a whole period, discs reach round the cylinder.
    attractors : sequence of Attractor
        The catalogue that ``solution`` indexes.
    index : int
        The motion; 0 is permanent contact.
    velocity_scale : float
        Speed that counts as much as one forcing period.

    Returns
    -------
    float
        In the scaled plane. 0 if a state lies in a cell of another motion. NaN if a state lies outside the window (for
        permanent contact: if the window does not begin at v = 0), or if the motion is undecided.

    Notes
    -----
    ``LIM = min |x - y|`` over the attractor's states x and points y outside its basin (Soliman and Thompson, 1989). For
    permanent contact x runs along v = 0. Negative speeds are not states, so v = 0 is not the end of a basin.
    """
    array, grid = _check(solution, grid, velocity_scale)
    outside = array != index
    attractor = attractors[index]
    if attractor.kind == AttractorKind.PERMANENT_CONTACT:
        return _distance_of_contact(outside, grid, velocity_scale)
    states = list(zip(attractor.time.tolist(), attractor.velocity.tolist(), strict=True))
    if not states or not all(_holds(grid, t, v) for t, v in states):
        return math.nan
    width, height = _scaled_cell(grid, velocity_scale)
    columns = wrap_all(attractor.time - grid.time_start) / width
    rows = (attractor.velocity - grid.velocity_start) / velocity_scale / height
    best = math.inf
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        around = _least_distance(outside, row, column, grid.wraps, width, height, grid.velocity_start > 0.0)
        best = min(best, around)
    return best
