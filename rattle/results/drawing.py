"""A result on a figure, whatever its kind."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import Collection as Points
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.legend import Legend

from rattle.results.curves import curves_of
from rattle.results.trajectories import TRAJECTORY, history_of
from rattle_kernels import Attractor
from worker.additions import additions
from worker.errors import InvalidJob
from worker.jobs.basin_job import BasinJob
from worker.kinds import KINDS
from worker.pictures.colours import Colour, Palette
from worker.pictures.history_picture import draw_history
from worker.pictures.overlay import Lines
from worker.pictures.overlay_kind import USUAL_OVERLAYS, OverlayKind, overlays_for
from worker.pictures.picture import legend_patches
from worker.pictures.share_chart import SHARES_SIZE, draw_lines, draw_shares
from worker.views import reading
from worker.views.basin_plot import lay_masks, plot_basin
from worker.views.loudness import expected_of
from worker.views.reading import thinned

_BASINS_ACROSS = 3
_SIZE = 10.0, 6.5
_SIZE_OF_A_HISTORY = 11.0, 4.5


class Paints(NamedTuple):
    """Palette of basins, if it is not the usual one, and colours of some motions by name."""

    palette: Palette | None = None
    colors: Mapping[str, Colour] = {}


_USUAL_PAINTS = Paints()


def paints_of(dataset: xr.Dataset, colors: Mapping[str, Any] | None, palette: str | None) -> Paints:
    """What basins are painted with.

    Raises
    ------
    InvalidJob
        If a palette, a motion or a colour is not known.
    """
    if palette is not None and palette not in list(Palette):
        raise InvalidJob(f"there is no palette {palette!r}: take {' or '.join(Palette)}")
    known = dataset["name"].values.tolist() if colors else []
    for name in colors or {}:
        if name not in known:
            raise InvalidJob(f"there is no motion {name!r} to colour: there are {', '.join(known)}")
    try:
        mixed = {name: to_rgb(color) for name, color in (colors or {}).items()}
    except ValueError as error:
        raise InvalidJob(f"colors: {error}") from None
    return Paints(None if palette is None else Palette(palette), mixed)


def draw_basin(
    dataset: xr.Dataset, ax: Axes | None, overlays: Collection[str] | None, legend: bool, paints: Paints = _USUAL_PAINTS
) -> Axes:
    """Draw one basin, on a new figure if there are no axes."""
    axes = plt.figure(figsize=_SIZE, layout="constrained").add_subplot() if ax is None else ax
    chosen: Any = USUAL_OVERLAYS if overlays is None else overlays
    images, points = len(axes.images), len(axes.collections)
    plot_basin(dataset, axes, legend=legend, overlays=chosen, palette=paints.palette)
    if paints.colors and "sample" in dataset.dims:
        _recolour_points(dataset, axes.collections[points], paints.colors)
    elif paints.colors:
        _recolour_cells(dataset, axes.images[images], paints.colors)
    if paints.colors and (drawn := axes.get_legend()) is not None:
        _recolour_legend(drawn, paints.colors)
    return axes


def _recoloured(dataset: xr.Dataset, colors: Mapping[str, Colour]) -> Iterator[tuple[int, Colour]]:
    """Number and new colour of each motion of a basin that is to have one."""
    motions = [each.name for each in reading.attractors_of(dataset)]
    return ((motions.index(name), color) for name, color in colors.items() if name in motions)


def _recolour_cells(dataset: xr.Dataset, image: AxesImage, colors: Mapping[str, Colour]) -> None:
    pixels, numbers = np.array(image.get_array()), thinned(dataset).solution.values
    for number, color in _recoloured(dataset, colors):
        pixels[numbers == number] = color
    image.set_data(pixels)


def _recolour_points(dataset: xr.Dataset, points: Points, colors: Mapping[str, Colour]) -> None:
    painted, numbers = np.array(points.get_facecolor()), dataset.solution.values
    numbers = numbers[numbers >= 0][: len(painted)]
    for number, color in _recoloured(dataset, colors):
        painted[numbers == number, :3] = color
    points.set_facecolor(painted)


def _recolour_legend(legend: Legend, colors: Mapping[str, Colour]) -> None:
    """Give the entries of some motions other colours; chaos is then of one colour, too."""
    for handle, text in zip(legend.get_patches(), legend.get_texts(), strict=False):
        # "P(1,1,0)   3.24 %" beside a basin, "1: P(1,1,0)" beside a sweep.
        name = text.get_text().partition("   ")[0].rpartition(": ")[2]
        if name in colors:
            handle.set_facecolor(colors[name])
            handle.set_hatch("")


def draw_on_figure(
    dataset: xr.Dataset,
    kind: str,
    job: Any,
    overlays: Collection[str] | None,
    legend: bool,
    paints: Paints = _USUAL_PAINTS,
) -> Figure:
    """Draw a result of another kind on a new figure; `job` is None for a trajectory."""
    figure = plt.figure(figsize=_SIZE_OF_A_HISTORY if kind == TRAJECTORY else _SIZE, layout="constrained")
    if kind == "sweep":
        _draw_sweep(figure, dataset, job, overlays, legend, paints)
    elif kind == TRAJECTORY:
        draw_history(figure, *history_of(dataset))
    else:
        columns = {str(name): array.values for name, array in dataset.variables.items()}
        KINDS[kind].draw(job, columns, figure)
    return figure


def _draw_sweep(
    figure: Figure, dataset: xr.Dataset, job: BasinJob, overlays: Collection[str] | None, legend: bool, paints: Paints
) -> None:
    """One axes for each basin; of two swept parameters the first runs upwards, the last to the right."""
    across = job.sweep_shape[1] if len(job.sweep_shape) == 2 else min(_BASINS_ACROSS, job.basins)
    down = -(-job.basins // across)
    figure.set_size_inches(2.0 + 3.3 * across, 1.0 + 2.4 * down)
    axes = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    places = axes[::-1] if len(job.sweep_shape) == 2 else axes
    for place in axes.flat[job.basins :]:
        place.set_axis_off()
    for number, place in zip(range(job.basins), places.flat, strict=False):
        values = job.values_of(number)
        draw_basin(reading.basin_of(dataset, **values), place, overlays, legend=False, paints=paints)
        place.label_outer()
        place.set_title(", ".join(f"{name} = {value:g}" for name, value in values.items()), fontsize="small")
    solutions = _solutions(dataset, job)
    if legend and solutions:
        shares = dataset.share.mean([each.parameter for each in job.vary]).values
        labels = [f"{number}: {solution.name}" for number, solution in enumerate(solutions)]
        own = {} if paints.palette is None else {"palette": paints.palette}
        patches = legend_patches(solutions, shares, labels, **own)
        _recolour_legend(figure.legend(handles=patches, loc="outside right upper", frameon=False), paints.colors)


def _solutions(dataset: xr.Dataset, job: BasinJob) -> tuple[Attractor, ...]:
    """Motions of a sweep with the points of its first basin: enough for their names and colours."""
    return reading.attractors_of(reading.basin_of(dataset, **job.values_of(0)))


def draw_shares_of(dataset: xr.Dataset, job: BasinJob, ax: Axes | None) -> Figure | Axes:
    """Draw the shares of a sweep on axes, or else on a new figure.

    Raises
    ------
    InvalidJob
        If no basin is complete yet, or maps would need more than the axes.
    """
    share = dataset.share.values if "share" in dataset else np.empty(0)
    if not np.isfinite(share).any():
        raise InvalidJob("no basin of the sweep is complete yet")
    error = dataset.share_error.values if job.sample else None
    if ax is not None:
        if len(job.vary) > 1:
            raise InvalidJob("shares over two parameters are maps on a figure of their own: leave out ax")
        draw_lines(ax, job, share, error, _solutions(dataset, job))
        return ax
    figure = plt.figure(figsize=SHARES_SIZE, layout="constrained")
    draw_shares(figure, job, share, error, _solutions(dataset, job), expected_of(dataset))
    return figure


def draw_over(
    dataset: xr.Dataset,
    kind: str,
    job: Any,
    names: Collection[str],
    ax: Axes | None,
    color: Any = None,
    linewidth: float | None = None,
) -> Axes:
    """Lay the overlays of a basin, or the curves of an analysis, over axes; by default the current ones."""
    axes = plt.gca() if ax is None else ax
    if kind == "basin":
        window = job.grid.velocity_start, job.grid.velocity_stop
        overlays = overlays_for(names or list(OverlayKind), job.oscillator, reading.attractors_of(dataset), window)
        there = [addition.overlay for addition in additions() if addition.mask().variable.name in dataset]
        lay_masks(dataset, axes, names or there)
    else:
        overlays = tuple(curves_of(dataset, kind))
    for each in overlays:
        if color is not None:
            each = each._replace(colour=color)
        if linewidth is not None and isinstance(each, Lines):
            each = each._replace(width=linewidth)
        each.draw(axes, axes.get_xlim()[0])
    return axes
