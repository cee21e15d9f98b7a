"""Charts of a sweep: the share of each solution over the swept parameters."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import Attractor
from worker.errors import InvalidJob
from worker.jobs.basin_job import BasinJob
from worker.pictures.colours import colours_of
from worker.pictures.figure_file import new_figure
from worker.pictures.symbols import in_words
from worker.stores.basin_store import BasinStore
from worker.stores.summary import representatives

# Shares over two parameters are mapped for the solutions with the largest shares only.
_MOST_MAPS = 9
_LEGEND_ROWS = 24


def _largest(share: np.ndarray, most: int) -> list[int]:
    total = np.nansum(share.reshape(-1, share.shape[-1]), axis=0)
    return sorted(np.argsort(-total, kind="stable")[:most].tolist())


def draw_lines(
    axes: Axes, job: BasinJob, share: np.ndarray, error: np.ndarray | None, solutions: tuple[Attractor, ...]
) -> None:
    """Draw one line per solution, broken where it does not exist, with standard errors if points were sampled."""
    palette = colours_of(solutions)
    named = _largest(share, _LEGEND_ROWS)
    for number, solution in enumerate(solutions):
        bar = None if error is None else error[:, number]
        axes.errorbar(
            job.vary[0].values, share[:, number], bar, marker=".", color=palette[number],
            label=f"{number}: {solution.name}" if number in named else None,
        )  # fmt: skip
    axes.set_xlabel(in_words(job.vary[0].parameter))
    axes.set_ylabel("share")
    axes.set_ylim(0.0, 1.0)
    axes.grid(alpha=0.3)


def _draw_maps(figure: Figure, job: BasinJob, share: np.ndarray, solutions: tuple[Attractor, ...]) -> None:
    """Draw one map per solution over both parameters."""
    numbers = _largest(share, _MOST_MAPS)
    across = int(np.ceil(np.sqrt(len(numbers))))
    down = -(-len(numbers) // across)
    axes = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    first, last = job.vary
    for place, number in zip(axes.flat, numbers, strict=False):
        image = place.pcolormesh(last.values, first.values, share[..., number], vmin=0.0, vmax=1.0, shading="nearest")
        place.set_title(f"{number}: {solutions[number].name}", fontsize="small")
        place.set_facecolor("lightgray")
    for place in axes.flat[len(numbers) :]:
        place.set_axis_off()
    figure.colorbar(image, ax=axes, label="share")
    figure.supxlabel(in_words(last.parameter))
    figure.supylabel(in_words(first.parameter))


def shares_figure(location: str) -> Figure:
    """Draw the shares of a sweep's solutions: lines over one parameter, maps over two.

    Parameters
    ----------
    location : str
        The store, complete or not. Incomplete basins are gaps.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidJob
        If nothing is swept, or no basin is complete yet.
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    store = BasinStore(location)
    table = store.read_solutions()
    if not store.job.vary:
        raise InvalidJob(f"{location} holds a single basin: there is no parameter to draw shares over")
    if not table.complete.any():
        raise InvalidJob(f"{location} holds no complete basin yet")
    solutions = representatives(store, table)
    share, error = (each.reshape(*store.job.sweep_shape, len(solutions)) for each in (table.share, table.share_error))
    figure = new_figure(10.0, 6.5)
    draw_shares(figure, store.job, share, error if store.job.sample else None, solutions)
    return figure


def draw_shares(
    figure: Figure, job: BasinJob, share: np.ndarray, error: np.ndarray | None, solutions: tuple[Attractor, ...]
) -> None:
    """Draw shares and their errors, of shape (*swept values, solutions), on an empty figure."""
    if len(job.vary) == 1:
        draw_lines(figure.subplots(), job, share, error, solutions)
        figure.legend(loc="outside right upper", frameon=False)
    else:
        _draw_maps(figure, job, share, solutions)
