"""Image of each cell under ``P_corr o P^k`` (Sec. 4, Fig. 5b).

The map starts from the cell's centre; only where ``P^k`` ends is put back on the grid.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.cell_mapping.cell_grid import SINK, CellGrid, cell_number, check_grid
from rattle_kernels.cell_mapping.iterations import check_iterations
from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from rattle_kernels.impact_map.chatter import is_captured
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.lanes.traps import NO_TRAPS, LaneTraps
from rattle_kernels.model.oscillator import Oscillator, check_domain
from rattle_kernels.model.outcome import OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped

PERMANENT_CONTACT = -2
UNDECIDED = -3


class CellImages(NamedTuple):
    """Images of a rectangle of cells, arrays of shape (rows, columns).

    ``image_cell`` (int64) is a cell number or SINK, PERMANENT_CONTACT, UNDECIDED; ``landing_time`` and
    ``landing_velocity`` (float64) are ``P^k(centre)``, NaN where captured or undecided; ``applications`` counts the
    applications of P that were computed.
    """

    image_cell: np.ndarray
    landing_time: np.ndarray
    landing_velocity: np.ndarray
    applications: int


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
            image_cell[i] = UNDECIDED
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
    """Image cells of a rectangle of the grid.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    grid : CellGrid
        The whole grid, not only the rectangle.
    iterations : int
        k, 1 or a prime.
    rows, columns : (int, int)
        Start and stop of the rectangle along velocity and along time.
    shortcuts : bool
        Lock and capture (see `impact_lanes`); without them every cell takes all k applications. No image of a
        trajectory that is not chaotic depends on them.
    traps : LaneTraps
        Of attractors known before (`build_trap_table`): a shortcut, too.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    CellImages

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    ValueError
        Where the grid or `iterations` is not valid.
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
    """Cells in which points land under ``P^k``, wherever they start.

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
        Where the oscillator's parameters lie outside the domain of the map.
    ValueError
        Where `iterations` is not valid.
    """
    checked = check_domain(oscillator)
    check_iterations(iterations)
    landing, run = run_lanes(checked, t, v, iterations, shortcuts=shortcuts, traps=traps, pause=pause)
    image_cell = np.empty(t.size, np.int64)
    bound = capture_bound(checked)
    _settle_images(checked, bound, grid, landing.outcome, landing.t, landing.v, image_cell)
    return CellImages(image_cell, landing.t, landing.v, run.applications)
