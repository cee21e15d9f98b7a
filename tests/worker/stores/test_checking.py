"""A check names what is damaged in a store, and what is computed anew is the same to the byte."""

import hashlib
import json
import shutil

import pytest
from hypothesis import HealthCheck, given, settings, strategies

import rattle
from rattle_kernels import CellGrid
from tests.object_store import BUCKET
from tests.store_content import content
from tests.worker.storage.test_flipped_bits import flip
from worker.errors import JobCancelled, StoreConflict, StoreFailed
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter
from worker.kinds import KINDS
from worker.storage.location import storage_at
from worker.storage.protocol import whole
from worker.stores.basin_store import BasinStore

GRID = CellGrid(time_cells=100, velocity_cells=100)
SMALL = CellGrid(time_cells=24, velocity_cells=24)
JOBS = {
    "basin": BasinJob(grid=GRID, iterations=101),
    "sweep": SweepJob(grid=SMALL, iterations=101, vary=(SweptParameter("damping", (0.7, 0.65, 0.6)),)),
    "sample": BasinJob(grid=SMALL, iterations=101, sample=Sample(points=512)),
    "proven": BasinJob(grid=SMALL, iterations=101, prove={"levels": 0}),
    "grazing": KINDS["grazing_curve"].job_class(order=1),
}


class _Finished:
    """Folder of finished stores, each computed when it is first asked for."""

    def __init__(self, folder):
        self._folder = folder

    def __truediv__(self, name):
        if not (self._folder / name).exists():
            rattle.compute(JOBS[name], store=self._folder / name, progress=False, workers=2)
        return self._folder / name


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    return _Finished(tmp_path_factory.mktemp("finished"))


PROVEN = pytest.param("proven", marks=pytest.mark.proof)


@pytest.fixture(params=[PROVEN if name == "proven" else name for name in JOBS])
def store(request, finished, tmp_path):
    """A copy of a store, and the store."""
    return shutil.copytree(finished / request.param, tmp_path / "store"), finished / request.param


def chunks(store):
    return sorted(path for path in store.rglob("*") if path.is_file() and path.name != "zarr.json")


def mended(store, whole, damage):
    """Check a damaged store; it becomes the whole one again."""
    damage()
    dry = rattle.check(store, dry_run=True)
    found = rattle.check(store, workers=2)
    assert found.damages == dry.damages != () and found.mended and not dry.mended
    assert content(store) == content(whole)
    assert rattle.open(store).drop_attrs(deep=False).identical(rattle.open(whole).drop_attrs(deep=False))
    assert rattle.check(store).damages == () and rattle.open(store).rattle.complete
    return {str(each.path) for each in found.damages}


def test_a_whole_store_has_no_damage_and_is_not_touched(store):
    copy, whole = store
    before = {path: path.stat().st_mtime_ns for path in copy.rglob("*")}
    found = rattle.check(copy)
    assert found.damages == () and found.mended and found.complete
    assert found.files == sum(path.is_file() for path in copy.rglob("*")) > 5
    assert before == {path: path.stat().st_mtime_ns for path in copy.rglob("*")}


def test_all_damages_at_once_are_mended(store):
    copy, whole = store
    named = mended(copy, whole, lambda: [flip(path) for path in chunks(copy)])
    assert named == {path.relative_to(whole).as_posix() for path in chunks(whole)}


def _one_of_each_array(store):
    return {path.relative_to(store).parts[:2]: path for path in chunks(store)}.values()


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("how", ["flipped", "removed"])
def test_any_one_damage_is_mended(store, how):
    copy, whole = store
    for path in _one_of_each_array(copy):
        name = path.relative_to(copy).as_posix()
        assert name in mended(copy, whole, lambda path=path: flip(path) if how == "flipped" else path.unlink())


