"""A basin that was opened as a dataset, drawn on axes of yours. `worker.pictures.picture` writes it into a file."""

from collections.abc import Collection

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from worker.errors import InvalidJob
from worker.pictures import colours
from worker.pictures.overlay_kind import USUAL_OVERLAYS, OverlayKind, masks_among, overlays_for
from worker.pictures.panel_picture import draw_points, frame
from worker.pictures.picture import draw_legend
from worker.views.reading import attractors_of, job_of, thinned


def _edges(centres: np.ndarray, width: float) -> tuple[float, float]:
    """Outer edges of cells, from the spacing of their centres, or from `width` for a single cell."""
    half = 0.5 * (float(centres[1] - centres[0]) if centres.size > 1 else width)
    return float(centres[0]) - half, float(centres[-1]) + half


def _extent(dataset: xr.Dataset) -> tuple[float, float, float, float]:
    grid = job_of(dataset).grid
    if "sample" in dataset.dims:
        return grid.time_start, grid.time_stop, grid.velocity_start, grid.velocity_stop
    width = (grid.time_stop - grid.time_start) / grid.time_cells
    height = (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells
    return *_edges(dataset.time.values, width), *_edges(dataset.velocity.values, height)


def lay_masks(dataset: xr.Dataset, axes: Axes, overlays: Collection[str]) -> None:
    """Draw the masks among overlays.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `open_basin`, whole or in part.
    axes : matplotlib.axes.Axes
        Of the (t, v) plane.
    overlays : collection of str

    Raises
    ------
    InvalidJob
        If the basin lacks one.
    """
    for mask in masks_among(overlays):
        name = mask.variable.name
        mask.demand(name in dataset)
        whole = dataset[name].shape == job_of(dataset).grid.shape
        share = mask.share([dataset[name].values]) if whole else None
        mask.draw(axes, thinned(dataset)[name].values, _extent(dataset), share)


def plot_basin(
    dataset: xr.Dataset, ax: Axes | None = None, *, legend: bool = True,
    overlays: Collection[OverlayKind] = USUAL_OVERLAYS, palette: colours.Palette | None = None,
) -> Axes:  # fmt: skip
    """Draw the solutions of a basin, of cells or of a sample's points, in the project's colours, with overlays.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `open_basin`, whole or in part (``basin.sel(time=slice(0.5, 0.7))``). Cells not computed yet are grey.
    ax : matplotlib.axes.Axes
        Axes to draw on; the current axes by default.
    legend : bool
        Whether to list the motions beside the axes, with their shares of all cells.
    overlays : collection of OverlayKind
        Any of ``("grazing", "preimages", "manifolds", "attractors", "saddles")``, and masks of packages. For others,
        call ``draw`` of an `Overlay` from `worker.pictures.overlay` on the axes.
    palette : Palette, optional
        Colours of the motions; the usual ones by default.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InvalidJob
        If the model or the basin lacks an overlay.

    Notes
    -----
    Beyond 1000 cells either way every n-th represents its neighbours, since labels cannot be averaged.
    """
    if "sample" not in dataset.dims and dataset.solution.ndim != 2:
        swept = ", ".join(each.parameter for each in job_of(dataset).vary)
        raise InvalidJob(f"this is a sweep over {swept}: choose a basin by basin_of(sweep, ...), then draw it")
    axes = plt.gca() if ax is None else ax
    figure = axes.get_figure(root=True)
    if ax is None and figure is not None and figure.get_layout_engine() is None:
        figure.set_layout_engine("constrained")  # room for the legend beside the axes, in files as well
    attractors, extent = attractors_of(dataset), _extent(dataset)
    shown = thinned(dataset)
    palette = colours.USUAL if palette is None else palette
    if "sample" in dataset.dims:
        t, v, solution = (dataset[name].values for name in ("time", "velocity", "solution"))
        draw_points(axes, t, v, solution, np.array(colours.colours_of(attractors, palette)))
    else:
        image = colours.paint_cells(shown.solution, shown.group, attractors, palette)
        axes.imshow(image, origin="lower", extent=extent, aspect="auto", interpolation="nearest")
    lay_masks(dataset, axes, overlays)
    for overlay in overlays_for(overlays, job_of(dataset).oscillator, attractors, extent[2:]):
        overlay.draw(axes, extent[0])
    if legend and attractors:
        draw_legend(axes, attractors, dataset.share.values, palette=palette)
    frame(axes, extent)
    return axes
