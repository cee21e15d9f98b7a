"""Picture of one basin in the paper's axes and colours (Figs. 6 to 16), complete or not."""

from collections.abc import Collection
from enum import StrEnum

import numpy as np
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle

from rattle_kernels import Attractor
from worker.pictures import colours
from worker.pictures.overlay_kind import OverlayKind, overlays_for
from worker.stores.basin_store import BasinStore
from worker.stores.layout import MISSING, SAMPLE_COORDINATES, TileState
from worker.stores.solution_table import SolutionTable

# Most points of a sample. The first ones of a Sobol sequence cover the window evenly, every second one only half of it.
_MOST_POINTS = 20_000


class Layer(StrEnum):
    """What a picture shows."""

    SOLUTION = "solution"
    GROUP = "group"
    PERIOD = "period"
    STEP = "step"


def frame(axes: Axes, extent: tuple[float, float, float, float]) -> None:
    """Limit axes to a window of the (t, v) plane, and label them.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    extent : (float, float, float, float)
        Least and largest time, least and largest speed.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> axes = Figure().subplots()
    >>> frame(axes, (0.0, 1.0, 0.0, 7.0))
    >>> axes.get_xlabel()
    'time t of departure (forcing periods)'
    """
    axes.set_xlim(*extent[:2])
    axes.set_ylim(*extent[2:])
    axes.set_xlabel("time t of departure (forcing periods)")
    axes.set_ylabel("velocity v of departure")


class PanelPicture:
    """Drawing of one panel.

    Parameters
    ----------
    store : BasinStore
    table : SolutionTable
    solutions : tuple of Attractor
        All solutions of the store, with the same colours in all panels.
    panel : int
    most_cells : int
        Most cells drawn each way. Beyond that, every n-th cell represents its neighbours (labels are not averaged).
    """

    def __init__(
        self, store: BasinStore, table: SolutionTable, solutions: tuple[Attractor, ...], panel: int, most_cells: int
    ) -> None:
        self.store, self.table, self.solutions, self.panel = store, table, solutions, panel
        self.every = 1 if store.job.sample else max(1, -(-max(store.job.grid.shape) // most_cells))
        self.tiles = store.tiling.numbers_of(panel)
        self.states = store.read_ledger()[self.tiles]
        self.palette = np.array([*colours.colours_of(solutions), colours.MISSING])
        grid = store.job.grid
        self.extent = grid.time_start, grid.time_stop, grid.velocity_start, grid.velocity_stop

    def _read(self, layer: Layer) -> np.ndarray:
        """A layer, read tile by tile and thinned if it is very large."""
        every = self.every
        rows, columns = (-(-cells // every) for cells in self.store.job.grid.shape)
        picture = np.full((rows, columns), MISSING, np.int64)
        places = self.store.places
        variable = tuple(each for each in (*places.labelled, places.solution) if each.name == layer)
        for number in np.array(self.tiles)[self.states == TileState.ASSEMBLED].tolist():
            tile = self.store.tiling.tile(number)
            (values,) = self.store.read_tile(variable, tile)
            first_row, first_column = -(-tile.rows[0] // every), -(-tile.columns[0] // every)
            part = values[first_row * every - tile.rows[0] :: every, first_column * every - tile.columns[0] :: every]
            picture[first_row : first_row + part.shape[0], first_column : first_column + part.shape[1]] = part
        return picture

    def _colours(self, solution: np.ndarray) -> np.ndarray:
        return self.palette[np.where(solution >= 0, solution, len(self.solutions))]

    def draw_solutions(self, axes: Axes) -> None:
        """Draw cells, or the points of a sample, in the colours of their solutions."""
        if self.store.job.sample is None:
            image = colours.paint_cells(self._read(Layer.SOLUTION), self._read(Layer.GROUP), self.solutions)
            axes.imshow(image, origin="lower", extent=self.extent, aspect="auto", interpolation="nearest")
        else:
            self._draw_points(axes)

    def _draw_points(self, axes: Axes) -> None:
        solution = self._read(Layer.SOLUTION)[0, :_MOST_POINTS]
        t, v = (values[:_MOST_POINTS] for values in self.store.read_whole(SAMPLE_COORDINATES))
        known = solution >= 0
        axes.scatter(t[known], v[known], s=2.0, c=self._colours(solution)[known], linewidths=0.0)
        axes.set_facecolor(colours.MISSING)

    def _catalogue(self) -> tuple[Attractor, ...]:
        numbers = self.table.numbers_in(self.panel)
        if not numbers and self.panel == 0:  # not complete, but its catalogue is known
            numbers = list(range(len(self.solutions)))
        return self.store.read_catalogue(self.panel, self.table, numbers)

    def draw_numbers(self, axes: Axes, layer: Layer) -> AxesImage:
        """Draw one of Hsu's numbers."""
        shown = np.ma.masked_equal(self._read(layer), MISSING)
        axes.set_facecolor(colours.MISSING)
        return axes.imshow(
            shown, origin="lower", extent=self.extent, aspect="auto", interpolation="nearest", cmap="turbo"
        )

    def hatch_missing(self, axes: Axes) -> None:
        """Hatch the tiles that are not labelled yet, densely if even their images are missing."""
        grid = self.store.job.grid
        width = (grid.time_stop - grid.time_start) / grid.time_cells
        height = (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells
        for at in np.flatnonzero(self.states != TileState.ASSEMBLED).tolist():
            # Points of a sample are spread over the window, whatever their tile.
            tile = self.store.tiling.tile(self.tiles[at])
            rows, columns = (
                (tile.rows, tile.columns) if self.store.job.sample is None else ((0, 1), (0, grid.time_cells))
            )
            corner = grid.time_start + columns[0] * width, grid.velocity_start + rows[0] * height
            size = (columns[1] - columns[0]) * width, (rows[1] - rows[0]) * height
            hatch = "xxx" if self.states[at] == TileState.PENDING else "//"
            axes.add_patch(
                Rectangle(corner, *size, facecolor=colours.MISSING, edgecolor="gray", hatch=hatch, linewidth=0.0)
            )

    def draw_overlays(self, axes: Axes, kinds: Collection[OverlayKind]) -> None:
        """Draw curves and marks over the panel, and limit the axes to the window."""
        oscillator = self.store.job.oscillator_of(self.panel)
        for overlay in overlays_for(kinds, oscillator, self._catalogue(), self.extent[2:]):
            overlay.draw(axes, self.extent[0])
        axes.set_xlim(self.extent[:2])
        axes.set_ylim(self.extent[2:])
