"""A power cut takes all that is not on the disk, or any part of it: the same job goes on to the same bytes."""

import contextlib
import itertools
import os
import subprocess
import sys
import threading

import numpy as np
import pytest

from rattle_kernels import CellGrid, CellGroups
from rattle_kernels.cell_mapping.image_set import ImageSet
from tests.forgetful_disk import ForgetfulDisk
from tests.store_content import content
from worker.basins import pipeline
from worker.cluster.driver import Driver
from worker.cluster.threads import threads_here
from worker.errors import StoreFailed
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter
from worker.kinds import KINDS
from worker.run import run_job
from worker.storage import folder
from worker.storage.folder import SyncedFiles, synced_together, write_file
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState
from worker.stores.opening import holds_store

BASIN = BasinJob(grid=CellGrid(time_cells=128, velocity_cells=128), iterations=499)
SWEEP = SweepJob(
    grid=CellGrid(time_cells=24, velocity_cells=24), iterations=101, vary=(SweptParameter("damping", (0.7, 0.65, 0.6)),)
)
SMALL = CellGrid(time_cells=24, velocity_cells=24)
GRAZING = KINDS["grazing_curve"].job_class(order=1)
JOBS = {
    "basin": BASIN,
    "sweep": SWEEP,
    "sample": BasinJob(grid=SMALL, iterations=101, sample=Sample(points=200)),
    "proven": BasinJob(grid=SMALL, iterations=101, prove={"levels": 0}),
    "grazing curve": GRAZING,
}
# Nothing that was not synced survives; all of it does; and three mixtures.
CHANCES = (0.0, 1.0, 0.3, 0.5, 0.9)


@pytest.fixture(scope="module")
def threads():
    """Threads of this process, in which every sync is seen."""
    with threads_here(2) as threads:
        yield threads


@pytest.fixture
def disk(tmp_path, monkeypatch):
    root = tmp_path / "disk"
    root.mkdir()
    disk = ForgetfulDisk(root, monkeypatch)
    yield disk
    disk.close()


def run(job, location, client, report=lambda progress: None):
    run_job(job, str(location), Driver(client), report=report, cancel=threading.Event(), fence=lambda: None)


def cut_at_every_report(job, disk, client, folder):
    """Run a job whose power is cut whenever it reports progress, once for each chance. Return what is left."""
    left = []

    def cut(progress):
        for seed, chance in enumerate(CHANCES):
            left.append(folder / f"{len(left)}")
            disk.power_cut(left[-1], chance, seed=1000 * len(left) + seed)

    run(job, disk.root / "store.zarr", client, cut)
    return left


def cut_before_syncs(job, disk, client, folder, every, chances=CHANCES):
    """Run a job whose power is cut before every n-th sync, the chances in turn. Return what is left."""
    left, syncs = [], itertools.count(1)

    def cut():
        if next(syncs) % every == 0:
            left.append(folder / f"{len(left)}")
            disk.power_cut(left[-1], chances[len(left) % len(chances)], seed=len(left))

    disk.before_sync = cut
    run(job, disk.root / "store.zarr", client)
    disk.before_sync = lambda: None
    return [place / "store.zarr" for place in left]


def claimed_tiles_are_there(location):
    """Number of tiles that the ledger speaks of; each of them is read whole."""
    store = BasinStore(str(location))
    states = store.read_ledger()
    for number, state in enumerate(states.tolist()):
        tile = store.tiling.tile(number)
        if state >= TileState.COMPUTED:
            store.tiles.read(store.places.mapped, tile)
        if state >= TileState.ASSEMBLED:
            store.tiles.read((*store.places.labelled, store.places.solution), tile)
    return int((states >= TileState.COMPUTED).sum())