@pytest.mark.parametrize(
    "array",
    ["solution", "share", *(pytest.param(name, marks=pytest.mark.slow) for name in ("landing_time", "attractor_time"))],
)
def test_one_damage_of_a_sweep_is_mended(finished, tmp_path, array):
    copy = shutil.copytree(finished / "sweep", tmp_path / "store")
    path = sorted((copy / array / "c").rglob("*"))[-1]
    assert mended(copy, finished / "sweep", lambda: flip(path)) == {path.relative_to(copy).as_posix()}


def test_only_what_is_damaged_is_computed_anew(finished, tmp_path):
    copy = shutil.copytree(finished / "basin", tmp_path / "store")
    flip(copy / "image_cell" / "c" / "0" / "1")
    seen = []
    rattle.check(copy, workers=1, computing=seen.append)
    assert (seen[0].tiles_done, seen[0].tiles_total) == (3, 4) and content(copy) == content(finished / "basin")


def test_missing_chunks_and_metadata_are_told_and_mended(finished, tmp_path):
    copy = shutil.copytree(finished / "basin", tmp_path / "store")

    def damage():
        (copy / "solution" / "c" / "1" / "0").unlink()
        (copy / "period" / "zarr.json").write_text("{")
        (copy / "assembly" / "words" / "zarr.json").unlink()

    assert mended(copy, finished / "basin", damage) == {
        "solution/c/1/0", "period/zarr.json", "assembly/words/zarr.json"
    }  # fmt: skip


def _replaced_in_copy(store, array, old, new):
    """Change what the root says once more of an array."""
    file = store / "zarr.json"
    document = json.loads(file.read_text())
    nodes = document["consolidated_metadata"]["metadata"]
    nodes[array] = json.loads(json.dumps(nodes[array]).replace(old, new, 1))
    file.write_text(json.dumps(document))


@pytest.mark.parametrize(
    "array, old, new, wrong",
    [
        ("solution", "100", "500", "zarr.json"),
        ("landing_time", "float64", "gloat64", "zarr.json"),  # such a root cannot be opened
        ("assembly", "group", "grouq", "zarr.json"),
    ],
)
def test_right_metadata_are_not_replaced_by_a_damaged_copy_of_the_root(finished, tmp_path, array, old, new, wrong):
    copy = shutil.copytree(finished / "basin", tmp_path / "store")
    named = mended(copy, finished / "basin", lambda: _replaced_in_copy(copy, array, old, new))
    assert named == {wrong}
    whole = {path.relative_to(copy): path.read_bytes() for path in copy.rglob("*/zarr.json")}
    assert all((finished / "basin" / path).read_bytes() == content for path, content in whole.items())


@pytest.mark.parametrize("old, new", [("100", "500"), ("int16", "knt16")])
def test_damaged_metadata_are_replaced_by_those_of_the_root(finished, tmp_path, old, new):
    copy, own = shutil.copytree(finished / "basin", tmp_path / "store"), "solution/zarr.json"

    def damage():
        (copy / own).write_text((copy / own).read_text().replace(old, new, 1))

    assert mended(copy, finished / "basin", damage) == {own}
    assert json.loads((copy / own).read_text()) == json.loads((finished / "basin" / own).read_text())


def test_files_that_are_none_of_the_store_are_left_alone(finished, tmp_path):
    copy = shutil.copytree(finished / "basin", tmp_path / "store")
    strays = [copy / "notes.txt", copy / "solution" / "c" / "0" / "9", copy / "solution" / "c" / "1" / "1.bak"]
    for stray in strays:
        stray.write_text("mine")
    found = rattle.check(copy)
    assert found.damages == () and found.mended and all(stray.read_text() == "mine" for stray in strays)


def test_a_store_whose_root_cannot_be_read_is_no_place_for_another(finished, tmp_path):
    copy = shutil.copytree(finished / "basin", tmp_path / "store")
    (copy / "zarr.json").write_text((copy / "zarr.json").read_text()[:500])
    before = content(copy)
    for call in (rattle.open, rattle.check, lambda place: rattle.compute(JOBS["basin"], store=place, progress=False)):
        with pytest.raises(StoreFailed, match="store is damaged: the metadata zarr.json cannot be read"):
            call(copy)
    assert content(copy) == before


