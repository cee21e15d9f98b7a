"""A driver that dies between any two of its writes: the next one brings the job to the same bytes."""

import asyncio
import errno
import threading

import pytest
import xarray as xr
from zarr.core.sync import sync

from rattle_kernels import CellGrid
from tests.store_content import content
from worker.cluster.driver import Driver
from worker.errors import StoreFailed
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.swept_parameter import SweptParameter
from worker.run import run_job
from worker.storage import folder


def sweep(cells):
    """The second basin has a solution more, so that room is made twice; its births and deaths are written, too."""
    grid = CellGrid(time_cells=cells, velocity_cells=cells)
    return SweepJob(grid=grid, iterations=101, vary=(SweptParameter("damping", (0.7, 0.6)),))


# Basins of one tile and of four: they are not computed in the same way.
# And one with a proof, whose lattice grows level by level.
PROVEN = BasinJob(grid=CellGrid(time_cells=8, velocity_cells=8), iterations=101, prove={"levels": 0})
JOBS = {"small": sweep(24), "tiled": sweep(100), "proven": PROVEN}


def run(job, location, client):
    run_job(job, str(location), Driver(client), report=lambda _: None, cancel=threading.Event())


class LastWrite:
    """Lets a number of files be written, and refuses every one after them: to the store, the process is dead."""

    def __init__(self, monkeypatch):
        self.left, self.write = 0, folder.write_file
        monkeypatch.setattr(folder, "write_file", self)

    def __call__(self, *arguments, **options):
        if self.left == 0:
            raise OSError(errno.EIO, "no more writes")
        self.left -= 1
        return self.write(*arguments, **options)

    def revive(self):
        """Let files be written again, once all that the dead process had under way has been refused."""
        sync(ended())
        self.left = 10**6


async def ended():
    """Wait for what else runs in Zarr's loop: where one file is refused, it goes on with those beside it."""
    others = asyncio.all_tasks() - {asyncio.current_task()}
    if others:
        await asyncio.wait(others, timeout=10.0)


@pytest.fixture
def undisturbed(client, tmp_path, job, last):
    """Place of a store, and how often its driver wrote."""
    location, last.left = tmp_path / "undisturbed.zarr", 10**6
    run(job, location, client)
    return location, 10**6 - last.left


@pytest.fixture
def last(monkeypatch):
    return LastWrite(monkeypatch)


@pytest.fixture(params=["small", *(pytest.param(name, marks=pytest.mark.slow) for name in ("tiled", "proven"))])
def job(request):
    return JOBS[request.param]


def comes_to_the_same(job, client, last, writes, location, undisturbed):
    last.left = writes
    try:
        run(job, location, client)
    except StoreFailed:
        last.revive()
        run(job, location, client)
    assert content(location) == content(undisturbed)
    with xr.open_zarr(location) as again, xr.open_zarr(undisturbed) as whole:
        assert again.attrs["complete"]
        xr.testing.assert_equal(again, whole)


def test_a_driver_that_dies_at_some_of_its_writes_leaves_no_trace(job, client, undisturbed, last, tmp_path):
    location, writes = undisturbed
    for dead_after in range(1, writes, writes // 4):
        comes_to_the_same(job, client, last, dead_after, tmp_path / f"{dead_after}.zarr", location)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_a_driver_that_dies_at_any_of_its_writes_leaves_no_trace(job, client, undisturbed, last, tmp_path):
    location, writes = undisturbed
    for dead_after in range(writes):
        comes_to_the_same(job, client, last, dead_after, tmp_path / f"{dead_after}.zarr", location)
