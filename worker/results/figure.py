"""Pictures of basins, from a dataset or a store: one, or those of a sweep side by side in shared colours."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from rattle_kernels import Attractor
from worker.additions import additions
from worker.errors import InvalidJob, as_store_failure
from worker.gear_pair import GearPair
from worker.jobs.basin_job import BasinJob
from worker.kinds import KINDS
from worker.motion_words import ends_in_words
from worker.pictures import colours
from worker.pictures.figure_file import new_figure
from worker.pictures.overlay_kind import OverlayKind, masks_among
from worker.pictures.symbols import oscillator_text, value_in_words
from worker.pictures.units import draw_units
from worker.pictures.window import demand_overlap
from worker.results.opening import machine_in, open_store
from worker.results.panel import MOST_CELLS, TIME, USUAL_LOOK, VELOCITY, Basins, Layer, Look, Panel
from worker.stores.analysis_store import kind_of_store
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState

# Most panels each way. Of more, an evenly spaced selection is shown.
_MOST_PANELS = 6
_LEGEND_ROWS = 18
_COLOURS = 256
# Of the textures of cells, in their order.
_HATCHES = (None, "////", "\\\\\\\\", "....")
_SPECKLED = "chaos is speckled by Hsu's groups"
# Of the marks that lie over cells, by Matplotlib's markers.
_MARKED = {"x": "departures of a motion that repeats", ".": "departures of chaos", "+": "departures of a saddle"}
_KEY_COLUMNS = 3


def draw_basin(dataset: xr.Dataset, axes: Axes, look: Look = USUAL_LOOK) -> Axes:
    """Draw a basin on axes: cells, or the points of a sample, in the project's colours, with overlays.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of one basin, whole or in part (``basin.sel(time=slice(0.5, 0.7))``). Cells that are not computed yet are grey.
    axes : matplotlib.axes.Axes
    look : Look
        Whose legend lists the motions beside the axes, with their shares of all cells.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InvalidJob
        If it is no single basin, the model lacks an overlay, or the basin lacks it.

    Notes
    -----
    Beyond 2000 cells either way every n-th represents its neighbours, since labels cannot be averaged.
    """
    basins = Basins(dataset)
    if basins.job.axes:
        swept = ", ".join(axis.name for axis in basins.job.axes)
        raise InvalidJob(f"this is a sweep over {swept}: choose a basin by basin_of(sweep, ...), then draw it")
    _demand_known(basins.job, look)
    panel = Panel(basins, 0, look)
    panel.draw(axes)
    if look.legend and panel.attractors and look.layer == Layer.SOLUTION:
        _draw_legend(axes, panel.attractors, dataset.share.values, look, dataset)
    axes.set(xlabel=TIME, ylabel=VELOCITY)
    _draw_units(axes, dataset)
    return axes


def _draw_units(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the units of the basin's machine on the axes' other sides, if it has one."""
    machine = machine_in(dataset)
    if isinstance(machine, GearPair):
        draw_units(axes, time=machine.scales.time, speed=machine.scales.speed)


def draw_basins(dataset: xr.Dataset, figure: Figure, look: Look = USUAL_LOOK) -> None:
    """Draw a basin, or those of a sweep side by side, on an empty figure, whose size this sets.

    Parameters
    ----------
    dataset : xarray.Dataset
    figure : matplotlib.figure.Figure
    look : Look

    Raises
    ------
    InvalidJob
        As for `basin_figure`.
    """
    _draw_basins(Basins(dataset), figure, look)


def figure_of_store(location: str, look: Look = USUAL_LOOK) -> Figure:
    """Draw a store of any kind, complete or not.

    Parameters
    ----------
    location : str
    look : Look
        How basins are drawn.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidJob
        If the store has no such layer, overlay, window or panel.
    StoreConflict, StoreFailed
        If there is no store, or it cannot be read.
    """
    return KINDS[kind_of_store(location)].figure(location, look)


