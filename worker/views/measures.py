"""Measures of all basins of a sweep, as described in `docs/guide/measures.md`.

sweep = open_basin("sweep.zarr")
measures = measure_basins(sweep)
measures.integrity_factor.sel(attractor="permanent contact").plot()  # over the swept parameter
"""

import itertools

import numpy as np
import xarray as xr

from rattle_kernels import (
    basin_entropy,
    grazing_velocity,
    integrity_factor,
    least_disturbance,
    local_integrity_measure,
    uncertainty_exponent,
)
from worker.errors import InvalidJob
from worker.stores.layout import TileState
from worker.views.at_level import demand_all_cells
from worker.views.reading import attractors_of, basin_of, job_of

# Cells each way required by the longest distance of `uncertainty_exponent`, 16 on both sides.
_LEAST_SIDE = 33


def measure_basins(dataset: xr.Dataset, tolerance: float = 1e-6) -> xr.Dataset:
    """Measures of each basin of a sweep, or of a single basin.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `worker.views.reading.open_basin`, complete or not.
    tolerance : float
        Largest final width of the bracket of each least disturbance.

    Returns
    -------
    xarray.Dataset
        The swept parameters are the leading dimensions. NaN if a basin is not complete or lacks the solution.

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
    names = [swept.parameter for swept in job.vary]
    measured = [
        _measures(basin_of(dataset, **dict(zip(names, values, strict=True))), tolerance)
        for values in itertools.product(*(swept.values for swept in job.vary))
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


_OF_SOLUTIONS = ("global_integrity", "local_integrity", "integrity_factor")
_OF_PANEL = ("basin_entropy", "boundary_entropy", "uncertainty_exponent", "uncertainty_error")
