"""`import rattle`: quick to import, and its verbs compute, keep and resume."""

import gc
import subprocess
import sys
import threading

import numpy as np
import pytest
import xarray as xr

import rattle
from rattle import local, names
from rattle.garbage import fewer_collections
from rattle.progress import ProgressLine
from worker.errors import JobCancelled, StoreConflict


def test_importing_it_loads_nothing_heavy():
    look = "import sys, rattle; print({'numba', 'dask', 'zarr', 'matplotlib', 'xarray', 'fastapi'} & set(sys.modules))"
    told = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, check=True, timeout=60)
    assert told.stdout.strip() == "set()"


def test_what_it_has_is_listed_and_what_it_has_not_is_said():
    assert set(dir(rattle)) >= {"basin", "connect", "open", "cache", "BasinJob", "__version__"}
    assert all(getattr(rattle, name) is not None for name in dir(rattle))
    with pytest.raises(AttributeError, match="it has BasinJob"):
        _ = rattle.basins


def test_names_that_are_loaded_on_first_use_are_public_ones():
    assert set(names.__all__) < set(rattle.__all__)
    assert all(getattr(rattle, name) is getattr(names, name) for name in names.__all__)


def test_a_small_basin_loads_no_arrays_and_no_cluster_of_dask(tmp_path):
    script = (
        "import sys, rattle\n"
        "basin = rattle.basin(cells=10, iterations=101, progress=False, store=sys.argv[1])\n"
        "basin.rattle.to_table(), basin.solution.values\n"
        "heavy = {'dask.array', 'distributed', 'httpx2', 'cryptography', 'rattle_proof.enclosures.cells'}\n"
        "print(heavy & set(sys.modules))"
    )
    told = subprocess.run(
        [sys.executable, "-c", script, tmp_path / "small.zarr"],
        capture_output=True, text=True, check=True, timeout=300,
    )  # fmt: skip
    assert told.stdout.strip() == "set()"


@pytest.mark.parametrize("threshold", [0, 700, 200_000])
def test_the_callers_thresholds_of_the_garbage_collector_are_back(threshold, tmp_path):
    before, seen = gc.get_threshold(), []
    gc.set_threshold(threshold, 11, 12)
    try:
        rattle.basin(
            cells=8, iterations=23, store=tmp_path / "small.zarr", progress=lambda _: seen.append(gc.get_threshold())
        )
        assert gc.get_threshold()[:2] == (threshold, 11)
    finally:
        gc.set_threshold(*before)
    assert set(seen) == {(max(threshold, 100_000) if threshold else 0, 11, 12)}


def test_thresholds_are_back_when_the_last_of_overlapping_verbs_ends():
    before = gc.get_threshold()
    first, second = fewer_collections(), fewer_collections()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)  # the one that began first, as in another thread
    assert gc.get_threshold() == (100_000, *before[1:])
    second.__exit__(None, None, None)
    assert gc.get_threshold() == before


def test_a_result_is_kept_under_its_request(basin, kept):
    before = {path: path.stat().st_mtime_ns for path in kept.iterdir()}
    again = rattle.basin(damping=0.6, cells=(40, 40), progress=False)
    assert {path: path.stat().st_mtime_ns for path in kept.iterdir()} == before
    xr.testing.assert_identical(again, basin)
    assert rattle.cache.size > 10_000 and str(kept) in repr(rattle.cache)


def test_a_store_of_ones_own_is_written_and_not_given_to_another_request(tmp_path):
    mine = str(tmp_path / "mine.zarr")
    first = rattle.basin(cells=10, iterations=101, store=mine, progress=False, workers=1)
    assert rattle.open(mine).attrs["request_sha256"] == first.attrs["request_sha256"]
    with pytest.raises(StoreConflict, match="holds the store of another request"):
        rattle.basin(cells=11, iterations=101, store=mine, progress=False)
    with pytest.raises(ValueError, match="workers must be 1 or more"):
        rattle.basin(cells=12, workers=0)


