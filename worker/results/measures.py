"""Measures of all basins of a sweep, as described in `docs/guide/measures.md`, and how loud its motions are.

sweep = open_basin("sweep.zarr")
measures = measure_basins(sweep)
measures.integrity_factor.sel(attractor="permanent contact").plot()  # over the swept parameter

The catalogue of a store says how loud its motions are: they are followed again. So stores of any age have it, and none
holds it.
"""

import itertools
from collections.abc import Callable, Mapping

import numpy as np
import xarray as xr

from rattle_kernels import (
    Attractor,
    ExpectedLoudness,
    Loudness,
    basin_entropy,
    expected_loudness,
    grazing_velocity,
    integrity_factor,
    least_disturbance,
    local_integrity_measure,
    loudness,
    uncertainty_exponent,
)
from worker.errors import InvalidJob
from worker.jobs.basin_job import BasinJob
from worker.results.opening import attractors_of, basin_at, basin_of, demand_all_cells, job_of
from worker.stores.layout import SPEED, TileState
from worker.stores.solution_table import shares_of_sets

# Cells each way required by the longest distance of `uncertainty_exponent`, 16 on both sides.
_LEAST_SIDE = 33
_OF_SOLUTIONS = ("global_integrity", "local_integrity", "integrity_factor")
_OF_PANEL = ("basin_entropy", "boundary_entropy", "uncertainty_exponent", "uncertainty_error")
WINDOW = "window"
"""Dimension of length 1 of what is to be expected of a single basin."""

_RATE, _POWER = {"units": "1", "comment": "per forcing period"}, {"units": "1", "comment": "v^2/2 per forcing period"}
_MEANINGS = {
    "impacts_per_period": ("impacts on both walls", _RATE),
    "largest_impact_speed": ("largest speed of arrival at a wall", SPEED),
    "impact_power": ("power of the impacts, sum v^2/(2 m)", _POWER),
    "time_in_contact": ("part of the time in contact", {"units": "1"}),
}


def measure_basins(dataset: xr.Dataset, tolerance: float = 1e-6) -> xr.Dataset:
    """Measures of each basin of a sweep, or of a single basin.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `worker.results.opening.open_basin`, complete or not.
    tolerance : float
        Largest final width of the bracket of each least disturbance.

    Returns
    -------
    xarray.Dataset
        The axes of a sweep are the leading dimensions. NaN if a basin is not complete or lacks the solution.

        - ``global_integrity``, ``local_integrity``, ``integrity_factor`` (attractor): share, largest disc about the
          states, largest disc centred on a cell; radii are in the plane (t, v/velocity_scale);
        - ``velocity_scale``: the greatest v* of the basin's grazing curve;
        - ``basin_entropy``, ``boundary_entropy``, ``uncertainty_exponent``, ``uncertainty_error``;
        - ``least_disturbance`` (time): the smallest speed at each phase that leads from quiet to rattle; NaN if the
          window does not begin at speed 0.

    Raises
    ------
    InvalidJob
        If the store holds a sample (it has no neighbouring cells), or too few cells for the measures, or the dataset is
        of a level.
    """
    demand_all_cells(dataset)
    job = job_of(dataset)
    if job.sample is not None:
        raise InvalidJob("a sample has no neighbouring cells: its measures are its shares and their errors")
    if min(job.grid.shape) < _LEAST_SIDE:
        raise InvalidJob(f"the measures need {_LEAST_SIDE} x {_LEAST_SIDE} cells at least, not {job.grid.shape}")
    names = [axis.name for axis in job.axes]
    measured = [
        _measures(basin_of(dataset, **dict(zip(names, values, strict=True))), tolerance)
        for values in itertools.product(*(axis.values for axis in job.axes))
    ]
    shape = job.sweep_shape
    variables = {
        name: ((*names, *dims), np.reshape([basin[name][1] for basin in measured], (*shape, *np.shape(first))))
        for name, (dims, first) in measured[0].items()
    }
    coordinates = {name: dataset[name] for name in (*names, "time", "name", "attractor") if name in dataset}
    return xr.Dataset(variables, coordinates)


