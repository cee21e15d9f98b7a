"""A store is opened once in a process, and whatever is read of it is what is there now."""

import shutil
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from rattle_kernels import CellGrid
from tests.worker.basins.made_up import CHAOS, QUIET, RATTLE
from worker.errors import InvalidJob, StoreConflict, StoreFailed
from worker.jobs.basin_job import BasinJob
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.kinds import KINDS
from worker.results.summary import summarise
from worker.results.viewer import outline_basin, read_tile_labels
from worker.stores import layout, opening
from worker.stores.analysis_store import AnalysisStore, kind_of_store
from worker.stores.basin_store import BasinStore
from worker.stores.opening import holds_store, is_complete
from worker.stores.solution_table import motion_of

GRID = CellGrid(time_cells=8, velocity_cells=8)


@pytest.fixture
def location(tmp_path):
    return str(tmp_path / "store.zarr")


@pytest.fixture
def openings(monkeypatch):
    """One entry for each root that is opened."""
    counted, open_group = [], opening.open_group
    monkeypatch.setattr(
        opening, "open_group", lambda *given, **how: (counted.append(given), open_group(*given, **how))[1]
    )
    return counted


def test_a_store_is_opened_once_and_shared(store, openings):
    first = BasinStore.open(store.location)
    with ThreadPoolExecutor(4) as threads:
        assert set(threads.map(BasinStore.open, [store.location] * 20)) == {first}
    assert len(openings) == 1
    for number in range(store.tiling.tiles):
        assert read_tile_labels(store.location, number) is not None
    outline_basin(store.location, 0)
    assert len(openings) == 1


def test_whether_there_is_a_store_is_looked_at_once(store, openings):
    assert all(holds_store(store.location) for _ in range(5)) and kind_of_store(store.location) == "basin"
    assert not is_complete(store.location, store.digest) and len(openings) == 1


def test_a_store_that_is_made_anew_is_another_one(location):
    first, second = (BasinJob(grid=GRID, iterations=k) for k in (1, 2))
    BasinStore.create_or_resume(location, first)
    assert BasinStore.open(location).digest == first.digest
    shutil.rmtree(location)
    BasinStore.create_or_resume(location, second)
    assert BasinStore.open(location).digest == second.digest and summarise(location).request["iterations"] == 2
    with pytest.raises(StoreConflict, match="holds the store of another request by now"):
        BasinStore.open(location, first.digest)
    shutil.rmtree(location)
    AnalysisStore.create_or_resume(location, "a curve", GrazingCurveJob())
    assert kind_of_store(location) == "grazing_curve"
    with pytest.raises(StoreConflict, match="is no basin store: it is one of kind grazing_curve"):
        BasinStore.open(location)


def test_a_store_that_is_removed_is_gone(location):
    BasinStore.create_or_resume(location, BasinJob(grid=GRID, iterations=1))
    assert holds_store(location) and BasinStore.open(location)
    shutil.rmtree(location)
    assert not holds_store(location)
    with pytest.raises(StoreConflict, match="nothing there that Zarr can open"):
        BasinStore.open(location)


def test_solutions_that_are_added_are_seen(store):
    assert len(summarise(store.location).solutions) == 3
    table = store.solutions.read()
    numbers = [0, 1, 2, table.append(motion_of(RATTLE))]
    found = QUIET, RATTLE, CHAOS, RATTLE
    table.enter(0, numbers, found, np.array([0.5, 0.2, 0.2, 0.1]))
    store.solutions.make_room(table, 70)
    store.solutions.write(table)
    store.solutions.write_points(0, numbers, found)
    assert len(summarise(store.location).solutions) == len(outline_basin(store.location, 0).solutions) == 4


def test_labels_and_the_ledger_are_read_each_time(store):
    before = read_tile_labels(store.location, 1)
    states = store.read_ledger()
    states[0] = layout.TileState.COMPUTED
    store.write_ledger(states)
    tile = store.tiling.tile(1)
    store.tiles.write(
        (layout.SOLUTION,), tile, (np.full(store.tiles.read((layout.SOLUTION,), tile)[0].shape, 2, np.int16),)
    )
    assert read_tile_labels(store.location, 0) is None
    assert read_tile_labels(store.location, 1).content != before.content


