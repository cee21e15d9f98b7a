"""The part of the plane of departures that a picture shows."""

import math
from typing import NamedTuple

from rattle_kernels import CellGrid
from worker.errors import InvalidJob

# Below, the ends of an axis are too near each other for double precision; the explorer stops there, too.
_NARROWEST = 1e-9
# Ends are written with some 12 digits each, so a whole period may come out a little longer.
_WIDEST = 1.0 + 1e-9


class Window(NamedTuple):
    """Times and speeds that a picture shows. Phases repeat: a window may lie across the end of the grid.

    Parameters
    ----------
    time_start, time_stop : float
        At most one period.
    velocity_start, velocity_stop : float

    Examples
    --------
    >>> Window(0.75, 1.25, 3.0, 5.0).periods_over(CellGrid())
    range(0, 2)
    """

    time_start: float
    time_stop: float
    velocity_start: float
    velocity_stop: float

    def periods_over(self, grid: CellGrid) -> range:
        """By how many periods the grid is moved so that it, or a part, lies within the window."""
        return range(
            math.floor(self.time_start - grid.time_stop) + 1, math.ceil(self.time_stop - grid.time_start)
        )  # fmt: skip

    def cells_of(self, grid: CellGrid, period: int) -> tuple[tuple[int, int], tuple[int, int]]:
        """Rows and columns of the grid's cells, as (start, stop), that the window shows of the grid moved so far."""
        height = (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells
        width = (grid.time_stop - grid.time_start) / grid.time_cells
        start = grid.time_start + period
        return (
            _overlap(self.velocity_start, self.velocity_stop, grid.velocity_start, height, grid.velocity_cells),
            _overlap(self.time_start, self.time_stop, start, width, grid.time_cells),
        )


def _overlap(start: float, stop: float, first: float, size: float, cells: int) -> tuple[int, int]:
    return (
        min(max(math.floor((start - first) / size), 0), cells),
        min(max(math.ceil((stop - first) / size), 0), cells),
    )


def whole_window(grid: CellGrid) -> Window:
    """Window that shows all of a grid."""
    return Window(grid.time_start, grid.time_stop, grid.velocity_start, grid.velocity_stop)


def parse_window(text: str) -> Window:
    """Window from four numbers separated by commas: time from, to, speed from, to.

    Raises
    ------
    InvalidJob
        If it is no window.

    Examples
    --------
    >>> parse_window("0.2,0.6,3,5")
    Window(time_start=0.2, time_stop=0.6, velocity_start=3.0, velocity_stop=5.0)
    """
    try:
        window = Window(*map(float, text.split(",")))
    except (ValueError, TypeError):
        raise InvalidJob(f"a window is four numbers, time from, to, speed from, to: 0.2,0.6,3,5, not {text}") from None
    if not all(map(math.isfinite, window)):
        raise InvalidJob(f"the numbers of a window are finite, not {text}")
    if not -1.0 <= window.time_start <= 2.0:
        raise InvalidJob(f"a window begins at a time from -1 to 2, as phases repeat, not at {window.time_start:g}")
    for axis, start, stop in (("time", *window[:2]), ("velocity", *window[2:])):
        if not stop - start >= _NARROWEST:
            raise InvalidJob(f"the {axis} of a window ends {_NARROWEST:g} or more above its start, not at {stop:g}")
    if window.time_stop - window.time_start > _WIDEST:
        raise InvalidJob(f"a window is at most one period wide, not {window.time_stop - window.time_start:g}")
    return window


def demand_overlap(window: Window, grid: CellGrid) -> Window:
    """Return the window, or raise if it shows nothing of a grid.

    Raises
    ------
    InvalidJob
        With the window of the grid.
    """
    above = window.velocity_start < grid.velocity_stop and grid.velocity_start < window.velocity_stop
    if not (above and window.periods_over(grid)):
        covered = f"t {grid.time_start:g} to {grid.time_stop:g}, v {grid.velocity_start:g} to {grid.velocity_stop:g}"
        raise InvalidJob(f"nothing was computed in this window; the job covers {covered}")
    return window