def _measures(basin: xr.Dataset, tolerance: float) -> dict[str, tuple[tuple[str, ...], np.ndarray | float]]:
    """Dimensions and values of the measures of one basin."""
    job, attractors = job_of(basin), attractors_of(basin)
    scale = float(grazing_velocity(job.oscillator, job.grid.time_centres()).max())
    of_solutions = {name: np.full(len(attractors), np.nan) for name in _OF_SOLUTIONS}
    of_basin, quiet = dict.fromkeys(_OF_PANEL, np.nan), np.full(job.grid.time_cells, np.nan)
    if bool((basin.tile_state == TileState.ASSEMBLED).all()):
        solution = basin.solution.values
        for index in np.flatnonzero(basin.share.notnull().values).tolist():
            disc = integrity_factor(solution, job.grid, index, velocity_scale=scale)
            local = local_integrity_measure(solution, job.grid, attractors, index, velocity_scale=scale)
            for name, value in zip(_OF_SOLUTIONS, (float(basin.share[index]), local, disc.radius), strict=True):
                of_solutions[name][index] = value
        entropy, fit = basin_entropy(solution), uncertainty_exponent(solution, wraps=job.grid.wraps)
        values = entropy.basin_entropy, entropy.boundary_entropy, fit.exponent, fit.error
        of_basin = dict(zip(_OF_PANEL, values, strict=True))
        if job.grid.velocity_start == 0.0:
            quiet = least_disturbance(job.oscillator, attractors, solution, job.grid, tolerance).velocity
    return (
        {name: (("attractor",), values) for name, values in of_solutions.items()}
        | {name: ((), value) for name, value in of_basin.items()}
        | {"velocity_scale": ((), scale), "least_disturbance": (("time",), quiet)}
    )


def measure_loudness(dataset: xr.Dataset) -> xr.Dataset:
    """Loudness of the motions of a basin or of a sweep's basins, and its mean over their windows.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `worker.results.opening.open_basin`, complete or not.

    Returns
    -------
    xarray.Dataset
        The axes of a sweep are the leading dimensions. NaN where a basin is not complete, or has no such motion.

        - the fields of `rattle_kernels.Loudness` (attractor): impacts a forcing period, largest impact speed, impact
          power, part of the time in contact, and the errors of chaotic motions; NaN where a motion is undecided;
        - ``expected_impacts_per_period`` and so on: shares times loudness, with errors; ``undecided_share`` is the part
          of the cells that counts as silent there because its motion is not known. A single basin has them along
          ``window``, of length 1.
    """
    job = job_of(dataset)
    names = tuple(axis.name for axis in job.axes)
    motions, expected = zip(*(_heard(dataset, job, number) for number in range(job.basins)), strict=True)
    of_motions = np.reshape(motions, (*job.sweep_shape, -1, len(Loudness._fields)))
    of_windows = np.reshape(expected, (*(job.sweep_shape or (1,)), len(ExpectedLoudness._fields)))
    variables = {
        name: _variable((*names, "attractor"), of_motions[..., place], _attributes(name))
        for place, name in enumerate(Loudness._fields)
    } | {
        _expected(name): _variable(names or (WINDOW,), of_windows[..., place], _attributes(name, " over the window"))
        for place, name in enumerate(ExpectedLoudness._fields)
    }
    coordinates = {name: dataset[name] for name in (*names, "name", "attractor") if name in dataset}
    return xr.Dataset(variables, coordinates)


def expected_of(dataset: xr.Dataset) -> tuple[ExpectedLoudness, ...]:
    """Mean loudness of each basin of a sweep, by number, as `measure_loudness` has it."""
    job = job_of(dataset)
    return tuple(_heard(dataset, job, number)[1] for number in range(job.basins))


def _heard(dataset: xr.Dataset, job: BasinJob, number: int) -> tuple[list[Loudness], ExpectedLoudness]:
    """Loudness of the motions of one basin of a dataset, and its mean."""
    basin = basin_at(dataset, job, number)
    motions = dict(enumerate(attractors_of(basin)))
    shares = basin.share.values[: len(motions)] if motions else np.empty(0)
    return heard_in(job, number, motions, shares, lambda: basin.solution.values)


def heard_in(
    job: BasinJob, basin: int, motions: Mapping[int, Attractor], shares: np.ndarray, solution: Callable[[], np.ndarray]
) -> tuple[list[Loudness], ExpectedLoudness]:
    """Loudness of the motions of one basin, by number, and its mean by their shares.

    The solution of each point is read where a sample has several sets, whose scatter is the error of the mean.
    """
    oscillator, sample = job.oscillator_of(basin), job.sample
    heard = [loudness(oscillator, each) for each in motions.values()]
    of_sets = shares_of_sets(solution(), [*motions], sample) if sample and sample.scramblings > 1 else None
    return heard, expected_loudness(shares, heard, sample.points if sample else None, of_sets)


def _variable(dims: tuple[str, ...], values: np.ndarray, attributes: dict[str, str]) -> xr.Variable:
    """A variable that xarray takes as it is: it would load Dask arrays to see whether the values are one."""
    return xr.Variable(dims, values, attributes, fastpath=True)


def _expected(name: str) -> str:
    return name if name == "undecided_share" else f"expected_{name}"


def _attributes(name: str, over: str = "") -> dict[str, str]:
    if name == "undecided_share":
        return {"units": "1", "long_name": "share of the cells whose motion is not known, which count as silent"}
    measured = name.removesuffix("_error")
    meaning, attributes = _MEANINGS[measured]
    long_name = f"mean of {meaning}{over}" if over else meaning
    return attributes | {"long_name": long_name if name == measured else f"standard error of the {long_name}"}