def test_an_interrupted_mending_goes_on(finished, tmp_path):
    copy = shutil.copytree(finished / "basin", tmp_path / "store")
    flip(copy / "image_cell" / "c" / "0" / "1")

    def stop(progress):
        raise JobCancelled("enough")

    with pytest.raises(JobCancelled):
        rattle.check(copy, computing=stop)
    assert not BasinStore(str(copy)).complete
    rattle.compute(JOBS["basin"], store=copy, progress=False)
    assert content(copy) == content(finished / "basin")


def test_an_unfinished_store_loses_what_is_damaged_and_is_not_finished(finished, tmp_path):
    def stop(progress):
        if progress.tiles_done == 2:
            raise JobCancelled("enough")

    with pytest.raises(JobCancelled):
        rattle.compute(JOBS["basin"], store=tmp_path / "begun", progress=stop, workers=1)
    claimed = sorted((tmp_path / "begun" / "image_cell" / "c").rglob("?/?"))
    flip(claimed[-1])
    found = rattle.check(tmp_path / "begun")
    assert not found.complete and found.mended and [each.array for each in found.damages] == ["image_cell"]
    assert rattle.check(tmp_path / "begun").damages == () and not BasinStore(str(tmp_path / "begun")).complete
    rattle.compute(JOBS["basin"], store=tmp_path / "begun", progress=False)
    assert content(tmp_path / "begun") == content(finished / "basin")


@pytest.mark.slow
def test_a_store_in_s3_is_checked_and_mended(object_store, finished):
    location = f"s3://{BUCKET}/worker/checked.zarr"
    rattle.compute(JOBS["sweep"], store=location, progress=False)
    assert rattle.check(location).damages == ()
    place = storage_at(location)
    content_of_chunk = place.read("solution/c/1/0/0", whole).content
    place.write("solution/c/1/0/0", content_of_chunk[:9] + bytes([content_of_chunk[9] ^ 1]) + content_of_chunk[10:])
    place.discard(["group/c/2/0/0", "period/zarr.json"])
    found = rattle.check(location)
    assert {each.path for each in found.damages} == {"solution/c/1/0/0", "group/c/2/0/0", "period/zarr.json"}
    assert rattle.check(location).damages == ()
    whole_files = content(finished / "sweep")
    assert {path: hashlib.sha256(place.read(path, whole).content).hexdigest() for path in whole_files} == whole_files


def test_a_damaged_part_of_an_unfinished_analysis_is_computed_again(finished, tmp_path):
    parts = []

    def stop(progress):
        parts.extend(sorted((tmp_path / "begun" / "parts").glob("*/*/c/0")))
        if parts:
            raise JobCancelled("enough")

    with pytest.raises(JobCancelled):
        rattle.compute(JOBS["grazing"], store=tmp_path / "begun", progress=stop, workers=1)
    assert rattle.check(tmp_path / "begun").damages == ()
    flip(parts[0])
    found = rattle.check(tmp_path / "begun")
    assert not found.complete and [tmp_path / "begun" / each.path for each in found.damages] == parts[:1]
    assert rattle.check(tmp_path / "begun").damages == ()
    rattle.compute(JOBS["grazing"], store=tmp_path / "begun", progress=False)
    assert content(tmp_path / "begun") == content(finished / "grazing")


def test_a_lost_request_cannot_be_mended(finished, tmp_path):
    copy = shutil.copytree(finished / "basin", tmp_path / "store")
    root = json.loads((copy / "zarr.json").read_text())
    root["attributes"]["request"] = root["attributes"]["request"].replace("101", "103")
    (copy / "zarr.json").write_text(json.dumps(root))
    with pytest.raises(StoreConflict, match="has lost its request"):
        rattle.check(copy)
    with pytest.raises(StoreConflict, match="nothing there"):
        rattle.check(tmp_path / "nowhere")


