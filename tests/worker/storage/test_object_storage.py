"""Stores in S3 and in folders: the same bytes, whole objects, and failures told in time."""

import http.server
import os
import signal
import threading
import time

import numpy as np
import pytest

from rattle_kernels import CellGrid
from tests.object_store import BUCKET, ObjectStore
from tests.worker.basins.test_pipeline import JOB, run
from worker.errors import JobCancelled, LeaseLost, StoreConflict, StoreFailed, as_store_failure
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.swept_parameter import SweptParameter
from worker.results.opening import open_basin
from worker.results.summary import summarise
from worker.storage.location import read_file_of_store, remove_result
from worker.stores import layout
from worker.stores.basin_store import BasinStore
from worker.stores.opening import holds_store

SMALL = BasinJob(grid=CellGrid(time_cells=24, velocity_cells=20), iterations=7)
SWEEP = SweepJob(grid=SMALL.grid, iterations=499, vary=(SweptParameter("damping", (0.575, 0.6, 0.7)),))


@pytest.fixture(scope="module")
def folders(client, tmp_path_factory):
    """Undisturbed results in folders."""
    folder = tmp_path_factory.mktemp("folders")
    for job in (JOB, SWEEP):
        run(job, folder / f"{job.kind}.zarr", client)
    return folder


def in_s3(name):
    return f"s3://{BUCKET}/worker/{name}"


def assert_same_bytes(object_store, name, folder):
    """Every object and no other, but for the times that metadata hold."""
    objects = object_store.objects(f"worker/{name}")
    files = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert objects.keys() == files.keys() and len(files) > 30
    different = {path for path in files if files[path] != objects[path]}
    assert different <= {"zarr.json"}


@pytest.mark.slow
@pytest.mark.parametrize("job", [JOB, SWEEP], ids=["basin", "sweep"])
def test_objects_are_the_files_of_a_folder_to_the_byte(client, object_store, folders, job):
    name = f"{job.kind}.zarr"
    summary = run(job, in_s3(name), client)
    assert summary.complete
    assert_same_bytes(object_store, name, folders / name)
    with open_basin(in_s3(name)) as remote, open_basin(folders / name) as local:
        assert remote.drop_attrs(deep=False).identical(local.drop_attrs(deep=False))
    file = read_file_of_store(in_s3(name), "zarr.json")
    assert file.content == object_store.objects(f"worker/{name}")["zarr.json"] and file.tag


def test_a_bucket_that_does_not_answer_is_named(object_store, monkeypatch):
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    with pytest.raises(StoreFailed, match="s3://results/worker/lost.zarr cannot be read"):
        open_basin(in_s3("lost.zarr"))


def test_keys_that_are_missing_are_asked_for():
    # What obstore says on a machine that is none of Amazon's.
    told = "Generic S3 error: Error performing PUT http://169.254.169.254/latest/api/token in 5 ms - 403"
    with (
        pytest.raises(StoreFailed, match="set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"),
        as_store_failure("s3://b/c"),
    ):
        raise OSError(told)


@pytest.mark.slow
def test_a_killed_worker_and_a_stop_leave_no_trace_in_the_objects(client, object_store, folders):
    killed, cancel = [], threading.Event()

    def kill_then_stop(progress):
        if progress.tiles_done == 3 and not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)
        if progress.tiles_done == 6:
            cancel.set()

    with pytest.raises(JobCancelled):
        run(JOB, in_s3("disturbed.zarr"), client, report=kill_then_stop, cancel=cancel)
    assert 6 <= summarise(in_s3("disturbed.zarr")).tiles_computed < 16
    seen = []
    run(JOB, in_s3("disturbed.zarr"), client, report=seen.append)
    assert killed and seen[0].tiles_done >= 6
    assert_same_bytes(object_store, "disturbed.zarr", folders / "basin.zarr")
    client.wait_for_workers(2)


