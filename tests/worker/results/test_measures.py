"""The measures of a sweep's basins are those of each basin by itself."""

import json

import numpy as np
import pytest

from rattle_kernels import (
    CellGrid,
    basin_entropy,
    grazing_velocity,
    integrity_factor,
    least_disturbance,
    local_integrity_measure,
    uncertainty_exponent,
)
from tests.worker.basins.test_pipeline import run
from worker.errors import InvalidJob
from worker.jobs.basin_job import SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter
from worker.results.measures import measure_basins
from worker.results.opening import attractors_of, basin_of, open_basin
from worker.stores.layout import TileState

DAMPINGS = (0.575, 0.6, 0.7)
JOB = SweepJob(grid=CellGrid(time_cells=48, velocity_cells=40), vary=(SweptParameter("damping", DAMPINGS),))


@pytest.fixture(scope="module")
def sweep(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("measures") / "sweep.zarr"
    run(JOB, location, client)
    with open_basin(location) as dataset:
        yield dataset.load()


def test_each_basin_has_its_own_measures(sweep):
    measures = measure_basins(sweep)
    assert measures.integrity_factor.dims == ("damping", "attractor")
    assert measures.least_disturbance.dims == ("damping", "time")
    basin, measured = basin_of(sweep, damping=0.6), measures.sel(damping=0.6)
    solution, attractors = basin.solution.values, attractors_of(basin)
    oscillator = JOB.oscillator_of(1)
    scale = grazing_velocity(oscillator, JOB.grid.time_centres()).max()
    assert measured.velocity_scale == scale
    assert measured.basin_entropy == basin_entropy(solution).basin_entropy
    assert measured.boundary_entropy == basin_entropy(solution).boundary_entropy
    assert measured.uncertainty_exponent == uncertainty_exponent(solution, wraps=True).exponent
    for index in np.flatnonzero(basin.share.notnull()).tolist():
        assert measured.global_integrity[index] == np.mean(solution == index)
        assert measured.integrity_factor[index] == integrity_factor(solution, JOB.grid, index, velocity_scale=scale)[0]
        local = local_integrity_measure(solution, JOB.grid, attractors, index, velocity_scale=scale)
        np.testing.assert_equal(float(measured.local_integrity[index]), local)
    alone = least_disturbance(
        oscillator, [each for each in attractors if each.time.size or each.kind == 1], solution, JOB.grid
    )
    np.testing.assert_array_equal(measured.least_disturbance, alone.velocity)


def test_where_all_is_quiet_nothing_disturbs(sweep):
    measured = measure_basins(sweep).sel(damping=0.7)
    assert measured.global_integrity[0] == 1.0 and measured.basin_entropy == 0.0
    assert np.isnan(measured.least_disturbance).all() and np.isnan(measured.boundary_entropy)


def test_a_basin_that_is_not_complete_has_no_measures(sweep):
    partial = sweep.copy(deep=True)
    partial.tile_state[1] = TileState.COMPUTED
    measures = measure_basins(partial)
    assert np.isnan(measures.basin_entropy.values).tolist() == [False, True, False]
    assert np.isnan(measures.integrity_factor[1]).all() and np.isnan(measures.least_disturbance[1]).all()


def test_samples_and_small_pictures_are_refused(sweep):
    sample = SweepJob(oscillator=JOB.oscillator, grid=JOB.grid, vary=JOB.vary, sample=Sample(64))
    with pytest.raises(InvalidJob, match="no neighbouring cells"):
        measure_basins(sweep.assign_attrs(request=json.dumps(sample.request()), request_sha256=sample.digest))
    small = SweepJob(grid=CellGrid(time_cells=20, velocity_cells=40), vary=JOB.vary)
    with pytest.raises(InvalidJob, match="33 x 33 cells"):
        measure_basins(sweep.assign_attrs(request=json.dumps(small.request()), request_sha256=small.digest))
