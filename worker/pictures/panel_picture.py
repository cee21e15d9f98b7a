"""Picture of one basin in the paper's axes (Figs. 6 to 16), complete or not."""

import itertools
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle

from rattle_kernels import Attractor
from rattle_kernels.basins.tiles import Tile
from worker.pictures import colours
from worker.pictures.overlay_kind import USUAL_OVERLAYS, OverlayKind, masks_among, overlays_for
from worker.pictures.window import Window, whole_window
from worker.stores.basin_store import BasinStore
from worker.stores.layout import MISSING, SAMPLE_COORDINATES, TileState
from worker.stores.pyramid import level_for
from worker.stores.solution_table import SolutionTable

# Most points of a sample. The first ones of a Sobol sequence cover the window evenly, every second one only half of it.
_MOST_POINTS = 20_000


class Layer(StrEnum):
    """What a picture shows."""

    SOLUTION = "solution"
    GROUP = "group"
    PERIOD = "period"
    STEP = "step"


def draw_points(axes: Axes, t: np.ndarray, v: np.ndarray, solution: np.ndarray, palette: np.ndarray) -> None:
    """Draw points of a sample, up to 20,000 of them, each in the colour of its solution."""
    known = np.flatnonzero(solution[:_MOST_POINTS] >= 0)
    axes.scatter(t[known], v[known], s=2.0, c=palette[solution[known]], linewidths=0.0)
    axes.set_facecolor(colours.MISSING)


@dataclass(frozen=True)
class Look:
    """How basins are drawn.

    Parameters
    ----------
    layer : Layer
        Solutions, or one of Hsu's numbers.
    overlays : collection of OverlayKind
        What lies over each basin.
    window : Window, optional
        What is shown of each; by default all that is computed.
    panel : int, optional
        The one basin of a sweep that is shown; by default all, side by side.
    palette : Palette
        Colours of motions.
    """

    layer: Layer = Layer.SOLUTION
    overlays: Collection[OverlayKind] = USUAL_OVERLAYS
    window: Window | None = None
    panel: int | None = None
    palette: colours.Palette = colours.USUAL