@pytest.mark.parametrize(
    "name",
    ["basin", "grazing", *(pytest.param(name, marks=pytest.mark.slow) for name in ("sweep", "sample", "proven"))],
)
def test_metadata_of_every_array_are_written_anew(finished, tmp_path, name):
    """Each is lost in turn; nothing is computed anew."""
    copy = shutil.copytree(finished / name, tmp_path / "store")
    for path in sorted(copy.rglob("*/zarr.json")):
        own = path.relative_to(copy).as_posix()
        path.write_text("x")
        assert [each.path for each in rattle.check(copy, dry_run=True).damages] == [own]
        path.write_bytes((finished / name / own).read_bytes())
    for path in sorted(copy.rglob("*/zarr.json")):
        path.write_text("x")
    assert rattle.check(copy).mended and rattle.check(copy).damages == ()
    for path in sorted(copy.rglob("*/zarr.json")):
        assert json.loads(path.read_text()) == json.loads((finished / name / path.relative_to(copy)).read_text())
    assert content(copy) == content(finished / name)


@pytest.mark.parametrize("root", [b"[]", b"", b"null", b"{}", b"\xff", b'{"attributes": [], "node_type": "group"}'])
def test_a_root_that_says_nothing_is_named_with_what_to_do(finished, tmp_path, root):
    copy = shutil.copytree(finished / "basin", tmp_path / "store")
    (copy / "zarr.json").write_bytes(root)
    with pytest.raises(StoreFailed, match="zarr.json cannot be read; .* put back a copy of that file, or compute it"):
        rattle.check(copy)


def _attributes_end(root):
    """Where the attributes of a root end: what follows stands in the arrays as well."""
    return root.index(b'"zarr_format"')


@pytest.mark.parametrize("name", ["basin", "grazing", pytest.param("proven", marks=pytest.mark.slow)])
@settings(max_examples=12, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=strategies.data())
def test_any_flipped_bit_of_a_root_is_mended_or_named(finished, tmp_path_factory, name, data):
    """What follows the attributes stands in the arrays' own metadata as well, so it is always mended."""
    copy = shutil.copytree(finished / name, tmp_path_factory.mktemp("flipped") / "store")
    root = bytearray((copy / "zarr.json").read_bytes())
    place = data.draw(strategies.integers(0, len(root) - 1))
    root[place] ^= 1 << data.draw(strategies.integers(0, 7))
    (copy / "zarr.json").write_bytes(root)
    whole_root = (finished / name / "zarr.json").read_bytes()
    try:
        found = rattle.check(copy)
    except (StoreFailed, StoreConflict) as error:
        assert "compute it anew" in str(error) and place < _attributes_end(whole_root)
        return
    assert found.mended and rattle.check(copy).damages == () and content(copy) == content(finished / name)
    if place >= _attributes_end(whole_root):
        mended_root, whole_root = json.loads((copy / "zarr.json").read_text()), json.loads(whole_root)
        assert mended_root["consolidated_metadata"] == whole_root["consolidated_metadata"]


@pytest.mark.parametrize("array, other", [("velocity/c/0", "solution/c/0/0"), ("solution/c/0/0", "landing_time/c/0/0")])
def test_a_chunk_of_another_array_is_mended(finished, tmp_path, array, other):
    """Its checksum is right, and its length is not."""
    copy = shutil.copytree(finished / "basin", tmp_path / "store")
    assert array in mended(copy, finished / "basin", lambda: shutil.copy(copy / other, copy / array))


def test_a_root_and_chunks_that_are_lost_at_once_are_mended(finished, tmp_path):
    copy = shutil.copytree(finished / "basin", tmp_path / "store")
    text = (copy / "zarr.json").read_text()
    (copy / "zarr.json").write_text(text.replace('"default"', '"defaulu"'))
    (copy / "solution" / "c" / "1" / "0").unlink()
    flip(copy / "image_cell" / "c" / "0" / "1")
    dry = rattle.check(copy, dry_run=True)
    assert {each.path for each in dry.damages} == {"zarr.json", "image_cell/c/0/1"} and not dry.mended
    assert rattle.check(copy).mended and rattle.check(copy).damages == ()
    assert content(copy) == content(finished / "basin")
