"""One basin on axes in the paper's units (Figs. 6 to 16), complete or not: cells or points, what is missing, overlays.

All is drawn from a dataset. Of a large basin in a store those of its levels are read, too, so that a picture reads no
more cells than it shows.
"""

import itertools
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle

from rattle_kernels import CellGrid, loudness
from worker.additions import additions
from worker.errors import StoreFailed
from worker.jobs.basin_job import BasinJob
from worker.pictures import colours
from worker.pictures.annotations import Annotation
from worker.pictures.overlay import Overlay
from worker.pictures.overlay_kind import USUAL_OVERLAYS, OverlayKind, masks_among, overlays_for
from worker.pictures.window import Window, whole_window
from worker.results.opening import LEVEL, attractors_of, basin_at, job_of, open_level
from worker.stores.layout import MISSING, NOT_THERE, TileState
from worker.stores.new_store import tiling_of
from worker.stores.pyramid import Level, level_for

MOST_CELLS = 2000
"""Most cells drawn each way, of all panels of a figure together."""
# Most points of a sample. The first ones of a Sobol sequence cover the window evenly, every second one only half of it.
_MOST_POINTS = 20_000
TIME, VELOCITY = "time t of departure (forcing periods)", "velocity v of departure"
"""Labels of axes."""

Part = tuple[int, int]
"""Cells along one axis, from start to stop."""


class Layer(StrEnum):
    """What a picture shows."""

    SOLUTION = "solution"
    GROUP = "group"
    PERIOD = "period"
    STEP = "step"
    LOUDNESS = "loudness"


@dataclass(frozen=True)
class Look:
    """How basins are drawn.

    Parameters
    ----------
    layer : Layer
        Solutions, one of Hsu's numbers, or the impact power of the motion that a cell ends in.
    overlays : collection of str
        What lies over each basin, of `OverlayKind`.
    window : Window, optional
        What is shown of each; by default all that is computed.
    panel : int, optional
        The one basin of a sweep that is shown; by default all, side by side.
    palette : Palette
        Colours of motions.
    own_colours : mapping of str to colour or Paint
        Other colours of some motions, by name.
    legend : bool
        Whether the motions are listed.
    overlay_key : bool
        Whether every overlay that is drawn is named: also its marks, and where no motions are listed.
    annotations : tuple of Annotation
        What a reader has written on each basin.
    """

    layer: Layer = Layer.SOLUTION
    overlays: Collection[str] = USUAL_OVERLAYS
    window: Window | None = None
    panel: int | None = None
    palette: colours.Palette = colours.USUAL
    own_colours: Mapping[str, colours.Colour | colours.Paint] = field(default_factory=dict)
    legend: bool = True
    overlay_key: bool = False
    annotations: tuple[Annotation, ...] = ()


USUAL_LOOK = Look()


@dataclass(frozen=True)
class Basins:
    """Basins to draw: their dataset, and if they lie in a store, what can be read there of their levels.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a basin or a sweep, whole or in part, or of one level.
    location : str, optional
        The store that it was opened from, whose cells are all there where its ledger says so.
    levels : tuple of Level
        The levels of the store that can be read, the basins themselves first.
    """

    dataset: xr.Dataset
    location: str | None = None
    levels: tuple[Level, ...] = ()

    @cached_property
    def job(self) -> BasinJob:
        """Their job."""
        return job_of(self.dataset)

    def at_level(self, number: int) -> xr.Dataset:
        """The dataset of a level."""
        return open_level(self.location, number) if self.location and number else self.dataset


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
    axes.set(xlabel=TIME, ylabel=VELOCITY)


def _own_axis(centres: np.ndarray, start: float, stop: float, cells: int, every: int) -> tuple[float, float]:
    """Outer edges of the cells of a dataset along one axis of the grid; of a level each is `every` cells wide."""
    size = (stop - start) / cells
    first = round((float(centres[0]) - start) / size - 0.5)
    every = round(float(centres[1] - centres[0]) / size) if centres.size > 1 else every
    last = first + every * centres.size
    return start + first * size, stop if last == cells else start + last * size