def test_kept_results_can_be_cleared(monkeypatch, tmp_path):
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path))
    rattle.grazing_curve(order=0, progress=False)
    assert len(rattle.cache.stores()) == 1
    size = rattle.cache.size
    rattle.cache.beside.mkdir()
    (rattle.cache.beside / "tried.txt").write_text("ten bytes!")
    assert rattle.cache.size == size + 10
    rattle.cache.clear()
    assert rattle.cache.stores() == [] and rattle.cache.size == 0 and not rattle.cache.beside.exists()


def test_an_interrupted_computation_goes_on_where_it_was(tmp_path, monkeypatch):
    """Ctrl-C in the thread that waits sets the event that cancels the work: here the first tile does."""
    given = {"cells": 160, "iterations": 4999, "store": str(tmp_path / "long.zarr"), "progress": False}

    def interrupted(work):
        cancel = threading.Event()
        monkeypatch.setattr(ProgressLine, "show", lambda _, stage, done, *__: cancel.set() if done[0] else None)
        return work(cancel)

    with monkeypatch.context() as patch:
        patch.setattr(local, "run_interruptibly", interrupted)
        with pytest.raises(JobCancelled):
            rattle.basin(**given)
    assert not rattle.open(given["store"]).rattle.complete
    monkeypatch.undo()
    left = rattle.open(given["store"]).tile_state.values.copy()
    assert (left > 1).any()
    assert rattle.basin(**given).rattle.complete


def test_progress_may_be_a_function_and_what_it_raises_stops_the_work(tmp_path):
    """As another program needs it that shows progress, or has a button to cancel."""
    job = rattle.BasinJob(grid={"time": {"cells": 160}, "velocity": {"cells": 160}}, iterations=101)
    store = tmp_path / "followed.zarr"

    def stop(progress):
        if progress.tiles_done:
            raise JobCancelled("enough")

    with pytest.raises(JobCancelled, match="enough"):
        rattle.compute(job, store=store, progress=stop)
    assert not rattle.open(store).rattle.complete
    seen = []
    assert rattle.compute(job, store=store, workers=1, progress=seen.append).rattle.complete
    assert (
        seen[0].tiles_done > 0 and seen[-1].stage == "done" and all(isinstance(each, rattle.Progress) for each in seen)
    )
    assert rattle.compute(job, store=store, progress=stop).rattle.complete


def test_threads_give_the_bytes_that_processes_give(client, tmp_path):
    """Work here and work on a cluster are the same to the byte."""
    from tests.store_content import content
    from worker.cluster.driver import Driver
    from worker.run import run_job

    job = rattle.BasinJob(iterations=101)
    job = type(job).from_request(job.request() | {"grid": {"time": {"cells": 30}, "velocity": {"cells": 30}}})
    here, there = tmp_path / "here.zarr", tmp_path / "there.zarr"
    rattle.compute(job, store=here, progress=False)
    run_job(job, str(there), Driver(client), report=lambda _: None, cancel=threading.Event())
    arrays = {name for name in content(there) if not name.endswith("zarr.json")}
    assert {name: content(here)[name] for name in arrays} == {name: content(there)[name] for name in arrays}


def test_a_trajectory_is_that_of_the_kernels():
    from rattle_kernels import Oscillator, time_history

    motion = rattle.trajectory(damping=0.6, velocity=4.0, periods=3.0)
    history = time_history(Oscillator(), 0.0, 0.6, -4.0, periods=3.0)
    np.testing.assert_array_equal(motion.displacement, history.displacement)
    np.testing.assert_array_equal(motion.contact_time, history.contacts.time)
    with pytest.raises(TypeError, match="missing 1 required keyword-only argument: 'velocity'"):
        rattle.trajectory(damping=0.6)
    with pytest.raises(ValueError, match="velocity must be positive"):
        rattle.trajectory(velocity=-4.0)


@pytest.mark.parametrize("verb", [rattle.basin, rattle.sweep, rattle.trajectory])
def test_arguments_without_names_are_refused(verb):
    with pytest.raises(TypeError, match="takes from 0 to 1 positional arguments but 3 were given"):
        verb(0.6, 0.1, 0.7)


def test_a_path_that_does_not_exist_is_one_traceback(tmp_path):
    with pytest.raises(StoreConflict, match="nothing there") as refused:
        rattle.open(tmp_path / "none.zarr")
    assert refused.value.__cause__ is None and refused.value.__suppress_context__
