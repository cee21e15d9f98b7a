"""A result on a figure, whatever its kind."""

from collections.abc import Collection
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle.results.curves import curves_of
from rattle.results.trajectories import TRAJECTORY, history_of
from rattle_kernels import Attractor
from worker.errors import InvalidJob
from worker.jobs.basin_job import BasinJob
from worker.kinds import KINDS
from worker.pictures.history_picture import draw_history
from worker.pictures.overlay_kind import USUAL_OVERLAYS, OverlayKind, overlays_for
from worker.pictures.picture import legend_patches
from worker.pictures.share_chart import SHARES_SIZE, draw_lines, draw_shares
from worker.stores.proof_layout import PROVEN
from worker.views import reading
from worker.views.basin_plot import lay_unproven, plot_basin
from worker.views.loudness import expected_of

_BASINS_ACROSS = 3
_SIZE = 10.0, 6.5
_SIZE_OF_A_HISTORY = 11.0, 4.5


def draw_basin(dataset: xr.Dataset, ax: Axes | None, overlays: Collection[str] | None, legend: bool) -> Axes:
    """Draw one basin, on a new figure if there are no axes."""
    axes = plt.figure(figsize=_SIZE, layout="constrained").add_subplot() if ax is None else ax
    chosen: Any = USUAL_OVERLAYS if overlays is None else overlays
    return plot_basin(dataset, axes, legend=legend, overlays=chosen)


def draw_on_figure(dataset: xr.Dataset, kind: str, job: Any, overlays: Collection[str] | None, legend: bool) -> Figure:
    """Draw a result of another kind on a new figure; `job` is None for a trajectory."""
    figure = plt.figure(figsize=_SIZE_OF_A_HISTORY if kind == TRAJECTORY else _SIZE, layout="constrained")
    if kind == "sweep":
        _draw_sweep(figure, dataset, job, overlays, legend)
    elif kind == TRAJECTORY:
        draw_history(figure, *history_of(dataset))
    else:
        columns = {str(name): array.values for name, array in dataset.variables.items()}
        KINDS[kind].loaded_analysis.draw(job, columns, figure)
    return figure


def _draw_sweep(
    figure: Figure, dataset: xr.Dataset, job: BasinJob, overlays: Collection[str] | None, legend: bool
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
        draw_basin(reading.basin_of(dataset, **values), place, overlays, legend=False)
        place.label_outer()
        place.set_title(", ".join(f"{name} = {value:g}" for name, value in values.items()), fontsize="small")
    solutions = _solutions(dataset, job)
    if legend and solutions:
        shares = dataset.share.mean([each.parameter for each in job.vary]).values
        labels = [f"{number}: {solution.name}" for number, solution in enumerate(solutions)]
        figure.legend(handles=legend_patches(solutions, shares, labels), loc="outside right upper", frameon=False)


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


def draw_over(dataset: xr.Dataset, kind: str, job: Any, names: Collection[str], ax: Axes | None) -> Axes:
    """Lay the overlays of a basin, or the curves of an analysis, over axes; by default the current ones."""
    axes = plt.gca() if ax is None else ax
    if kind == "basin":
        window = job.grid.velocity_start, job.grid.velocity_stop
        overlays = overlays_for(names or list(OverlayKind), job.oscillator, reading.attractors_of(dataset), window)
        if OverlayKind.PROVEN in names or (not names and PROVEN.name in dataset):
            lay_unproven(dataset, axes)
    else:
        overlays = tuple(curves_of(dataset, kind))
    for each in overlays:
        each.draw(axes, axes.get_xlim()[0])
    return axes
