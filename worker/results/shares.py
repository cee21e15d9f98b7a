"""Charts of a sweep over its parameters: the share of each solution, and how loud the machine is on average."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import Attractor, ExpectedLoudness
from worker.errors import InvalidJob, as_store_failure
from worker.jobs.basin_job import BasinJob
from worker.pictures.colours import colours_of
from worker.pictures.figure_file import new_figure
from worker.pictures.symbols import axis_in_words
from worker.results.measures import expected_of
from worker.results.opening import attractors_of, basin_at, job_of, machine_in, open_store
from worker.stores.basin_store import BasinStore

# Shares over two parameters are mapped for the solutions with the largest shares only.
_MOST_MAPS = 9
_LEGEND_ROWS = 24
_MEASURES = {
    "impacts_per_period": "impacts\na period",
    "largest_impact_speed": "largest\nspeed",
    "impact_power": "power",
}
_HEIGHTS = 4.0, 1.0, 1.0, 1.0
_SIZE = 10.0, 8.5

Expected = Sequence[ExpectedLoudness]
"""Mean loudness of each basin, by number; NaN where it is not complete."""
Factors = Mapping[str, tuple[str, float | np.ndarray]]
"""Of measures that have a unit: the unit, and one unit of the model in it, of all basins or of each."""


def _largest(share: np.ndarray, most: int) -> list[int]:
    total = np.nansum(share.reshape(-1, share.shape[-1]), axis=0)
    return sorted(np.argsort(-total, kind="stable")[:most].tolist())


def _draw_lines(
    axes: Axes, job: BasinJob, share: np.ndarray, error: np.ndarray | None, solutions: tuple[Attractor, ...]
) -> None:
    """Draw one line per solution, broken where it does not exist, with standard errors if points were sampled."""
    palette = colours_of(solutions)
    named = _largest(share, _LEGEND_ROWS)
    for number, solution in enumerate(solutions):
        bar = None if error is None else error[:, number]
        axes.errorbar(
            job.axes[0].values, share[:, number], bar, marker=".", color=palette[number],
            label=f"{number}: {solution.name}" if number in named else None,
        )  # fmt: skip
    axes.set_xlabel(axis_in_words(job.axes[0]))
    axes.set_ylabel("share")
    axes.set_ylim(0.0, 1.0)
    axes.grid(alpha=0.3)


def _measured(expected: Expected, field: str) -> np.ndarray:
    return np.array([getattr(basin, field) for basin in expected])


def _draw_loudness(places: Sequence[Axes], job: BasinJob, expected: Expected, factors: Factors) -> None:
    """Draw the expected loudness over the parameter, one measure below the other, with standard errors."""
    for axes, (field, name) in zip(places, _MEASURES.items(), strict=True):
        unit, factor = factors.get(field, ("", 1.0))
        value, error = factor * _measured(expected, field), factor * _measured(expected, f"{field}_error")
        axes.errorbar(job.axes[0].values, value, error, marker=".", color="black")
        axes.set_ylabel(f"{name} ({unit})" if unit else name, fontsize="small")
        axes.set_ylim(bottom=0.0)
        axes.grid(alpha=0.3)


def _draw_maps(
    figure: Figure, job: BasinJob, share: np.ndarray, solutions: tuple[Attractor, ...], expected: Expected,
    factors: Factors,
) -> None:  # fmt: skip
    """Draw one map per solution over both parameters, and one of the expected impact power."""
    numbers = _largest(share, _MOST_MAPS)
    across = int(np.ceil(np.sqrt(len(numbers) + 1)))
    down = -(-(len(numbers) + 1) // across)
    axes = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    first, last = job.axes
    for place, number in zip(axes.flat, numbers, strict=False):
        image = place.pcolormesh(last.values, first.values, share[..., number], vmin=0.0, vmax=1.0, shading="nearest")
        place.set_title(f"{number}: {solutions[number].name}", fontsize="small")
        place.set_facecolor("lightgray")
    figure.colorbar(image, ax=axes, label="share")
    unit, factor = factors.get("impact_power", ("", 1.0))
    loud, power = axes.flat[len(numbers)], (factor * _measured(expected, "impact_power")).reshape(job.sweep_shape)
    image = loud.pcolormesh(last.values, first.values, power, vmin=0.0, shading="nearest", cmap="magma")
    loud.set_title("expected impact power", fontsize="small")
    loud.set_facecolor("lightgray")
    for place in axes.flat[len(numbers) + 1 :]:
        place.set_axis_off()
    figure.colorbar(image, ax=axes, label=f"impact power ({unit})" if unit else "impact power")
    figure.supxlabel(axis_in_words(last))
    figure.supylabel(axis_in_words(first))


def shares_figure(location: str) -> Figure:
    """Draw the shares in a sweep's store; see `draw_shares`.

    Parameters
    ----------
    location : str
        The store, complete or not.

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
    BasinStore.open(location)  # refuses what is none
    figure = new_figure()
    with as_store_failure(location), open_store(location) as dataset:
        draw_shares(dataset, figure)
    return figure


def draw_shares(dataset: xr.Dataset, figure: Figure | Axes) -> None:
    """Draw the shares of a sweep's solutions, and the expected loudness: lines over one parameter, maps over two.

    The loudness of machines is in their units.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a sweep, complete or not. Incomplete basins are gaps.
    figure : matplotlib.figure.Figure or matplotlib.axes.Axes
        An empty figure, whose size this sets; or axes, for lines of shares alone, without a legend.

    Raises
    ------
    InvalidJob
        If nothing is swept, no basin is complete yet, or maps would need more than the axes.
    """
    job = job_of(dataset)
    if not job.axes:
        raise InvalidJob("this is a single basin: there is no parameter to draw shares over")
    share = dataset.share.values if "share" in dataset else np.empty(0)
    if not np.isfinite(share).any():
        raise InvalidJob("no basin of the sweep is complete yet")
    solutions = attractors_of(basin_at(dataset, job, 0))
    share, error = share[..., : len(solutions)], dataset.share_error.values if job.sample else None
    if isinstance(figure, Axes):
        if len(job.axes) > 1:
            raise InvalidJob("shares over two parameters are maps on a figure of their own: leave out ax")
        _draw_lines(figure, job, share, error, solutions)
        return
    figure.set_size_inches(_SIZE)
    machine = machine_in(dataset)
    factors: Factors = {} if machine is None else machine.factors
    expected = expected_of(dataset)
    if len(job.axes) > 1:
        _draw_maps(figure, job, share, solutions, expected, factors)
        return
    gamma = dataset["gamma"] if "gamma" in dataset else None
    heights = _HEIGHTS if gamma is None else (*_HEIGHTS, _HEIGHTS[-1])
    shares, *below = figure.subplots(len(heights), sharex=True, height_ratios=heights)
    _draw_lines(shares, job, share, error, solutions)
    _draw_loudness(below[: len(_MEASURES)], job, expected, factors)
    if gamma is not None:
        below[-1].plot(job.axes[0].values, gamma.values, marker=".", color="black")
        below[-1].set_ylabel("Γ", fontsize="small")
        below[-1].set_ylim(0.0, max(1.0, 1.05 * float(gamma.max())))
        below[-1].axhline(1.0, color="grey", linestyle=":")
        below[-1].grid(alpha=0.3)
    shares.set_xlabel("")
    below[-1].set_xlabel(axis_in_words(job.axes[0]))
    figure.legend(*shares.get_legend_handles_labels(), loc="outside right upper", frameon=False)
