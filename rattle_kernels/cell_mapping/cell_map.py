"""Image of each cell under ``P_corr o P^k`` (Sec. 4, Fig. 5b).

Trajectories start from cell centres. Only the landing point of ``P^k`` is rounded to a cell.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.cell_mapping.cell_grid import SINK, CellGrid, cell_number, check_grid
from rattle_kernels.cell_mapping.iterations import check_iterations
from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from rattle_kernels.impact_map.chatter import is_captured
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.lanes.traps import NO_TRAPS, LaneTraps
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped

PERMANENT_CONTACT = -2
"""Image of a cell that ends in permanent contact."""

NOT_CONVERGED = -3
"""Image of a cell on whose way a root-finder gave up, called undecided in stores; none is expected."""


class CellImages(NamedTuple):
    """Images of a rectangle of cells, arrays of shape (rows, columns).

    ``image_cell`` (int64) is a cell number, SINK, PERMANENT_CONTACT or NOT_CONVERGED. ``landing_time`` and
    ``landing_velocity`` (float64) are ``P^k(centre)``, NaN if captured or not converged. ``applications`` is the number
    of applications of P computed.
    """

    image_cell: np.ndarray
    landing_time: np.ndarray
    landing_velocity: np.ndarray
    applications: int


def join_images(parts: Sequence[CellImages]) -> CellImages:
    """Images of some rectangles, one above the other, or of some lists of points as one."""
    image_cell, t, v = map(np.concatenate, zip(*(part[:3] for part in parts), strict=True))
    return CellImages(image_cell, t, v, sum(part.applications for part in parts))


@kernel
def _settle_images(oscillator, bound, grid, outcome, t, v, image_cell):
    for i in range(t.size):
        if outcome[i] == OUTCOME_PERMANENT_CONTACT or (
            outcome[i] == OUTCOME_RETURNED and is_captured(oscillator, bound, t[i], v[i])
        ):
            image_cell[i] = PERMANENT_CONTACT
        elif outcome[i] == OUTCOME_RETURNED:
            image_cell[i] = cell_number(grid, t[i], v[i])
        else:
            image_cell[i] = NOT_CONVERGED
        if image_cell[i] < SINK:
            t[i] = v[i] = np.nan


def map_cells(
    oscillator: Oscillator,
    grid: CellGrid,
    iterations: int,
    rows: tuple[int, int],
    columns: tuple[int, int],
    *,
    shortcuts: bool = True,
    traps: LaneTraps = NO_TRAPS,
    pause: Pause = never_stopped,
) -> CellImages:
    """Images of the cells in a rectangle of the grid.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    grid : CellGrid
        The whole grid, not only the rectangle.
    iterations : int
        k, 1 or a prime.
    rows, columns : (int, int)
        Start and stop of the rectangle along velocity and along time.
    shortcuts : bool
        Whether to use lock and capture (``lanes.run``). Without them every cell takes all k applications. Only
        images of chaotic trajectories depend on them.
    traps : LaneTraps
        Traps of attractors known beforehand (``build_trap_table``), another shortcut.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    CellImages

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If the grid or ``iterations`` is not valid.
    """
    check_grid(grid)
    times, velocities = grid.time_centres()[slice(*columns)], grid.velocity_centres()[slice(*rows)]
    t, v = np.tile(times, velocities.size), np.repeat(velocities, times.size)
    images = map_points(oscillator, grid, iterations, t, v, shortcuts=shortcuts, traps=traps, pause=pause)
    shape = velocities.size, times.size
    image_cell, landing_time, landing_velocity = (field.reshape(shape) for field in images[:3])
    return CellImages(image_cell, landing_time, landing_velocity, images.applications)


def map_points(
    oscillator: Oscillator,
    grid: CellGrid,
    iterations: int,
    t: np.ndarray,
    v: np.ndarray,
    *,
    shortcuts: bool = True,
    traps: LaneTraps = NO_TRAPS,
    pause: Pause = never_stopped,
) -> CellImages:
    """Cells in which arbitrary points land under ``P^k``.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    grid : CellGrid
        Its cells are the images.
    iterations : int
        k, 1 or a prime.
    t, v : ndarray of float64, shape (n,)
        Departures from +beta.
    shortcuts : bool
        As in `map_cells`.
    traps : LaneTraps
        As in `map_cells`.
    pause : callable
        As in `map_cells`.

    Returns
    -------
    CellImages
        Of shape (n,).

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If ``iterations`` is not valid.
    """
    checked = check_oscillator(oscillator)
    check_iterations(iterations)
    landing, run = run_lanes(checked, t, v, iterations, shortcuts=shortcuts, traps=traps, pause=pause)
    image_cell = np.empty(t.size, np.int64)
    bound = capture_bound(checked)
    _settle_images(checked, bound, grid, landing.outcome, landing.t, landing.v, image_cell)
    return CellImages(image_cell, landing.t, landing.v, run.applications)
