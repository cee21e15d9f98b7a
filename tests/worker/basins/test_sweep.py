"""A sweep through the worker: each basin as if computed alone, one number a solution, whatever happened on the way."""

import heapq
import os
import random
import signal
import threading

import numpy as np
import pytest
import xarray as xr

from rattle_kernels import CellGrid, Oscillator
from tests.worker.basins.test_pipeline import content, run
from worker.basins.schedule import Schedule
from worker.cluster.driver import Driver
from worker.errors import JobCancelled
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.swept_parameter import SweptParameter
from worker.results.summary import summarise
from worker.stores.layout import ChangeKind, TileState

DAMPINGS = (0.5, 0.55, 0.6, 0.65, 0.7)
GRID = CellGrid(time_cells=48, velocity_cells=40)
JOB = SweepJob(grid=GRID, iterations=499, vary=(SweptParameter("damping", DAMPINGS),))


@pytest.fixture(scope="session")
def undisturbed(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("sweep") / "sweep.zarr"
    return location, run(JOB, location, client)


def test_a_sweep_has_the_swept_parameter_as_leading_dimension(undisturbed):
    location, _ = undisturbed
    with xr.open_zarr(location) as sweep:
        for name in ("image_cell", "landing_time", "group", "period", "step", "solution"):
            assert sweep[name].dims == ("damping", "velocity", "time")
        assert sweep.damping.values.tolist() == list(DAMPINGS)
        assert sweep.grazing_velocity.dims == ("damping", "time")
        assert sweep.share.dims == ("damping", "attractor")
        assert sweep.attractor_time.dims == ("damping", "attractor", "point")
        assert sweep.tile_state.dims == ("damping", "tile_velocity", "tile_time")
        assert (sweep.tile_state == TileState.ASSEMBLED).all()
        np.testing.assert_allclose(sweep.share.sum("attractor"), 1.0)
        for number in range(sweep.sizes["attractor"]):
            counted = (sweep.solution == number).mean(("velocity", "time")).values
            np.testing.assert_allclose(np.nan_to_num(sweep.share.values[:, number]), counted)


@pytest.mark.parametrize("basin", range(len(DAMPINGS)))
def test_each_basin_is_the_one_computed_alone(client, undisturbed, tmp_path, basin):
    alone = BasinJob(oscillator=Oscillator(damping=DAMPINGS[basin]), grid=GRID, iterations=499)
    run(alone, tmp_path / "alone.zarr", client)
    with xr.open_zarr(tmp_path / "alone.zarr") as one, xr.open_zarr(undisturbed[0]) as many:
        same = many.isel(damping=basin)
        for name in ("image_cell", "landing_time", "landing_velocity", "group", "period", "step", "grazing_velocity"):
            np.testing.assert_array_equal(one[name].values, same[name].values)
        names = one.name.values[one.solution.values], many.name.values[same.solution.values]
        np.testing.assert_array_equal(*names)
        for own in np.unique(one.solution.values):
            numbers = np.unique(same.solution.values[one.solution.values == own])
            assert numbers.size == 1
            at = int(numbers[0])
            points = same.attractor_velocity.values[at]
            np.testing.assert_array_equal(points[np.isfinite(points)], _points(one, own))
            assert same.share.values[at] == one.share.values[own]


def _points(basin, number):
    points = basin.attractor_velocity.values[number]
    return points[np.isfinite(points)]


def test_the_same_motion_keeps_its_number(undisturbed):
    _, summary = undisturbed
    names = [solution.name for solution in summary.solutions]
    number = names.index("P(1,1,0)")
    # Balance of impulses: P(1,1,0) is there with v = 2 pi delta at all dampings but the largest.
    there = [{share.solution for share in basin.shares} for basin in summary.basins]
    assert [number in each for each in there] == [True, True, True, True, False]
    assert names.count("P(1,1,0)") == 1 and names[0] == "permanent contact"
    deaths = {(each.kind, each.solution, each.before, each.after) for each in summary.changes}
    assert ("death", number, 0.65, 0.7) in deaths
    assert ("death", names.index("P(1,2,0)"), 0.55, 0.6) in deaths
    assert ("birth", names.index("chaotic"), 0.55, 0.6) in deaths


def test_changes_are_in_the_store(undisturbed):
    location, summary = undisturbed
    with xr.open_zarr(location) as sweep:
        stored = zip(
            *(sweep[f"change_{what}"].values.tolist() for what in ("kind", "solution", "from", "to")), strict=True
        )
        told = [(ChangeKind[each.kind.upper()], each.solution, each.before, each.after) for each in summary.changes]
        assert list(stored) == told
        assert set(sweep.change_parameter.values.tolist()) == {"damping"}


@pytest.mark.slow
def test_killed_workers_leave_no_trace_in_a_sweep(client, undisturbed, tmp_path):
    killed = []

    def kill_once(progress):
        if progress.basins_done >= 2 and not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    run(JOB, tmp_path / "sweep.zarr", client, report=kill_once)
    assert killed
    client.wait_for_workers(2)
    assert content(tmp_path / "sweep.zarr") == content(undisturbed[0])


@pytest.mark.parametrize("done", [pytest.param(each, marks=pytest.mark.slow) for each in (0, 1, 2)])
def test_a_cancelled_sweep_is_readable_basin_by_basin_and_resumes_to_the_same_bytes(
    client, undisturbed, tmp_path, done
):
    location, cancel = tmp_path / "sweep.zarr", threading.Event()

    def cancel_soon(progress):
        if done <= progress.basins_done < len(DAMPINGS) and progress.tiles_done > 0:
            cancel.set()

    with pytest.raises(JobCancelled):
        run(JOB, location, client, report=cancel_soon, cancel=cancel)
    partial = summarise(str(location))
    complete = [basin.complete for basin in partial.basins]
    assert not partial.complete and complete == [True] * sum(complete) + [False] * (5 - sum(complete))
    assert sum(complete) >= done
    with xr.open_zarr(location) as sweep, xr.open_zarr(undisturbed[0]) as whole:
        assert ((sweep.tile_state == TileState.ASSEMBLED).all(("tile_velocity", "tile_time")).values == complete).all()
        there = np.flatnonzero(complete)
        np.testing.assert_array_equal(sweep.solution[there], whole.solution[there])
    seen = []
    run(JOB, location, client, report=seen.append)
    assert seen[0].basins_done == sum(complete)
    assert content(location) == content(undisturbed[0])


def test_numbers_depend_on_no_timing(client, undisturbed, tmp_path, monkeypatch):
    """Tasks that are done in a random order, whatever panel they belong to, give the same numbers."""
    order = random.Random(1)

    def push_anywhere(run, tasks):
        for task in tasks:
            run._pushed += 1
            heapq.heappush(run._ready, (order.random(), run._pushed, task))

    monkeypatch.setattr(Schedule, "_push", push_anywhere)
    run(JOB, tmp_path / "sweep.zarr", client)
    assert content(tmp_path / "sweep.zarr") == content(undisturbed[0])


@pytest.mark.slow
def test_few_tasks_are_in_flight_and_few_panels_under_way_however_many_there_are(client, tmp_path, monkeypatch):
    damping = SweptParameter("damping", tuple(np.linspace(0.7, 0.9, 60).tolist()))
    job = SweepJob(grid=CellGrid(time_cells=8, velocity_cells=8), iterations=1, vary=(damping,))
    in_flight, under_way = [], []
    take = Schedule.take
    submit = client.map
    futures = []

    def watched_map(*arguments, **options):
        submitted = submit(*arguments, **options)
        futures.extend(submitted)
        in_flight.append(sum(not future.done() for future in futures))
        return submitted

    def watched_take(run, task, receipt):
        futures[:] = [future for future in futures if not future.done()]
        under_way.append(len(run.basins))
        take(run, task, receipt)

    monkeypatch.setattr(client, "map", watched_map)
    monkeypatch.setattr(Schedule, "take", watched_take)
    assert run(job, tmp_path / "sweep.zarr", client).complete
    assert max(in_flight) <= Driver(client).window_size <= 4
    assert max(under_way) <= 4 * Driver(client).window_size < 60


def test_two_parameters_make_two_leading_dimensions(client, tmp_path):
    vary = SweptParameter("eccentricity", (0.09, 0.1)), SweptParameter("damping", (0.5, 0.55, 0.6))
    job = SweepJob(grid=CellGrid(time_cells=30, velocity_cells=30), iterations=101, vary=vary)
    summary = run(job, tmp_path / "sweep.zarr", client)
    assert summary.basins[1].parameters == {"eccentricity": 0.09, "damping": 0.55}
    with xr.open_zarr(tmp_path / "sweep.zarr") as sweep:
        assert sweep.solution.dims == ("eccentricity", "damping", "velocity", "time")
        assert sweep.share.shape[:2] == (2, 3)
        number = sweep.name.values.tolist().index("P(1,1,0)")
        np.testing.assert_allclose(
            sweep.attractor_velocity.values[:, :, number, 0], 2 * np.pi * np.array([[0.5, 0.55, 0.6]] * 2)
        )
        assert set(sweep.change_parameter.values.tolist()) <= {"eccentricity", "damping"}


def test_files_of_many_basins_lie_in_nested_folders(undisturbed):
    location, _ = undisturbed
    assert sorted(path.name for path in (location / "solution" / "c").iterdir()) == ["0", "1", "2", "3", "4"]
    assert max(len(list(folder.iterdir())) for folder in location.rglob("*") if folder.is_dir()) < 40