USUAL_LOOK = Look()


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
        Most cells drawn each way. Beyond that, every n-th cell represents its neighbours (labels are not averaged). If
        the store has levels, n is a power of two, and the cells are read from the level that has just these.
    look : Look
    """

    def __init__(
        self, store: BasinStore, table: SolutionTable, solutions: tuple[Attractor, ...], panel: int, most_cells: int,
        look: Look = USUAL_LOOK,
    ) -> None:  # fmt: skip
        self.store, self.table, self.solutions, self.panel, self.look = store, table, solutions, panel, look
        self.most_cells = most_cells
        self.tiles = store.tiling.numbers_of(panel)
        self.states = store.read_ledger()[self.tiles]
        self.palette = np.array([*colours.colours_of(solutions, look.palette), colours.MISSING])
        self.grid = store.job.grid
        self.whole = whole_window(self.grid)
        self.window = look.window or self.whole
        self.periods = range(1) if self.window == self.whole else self.window.periods_over(self.grid)
        self.every = 1 if store.job.sample else max(1, -(-self._most_shown() // most_cells))
        if len(store.whole_levels) > 1:
            self.every = 1 << (self.every - 1).bit_length()
        self.level = level_for(store.whole_levels, self.every)

    def _most_shown(self) -> int:
        """Most cells that are shown each way."""
        return max(stop - start for period in self.periods for start, stop in self.window.cells_of(self.grid, period))

    def _read(
        self, read: Callable[[Tile], np.ndarray | None], rows: tuple[int, int], columns: tuple[int, int]
    ) -> np.ndarray:
        """Part of what the tiles hold, read tile by tile and thinned if very large. It begins at thinned cells."""
        every = self.every
        first_row, first_column = rows[0] // every, columns[0] // every
        shape = -(-rows[1] // every) - first_row, -(-columns[1] // every) - first_column
        picture = np.full(shape, MISSING, np.int64)
        stride = every // self.level.every
        wanted = [(-(-start // self.level.every), -(-stop // self.level.every)) for start, stop in (rows, columns)]
        for number in self._tiles_there():
            tile = self.level.tiling.tile(number)
            lines, strips = (
                _shared(own, side, stride) for own, side in zip((tile.rows, tile.columns), wanted, strict=True)
            )
            values = read(tile) if lines and strips else None
            if values is None:
                continue
            part = values[
                lines.start * stride - tile.rows[0] : tile.rows[1] - tile.rows[0] : stride,
                strips.start * stride - tile.columns[0] : tile.columns[1] - tile.columns[0] : stride,
            ][: len(lines), : len(strips)]
            row, column = lines.start - first_row, strips.start - first_column
            picture[row : row + part.shape[0], column : column + part.shape[1]] = part
        return picture

    def _of_layer(self, layer: Layer) -> Callable[[Tile], np.ndarray]:
        places = self.store.places
        named = (each for each in (*places.labelled, places.solution) if each.name == layer)
        variable = tuple(self.level.own(each) for each in named)
        return lambda tile: self.store.tiles.read(variable, tile)[0]

    def _tiles_there(self) -> list[int]:
        """Tiles of the level that can be read; levels are there as a whole."""
        if self.level.number:
            return list(self.level.tiling.numbers_of(self.panel))
        return np.array(self.tiles)[self.states == TileState.ASSEMBLED].tolist()

    def _parts(self) -> Iterator[tuple[tuple[int, int], tuple[int, int], tuple[float, float, float, float]]]:
        """Rows and columns of cells that are shown, with their place; twice where the window crosses the grid's end."""
        grid, every = self.grid, self.every
        width = (grid.time_stop - grid.time_start) / grid.time_cells
        height = (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells
        for period in self.periods:
            rows, columns = self.window.cells_of(grid, period)
            if self.window == self.whole:
                yield rows, columns, self.whole
            elif rows[0] < rows[1] and columns[0] < columns[1]:
                rows, columns = ((start // every * every, -(-stop // every) * every) for start, stop in (rows, columns))
                t, v = grid.time_start + period, grid.velocity_start
                place = (t + columns[0] * width, t + columns[1] * width, v + rows[0] * height, v + rows[1] * height)
                yield rows, columns, place

    def draw_solutions(self, axes: Axes) -> None:
        """Draw cells, or the points of a sample, in the colours of their solutions."""
        if self.window != self.whole:
            axes.set_facecolor(colours.MISSING)
        if self.store.job.sample is not None:
            self._draw_points(axes)
            return
        usual = None if self.window == self.whole else self._usual_speckle()
        for rows, columns, place in self._parts():
            solution, group = (
                self._read(self._of_layer(layer), rows, columns) for layer in (Layer.SOLUTION, Layer.GROUP)
            )
            image = colours.paint_cells(solution, group, self.solutions, self.look.palette, usual)
            axes.imshow(image, origin="lower", extent=place, aspect="auto", interpolation="nearest")

    def _usual_speckle(self) -> int:
        """That of the whole panel: each of its windows has the same."""
        look = replace(self.look, window=None)
        panel = PanelPicture(self.store, self.table, self.solutions, self.panel, self.most_cells, look)
        sides = (0, self.grid.velocity_cells), (0, self.grid.time_cells)
        solution, group = (panel._read(panel._of_layer(layer), *sides) for layer in (Layer.SOLUTION, Layer.GROUP))
        return colours.usual_speckle(solution, group, self.solutions)

    def _draw_points(self, axes: Axes) -> None:
        solution = self._read(self._of_layer(Layer.SOLUTION), (0, 1), (0, self.grid.time_cells))[0]
        t, v = self.store.read_whole(SAMPLE_COORDINATES)
        for period in self.periods:
            draw_points(axes, t + period, v, solution, self.palette)

    def _catalogue(self) -> tuple[Attractor, ...]:
        numbers = self.table.numbers_in(self.panel)
        if not numbers and self.panel == 0:  # not complete, but its catalogue is known
            numbers = list(range(len(self.solutions)))
        return self.store.solutions.read_catalogue(self.panel, self.table, numbers)

    def draw_numbers(self, axes: Axes, layer: Layer) -> list[AxesImage]:
        """Draw one of Hsu's numbers."""
        axes.set_facecolor(colours.MISSING)
        return [
            axes.imshow(
                np.ma.masked_equal(self._read(self._of_layer(layer), rows, columns), MISSING),
                origin="lower", extent=place, aspect="auto", interpolation="nearest", cmap="turbo",
            )
            for rows, columns, place in self._parts()
        ]  # fmt: skip

    def draw_masks(self, axes: Axes) -> None:
        """Draw the masks that are asked for. Basins with levels have none, so tiles are those of the cells themselves.

        Raises
        ------
        InvalidJob
            If the store lacks one.
        """
        for mask in masks_among(self.look.overlays):
            mask.demand(self.store.holds(mask.variable))
            read = partial(self.store.tiles.read_one, mask.variable)
            share = mask.share(read(self.store.tiling.tile(number)) for number in self.tiles)
            for rows, columns, place in self._parts():
                mask.draw(axes, self._read(read, rows, columns), place, share)

    def hatch_missing(self, axes: Axes) -> None:
        """Hatch the tiles that are not labelled yet, densely if even their images are missing."""
        grid = self.grid
        width = (grid.time_stop - grid.time_start) / grid.time_cells
        height = (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells
        for at, period in itertools.product(np.flatnonzero(self.states != TileState.ASSEMBLED).tolist(), self.periods):
            # Points of a sample are spread over the window, whatever their tile.
            tile = self.store.tiling.tile(self.tiles[at])
            rows, columns = (
                (tile.rows, tile.columns) if self.store.job.sample is None else ((0, 1), (0, grid.time_cells))
            )
            corner = grid.time_start + period + columns[0] * width, grid.velocity_start + rows[0] * height
            size = (columns[1] - columns[0]) * width, (rows[1] - rows[0]) * height
            hatch = "xxx" if self.states[at] == TileState.PENDING else "//"
            axes.add_patch(
                Rectangle(corner, *size, facecolor=colours.MISSING, edgecolor="gray", hatch=hatch, linewidth=0.0)
            )

    def draw_overlays(self, axes: Axes) -> None:
        """Draw curves and marks over the panel, and limit the axes to the window."""
        oscillator = self.store.job.oscillator_of(self.panel)
        # A curve that leaves the window may return: it ends only where it leaves what is computed, too.
        speeds = (
            min(self.window.velocity_start, self.whole.velocity_start),
            max(self.window.velocity_stop, self.whole.velocity_stop),
        )
        for overlay in overlays_for(self.look.overlays, oscillator, self._catalogue(), speeds):
            overlay.draw(axes, self.window.time_start)
        axes.set_xlim(self.window[:2])
        axes.set_ylim(self.window[2:])


def _shared(own: tuple[int, int], wanted: tuple[int, int], every: int) -> range:
    """Every n-th cell that a tile shares with a part of the grid, by its number among every n-th cell."""
    start, stop = max(own[0], wanted[0]), min(own[1], wanted[1])
    return range(-(-start // every), -(-stop // every))
