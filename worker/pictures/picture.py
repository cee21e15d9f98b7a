"""Pictures of a store: one basin, or those of a sweep side by side in shared colours."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.ticker import MaxNLocator

from rattle_kernels import Attractor
from worker.errors import InvalidJob
from worker.kinds import KINDS
from worker.motion_words import ends_in_words
from worker.pictures import colours
from worker.pictures.figure_file import new_figure
from worker.pictures.overlay_kind import OverlayKind
from worker.pictures.panel_picture import USUAL_LOOK, Layer, Look, PanelPicture
from worker.pictures.symbols import oscillator_text, symbol_of
from worker.pictures.unproven import label_of, unproven_patch
from worker.pictures.window import demand_overlap
from worker.stores.analysis_store import kind_of_store
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState
from worker.stores.solution_table import SolutionTable
from worker.stores.summary import representatives

_MOST_CELLS = 2000
# Most panels each way. Of more, an evenly spaced selection is shown.
_MOST_PANELS = 6
_LEGEND_ROWS = 18
_COLOURS = 256
# Of the textures of cells, in their order.
_HATCHES = (None, "////", "\\\\\\\\", "....")
_SPECKLED = "chaos is speckled by Hsu's groups"


def _legend(
    figure: Figure, axes: Axes, store: BasinStore, table: SolutionTable, solutions: tuple[Attractor, ...], look: Look
) -> None:  # fmt: skip
    shares = np.nanmean(table.share, axis=0) if store.complete else np.full(len(solutions), np.nan)
    if store.job.vary:
        labels = [f"{i}: {solution.name}" for i, solution in enumerate(solutions)]
        handles = legend_patches(solutions, shares, labels, look.palette)
        handles += [unproven_patch(label_of(None))] if OverlayKind.PROVEN in look.overlays else []
        figure.legend(handles=handles, loc="outside right upper", frameon=False)
    else:
        draw_legend(axes, solutions, shares, look.palette)


def legend_patches(
    solutions: tuple[Attractor, ...], shares: np.ndarray, labels: list[str],
    palette: colours.Palette = colours.USUAL,
) -> list[Patch]:  # fmt: skip
    """Legend entries: permanent contact first, others by share. Once shares are known, only those that have one."""
    filled = colours.paints_of(solutions, palette)
    there = np.isfinite(shares) if np.isfinite(shares).any() else np.full(len(solutions), True)
    order = sorted(np.flatnonzero(there).tolist(), key=lambda i: (i > 0, -np.nan_to_num(shares[i])))
    patches = [_patch(solutions[i], filled[i], labels[i]) for i in order[:_LEGEND_ROWS]]
    if len(order) > _LEGEND_ROWS:
        patches.append(Patch(alpha=0.0, label=f"and {len(order) - _LEGEND_ROWS} more"))
    return patches


def _patch(solution: Attractor, paint: colours.Paint, label: str) -> Patch:
    """The colour and texture of a motion; of chaos its usual and a brighter shade."""
    colour = paint.colour
    if not solution.is_chaotic:
        ink, hatch = colours.ink_on(colour), _HATCHES[paint.texture]
        return Patch(facecolor=colour, edgecolor="black", hatchcolor=ink, hatch=hatch, label=label)
    brighter = tuple(min(part * colours.SPECKLE[-1] / colours.SPECKLE[0], 1.0) for part in colour)
    return Patch(facecolor=colour, edgecolor="black", hatchcolor=brighter, hatch="xxxxx", label=label)


def draw_legend(
    axes: Axes, solutions: tuple[Attractor, ...], shares: np.ndarray, palette: colours.Palette = colours.USUAL
) -> None:
    """List solutions with colours and shares beside axes on which they are drawn; NaN is a share not known yet."""
    told = [f"{100.0 * share:.2f} %" if np.isfinite(share) else "share not known yet" for share in shares]
    names = [solution.name for solution in solutions]
    ends = [f"\n{ends_in_words(solution.ends, names)}" if solution.ends else "" for solution in solutions]
    labels = [f"{solution.label}   {share}{end}" for solution, share, end in zip(solutions, told, ends, strict=True)]
    handles = [*legend_patches(solutions, shares, labels, palette), *_unproven_of(axes), *_lines_of(axes)]
    speckled = axes.images and any(each.is_chaotic for each in solutions)  # points of a sample have no groups
    axes.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, borderaxespad=0.0,
        title=_SPECKLED if speckled else None, title_fontsize="x-small",
    )  # fmt: skip


def _unproven_of(axes: Axes) -> list[Patch]:
    """Legend entry of what is not proven, where that is drawn."""
    names = {str(patch.get_label()) for patch in axes.patches if isinstance(patch, PathPatch)}
    return [unproven_patch(name) for name in names]


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


def _title(store: BasinStore, shown: int, look: Look) -> str:
    swept = tuple(each.parameter for each in store.job.vary)
    title = f"{oscillator_text(store.job.oscillator, without=swept)}, k = {store.job.iterations}"
    if look.window is not None and look.layer == Layer.SOLUTION:
        grid = store.job.grid
        title += (
            f"\nshares are those of t {grid.time_start:g} to {grid.time_stop:g}, "
            f"v {grid.velocity_start:g} to {grid.velocity_stop:g}"
        )
    if shown < store.job.basins:
        title += f"; {shown} of {store.job.basins} basins"
    if not store.complete:
        states = store.read_ledger()
        title += f"\nincomplete: {int((states == TileState.ASSEMBLED).sum())} of {states.size} tiles"
    return title


def _evenly(count: int, most: int) -> list[int]:
    """At most `most` of `count` numbers, evenly spaced, including the first and the last."""
    return sorted(set(np.linspace(0, count - 1, min(count, most)).round().astype(int).tolist()))


def _arrangement(store: BasinStore, panel: int | None) -> list[list[int]]:
    """Panels in rows. Of two swept parameters, the first increases upwards, the last to the right."""
    if panel is not None:
        if not 0 <= panel < store.job.basins:
            raise InvalidJob(f"there is no basin {panel}: there are {store.job.basins}, from 0 on")
        return [[panel]]
    shape = store.job.sweep_shape
    if len(shape) == 2:
        columns = _evenly(shape[1], _MOST_PANELS)
        return [[row * shape[1] + column for column in columns] for row in reversed(_evenly(shape[0], _MOST_PANELS))]
    panels = _evenly(store.job.basins, _MOST_PANELS**2)
    across = int(np.ceil(np.sqrt(len(panels))))
    return [panels[start : start + across] for start in range(0, len(panels), across)]


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
    store = BasinStore.open(location)
    if store.job.sample is not None and look.layer != Layer.SOLUTION:
        raise InvalidJob(f"a sample has no cells, and so no {look.layer}: its solutions can be drawn")
    if look.window is not None:
        demand_overlap(look.window, store.job.grid)
    rows = _arrangement(store, look.panel)
    across, down = len(rows[0]), len(rows)
    size = (10.0, 6.5) if across == down == 1 else (3.0 + 2.6 * across, 1.2 + 2.1 * down)
    figure = new_figure(*size)
    axes = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    _draw_panels(figure, axes, store, rows, look)
    shown = sum(len(row) for row in rows)
    if store.job.vary:
        figure.suptitle(_title(store, shown, look))
        figure.supxlabel("time t of departure (forcing periods)")
        figure.supylabel("velocity v of departure")
    else:
        axes[0, 0].set(xlabel="time t of departure (forcing periods)", ylabel="velocity v of departure")
        axes[0, 0].set_title(_title(store, shown, look))
    return figure


def _draw_panels(figure: Figure, axes: np.ndarray, store: BasinStore, rows: list[list[int]], look: Look) -> None:
    table = store.solutions.read()
    solutions = representatives(store, table)
    most_cells = max(_MOST_CELLS // axes.shape[1], 1)
    images: list[AxesImage] = []
    for at, place in zip(np.ndindex(axes.shape), axes.flat, strict=True):
        if at[1] >= len(rows[at[0]]):
            place.set_axis_off()
            continue
        panel = PanelPicture(store, table, solutions, rows[at[0]][at[1]], most_cells, look)
        if look.layer == Layer.SOLUTION:
            panel.draw_solutions(place)
        else:
            images += panel.draw_numbers(place, look.layer)
        panel.draw_unproven(place)
        panel.hatch_missing(place)
        panel.draw_overlays(place)
        values = store.job.values_of(panel.panel).items()
        place.set_title(", ".join(f"{symbol_of(name)} = {value:g}" for name, value in values), fontsize="small")
    if images:
        _draw_scale(figure, axes, images, f"Hsu's {look.layer}")
    elif solutions:
        _legend(figure, axes[0, -1], store, table, solutions, look)


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
