"""A job refuses workers that round otherwise than its driver, and stores that were begun so."""

import logging
import subprocess
import sys
import threading
import time

import pytest
from distributed import Client, LocalCluster

from rattle_kernels import CellGrid
from tests.processors import NATIVE, ROOT, V2, environment_for, reason_against
from tests.worker.analyses.test_analyses import GRAZING
from worker import rounding
from worker.analyses.analysis import compute_piece
from worker.analyses.grazing_curves import GRAZING_CURVE
from worker.cluster import connection
from worker.cluster.calls import Task
from worker.cluster.driver import Driver
from worker.errors import StoreConflict, UnlikeWorkers
from worker.jobs.basin_job import BasinJob
from worker.stores.analysis_store import AnalysisStore
from worker.stores.basin_store import BasinStore
from worker.stores.opening import opened_for_tasks


def open_for_a_while(location, digest, number):
    """Long enough for every worker to get one."""
    BasinStore.open(location, digest)
    time.sleep(0.05)
    return number


def run(client, store):
    tasks = iter([Task(open_for_a_while, number) for number in range(20)])
    done = Driver(client).run_tasks((store.location, store.digest), lambda: next(tasks, None), threading.Event())
    return sorted(receipt for _, receipt in done)


@pytest.fixture
def odd_worker():
    """Starts a worker without fused multiply-add, as a shell does."""
    environment, started = environment_for(V2), []

    def start(address):
        options = ["--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        command = [sys.executable, "-m", "dask", "worker", address, *options]
        started.append(subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.DEVNULL))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.wait(20)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_cluster_of_both_kinds_is_refused_for_as_long_as_it_is_one(odd_worker, tmp_path):
    store = create_basin(str(tmp_path / "store"))
    options = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0", "host": "127.0.0.1"}
    with LocalCluster(processes=True, **options) as alike, Client(alike, set_as_default=False) as client:
        assert run(client, store) == list(range(20))
        process = odd_worker(alike.scheduler_address)
        client.wait_for_workers(2, timeout=120)
        with pytest.raises(UnlikeWorkers, match=f"was begun with .* and process {process.pid} on .* without it"):
            run(client, store)
        process.kill()
        process.wait(20)
        while len(client.scheduler_info()["workers"]) > 1:
            time.sleep(0.1)
        assert run(client, store) == list(range(20))


def create_basin(place):
    return BasinStore.create_or_resume(place, BasinJob(grid=CellGrid(time_cells=8, velocity_cells=8), iterations=1))


def create_analysis(place):
    return AnalysisStore.create_or_resume(place, GRAZING_CURVE.title, GRAZING)


def open_basin(store):
    opened_for_tasks.cache.clear()
    BasinStore.open(store.location, store.digest)


def open_analysis(store):
    opened_for_tasks.cache.clear()
    compute_piece(store.location, store.digest, 1, "none", lambda pause: {}, ())


@pytest.mark.parametrize(("create", "open_"), [(create_basin, open_basin), (create_analysis, open_analysis)])
def test_a_task_refuses_a_store_that_was_begun_otherwise(create, open_, tmp_path, monkeypatch):
    store = create(str(tmp_path / "store"))
    open_(store)
    fused = store.attributes[rounding.FUSED]
    monkeypatch.setattr(rounding, "fuses_multiply_add", lambda: not fused)
    with pytest.raises(UnlikeWorkers, match="was begun with.* fused multiply-add"):
        open_(store)


@pytest.mark.parametrize("create", [create_basin, create_analysis])
def test_a_store_that_was_begun_otherwise_is_refused_until_it_is_complete(create, tmp_path, monkeypatch):
    store = create(str(tmp_path / "store"))
    fused = store.attributes[rounding.FUSED]
    monkeypatch.setattr(rounding, "fuses_multiply_add", lambda: not fused)
    with pytest.raises(StoreConflict, match="was begun with.* fused multiply-add"):
        create(store.location)
    store.finish({})
    assert create(store.location).complete


def test_a_store_from_before_it_was_noted_is_taken():
    rounding.demand_same_rounding("place", {})


@pytest.mark.parametrize(("target", "lines"), [(NATIVE, 0), (V2, 1)])
def test_a_process_without_it_says_so(target, lines):
    if target == NATIVE and (reason := reason_against(V2)):
        pytest.skip(reason)
    code = "from worker.rounding import warn_if_unfused; warn_if_unfused()"
    command = [sys.executable, "-c", code]
    told = subprocess.run(command, cwd=ROOT, env=environment_for(target), capture_output=True, text=True, check=True)
    assert told.stderr.count("no fused multiply-add (FMA)") == told.stderr.count("\n") == lines


def test_a_worker_says_so_before_it_loads_its_kernels(monkeypatch, caplog):
    monkeypatch.setattr(rounding, "fuses_multiply_add", lambda: False)
    monkeypatch.setattr(connection, "warm_up", lambda: logging.getLogger("rattle.rounding").warning("warm"))
    with caplog.at_level(logging.WARNING, "rattle.rounding"):
        connection.WarmKernels().setup(None)
    told = [record.getMessage() for record in caplog.records if record.name == "rattle.rounding"]
    assert len(told) == 2 and "fused multiply-add" in told[0]
