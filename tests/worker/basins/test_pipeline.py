"""A basin through the worker: right, resumable, the same to the byte whatever happened on the way."""

import os
import signal
import threading
import time

import numpy as np
import pytest
import xarray as xr

from rattle_kernels import CellGrid, Oscillator, map_cells
from tests.store_content import content
from worker.cluster.driver import Driver
from worker.errors import JobCancelled, StoreConflict, StoreFailed
from worker.jobs.basin_job import BasinJob
from worker.results.opening import attractors_of, open_basin
from worker.results.summary import summarise
from worker.run import run_job
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState

JOB = BasinJob(grid=CellGrid(time_cells=200, velocity_cells=200))


def run(job, location, client, *, report=lambda _: None, cancel=None):
    """Compute a job; the summary of its store."""
    run_job(job, str(location), Driver(client), report=report, cancel=cancel or threading.Event())
    return summarise(str(location))


@pytest.fixture(scope="session")
def undisturbed(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("undisturbed") / "basin.zarr"
    return location, run(JOB, location, client)


def test_the_papers_basin_has_three_motions_and_nothing_else(undisturbed):
    location, summary = undisturbed
    shares = {solution.name: solution.share for solution in summary.solutions}
    assert shares.keys() == {"permanent contact", "P(1,1,0)", "chaotic"}
    assert sum(shares.values()) == pytest.approx(1.0)
    assert shares["permanent contact"] == pytest.approx(0.72, abs=0.01)
    assert shares["P(1,1,0)"] == pytest.approx(0.032, abs=0.003)
    (departure,) = summary.solutions[1].points
    # Balance of impulses over one period: P(1,1,0) strikes with v = 2 pi delta.
    assert departure[1] == pytest.approx(2.0 * np.pi * 0.6, abs=1e-12)
    with open_basin(location) as basin:
        chaotic = attractors_of(basin)[2]
    assert chaotic.lyapunov_exponent == summary.solutions[2].lyapunov_exponent > 20.0 * chaotic.lyapunov_error > 0.0


def test_the_store_opens_with_xarray_labelled_and_complete(undisturbed):
    location, _ = undisturbed
    with xr.open_zarr(location) as basin:
        assert basin.group.dims == basin.solution.dims == basin.image_cell.dims == ("velocity", "time")
        assert basin.solution.dtype == np.int16 and basin.group.dtype == np.int32
        np.testing.assert_allclose(basin.time, JOB.grid.time_centres())
        np.testing.assert_allclose(basin.velocity, JOB.grid.velocity_centres())
        assert basin.solution.attrs["flag_meanings"].split()[0] == "permanent_contact"
        assert basin.name.values.tolist() == ["permanent contact", "P(1,1,0)", "chaotic"]
        assert (basin.tile_state == TileState.ASSEMBLED).all()
        shares = [float((basin.solution == i).mean()) for i in range(3)]
        np.testing.assert_allclose(basin.share, shares)
        assert basin.attrs["complete"] is True
        captured = basin.image_cell == -2
        assert (basin.group.values[captured.values] == -1).all() and np.isnan(basin.landing_time.values[captured]).all()
        assert int(basin.solution.sel(time=0.9, velocity=3.77, method="nearest")) == 1


def test_the_stored_images_are_those_of_the_map(undisturbed):
    location, _ = undisturbed
    direct = map_cells(JOB.oscillator, JOB.grid, JOB.iterations, (60, 80), (0, 200))
    with xr.open_zarr(location) as basin:
        np.testing.assert_array_equal(basin.image_cell[60:80], direct.image_cell)
        np.testing.assert_array_equal(basin.landing_velocity[60:80], direct.landing_velocity)


def test_the_pace_of_a_finished_job_is_that_of_its_whole_run(client, tmp_path):
    seen, begin = [], time.monotonic()
    summary = run(JOB, tmp_path / "basin.zarr", client, report=seen.append)
    whole, last = time.monotonic() - begin, seen[-1]
    stages = sum(summary.seconds[stage] for stage in ("mapping", "assembling", "labelling"))
    assert last.stage == "done" and last.cells_done == JOB.grid.cells
    assert JOB.grid.cells / whole <= last.cells_per_second <= JOB.grid.cells / stages


@pytest.mark.slow
def test_killed_workers_leave_no_trace_in_the_result(client, undisturbed, tmp_path):
    killed = []

    def kill_once(progress):
        if progress.stage == "mapping" and 0 < progress.tiles_done and not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    run(JOB, tmp_path / "basin.zarr", client, report=kill_once)
    assert killed
    client.wait_for_workers(2)
    assert content(tmp_path / "basin.zarr") == content(undisturbed[0])


def test_a_cancelled_job_stops_stays_readable_and_resumes_to_the_same_bytes(client, undisturbed, tmp_path):
    location, cancel = tmp_path / "basin.zarr", threading.Event()

    def cancel_soon(progress):
        if progress.tiles_done == 3:
            cancel.set()

    with pytest.raises(JobCancelled):
        run(JOB, location, client, report=cancel_soon, cancel=cancel)
    partial = summarise(str(location))
    assert not partial.complete and 3 <= partial.tiles_computed < partial.tiles and partial.solutions == []
    with xr.open_zarr(location) as basin:
        assert set(np.unique(basin.tile_state)) == {TileState.PENDING, TileState.COMPUTED}
    seen = []
    run(JOB, location, client, report=seen.append)
    assert seen[0].tiles_done == partial.tiles_computed
    assert content(location) == content(undisturbed[0])


def test_a_complete_store_answers_at_once(client, undisturbed):
    seen = []
    summary = run(JOB, undisturbed[0], client, report=seen.append)
    assert seen == [] and summary.complete


def test_another_jobs_store_is_not_touched(client, undisturbed):
    before = content(undisturbed[0])
    with pytest.raises(StoreConflict, match="holds the store of another request"):
        run(BasinJob(grid=CellGrid(time_cells=10, velocity_cells=10)), undisturbed[0], client)
    assert content(undisturbed[0]) == before


def test_a_place_that_is_no_store_is_not_touched(client, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(StoreConflict, match="is no basin store"):
        run(JOB, tmp_path, client)
    with pytest.raises(StoreConflict, match="is no basin store"):
        run(JOB, tmp_path / "notes.txt", client)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    with pytest.raises(StoreConflict, match="is no basin store"):
        summarise(str(tmp_path / "nothing"))


def test_a_place_that_cannot_be_written_is_named_with_the_reason(client):
    with pytest.raises(StoreFailed, match="/proc/basin.zarr cannot be read or written: "):
        run(JOB, "/proc/basin.zarr", client)


def test_orphans_of_killed_writers_are_swept(client, tmp_path):
    job = BasinJob(grid=CellGrid(time_cells=8, velocity_cells=8), iterations=1)
    store = BasinStore.create_or_resume(str(tmp_path / "b.zarr"), job)
    orphan = tmp_path / "b.zarr" / "group" / "c.1234.partial"
    orphan.write_text("half")
    run(job, store.location, client)
    assert not orphan.exists()


@pytest.mark.parametrize("iterations", [pytest.param(1, marks=pytest.mark.slow), 7])
def test_a_window_is_coloured_like_the_same_cells_of_the_full_one(client, undisturbed, tmp_path, iterations):
    # v in [4.2, 4.8), t in [0.5, 0.7): every attractor but the chaotic one lies outside.
    window = CellGrid(0.5, 0.7, 40, 4.2, 4.8, 40)
    run(BasinJob(grid=window, iterations=iterations), tmp_path / "window.zarr", client)
    full = CellGrid(0.0, 1.0, 200, 0.0, 6.0, 400)
    run(BasinJob(grid=full, iterations=1499), tmp_path / "full.zarr", client)
    with xr.open_zarr(tmp_path / "window.zarr") as zoom, xr.open_zarr(tmp_path / "full.zarr") as whole:
        names = zoom.name.values[zoom.solution.values], whole.name.values[whole.solution.values]
        np.testing.assert_array_equal(names[0], names[1][280:320, 100:140])
        assert set(np.unique(names[0])) == {"permanent contact", "chaotic"}


def test_everything_is_permanent_contact_at_strong_damping(client, tmp_path):
    job = BasinJob(oscillator=Oscillator(damping=0.7), grid=CellGrid(time_cells=64, velocity_cells=64))
    summary = run(job, tmp_path / "b.zarr", client)
    assert [(solution.name, solution.share) for solution in summary.solutions] == [("permanent contact", 1.0)]
