"""A basin in memory is that of the store of the same request: every number, the catalogue, the shares."""

import threading

import numpy as np
import pytest
import xarray as xr

from rattle_kernels import CellGrid, Oscillator, basin
from worker.cluster.driver import Driver
from worker.jobs.basin_job import BasinJob
from worker.results.opening import attractors_of, open_basin
from worker.run import run_job
from worker.stores.basin_store import BasinStore

_ARRAYS = ("image_cell", "landing_time", "landing_velocity", "group", "period", "step", "solution")
_WEAK = Oscillator(damping=0.05, eccentricity=0.008, half_backlash=0.05)
CASES = {
    "several tiles": (Oscillator(), CellGrid(time_cells=150, velocity_cells=170), 127),
    "springs": (Oscillator(stiffness=1e4), CellGrid(time_cells=130, velocity_cells=110), 31),
    "one tile": (Oscillator(damping=0.527), CellGrid(time_cells=40, velocity_cells=30), 127),
    "a window across phase 0": (Oscillator(), CellGrid(0.7, 1.1, 40, 3.0, 4.0, 50), 7),
    "little damped": (_WEAK, CellGrid(time_cells=40, velocity_stop=0.6, velocity_cells=40), None),
}


@pytest.mark.parametrize(("oscillator", "grid", "iterations"), CASES.values(), ids=CASES)
def test_it_is_that_of_the_store(oscillator, grid, iterations, client, tmp_path):
    found = basin(oscillator, grid, iterations)
    location = str(tmp_path / "basin.zarr")
    asked = {} if iterations is None else {"iterations": iterations}
    job = BasinJob(oscillator=oscillator, grid=grid, **asked)
    run_job(job, location, Driver(client), report=lambda _: None, cancel=threading.Event())
    assert found.iterations == job.iterations
    with xr.open_zarr(location) as stored:
        for name in _ARRAYS:
            assert getattr(found, name).dtype == stored[name].dtype
            np.testing.assert_array_equal(getattr(found, name), stored[name])
        np.testing.assert_array_equal(found.share, stored.share)
    for ours, theirs in zip(found.attractors, attractors_of(open_basin(location)), strict=True):
        for one, other in zip(ours, theirs, strict=True):
            np.testing.assert_array_equal(one, other)


def test_some_of_these_have_several_tiles_and_others_one(tmp_path):
    tiles = {
        name: BasinStore.create_or_resume(str(tmp_path / name), BasinJob(oscillator=each[0], grid=each[1])).tiling.tiles
        for name, each in CASES.items()
    }
    assert min(tiles["several tiles"], tiles["springs"]) >= 4 and tiles["one tile"] == 1