def basin_figure(location: str, look: Look = USUAL_LOOK) -> Figure:
    """Draw the basins in a store.

    Parameters
    ----------
    location : str
        The store, complete or not.
    look : Look

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidJob
        If Hsu's numbers are requested for a sample, which has no cells, the model lacks an overlay, there is no such
        panel, or nothing was computed in the window.
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    levels = BasinStore.open(location).whole_levels
    figure = new_figure()
    with as_store_failure(location), open_store(location) as dataset:
        _draw_basins(Basins(dataset, location, levels), figure, look)
    return figure


def _demand_known(job: BasinJob, look: Look) -> None:
    if job.sample is not None and look.layer != Layer.SOLUTION:
        raise InvalidJob(f"a sample has no cells, and so no {look.layer}: its solutions can be drawn")
    if look.window is not None:
        demand_overlap(look.window, job.grid)


def _draw_basins(basins: Basins, figure: Figure, look: Look) -> None:
    job = basins.job
    _demand_known(job, look)
    rows = _arrangement(job, look.panel)
    across, down = len(rows[0]), len(rows)
    if (across, down) != (1, 1):
        figure.set_size_inches(3.0 + 2.6 * across, 1.2 + 2.1 * down)
    axes = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    title = _title(basins.dataset, job, sum(map(len, rows)), look)
    _draw_panels(figure, axes, basins, rows, look)
    if job.axes:
        figure.suptitle(title)
        figure.supxlabel(TIME)
        figure.supylabel(VELOCITY)
    else:
        axes[0, 0].set(xlabel=TIME, ylabel=VELOCITY, title=title)
        _draw_units(axes[0, 0], basins.dataset)


def _draw_panels(figure: Figure, axes: np.ndarray, basins: Basins, rows: list[list[int]], look: Look) -> None:
    images: list[AxesImage] = []
    for at, place in zip(np.ndindex(axes.shape), axes.flat, strict=True):
        if at[1] >= len(rows[at[0]]):
            place.set_axis_off()
            continue
        panel = Panel(basins, rows[at[0]][at[1]], look, max(MOST_CELLS // axes.shape[1], 1))
        images += panel.draw(place)
        at_axes = zip(panel.job.axes, panel.job.place_of(panel.number), strict=True)
        place.set_title(", ".join(value_in_words(axis, at) for axis, at in at_axes), fontsize="small")
    if images and look.layer == Layer.LOUDNESS:
        _draw_powers(figure, axes, images, machine_in(basins.dataset))
    elif images:
        _draw_scale(figure, axes, images, f"Hsu's {look.layer}")
    listed = not images and look.legend and panel.attractors
    if listed:
        _list_motions(figure, axes[0, -1], basins.dataset, panel, look)
    if look.overlay_key and (basins.job.axes or not listed):
        _draw_key(figure, axes)


def _draw_key(figure: Figure, axes: np.ndarray) -> None:
    """Name what lies over the panels, below a single one, and beside several."""
    handles = {str(each.get_label()): each for place in axes.flat for each in (*_masks_of(place), *_key_of(place))}
    # A sweep has the name of its lowest axis there.
    alone = axes.size == 1
    place, columns = ("outside lower center", _KEY_COLUMNS) if alone else ("outside right lower", 1)
    if handles:
        figure.legend(handles=list(handles.values()), loc=place, ncols=columns, frameon=False)


def _list_motions(figure: Figure, axes: Axes, dataset: xr.Dataset, panel: Panel, look: Look) -> None:
    """Legend of the motions of all basins, which have the same colours in all panels."""
    job, motions = panel.job, panel.attractors
    shares = np.full(len(motions), np.nan)
    if dataset.attrs.get("complete", True):
        shares = dataset.share.mean([axis.name for axis in job.axes]).values
    if not job.axes:
        _draw_legend(axes, motions, shares, look, dataset)
        return
    labels = [f"{number}: {motion.name}" for number, motion in enumerate(motions)]
    handles = _legend_patches(motions, shares, labels, look)
    figure.legend(handles=handles, loc="outside right upper", frameon=False)


def _legend_patches(motions: tuple[Attractor, ...], shares: np.ndarray, labels: list[str], look: Look) -> list[Patch]:
    """Legend entries: permanent contact first, others by share. Once shares are known, only those that have one."""
    filled = colours.paints_of(motions, look.palette, look.own_colours)
    there = np.isfinite(shares) if np.isfinite(shares).any() else np.full(len(motions), True)
    order = sorted(np.flatnonzero(there).tolist(), key=lambda i: (i > 0, -np.nan_to_num(shares[i])))
    speckled = [motion.is_chaotic and motion.name not in look.own_colours for motion in motions]
    patches = [_patch(filled[i], labels[i], speckled[i]) for i in order[:_LEGEND_ROWS]]
    if len(order) > _LEGEND_ROWS:
        patches.append(Patch(alpha=0.0, label=f"and {len(order) - _LEGEND_ROWS} more"))
    return patches


def _patch(paint: colours.Paint, label: str, speckled: bool) -> Patch:
    """The colour and texture of a motion; of chaos its usual and a brighter shade."""
    colour = paint.colour
    if not speckled:
        ink, hatch = colours.ink_on(colour), _HATCHES[paint.texture]
        return Patch(facecolor=colour, edgecolor="black", hatchcolor=ink, hatch=hatch, label=label)
    brighter = tuple(min(part * colours.SPECKLE[-1] / colours.SPECKLE[0], 1.0) for part in colour)
    return Patch(facecolor=colour, edgecolor="black", hatchcolor=brighter, hatch="xxxxx", label=label)


def _draw_legend(
    axes: Axes, motions: tuple[Attractor, ...], shares: np.ndarray, look: Look, dataset: xr.Dataset
) -> None:
    """List motions with colours and shares beside axes on which they are drawn; NaN is a share not known yet."""
    texts = [f"{100.0 * share:.2f} %" if np.isfinite(share) else "share not known yet" for share in shares]
    names = [motion.name for motion in motions]
    ends = [f"\n{ends_in_words(motion.ends, names)}" if motion.ends else "" for motion in motions]
    for lines in filter(None, (each.below_shares(dataset) for each in additions())):
        texts = [f"{text}\n{line}" for text, line in zip(texts, lines, strict=True)]
    labels = [f"{motion.label}   {share}{end}" for motion, share, end in zip(motions, texts, ends, strict=True)]
    laid = _key_of(axes) if look.overlay_key else _lines_of(axes)
    handles = [*_legend_patches(motions, shares, labels, look), *_masks_of(axes), *laid]
    speckled = axes.images and any(each.is_chaotic for each in motions)  # points of a sample have no groups
    axes.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, borderaxespad=0.0,
        title=_SPECKLED if speckled else None, title_fontsize="x-small",
    )  # fmt: skip


def _masks_of(axes: Axes) -> list[Patch]:
    """Legend entries of the masks that are drawn."""
    return [entry for mask in masks_among(list(OverlayKind)) for entry in mask.legend(axes)]


def _lines_of(axes: Axes) -> list[Line2D]:
    """Legend entries of the overlays, each name once; marks of attractors are listed among the motions."""
    named = {str(line.get_label()): line for line in axes.get_lines() if line.get_linestyle() != "None"}
    drawn = {name: line for name, line in named.items() if not name.startswith("_")}
    # On white paper a white curve is shown grey.
    return [
        Line2D([], [], color="0.6" if line.get_color() == "white" else line.get_color(), label=name,
               linestyle=line.get_linestyle())
        for name, line in drawn.items()
    ]  # fmt: skip


def _key_of(axes: Axes) -> list[Line2D]:
    """Legend entries of all overlays: curves, and each kind of mark once."""
    marks = {str(line.get_marker()): line for line in axes.get_lines() if line.get_linestyle() == "None"}
    return _lines_of(axes) + [
        Line2D([], [], color="0.6" if line.get_color() == "white" else line.get_color(), label=_MARKED[marker],
               linestyle="None", marker=marker, markersize=max(line.get_markersize(), 4.0),
               markeredgewidth=line.get_markeredgewidth())
        for marker, line in marks.items() if marker in _MARKED
    ]  # fmt: skip


def _title(dataset: xr.Dataset, job: BasinJob, shown: int, look: Look) -> str:
    swept = tuple(name for axis in job.axes for name in axis.columns)
    title = f"{oscillator_text(job.oscillator, without=swept)}, k = {job.iterations}"
    if look.window is not None and look.layer == Layer.SOLUTION:
        grid = job.grid
        title += (
            f"\nshares are those of t {grid.time_start:g} to {grid.time_stop:g}, "
            f"v {grid.velocity_start:g} to {grid.velocity_stop:g}"
        )
    if shown < job.basins:
        title += f"; {shown} of {job.basins} basins"
    if not dataset.attrs.get("complete", True):
        states = dataset.tile_state.values
        title += f"\nincomplete: {int((states == TileState.ASSEMBLED).sum())} of {states.size} tiles"
    return title


def _evenly(count: int, most: int) -> list[int]:
    """At most `most` of `count` numbers, evenly spaced, including the first and the last."""
    return sorted(set(np.linspace(0, count - 1, min(count, most)).round().astype(int).tolist()))


def _arrangement(job: BasinJob, panel: int | None) -> list[list[int]]:
    """Panels in rows. Of two axes, the first increases upwards, the last to the right."""
    if panel is not None:
        if not 0 <= panel < job.basins:
            raise InvalidJob(f"there is no basin {panel}: there are {job.basins}, from 0 on")
        return [[panel]]
    shape = job.sweep_shape
    if len(shape) == 2:
        columns = _evenly(shape[1], _MOST_PANELS)
        return [[row * shape[1] + column for column in columns] for row in reversed(_evenly(shape[0], _MOST_PANELS))]
    panels = _evenly(job.basins, _MOST_PANELS**2)
    across = int(np.ceil(np.sqrt(len(panels))))
    return [panels[start : start + across] for start in range(0, len(panels), across)]


def _draw_scale(figure: Figure, axes: np.ndarray, images: list[AxesImage], label: str) -> None:
    """Give each whole number one colour, the same in all panels, and draw the scale."""
    shown = np.concatenate([np.ma.asarray(image.get_array()).compressed() for image in images])
    lowest, highest = int(shown.min(initial=0)), int(shown.max(initial=1))
    # A colour map has so many colours; of more numbers, neighbours share one.
    step = 1 + (highest - lowest) // _COLOURS
    norm = BoundaryNorm(np.arange(lowest, highest + 2 * step, step) - 0.5, _COLOURS)
    for image in images:
        image.set_norm(norm)
    figure.colorbar(images[0], ax=axes, label=label, ticks=MaxNLocator(10, integer=True), spacing="proportional")


def _draw_powers(figure: Figure, axes: np.ndarray, images: list[AxesImage], machine: object) -> None:
    """Give each power one colour, the same in all panels, and draw the scale; in W beside it for a machine."""
    shown = np.concatenate([np.ma.asarray(image.get_array()).compressed() for image in images])
    highest = float(shown.max(initial=0.0)) or 1.0
    for image in images:
        image.set_clim(0.0, highest)
    label = "impact power of the motion, v²/2 per forcing period"
    if isinstance(machine, GearPair):
        label += f"; 1 is {machine.scales.power:.3g} W"
    figure.colorbar(images[0], ax=axes, label=label)
