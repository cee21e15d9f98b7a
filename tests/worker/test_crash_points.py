"""A driver that dies between any two of its writes: the next one brings the job to the same bytes."""

import errno
import threading

import pytest
import xarray as xr

from rattle_kernels import CellGrid
from tests.store_content import content
from worker.basin_job import BasinJob
from worker.errors import StoreFailed
from worker.pipeline import run_basin
from worker.swept_parameter import SweptParameter

# The second basin has a solution more, so that room is made twice; its births and deaths are written, too.
JOB = BasinJob(
    grid=CellGrid(time_cells=24, velocity_cells=24), iterations=101, vary=(SweptParameter("damping", (0.7, 0.6)),)
)


def run(location, client):
    return run_basin(JOB, str(location), client, report=lambda _: None, cancel=threading.Event())


class LastWrite:
    """Lets a number of files be written, and refuses every one after them: to the store, the process is dead."""

    def __init__(self, monkeypatch):
        import zarr.storage._local as local

        self.left, self.write = 0, local._put
        monkeypatch.setattr(local, "_put", self)

    def __call__(self, *arguments, **options):
        if self.left == 0:
            raise OSError(errno.EIO, "no more writes")
        self.left -= 1
        return self.write(*arguments, **options)


@pytest.fixture(scope="module")
def undisturbed(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("undisturbed") / "sweep.zarr"
    run(location, client)
    return location


def count_writes(client, last, location):
    last.left = 10**6
    run(location, client)
    return 10**6 - last.left


def comes_to_the_same(client, last, writes, location, undisturbed):
    last.left = writes
    try:
        run(location, client)
    except StoreFailed:
        last.left = 10**6
        run(location, client)
    assert content(location) == content(undisturbed)
    with xr.open_zarr(location) as again, xr.open_zarr(undisturbed) as whole:
        assert again.attrs["complete"]
        xr.testing.assert_equal(again, whole)


def test_a_driver_that_dies_at_some_of_its_writes_leaves_no_trace(client, undisturbed, tmp_path, monkeypatch):
    last = LastWrite(monkeypatch)
    writes = count_writes(client, last, tmp_path / "counted.zarr")
    for dead_after in range(1, writes, writes // 8):
        comes_to_the_same(client, last, dead_after, tmp_path / f"{dead_after}.zarr", undisturbed)


@pytest.mark.faults
@pytest.mark.timeout(300)
def test_a_driver_that_dies_at_any_of_its_writes_leaves_no_trace(client, undisturbed, tmp_path, monkeypatch):
    last = LastWrite(monkeypatch)
    writes = count_writes(client, last, tmp_path / "counted.zarr")
    for dead_after in range(writes):
        comes_to_the_same(client, last, dead_after, tmp_path / f"{dead_after}.zarr", undisturbed)
