"""How loud the motions of a basin are, or of every basin of a sweep, and what is to be expected over its window.

The catalogue of a store says it: its motions are followed again. So stores of any age have it, and none holds it.
"""

import numpy as np
import xarray as xr

from rattle_kernels import ExpectedLoudness, Loudness, expected_loudness, loudness
from worker.jobs.basin_job import BasinJob
from worker.stores.layout import SPEED
from worker.stores.solution_table import shares_of_sets
from worker.views.reading import attractors_of, basin_of, job_of

WINDOW = "window"
"""Dimension of length 1 of what is to be expected of a single basin."""

_RATE, _POWER = {"units": "1", "comment": "per forcing period"}, {"units": "1", "comment": "v^2/2 per forcing period"}
_MEANINGS = {
    "impacts_per_period": ("impacts on both walls", _RATE),
    "largest_impact_speed": ("largest speed of arrival at a wall", SPEED),
    "impact_power": ("power of the impacts, sum v^2/(2 m)", _POWER),
}


def measure_loudness(dataset: xr.Dataset) -> xr.Dataset:
    """Loudness of the motions of a basin or of a sweep's basins, and its mean over their windows.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `worker.views.reading.open_basin`, complete or not.

    Returns
    -------
    xarray.Dataset
        The swept parameters are the leading dimensions. NaN where a basin is not complete, or has no such motion.

        - the fields of `rattle_kernels.Loudness` (attractor): impacts a forcing period, largest impact speed, impact
          power, and the errors of chaotic motions; NaN where a motion is undecided;
        - ``expected_impacts_per_period`` and so on: shares times loudness, with errors; ``undecided_share`` is the part
          of the cells that counts as silent there because its motion is not known. A single basin has them along
          ``window``, of length 1.
    """
    job = job_of(dataset)
    names = tuple(swept.parameter for swept in job.vary)
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
    """Loudness of the motions of one basin, and its mean."""
    basin = basin_of(dataset, **job.values_of(number))
    heard = [loudness(job.oscillator_of(number), each) for each in attractors_of(basin)]
    if not heard:
        return heard, expected_loudness([], [])
    points, of_sets = None, None
    if job.sample is not None:
        points = job.sample.points
        of_sets = shares_of_sets(basin.solution.values, range(len(heard)), job.sample)
    return heard, expected_loudness(basin.share.values, heard, points, of_sets)


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
    told = f"mean of {meaning}{over}" if over else meaning
    return attributes | {"long_name": told if name == measured else f"standard error of the {told}"}
