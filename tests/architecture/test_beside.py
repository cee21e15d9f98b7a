"""What stands beside the core is not named there, and the core works without it."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import rattle
from tests.store_content import content

ROOT = Path(__file__).parents[2]
CORE = ("rattle_kernels", "worker", "service", "rattle")
NAMED = re.compile(r"proof|(un)?\bprov(e|en|es|ing)\b|rattle_(chart|paper|machine|notebook)", re.IGNORECASE)
EXCEPT = {
    "rattle/verbs.py": "the arguments of `rattle.basin` are written out, for editors and type checkers",
    "rattle/results/accessor.py": "`proven_quiet` is of the paper: a speed, known for every basin",
}
# Hides what is installed beside, as if it were not there.
ALONE = """
import importlib.metadata as metadata, sys
installed = metadata.entry_points
def others(**wanted):
    found = installed(**wanted)
    ours = wanted.get("group", "").startswith("rattle.")
    beside = ("rattle_chart", "rattle_machine", "rattle_notebook", "rattle_p")
    return [each for each in found if not each.value.startswith(beside)] if ours else found
metadata.entry_points = others
sys.modules["rattle_proof"] = sys.modules["rattle_paper"] = sys.modules["rattle_machine"] = None
sys.modules["rattle_notebook"] = sys.modules["rattle_chart"] = None
"""


def files():
    names = subprocess.run(["git", "ls-files", *CORE], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    texts = (name for name in names.split() if name.endswith((".py", ".js", ".ts", ".html", ".css", ".json")))
    return [name for name in texts if not name.startswith(tuple(EXCEPT))]


def test_no_file_of_the_core_names_what_stands_beside():
    assert {name.split("/")[0] for name in files()} == set(CORE)
    assert [name for name in files() if NAMED.search((ROOT / name).read_text())] == []


def alone(code, folder):
    """What a program prints that has the core alone."""
    environment = os.environ | {"PYTHONPATH": str(ROOT), "RATTLE_CACHE": str(folder / "cache")}
    done = subprocess.run(
        [sys.executable, "-c", ALONE + code], cwd=folder, env=environment, capture_output=True, text=True, timeout=400
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def proven(tmp_path_factory):
    """A store with a proof, computed where there is all."""
    path = tmp_path_factory.mktemp("proven") / "basin.zarr"
    rattle.basin(damping=1.5, cells=8, prove=True, levels=0, store=path, progress=False)
    return path


@pytest.mark.timeout(400)  # the first proof compiles its kernels
@pytest.mark.proof
def test_a_store_with_more_is_read_drawn_and_checked_as_a_plain_one(proven, tmp_path):
    code = f"""
import rattle
from worker.results.summary import summarise
basin = rattle.open({str(proven)!r})
basin.rattle.plot()
assert basin.rattle.complete and basin.rattle.job.request() == basin.rattle.request and "prove" in basin.rattle.request
assert "share_proven" not in basin and not hasattr(basin.rattle, "certificate")
assert "share_proven" not in summarise({str(proven)!r}).model_dump()["solutions"][0]
print(rattle.check({str(proven)!r}, dry_run=True).damages)
"""
    assert alone(code, tmp_path).strip() == "()"


def test_what_is_not_there_is_refused_in_words(tmp_path):
    code = """
import rattle
from typer.testing import CliRunner
from rattle.cli import app
for ask in (lambda: rattle.basin(cells=8, prove=True), lambda: rattle.BasinJob(prove=True)):
    try:
        ask()
    except ValueError as error:
        print(error)
assert not hasattr(rattle, "verify") and not hasattr(rattle, "pulses") and not hasattr(rattle, "explore")
assert "tolerance" not in CliRunner().invoke(app, ["basin", "--help"]).output
assert CliRunner().invoke(app, ["verify"]).exit_code == 2
print(rattle.basin(cells=8, progress=False).rattle.complete)
"""
    refused = "prove: Extra inputs are not permitted"
    assert alone(code, tmp_path).splitlines() == [refused, refused, "True"]


@pytest.mark.proof
def test_a_store_that_has_more_is_neither_computed_nor_mended_without_it(proven, tmp_path):
    damaged = tmp_path / "damaged.zarr"
    shutil.copytree(proven, damaged)
    (damaged / "solution" / "c" / "0" / "0").unlink()
    before = content(damaged)
    code = """
import rattle
job = rattle.open("damaged.zarr").rattle.job
for ask in (lambda: rattle.compute(job, store="new.zarr", progress=False), lambda: rattle.check("damaged.zarr")):
    try:
        ask()
    except rattle.StoreConflict as error:
        print(error)
"""
    told = alone(code, tmp_path).splitlines()
    assert told == [
        f"{name} has prove as well: install the package that adds it" for name in ("new.zarr", "damaged.zarr")
    ]
    assert content(damaged) == before and not (tmp_path / "new.zarr").exists()