def _own_grid(basin: xr.Dataset, grid: CellGrid) -> CellGrid:
    """The cells that a dataset of a basin has, as a grid: that of its job if it has all of them."""
    if "sample" in basin.dims:
        return grid
    every = 1 << basin.attrs.get(LEVEL, 0)
    time = _own_axis(basin.time.values, *grid[:3], every)
    velocity = _own_axis(basin.velocity.values, *grid[3:], every)
    return CellGrid(*time, basin.sizes["time"], *velocity, basin.sizes["velocity"])


class Panel:
    """Drawing of one basin.

    Parameters
    ----------
    basins : Basins
    number : int
        Which of them.
    look : Look
    most_cells : int
        Most cells drawn each way. Beyond that, every n-th cell represents its neighbours (labels are not averaged). If
        the store has levels, n is a power of two, and the cells are read from the level that has just these.
    """

    def __init__(self, basins: Basins, number: int, look: Look = USUAL_LOOK, most_cells: int = MOST_CELLS) -> None:
        self.basins, self.number, self.look, self.most_cells = basins, number, look, most_cells
        self.job = basins.job
        self.basin = basin_at(basins.dataset, self.job, number)
        self.attractors = attractors_of(self.basin)
        self.tiling = tiling_of(self.job)
        # Before the cells are read: what it says is there stays there.
        states = self.basin.tile_state.values if "tile_state" in self.basin else np.array(TileState.ASSEMBLED)
        self.states = np.broadcast_to(states, self.tiling.shape)
        own = _own_grid(self.basin, self.job.grid)
        # The cells at the upper edges of a level may stand for fewer.
        ends = min(own.time_stop, self.job.grid.time_stop), min(own.velocity_stop, self.job.grid.velocity_stop)
        self.whole = whole_window(own._replace(time_stop=ends[0], velocity_stop=ends[1]))
        self.window = look.window or self.whole
        self.periods = range(1) if self.window == self.whole else self.window.periods_over(own)
        sides = (side for period in self.periods for side in self.window.cells_of(own, period))
        self.every = 1 if self.job.sample else max(1, -(-max(b - a for a, b in sides) // most_cells))
        self.shown, self.grid = self.basin, own
        if len(basins.levels) > 1:
            self.every = 1 << (self.every - 1).bit_length()
            level = level_for(basins.levels, self.every)
            self.shown = basin_at(basins.at_level(level.number), self.job, number)
            self.grid = _own_grid(self.shown, self.job.grid)
            self.every //= level.every

    def _parts(self) -> Iterator[tuple[Part, Part, tuple[float, float, float, float]]]:
        """Rows and columns that are shown, with their place; twice where the window crosses the grid's end.

        They begin at cells that are kept where only every n-th is.
        """
        for period in self.periods:
            sides = self.window.cells_of(self.grid, period)
            if all(start < stop for start, stop in sides):
                rows, columns = ((a // self.every * self.every, -(-b // self.every) * self.every) for a, b in sides)
                time = self._edges(columns, self.grid.time_start, self.grid.time_stop, self.grid.time_cells)
                velocity = self._edges(
                    rows, self.grid.velocity_start, self.grid.velocity_stop, self.grid.velocity_cells
                )
                yield rows, columns, (time[0] + period, time[1] + period, *velocity)

    def _edges(self, part: Part, start: float, stop: float, cells: int) -> tuple[float, float]:
        first, last = (stop if cell == cells else start + cell * ((stop - start) / cells) for cell in part)
        return first, last

    def _read(self, name: str, rows: Part, columns: Part, missing: int = MISSING) -> np.ndarray:
        """Part of what the cells have, thinned if very large: where the ledger says that it is there.

        Of an unfinished basin only such tiles are read. Levels are there as a whole.
        """
        if (self.states == TileState.ASSEMBLED).all():
            return self._values(name, rows, columns)
        grid = self.job.grid
        down = self._tiles_of(self.shown.velocity, rows, grid[3:], self.tiling.tile_rows)
        across = self._tiles_of(self.shown.time, columns, grid[:3], self.tiling.tile_columns)
        picture = np.full((down.size, across.size), missing, np.int64)
        for row, column in np.argwhere(self.states == TileState.ASSEMBLED).tolist():
            lines, strips = np.flatnonzero(down == row), np.flatnonzero(across == column)
            if lines.size and strips.size:
                of_rows, of_columns = (
                    (start + own[0] * self.every, start + (own[-1] + 1) * self.every)
                    for own, start in ((lines, rows[0]), (strips, columns[0]))
                )
                picture[np.ix_(lines, strips)] = self._values(name, of_rows, of_columns)
        return picture

    def _tiles_of(self, centres: xr.DataArray, part: Part, axis: tuple[float, float, int], side: int) -> np.ndarray:
        """Number of the tile of each cell that is kept, along one axis."""
        start, stop, cells = axis
        kept = centres.values[slice(*part, self.every)]
        return ((kept - start) / ((stop - start) / cells)).astype(int) // side

    def _values(self, name: str, rows: Part, columns: Part) -> np.ndarray:
        kept = {"velocity": slice(*rows, self.every), "time": slice(*columns, self.every)}
        values: np.ndarray = self.shown[name].isel(kept).values
        if self.basins.location is not None and (values == MISSING).any():
            raise StoreFailed(f"the store {self.basins.location} has lost a part of {name}")
        return values

    def draw_solutions(self, axes: Axes) -> None:
        """Draw cells, or the points of a sample, in the colours of their solutions."""
        if self.window != self.whole:
            axes.set_facecolor(colours.MISSING)
        if self.job.sample is not None:
            self._draw_points(axes)
            return
        usual = None if self.window == self.whole else self._usual_speckle()
        for rows, columns, place in self._parts():
            solution, group = (self._read(layer, rows, columns) for layer in (Layer.SOLUTION, Layer.GROUP))
            image = colours.paint_cells(
                solution, group, self.attractors, self.look.palette, usual, self.look.own_colours
            )  # fmt: skip
            axes.imshow(image, origin="lower", extent=place, aspect="auto", interpolation="nearest")

    def _usual_speckle(self) -> int:
        """That of the whole panel: each of its windows has the same."""
        panel = Panel(self.basins, self.number, replace(self.look, window=None), self.most_cells)
        sides = (0, panel.grid.velocity_cells), (0, panel.grid.time_cells)
        solution, group = (panel._read(layer, *sides) for layer in (Layer.SOLUTION, Layer.GROUP))
        return colours.usual_speckle(solution, group, self.attractors)

    def _draw_points(self, axes: Axes) -> None:
        first = {"sample": slice(_MOST_POINTS)}
        t, v, solution = (self.basin[name].isel(first).values for name in ("time", "velocity", "solution"))
        tiles = np.arange(solution.size) // self.tiling.tile_columns
        known = (self.states[0, tiles] == TileState.ASSEMBLED) & (solution >= 0)
        paints = colours.paints_of(self.attractors, self.look.palette, self.look.own_colours)
        colour = np.array([paint.colour for paint in paints]).reshape(-1, 3)[solution[known]]
        for period in self.periods:
            axes.scatter(t[known] + period, v[known], s=2.0, c=colour, linewidths=0.0)
        axes.set_facecolor(colours.MISSING)

    def draw_numbers(self, axes: Axes) -> list[AxesImage]:
        """Draw one of Hsu's numbers."""
        axes.set_facecolor(colours.MISSING)
        return [
            axes.imshow(
                np.ma.masked_equal(self._read(self.look.layer, rows, columns), MISSING),
                origin="lower", extent=place, aspect="auto", interpolation="nearest", cmap="turbo",
            )
            for rows, columns, place in self._parts()
        ]  # fmt: skip

    def draw_loudness(self, axes: Axes) -> list[AxesImage]:
        """Draw the impact power of the motion that each cell ends in; cells whose power is not known are grey."""
        axes.set_facecolor(colours.MISSING)
        oscillator = self.job.oscillator_of(self.number)
        # Last, where a cell without a solution finds it.
        power = np.array([*(loudness(oscillator, each).impact_power for each in self.attractors), np.nan])
        return [
            axes.imshow(
                np.ma.masked_invalid(power[np.maximum(self._read(Layer.SOLUTION, rows, columns), -1)]),
                origin="lower", extent=place, aspect="auto", interpolation="nearest", cmap="viridis",
            )
            for rows, columns, place in self._parts()
        ]  # fmt: skip

    def draw_masks(self, axes: Axes, kinds: Collection[str]) -> None:
        """Draw the masks among overlays.

        Raises
        ------
        InvalidJob
            If the basin lacks one.
        """
        for mask in masks_among(kinds):
            name = mask.variable.name
            mask.demand(name in self.basin)
            share = mask.share([self.basin[name].values]) if self.grid.shape == self.job.grid.shape else None
            for rows, columns, place in self._parts():
                mask.draw(axes, self._read(name, rows, columns, NOT_THERE), place, share)

    def hatch_missing(self, axes: Axes) -> None:
        """Hatch the tiles that are not labelled yet, densely if even their images are missing."""
        grid = self.job.grid
        width = (grid.time_stop - grid.time_start) / grid.time_cells
        height = (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells
        states = self.states.ravel()
        for at, period in itertools.product(np.flatnonzero(states != TileState.ASSEMBLED).tolist(), self.periods):
            # Points of a sample are spread over the window, whatever their tile.
            tile = self.tiling.tile(at)
            rows, columns = (tile.rows, tile.columns) if self.job.sample is None else ((0, 1), (0, grid.time_cells))
            corner = grid.time_start + period + columns[0] * width, grid.velocity_start + rows[0] * height
            size = (columns[1] - columns[0]) * width, (rows[1] - rows[0]) * height
            hatch = "xxx" if states[at] == TileState.PENDING else "//"
            axes.add_patch(
                Rectangle(corner, *size, facecolor=colours.MISSING, edgecolor="gray", hatch=hatch, linewidth=0.0)
            )

    def draw_overlays(self, axes: Axes) -> None:
        """Draw curves and marks over the panel, and limit the axes to the window."""
        # A curve that leaves the window may return: it ends only where it leaves what is computed, too.
        speeds = (
            min(self.window.velocity_start, self.whole.velocity_start),
            max(self.window.velocity_stop, self.whole.velocity_stop),
        )
        oscillator = self.job.oscillator_of(self.number)
        for overlay in overlays_for(self.look.overlays, oscillator, self.attractors, speeds):
            overlay.draw(axes, self.window.time_start)
        for annotation in self.look.annotations:
            annotation.draw(axes, self.window.time_start)
        axes.set_xlim(self.window[:2])
        axes.set_ylim(self.window[2:])

    def draw(self, axes: Axes) -> list[AxesImage]:
        """Draw all that is asked for. Returns the images that a scale belongs to."""
        images: list[AxesImage] = []
        if self.look.layer == Layer.SOLUTION:
            self.draw_solutions(axes)
        elif self.look.layer == Layer.LOUDNESS:
            images = self.draw_loudness(axes)
        else:
            images = self.draw_numbers(axes)
        self.draw_masks(axes, self.look.overlays)
        self.hatch_missing(axes)
        self.draw_overlays(axes)
        return images


class MaskOverlay(NamedTuple):
    """A mask of a basin, to be drawn on axes of the (t, v) plane."""

    dataset: xr.Dataset
    kind: str

    def draw(self, axes: Axes, time_start: float = 0.0) -> None:
        """Draw it; an `InvalidJob` if the basin lacks it. The dataset says where it lies."""
        Panel(Basins(self.dataset), 0).draw_masks(axes, (self.kind,))


def overlays_of(dataset: xr.Dataset, names: Collection[str] = ()) -> tuple[Overlay | MaskOverlay, ...]:
    """Overlays of a basin, of some `OverlayKind`; by default all that there are.

    Raises
    ------
    InvalidJob
        If a name is unknown, or this oscillator has no such overlay.
    """
    job = job_of(dataset)
    speeds = job.grid.velocity_start, job.grid.velocity_stop
    found = overlays_for(names or list(OverlayKind), job.oscillator, attractors_of(dataset), speeds)
    there = [addition.overlay for addition in additions() if addition.mask().variable.name in dataset]
    masks = [addition.overlay for addition in additions() if addition.overlay in (names or there)]
    return (*(MaskOverlay(dataset, kind) for kind in masks), *found)