def test_a_store_that_ends_or_is_taken_back_is_seen_so(store):
    assert not read_tile_labels(store.location, 0).final
    store.finish({})
    assert read_tile_labels(store.location, 0).final and is_complete(store.location, store.digest)
    BasinStore(store.location).invalidate(np.full(store.tiling.tiles, layout.TileState.PENDING, np.uint8))
    assert read_tile_labels(store.location, 0) is None and not is_complete(store.location, store.digest)
    assert summarise(store.location).solutions == [] and not outline_basin(store.location, 0).complete


def test_arrays_of_a_finished_store_are_opened_anew_once_it_is_taken_back_and_has_grown(store):
    store.finish({})
    assert len(summarise(store.location).solutions) == 3  # with all arrays open
    again = BasinStore(store.location)
    again.invalidate(np.full(store.tiling.tiles, layout.TileState.ASSEMBLED, np.uint8))
    table = again.solutions.read()
    table.append(motion_of(RATTLE))
    again.solutions.make_room(table, 90)
    again.solutions.write(table)
    again.finish({})
    assert len(summarise(store.location).solutions) == 1


def test_a_request_that_was_changed_is_refused_although_the_store_was_open(store):
    root = Path(store.location) / "zarr.json"
    content = root.read_text()
    assert BasinStore.open(store.location)
    root.write_text(content.replace('\\"damping\\": 0.6', '\\"damping\\": 0.7'))
    with pytest.raises(StoreFailed, match="it does not have the digest that was stored with it; `rattle check` tells"):
        BasinStore.open(store.location)
    root.write_text(content)
    assert BasinStore.open(store.location).job == store.job


def test_what_is_open_is_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(opening, "_OPENED", opening.LRUCache(3 << 16, getsizeof=lambda opened: 1 << 16))
    for number in range(5):
        BasinStore.create_or_resume(str(tmp_path / str(number)), BasinJob(grid=GRID, iterations=1))
        assert BasinStore.open(str(tmp_path / str(number)))
    assert len(opening._OPENED) == 3
    monkeypatch.setattr(opening, "_OPENED", opening.LRUCache(1, getsizeof=lambda opened: 2))
    assert BasinStore.open(str(tmp_path / "0")).job.iterations == 1 and not opening._OPENED


def test_a_root_that_changes_while_it_is_opened_is_not_kept(location):
    BasinStore.create_or_resume(location, BasinJob(grid=GRID, iterations=1))

    def replaced(there):
        store = BasinStore(there)
        shutil.rmtree(there)
        BasinStore.create_or_resume(there, BasinJob(grid=GRID, iterations=2))
        return store

    assert opening.opened_once(replaced, location).job.iterations == 1
    assert (replaced, location) not in opening._OPENED


def test_tasks_of_a_job_share_its_store(location, openings):
    digest = BasinStore.create_or_resume(location, BasinJob(grid=GRID, iterations=1)).digest
    openings.clear()
    found, barrier = [], threading.Barrier(4)

    def task():
        barrier.wait()
        found.append(BasinStore.open(location, digest))

    threads = [threading.Thread(target=task) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4 and BasinStore.open(location, digest) is BasinStore.open(location, digest)


@pytest.mark.parametrize(
    ("kind", "request_"),
    [
        ("basin", {"oscillator": {"damping": 0.6, "eccentricity": 5.0}}),
        ("basin", {"iterations": 4}),
        ("orbits", {"kind": "orbits", "region": {"velocity": {"start": 0, "stop": 1e13}}}),
    ],
)
def test_a_request_is_trusted_by_its_digest_alone(kind, request_):
    job_class = KINDS[kind].job_class
    digest = job_class().digest
    assert job_class.trusted(job_class().request(), digest) == job_class()
    with pytest.raises(InvalidJob, match="does not have the digest that was stored with it"):
        job_class.trusted(job_class().request() | request_, digest)
