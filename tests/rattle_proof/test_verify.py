"""`rattle verify` says what it cannot verify; what it finds is tested in tests/rattle_proof/verification."""

import pytest
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from rattle_proof import verifying


def verify(*arguments):
    return CliRunner().invoke(app, ["verify", *map(str, arguments)])


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    path = tmp_path_factory.mktemp("verify") / "plain.zarr"
    rattle.basin(cells=8, iterations=101, store=path, progress=False)
    return path


def test_a_store_without_a_proof_is_told_so(plain):
    answer = verify(plain)
    assert answer.exit_code == 1 and "proof" in answer.output and "Traceback" not in answer.output


def test_what_is_no_store_is_told_so(tmp_path):
    answer = verify(tmp_path)
    assert answer.exit_code == 1 and str(tmp_path) in " ".join(answer.output.split())


def test_a_number_of_boxes_that_is_none_is_told_so(plain):
    answer = verify(plain, "--boxes", "many")
    assert answer.exit_code == 2 and "a number or all, not many" in answer.output


def test_without_python_flint_the_extra_is_named(plain, monkeypatch):
    monkeypatch.setattr(verifying.importlib.util, "find_spec", lambda name: None)
    answer = verify(plain)
    assert answer.exit_code == 2 and "gear-rattle[proof]" in answer.output
