"""A flipped bit in a store is an error that names the store, the array and the tile, wherever it is read."""

import json
import pickle
import shutil
import threading

import pytest
import zarr

import rattle
from rattle_kernels import CellGrid
from tests.worker.stores.zarr_stores.write import HERE
from worker.cluster.driver import Driver
from worker.errors import DamagedChunk, StoreFailed
from worker.jobs.basin_job import BasinJob
from worker.results.figure import figure_of_store
from worker.results.panel import Look
from worker.results.summary import summarise
from worker.results.viewer import read_tile_labels
from worker.run import run_job
from worker.storage.location import storage_at
from worker.storage.protocol import whole
from worker.stores.basin_store import BasinStore
from worker.stores.layout import SOLUTION
from worker.stores.opening import open_group

POINTS = ("attractor_time", "attractor_velocity")
JOB = BasinJob(grid=CellGrid(time_cells=100, velocity_cells=100), iterations=101)


@pytest.fixture(scope="module")
def finished(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("finished") / "basin.zarr"
    run_job(JOB, str(location), Driver(client), report=lambda progress: None, cancel=threading.Event())
    return location


@pytest.fixture
def store(finished, tmp_path):
    """A copy that may be damaged."""
    return shutil.copytree(finished, tmp_path / "basin.zarr")


def flip(path, bit=None):
    """Flip one bit of a file, by default one in the middle."""
    content = bytearray(path.read_bytes())
    bit = 4 * len(content) if bit is None else bit
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)


def chunks(store):
    return sorted(path for path in store.rglob("*") if path.is_file() and path.name != "zarr.json")


def test_every_chunk_of_every_array_has_a_checksum(store):
    arrays = [json.loads(path.read_text()) for path in store.rglob("zarr.json")]
    codecs = [[codec["name"] for codec in each["codecs"]] for each in arrays if each["node_type"] == "array"]
    assert len(codecs) > 25 and all(names[-2:] == ["blosc", "crc32c"] for names in codecs)


def test_a_flipped_bit_in_any_chunk_is_told_with_its_place(store):
    paths = chunks(store)
    assert len(paths) > 30
    for number, path in enumerate(paths):
        kept = path.read_bytes()
        flip(path, bit=number * 7919 % (8 * len(kept)))
        array, _, chunk = path.relative_to(store).as_posix().rpartition("/c/")
        with pytest.raises(DamagedChunk) as caught:
            open_group(str(store), "r")[array][...]
        assert (caught.value.store, caught.value.array, caught.value.chunk) == (str(store), array, chunk)
        path.write_bytes(kept)


@pytest.mark.parametrize("left", [0, 3, 30])
def test_a_chunk_that_is_cut_short_is_told(store, left):
    path = store / "solution" / "c" / "1" / "0"
    path.write_bytes(path.read_bytes()[:left])
    with pytest.raises(DamagedChunk, match="tile 1/0 of solution"):
        rattle.open(store).solution.load()


def test_a_chunk_that_a_finished_store_has_lost_is_told_and_not_read_as_data(store):
    lost = [path for path in chunks(store) if path.relative_to(store).parts[0] not in ("assembly", *POINTS)]
    assert len(lost) > 20
    for path in lost:
        kept = path.read_bytes()
        path.unlink()
        array, _, chunk = path.relative_to(store).as_posix().rpartition("/c/")
        with pytest.raises(DamagedChunk, match=f"tile {chunk} of {array} is missing"):
            rattle.open(store)[array].load()
        path.write_bytes(kept)


def test_an_unfinished_store_may_lack_chunks(tmp_path):
    BasinStore.create_or_resume(str(tmp_path / "begun"), JOB)
    assert (rattle.open(tmp_path / "begun").solution.load() == SOLUTION.fill).all()


READERS = {
    "xarray": lambda place: rattle.open(place).solution.values,
    "table of all": lambda place: rattle.open(place).load(),
    "measures": lambda place: rattle.open(place).rattle.measures(),
    "picture": lambda place: figure_of_store(place, Look()),
    "tile": lambda place: read_tile_labels(place, 2),
    "store": lambda place: (opened := BasinStore(place)).tiles.read((opened.places.solution,), opened.tiling.tile(2)),
}


@pytest.mark.parametrize("reader", READERS)
def test_every_reader_names_store_array_and_tile(store, reader):
    flip(store / "solution" / "c" / "1" / "0")
    with pytest.raises(StoreFailed) as caught:
        READERS[reader](str(store))
    assert str(caught.value).startswith(f"the store {store} is damaged: tile 1/0 of solution")


@pytest.mark.parametrize("content", ["{", '{"zarr_format": 3, "node_type": "array"}'])
@pytest.mark.parametrize("reader", ["tile", "store"])
def test_readers_name_metadata_that_cannot_be_read(store, reader, content):
    (store / "solution" / "zarr.json").write_text(content)
    with pytest.raises(StoreFailed) as caught:
        READERS[reader](str(store))
    assert str(caught.value).startswith(f"the store {store} is damaged: the metadata solution/zarr.json cannot be read")


def test_a_summary_names_a_damaged_ledger(store):
    flip(store / "tile_state" / "c" / "0" / "0")
    with pytest.raises(StoreFailed, match="damaged: tile 0/0 of tile_state"):
        summarise(str(store))


def test_the_error_travels_from_a_worker():
    error = pickle.loads(pickle.dumps(DamagedChunk("a.zarr", "solution", "1/0")))
    assert (error.store, error.array, error.chunk) == ("a.zarr", "solution", "1/0") and "tile 1/0" in str(error)


def test_another_reader_sees_the_error_too(store):
    """Zarr's own codec, as anybody's program has it."""
    flip(store / "solution" / "c" / "1" / "0")
    with pytest.raises(ValueError, match="checksum do not match"):
        zarr.open_array(str(store), path="solution", mode="r")[...]


def test_a_store_without_checksums_opens_as_before(tmp_path):
    shutil.unpack_archive(HERE / "zarr-3.1.6.zip", tmp_path)
    assert "crc32c" not in (tmp_path / "sweep" / "zarr.json").read_text()
    assert rattle.open(tmp_path / "sweep").load().solution.size and summarise(str(tmp_path / "sweep")).complete


def test_over_http_tiles_results_and_pictures_name_it(service):
    body = {"grid": {"time": {"cells": 100}, "velocity": {"cells": 100}}, "iterations": 103}
    job = service.wait(service.submit(body)["id"])
    place = storage_at(service.store_of(job))
    content = place.read("solution/c/1/0", whole).content
    place.write("solution/c/1/0", content[:9] + bytes([content[9] ^ 1]) + content[10:])
    path = f"/v1/jobs/{job['id']}"
    for what in ("tiles/2", "picture.png"):
        problem = service.request("GET", f"{path}/{what}")
        assert problem.status_code == 503 and problem.json()["type"] == "/problems/store-failed", what
        assert f"{job['id']}.zarr is damaged: tile 1/0 of solution" in problem.json()["detail"]
    with pytest.raises(DamagedChunk, match=f"{job['id']}/result.zarr is damaged: tile 1/0 of solution"):
        rattle.open(f"{service.url}{path}/result.zarr").solution.load()
