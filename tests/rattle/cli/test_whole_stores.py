"""The commands that check a store and write it down, as a user types them."""

import json
import zipfile

import pytest
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from tests.worker.storage.test_flipped_bits import flip


@pytest.fixture
def store(tmp_path):
    rattle.basin(cells=20, store=tmp_path / "basin.zarr", progress=False)
    return tmp_path / "basin.zarr"


def typed(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


def test_a_check_tells_what_is_damaged_and_mends_it(store):
    whole = typed("check", store)
    assert whole.exit_code == 0 and "none is damaged or missing" in whole.output
    flip(store / "solution" / "c" / "0" / "0")
    dry = typed("check", store, "--dry-run")
    assert dry.exit_code == 1 and "solution, tile 0/0: its checksum is wrong" in dry.output
    as_json = typed("check", store, "--dry-run", "--json")
    told = json.loads(as_json.output)
    assert as_json.exit_code == 1 and not told["mended"] and told["damages"][0]["array"] == "solution"
    mended = typed("check", store)
    assert mended.exit_code == 0 and "1 damaged or missing, computed anew" in mended.output
    assert typed("check", store, "--dry-run").exit_code == 0


def test_a_store_that_is_not_there_cannot_be_checked_or_exported(tmp_path):
    for command in (("check", tmp_path / "nowhere"), ("export", tmp_path / "nowhere", "--zip", tmp_path / "a.zip")):
        answer = typed(*command)
        assert answer.exit_code == 1 and "nothing there that Zarr can open" in answer.output + answer.stderr


def test_an_export_is_written_or_refused_by_its_name(store, tmp_path):
    answer = typed("export", store, "--zip", tmp_path / "a.zip", "--creator", "A. Author")
    assert answer.exit_code == 0 and "a.zip is written" in answer.output
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        assert "ro-crate-metadata.json" in archive.namelist()
    assert typed("export", store, "--zip", tmp_path / "a.tar").exit_code == 2
    assert typed("export", store, "--zip", tmp_path / "no" / "a.zip").exit_code == 1
