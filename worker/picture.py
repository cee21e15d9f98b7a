"""Pictures of a basin in the paper's axes and colours (Figs. 6 to 16), also while tiles are still coming."""

import math
from enum import StrEnum
from pathlib import Path
from typing import IO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from rattle_kernels import Attractor, AttractorKind, Oscillator, grazing_velocity
from worker import colours
from worker.layout import LABELLED, MISSING, TileState
from worker.store import BasinStore

# Cells drawn each way at the most: beyond, every n-th cell stands for its neighbours (labels may not be averaged).
_MOST_CELLS = 2000
_LEGEND_ROWS = 18


class Layer(StrEnum):
    """What a picture shows."""

    SOLUTION = "solution"
    GROUP = "group"
    PERIOD = "period"
    STEP = "step"


def _every(store: BasinStore) -> int:
    return max(1, -(-max(store.job.grid.shape) // _MOST_CELLS))


def _read(store: BasinStore, layer: Layer) -> np.ndarray:
    """A layer, thinned out where it is very large, read tile by tile."""
    every = _every(store)
    rows, columns = (-(-cells // every) for cells in store.job.grid.shape)
    picture = np.full((rows, columns), MISSING, np.int64)
    variable = tuple(variable for variable in LABELLED if variable.name == layer)
    for number in np.flatnonzero(store.read_ledger() == TileState.ASSEMBLED):
        tile = store.tiling.tile(int(number))
        (values,) = store.read_tile(variable, tile)
        first_row, first_column = -(-tile.rows[0] // every), -(-tile.columns[0] // every)
        part = values[first_row * every - tile.rows[0] :: every, first_column * every - tile.columns[0] :: every]
        picture[first_row : first_row + part.shape[0], first_column : first_column + part.shape[1]] = part
    return picture


def _extent(store: BasinStore) -> tuple[float, float, float, float]:
    grid = store.job.grid
    return grid.time_start, grid.time_stop, grid.velocity_start, grid.velocity_stop


def _draw_solutions(axes: Axes, store: BasinStore) -> None:
    attractors = store.read_attractors()
    image = colours.paint_cells(_read(store, Layer.SOLUTION), _read(store, Layer.GROUP), attractors)
    axes.imshow(image, origin="lower", extent=_extent(store), aspect="auto", interpolation="nearest")
    draw_attractors(axes, attractors, store.job.grid.time_start)
    if attractors:
        draw_legend(axes, attractors, store.read_shares())


def draw_attractors(axes: Axes, attractors: tuple[Attractor, ...], time_start: float) -> None:
    """Mark the states of attractors at phases from `time_start` on: white crosses, black dots for chaos."""
    for attractor in attractors:
        t = time_start + (attractor.time - time_start) % 1.0
        if attractor.kind == AttractorKind.PERIODIC:
            axes.plot(t, attractor.velocity, "x", color="white", markersize=7, markeredgewidth=1.6)
        elif attractor.kind == AttractorKind.CHAOTIC:
            axes.plot(t, attractor.velocity, ".", color="black", markersize=1.0, markeredgewidth=0.0)


def draw_legend(axes: Axes, attractors: tuple[Attractor, ...], shares: np.ndarray) -> None:
    """List attractors with colour and share beside the axes, permanent contact first, the others by share."""
    order = [0, *sorted(range(1, len(attractors)), key=lambda i: -np.nan_to_num(shares[i]))]
    palette = colours.colours_of(attractors)
    handles = []
    for i in order[:_LEGEND_ROWS]:
        share = f"{100.0 * shares[i]:.2f} %" if np.isfinite(shares[i]) else "share not known yet"
        handles.append(Patch(facecolor=palette[i], edgecolor="black", label=f"{attractors[i].name}   {share}"))
    if len(order) > _LEGEND_ROWS:
        handles.append(Patch(alpha=0.0, label=f"and {len(order) - _LEGEND_ROWS} more"))
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, borderaxespad=0.0)


def _draw_numbers(figure: Figure, axes: Axes, store: BasinStore, layer: Layer) -> None:
    values = _read(store, layer)
    shown = np.ma.masked_equal(values, MISSING)
    image = axes.imshow(
        shown, origin="lower", extent=_extent(store), aspect="auto", interpolation="nearest", cmap="turbo"
    )
    axes.set_facecolor(colours.MISSING)
    figure.colorbar(image, ax=axes, label=f"Hsu's {layer}")


def _hatch_missing(axes: Axes, store: BasinStore) -> None:
    """Hatch the tiles that are not labelled yet: densely where even their images are missing."""
    states = store.read_ledger()
    grid = store.job.grid
    width = (grid.time_stop - grid.time_start) / grid.time_cells
    height = (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells
    for number in np.flatnonzero(states != TileState.ASSEMBLED):
        tile = store.tiling.tile(int(number))
        corner = grid.time_start + tile.columns[0] * width, grid.velocity_start + tile.rows[0] * height
        size = (tile.columns[1] - tile.columns[0]) * width, (tile.rows[1] - tile.rows[0]) * height
        hatch = "xxx" if states[number] == TileState.PENDING else "//"
        axes.add_patch(
            Rectangle(corner, *size, facecolor=colours.MISSING, edgecolor="gray", hatch=hatch, linewidth=0.0)
        )


def draw_grazing_curve(axes: Axes, oscillator: Oscillator, time_start: float, time_stop: float) -> None:
    """Draw v*(t) between two phases in white."""
    t = np.linspace(time_start, time_stop, 512)
    axes.plot(t, grazing_velocity(oscillator, t), color="white", linewidth=1.4)


def frame(axes: Axes, extent: tuple[float, float, float, float]) -> None:
    """Limit axes to a window (least and largest t, least and largest v) and say what they show."""
    axes.set_xlim(*extent[:2])
    axes.set_ylim(*extent[2:])
    axes.set_xlabel("time t of departure (forcing periods)")
    axes.set_ylabel("velocity v of departure")


def _title(store: BasinStore) -> str:
    damping, eccentricity, half_backlash, stiffness, _ = store.job.oscillator
    model = "impacting model" if math.isinf(stiffness) else f"piecewise linear model, κ = {stiffness:g}"
    title = f"{model}, δ = {damping:g}, ε = {eccentricity:g}, β = {half_backlash:g}, k = {store.job.iterations}"
    states = store.read_ledger()
    if not store.complete:
        done = int((states == TileState.ASSEMBLED).sum())
        title += f"\nincomplete: {done} of {states.size} tiles"
    return title


def draw_basin(location: str, target: str | Path | IO[bytes], *, layer: Layer = Layer.SOLUTION) -> None:
    """Draw the basin in a store as a PNG.

    Parameters
    ----------
    location : str
        The store, complete or not.
    target : path or binary file
        Where the PNG goes.
    layer : Layer
        Solutions in the paper's colours, or Hsu's group, period or step.

    Raises
    ------
    StoreConflict, StoreFailed
        Where there is no basin's store, or it cannot be read.
    """
    store = BasinStore(location)
    figure = Figure(figsize=(10.0, 6.5), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    if layer == Layer.SOLUTION:
        _draw_solutions(axes, store)
    else:
        _draw_numbers(figure, axes, store, layer)
    _hatch_missing(axes, store)
    grid = store.job.grid
    draw_grazing_curve(axes, store.job.oscillator, grid.time_start, grid.time_stop)
    frame(axes, _extent(store))
    axes.set_title(_title(store))
    # No date in the file: the same store gives the same bytes.
    figure.savefig(target, format="png", metadata={"Software": None})