@pytest.mark.parametrize(
    "name",
    ["basin", pytest.param("sweep", marks=pytest.mark.slow), pytest.param("grazing curve", marks=pytest.mark.slow)],
)
def test_what_a_power_cut_leaves_is_gone_on_with_to_the_same_bytes(name, disk, threads, tmp_path):
    job, folder = JOBS[name], tmp_path / "left"
    folder.mkdir()
    left = cut_at_every_report(job, disk, threads, folder)
    undisturbed = content(disk.root / "store.zarr")
    assert len(left) >= 5 * len(CHANCES) and len(undisturbed) > 5
    claimed = []
    for place in left:
        location = place / "store.zarr"
        if job is not GRAZING and holds_store(str(location)):
            claimed.append(claimed_tiles_are_there(location))
    assert job is GRAZING or max(claimed) > 0
    # Every one would take minutes: some early and some late, of different chances.
    for place in left[:: len(left) // 5] + left[-len(CHANCES) :: 3]:
        location = place / "store.zarr"
        run(job, location, threads)
        assert content(location) == undisturbed, place


@pytest.mark.slow
def test_after_a_cut_before_any_sync_what_the_next_driver_reads_is_whole(disk, threads, tmp_path):
    left = cut_before_syncs(SWEEP, disk, threads, tmp_path, 2, (0.7,))
    left = [each for each in left if holds_store(str(each))]
    assert len(left) > 100
    for location in left:
        store = BasinStore(str(location))
        store.solutions.read()
        store.read_image_counts()
        claimed_tiles_are_there(location)


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("name, every", [("sweep", 7), ("sample", 9), ("proven", 23), ("grazing curve", 5)])
def test_a_cut_before_any_sync_is_gone_on_with_to_the_same_bytes(name, every, disk, threads, tmp_path):
    job, folder = JOBS[name], tmp_path / "left"
    folder.mkdir()
    left = cut_before_syncs(job, disk, threads, folder, every)
    undisturbed = content(disk.root / "store.zarr")
    assert len(left) > 10 and len(undisturbed) > 5
    for location in left:
        run(job, location, threads)
        assert content(location) == undisturbed, location


@pytest.mark.parametrize("left", [b"", b"the first bytes"])
def test_a_part_of_a_chunk_is_written_over_whatever_a_cut_has_left_of_it(tmp_path, left):
    stores = [BasinStore.create_or_resume(str(tmp_path / name), SWEEP) for name in ("cut", "whole")]
    write_file(tmp_path / "cut", "assembly/group/c/1/0", left)
    groups = CellGroups(ImageSet(*np.zeros((2, 1), np.int64)), *np.ones((3, 5), np.int32))
    for store in stores:
        store.write_groups(1, groups)
    assert content(tmp_path / "cut") == content(tmp_path / "whole")


def test_a_finished_store_survives_whole(disk, threads, tmp_path):
    run(SWEEP, disk.root / "store.zarr", threads)
    disk.power_cut(tmp_path / "left", chance=0.0)
    finished, left = disk.root / "store.zarr", tmp_path / "left" / "store.zarr"
    assert content(left) == content(finished)
    metadata = [path.relative_to(finished) for path in finished.rglob("zarr.json")]
    assert all((left / path).read_bytes() == (finished / path).read_bytes() for path in metadata)
    assert BasinStore(str(left)).complete


def test_the_disk_forgets_what_is_not_synced(disk, tmp_path):
    """Shows that the other tests would see it."""
    (disk.root / "named.txt").write_text("never synced")
    with (disk.root / "synced.txt").open("w") as file:
        file.write("synced, without its name")
        file.flush()
        os.fsync(file.fileno())
    disk.power_cut(tmp_path / "nothing", chance=0.0)
    assert not list((tmp_path / "nothing").iterdir())
    opened = os.open(disk.root, os.O_RDONLY)
    os.fsync(opened)
    os.close(opened)
    disk.power_cut(tmp_path / "names", chance=0.0)
    assert (tmp_path / "names" / "named.txt").read_text() == ""
    assert (tmp_path / "names" / "synced.txt").read_text() == "synced, without its name"


@contextlib.contextmanager
def never_synced(location):
    """In place of `synced_together`: new files wait for a sync that never comes."""
    token = folder._together.set(folder.Unsynced())
    yield
    folder._together.reset(token)


def test_a_store_whose_tiles_are_not_synced_loses_some_that_its_ledger_claims(disk, threads, tmp_path, monkeypatch):
    """Shows that the other tests would see it."""
    monkeypatch.setattr(pipeline, "synced_together", never_synced)
    left = []

    def cut(progress):
        left.append(tmp_path / f"left{len(left)}")
        disk.power_cut(left[-1], chance=0.5, seed=len(left))

    run_job(BASIN, str(disk.root / "store.zarr"), Driver(threads), report=cut, cancel=threading.Event())
    with pytest.raises(StoreFailed, match="has lost a part|damaged"):
        for place in left:
            if holds_store(str(place / "store.zarr")):
                claimed_tiles_are_there(place / "store.zarr")


def test_new_files_of_a_block_are_synced_at_its_end_and_others_at_once(disk):
    write_file(disk.root, "ledger", b"old")
    assert b"old" in disk.contents.values()
    with synced_together("store"):
        write_file(disk.root, "array/c/0/1", b"new")
        write_file(disk.root, "ledger", b"newer")
        write_file(disk.root, "array/zarr.json", b"metadata")
        assert {b"newer", b"metadata"} <= set(disk.contents.values()) and b"new" not in disk.contents.values()
    assert b"new" in disk.contents.values()


def test_a_failed_sync_is_an_error_of_those_who_wrote(disk, monkeypatch):
    def fails(opened):
        raise OSError(5, "Input/output error")

    with pytest.raises(StoreFailed, match="the store store cannot .* Input/output"), synced_together("store"):
        write_file(disk.root, "array/c/0", b"lost")
        monkeypatch.setattr(os, "fsync", fails)


def test_a_killed_writer_leaves_no_half_file(disk, monkeypatch):
    def fails(opened):
        raise OSError(28, "No space left on device")

    write_file(disk.root, "ledger", b"old")
    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(OSError, match="No space"):
        write_file(disk.root, "ledger", b"newer")
    assert [path.name for path in disk.root.iterdir()] == ["ledger"] and SyncedFiles(disk.root).name == str(disk.root)
    assert (disk.root / "ledger").read_bytes() == b"old"


def test_a_fork_syncs_with_threads_of_its_own(tmp_path):
    """The threads of this process are not there in a fork: it would wait for them for ever."""
    program = f"""
import os
import subprocess
import sys
from pathlib import Path
from worker.storage.folder import write_file
root = Path({str(tmp_path)!r})
write_file(root, "a/zarr.json", b"1")
child = os.fork()
write_file(root, f"{{bool(child)}}/zarr.json", b"2")
if child:
    assert os.waitpid(child, 0)[1] == 0
"""
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
    assert sorted(path.parent.name for path in tmp_path.rglob("zarr.json")) == ["False", "True", "a"]