def test_aligned_writers_do_not_meet(object_store):
    location = in_s3("aligned.zarr")
    tiling = BasinStore.create_or_resume(location, JOB).tiling
    barrier = threading.Barrier(tiling.tiles)

    def write(number):
        store, tile = BasinStore(location), tiling.tile(number)
        values = np.full((tile.rows[1] - tile.rows[0], tile.columns[1] - tile.columns[0]), number, np.int64)
        barrier.wait()
        store.tiles.write(layout.MAPPED[:1], tile, [values])

    writers = [threading.Thread(target=write, args=(number,)) for number in range(tiling.tiles)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    store = BasinStore(location)
    for number in range(tiling.tiles):
        (read,) = store.tiles.read(layout.MAPPED[:1], tiling.tile(number))
        assert (read == number).all()


def test_a_store_is_removed_to_its_last_object_and_no_other_with_it(object_store):
    for name in ("gone.zarr", "gone.zarr-not", "gone"):
        BasinStore.create_or_resume(in_s3(name), SMALL)
    remove_result(in_s3("gone.zarr"))
    assert not holds_store(in_s3("gone.zarr")) and object_store.objects("worker/gone.zarr") == {}
    assert holds_store(in_s3("gone.zarr-not")) and holds_store(in_s3("gone"))
    remove_result(in_s3("gone.zarr"))


def test_what_is_no_store_is_not_touched(object_store):
    BasinStore.create_or_resume(in_s3("folder/inner.zarr"), SMALL)
    before = object_store.objects("worker/folder")
    with pytest.raises(StoreConflict, match="is no basin store"):
        BasinStore.create_or_resume(in_s3("folder"), SMALL)
    with pytest.raises(StoreConflict, match="holds the store of another request"):
        BasinStore.create_or_resume(in_s3("folder/inner.zarr"), JOB)
    assert object_store.objects("worker/folder") == before


@pytest.fixture(scope="module", params=["folder", "s3"])
def root(request, object_store, tmp_path_factory):
    """Where two stores lie side by side."""
    root = str(tmp_path_factory.mktemp("paths")) if request.param == "folder" else in_s3("paths")
    for name in ("one.zarr", "other.zarr"):
        BasinStore.create_or_resume(f"{root}/{name}", SMALL)
    return root


@pytest.mark.parametrize("path", ["../other.zarr/zarr.json", "group/../../other.zarr/zarr.json", "", "group", "no\0"])
def test_no_path_leads_out_of_a_store(root, path):
    assert read_file_of_store(f"{root}/one.zarr", "group/zarr.json").content.startswith(b"{")
    assert read_file_of_store(f"{root}/one.zarr", path) is None


def test_a_part_that_is_lost_is_a_failure_and_no_data(tmp_path):
    store = BasinStore.create_or_resume(str(tmp_path / "b.zarr"), SMALL)
    with pytest.raises(StoreFailed, match="has lost a part of image_cell"):
        store.tiles.read(layout.MAPPED[:1], store.tiling.tile(0))


@pytest.mark.parametrize("location", ["s3://", "s3://bucket", "gs://bucket/prefix", "http://127.0.0.1/x.zarr"])
def test_a_place_of_another_kind_is_refused(location):
    with pytest.raises(StoreFailed, match="is no place for stores: write"):
        BasinStore.create_or_resume(location, SMALL)


def test_a_bucket_that_is_not_there_is_told(object_store):
    for attempt in (holds_store, lambda location: BasinStore.create_or_resume(location, SMALL)):
        with pytest.raises(StoreFailed, match="s3://nowhere/a.zarr .*: NoSuchBucket: The specified bucket does not"):
            attempt("s3://nowhere/a.zarr")


class Denies(http.server.BaseHTTPRequestHandler):
    """Answers every request as S3 does one that is not allowed."""

    def do_GET(self):
        body = b"<Error><Code>AccessDenied</Code><Message>Access Denied</Message></Error>"
        self.send_response(403)
        self.send_header("content-length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    do_PUT = do_HEAD = do_GET

    def log_message(self, *_):
        pass


def test_a_server_that_denies_is_told(monkeypatch):
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Denies) as server:
        threading.Thread(target=server.serve_forever).start()
        monkeypatch.setenv("AWS_ACCESS_KEY_ID", "somebody")
        monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "else")
        monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{server.server_port}")
        for attempt in (holds_store, lambda location: BasinStore.create_or_resume(location, SMALL)):
            with pytest.raises(StoreFailed, match=r"s3://.*/b.zarr cannot be read or written: AccessDenied: Access"):
                attempt(in_s3("b.zarr"))
        server.shutdown()


def test_a_server_that_is_gone_is_told(monkeypatch):
    server = ObjectStore()
    for name, value in server.variables.items():
        monkeypatch.setenv(name, value)
    server.start()
    store = BasinStore.create_or_resume(in_s3("b.zarr"), SMALL)
    server.kill()
    # The library itself would try for three minutes, longer than a test may take.
    with pytest.raises(StoreFailed, match=r"s3://.*/b.zarr cannot be read or written: .*error sending request"):
        store.write_ledger(np.ones(store.tiling.tiles))


def test_a_driver_that_waits_for_a_server_sends_nothing_more_once_its_job_is_anothers(object_store, monkeypatch):
    """The server hangs: requests are given up, and sent again only while the fence lets them through."""
    monkeypatch.setattr("worker.storage.object_storage._HURRY", {"connect_timeout": "2s", "timeout": "300ms"})
    asked = []

    def fence():
        asked.append(time.monotonic())
        if len(asked) > 4:
            raise LeaseLost("another's")

    store = BasinStore.create_or_resume(in_s3("hangs.zarr"), SMALL)
    driver = BasinStore(in_s3("hangs.zarr"), fence)
    driver.write_ledger(store.read_ledger())
    asked.clear()
    object_store.process.send_signal(signal.SIGSTOP)
    try:
        with pytest.raises(LeaseLost):
            driver.write_ledger(np.ones(store.tiling.tiles, np.uint8))
    finally:
        object_store.process.send_signal(signal.SIGCONT)
    # Of the four between them, each was given up after 300 ms; one that waits for the server would never end.
    assert len(asked) == 5 and asked[-1] - asked[1] > 3 * 0.3
