"""An export is an RO-Crate 1.1 by the rules of its specification, and the same store gives the same bytes."""

import json
import pathlib
import re
import zipfile

import pandas as pd
import pytest

import rattle
from rattle_chart.job import ChartJob
from rattle_machine.job import ReportJob
from tests.analysis_requests import CHART, REPORT
from worker.errors import InvalidJob, JobCancelled, StoreConflict
from worker.kinds import KINDS

RUNS = {
    "basin": lambda **here: rattle.basin(cells=20, **here),
    "sweep": lambda **here: rattle.sweep(damping=[0.6, 0.7], cells=16, **here),
    "bifurcation": lambda **here: rattle.bifurcation(damping=(0.5, 0.6, 5), seeds=[(0.7641, 4.0002)], **here),
    "orbits": lambda **here: rattle.orbits(damping=0.6, longest=1, cells=8, **here),
    "manifold": lambda **here: rattle.manifolds(damping=0.6, saddles=[(0.6017, 3.7699)], arclength=2, **here),
    "grazing_curve": lambda **here: rattle.grazing_curve(damping=0.6, order=1, **here),
    "chart": lambda **here: rattle.compute(ChartJob(**CHART), **here),
    "report": lambda **here: rattle.compute(ReportJob(**REPORT), **here),
}
assert RUNS.keys() == KINDS.keys()


FAST = {"basin"}


@pytest.fixture(
    scope="module", params=[name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in RUNS]
)
def exported(request, tmp_path_factory):
    """A store, and its crate."""
    folder = tmp_path_factory.mktemp("exported")
    RUNS[request.param](store=folder / "store", progress=False)
    rattle.export(folder / "store", folder / "crate.zip", creator="A. Author", license="CC-BY-4.0")
    return folder / "store", folder / "crate.zip"


def entities(archive):
    document = json.loads(archive.read("ro-crate-metadata.json"))
    assert document["@context"] == "https://w3id.org/ro/crate/1.1/context"
    by_id = {entity["@id"]: entity for entity in document["@graph"]}
    assert len(by_id) == len(document["@graph"]) and all("@type" in entity for entity in by_id.values())
    return by_id


def references(value):
    """Every ``@id`` that an entity refers to."""
    if isinstance(value, dict):
        if value.keys() == {"@id"}:
            yield value["@id"]
        for each in value.values():
            yield from references(each)
    if isinstance(value, list):
        for each in value:
            yield from references(each)


def test_the_crate_follows_its_specification(exported):
    with zipfile.ZipFile(exported[1]) as archive:
        by_id, names = entities(archive), set(archive.namelist())
        sizes = {info.filename: info.file_size for info in archive.infolist()}
    descriptor, root = by_id["ro-crate-metadata.json"], by_id["./"]
    assert descriptor["@type"] == "CreativeWork" and descriptor["about"] == {"@id": "./"}
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert root["@type"] == "Dataset" and root["name"] and root["description"]
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT[\d:.]+\+00:00", root["datePublished"])
    assert root["license"] == {"@id": "https://spdx.org/licenses/CC-BY-4.0"}
    parts = {part["@id"] for part in root["hasPart"]}
    assert parts == names - {"ro-crate-metadata.json"} == {
        path for path, entity in by_id.items() if entity["@type"] == "File"
    }  # fmt: skip
    assert all(by_id[path]["contentSize"] == str(sizes[path]) and by_id[path]["encodingFormat"] for path in parts)
    assert set(references(list(by_id.values()))) - {"https://w3id.org/ro/crate/1.1"} <= by_id.keys()


def test_it_holds_request_versions_tables_and_pictures(exported):
    store, crate = exported
    with rattle.open(store) as dataset, zipfile.ZipFile(crate) as archive:
        request = json.loads(archive.read("request.json"))
        assert request == json.loads(dataset.attrs["request"])
        versions = json.loads(archive.read("versions.json"))
        assert versions["versions"]["gear-rattle"] == rattle.__version__ and "git_revision" in versions
        tables = [name for name in archive.namelist() if name.startswith("tables/")]
        assert tables and all(len(pd.read_csv(archive.open(name))) for name in tables)
        assert archive.read("pictures/picture.png").startswith(b"\x89PNG")
        assert b"<svg" in archive.read("pictures/picture.svg")
        assert entities(archive)["#creator"]["name"] == "A. Author"
        assert ("pictures/shares.png" in archive.namelist()) == ("vary" in request and "kind" not in request)


def test_the_same_store_gives_the_same_bytes(exported, tmp_path):
    store, crate = exported
    rattle.export(store, tmp_path / "again.zip", creator="A. Author", license="CC-BY-4.0")
    assert (tmp_path / "again.zip").read_bytes() == crate.read_bytes()


def test_nobody_is_named_unless_asked(exported, tmp_path):
    rattle.export(exported[0], tmp_path / "crate.zip")
    with zipfile.ZipFile(tmp_path / "crate.zip") as archive:
        by_id = entities(archive)
    assert "#creator" not in by_id and "author" not in by_id["./"]
    assert by_id["./"]["license"] == {"@id": "https://spdx.org/licenses/CC0-1.0"}


@pytest.mark.proof
def test_it_holds_the_certificate_of_a_proof(tmp_path):
    rattle.basin(damping=1.5, cells=20, prove=True, levels=0, store=tmp_path / "proven", progress=False)
    rattle.export(tmp_path / "proven", tmp_path / "crate.zip")
    with rattle.open(tmp_path / "proven") as dataset, zipfile.ZipFile(tmp_path / "crate.zip") as archive:
        assert json.loads(archive.read("certificate.json")) == dataset.rattle.certificate
        assert entities(archive)["certificate.json"]["encodingFormat"] == "application/json"


def test_a_file_that_was_there_is_replaced_as_a_whole_or_not_at_all(exported, tmp_path, monkeypatch):
    target = tmp_path / "crate.zip"
    target.write_text("older")

    def fails(path, content):
        with path.open("wb") as file:
            file.write(content[:10])
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as full:
        full.setattr(pathlib.Path, "write_bytes", fails)
        with pytest.raises(OSError, match="No space"):
            rattle.export(exported[0], target)
    assert target.read_text() == "older" and list(tmp_path.iterdir()) == [target]
    rattle.export(exported[0], target)
    assert zipfile.is_zipfile(target) and list(tmp_path.iterdir()) == [target]


def test_what_cannot_be_exported_is_told(tmp_path):
    with pytest.raises(StoreConflict, match="nothing there"):
        rattle.export(tmp_path / "nowhere", tmp_path / "crate.zip")
    with pytest.raises(InvalidJob, match=r"ends in \.zip"):
        rattle.export(tmp_path, tmp_path / "crate.tar")
    with pytest.raises(InvalidJob, match="no SPDX name"):
        rattle.export(tmp_path, tmp_path / "crate.zip", license="do what you want")
    with pytest.raises(InvalidJob, match="rattle fetch"):
        rattle.export("http://127.0.0.1:9/v1/jobs/a/result.zarr", tmp_path / "crate.zip")


def test_an_unfinished_result_is_not_exported(tmp_path):
    def stop(progress):
        raise JobCancelled("enough")

    with pytest.raises(JobCancelled):
        rattle.basin(cells=20, store=tmp_path / "begun", progress=stop)
    with pytest.raises(InvalidJob, match="not finished"):
        rattle.export(tmp_path / "begun", tmp_path / "crate.zip")
