"""The grid of cells over a window of the (t, v) plane, and the cell that holds a point."""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.numerics.jit import inlined

# Rounding: 1.001 - 0.001 is not 1, yet that window spans a whole period.
_WHOLE_PERIOD = 1.0 - 1e-12

SINK = -1
"""Image of a cell that lands outside the grid."""


class CellGrid(NamedTuple):
    """Equal cells over ``[time_start, time_stop) x [velocity_start, velocity_stop)``.

    The cell number is ``i_v * time_cells + i_t``. Time is a phase in forcing periods. The window may cross phase 0, as
    from 0.9 to 1.1, and it wraps if it spans a whole period. The defaults are the paper's.
    """

    time_start: float = 0.0
    time_stop: float = 1.0
    time_cells: int = 1000
    velocity_start: float = 0.0
    velocity_stop: float = 7.0
    velocity_cells: int = 1000

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.time_cells * self.velocity_cells

    @property
    def shape(self) -> tuple[int, int]:
        """Rows along velocity, columns along time."""
        return self.velocity_cells, self.time_cells

    @property
    def wraps(self) -> bool:
        """Whether the window spans a whole period. No point then lies outside it in time."""
        return self.time_stop - self.time_start >= _WHOLE_PERIOD

    def time_centres(self) -> np.ndarray:
        """Phases of the cell centres, shape (time_cells,). They exceed 1 if the window crosses phase 0."""
        width = (self.time_stop - self.time_start) / self.time_cells
        return self.time_start + (np.arange(self.time_cells) + 0.5) * width

    def velocity_centres(self) -> np.ndarray:
        """Speeds of the cell centres, shape (velocity_cells,)."""
        height = (self.velocity_stop - self.velocity_start) / self.velocity_cells
        return self.velocity_start + (np.arange(self.velocity_cells) + 0.5) * height

    def cell_numbers(self, rows: tuple[int, int], columns: tuple[int, int]) -> np.ndarray:
        """Numbers of the cells of a rectangle, from start to stop along velocity and along time: one row a velocity."""
        return np.arange(*rows)[:, None] * self.time_cells + np.arange(*columns)


def check_grid(grid: CellGrid) -> CellGrid:
    """Return the grid with plain float and int fields, or raise if it is not valid.

    Raises
    ------
    ValueError
        Names the field, its value and the values allowed.
    """
    checked = CellGrid(
        float(grid.time_start), float(grid.time_stop), int(grid.time_cells),
        float(grid.velocity_start), float(grid.velocity_stop), int(grid.velocity_cells),
    )  # fmt: skip
    if not 0.0 <= checked.time_start < 1.0:
        raise ValueError(f"time_start must be a phase in [0, 1), not {checked.time_start}")
    if not 0.0 < checked.time_stop - checked.time_start <= 2.0 - _WHOLE_PERIOD:
        raise ValueError(
            f"time_stop must be above time_start = {checked.time_start} by at most one period, not {checked.time_stop}"
        )
    if not (checked.velocity_start >= 0.0 and math.isfinite(checked.velocity_stop)):
        raise ValueError(f"velocities must be finite and not negative, not {checked.velocity_start}")
    if not checked.velocity_start < checked.velocity_stop:
        raise ValueError(
            f"velocity_stop must be above velocity_start = {checked.velocity_start}, not {checked.velocity_stop}"
        )
    if checked.time_cells < 1 or checked.velocity_cells < 1:
        raise ValueError(
            f"a grid needs at least one cell each way, not {checked.time_cells} x {checked.velocity_cells}"
        )
    return checked


@inlined
def cell_number(grid, t, v):
    """Cell that holds the point (t, v), SINK if none does.

    Parameters
    ----------
    grid : CellGrid
        Checked by the caller.
    t, v : float
        Phase (any value) and speed, finite.

    Returns
    -------
    int
    """
    into = t - grid.time_start
    into -= math.floor(into)
    span = grid.time_stop - grid.time_start
    up = v - grid.velocity_start
    height = grid.velocity_stop - grid.velocity_start
    # A whole period has no outside, but a phase just below the start may round up to the span itself.
    if (into >= span and span < _WHOLE_PERIOD) or not 0.0 <= up < height:
        return SINK
    # Just inside an upper edge the quotient may round up to the number of cells.
    i_t = min(int(into / span * grid.time_cells), grid.time_cells - 1)
    i_v = min(int(up / height * grid.velocity_cells), grid.velocity_cells - 1)
    return i_v * grid.time_cells + i_t
