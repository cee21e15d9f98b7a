"""The folder of compiled kernels: another one for every change of the sources or of what compiles them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import rattle_kernels

_PRINT_FOLDER = "import runpy, sys; print(runpy.run_path(sys.argv[1])['cache_folder']())"


@pytest.fixture
def package(tmp_path):
    return Path(shutil.copytree(Path(rattle_kernels.__file__).parent, tmp_path / "rattle_kernels"))


def _cache_folder(package: Path, **environment: str) -> str:
    command = [sys.executable, "-c", _PRINT_FOLDER, str(package / "numerics" / "jit.py")]
    ran = subprocess.run(command, env=os.environ | environment, check=True, capture_output=True, text=True)
    return ran.stdout.strip()


def test_sources_that_do_not_change_keep_their_folder(package):
    assert _cache_folder(package) == _cache_folder(package)


@pytest.mark.parametrize("changed", ["warm_up.py", "model/flight.py", "lanes/run.py"])
def test_any_changed_source_has_another_folder(package, changed):
    before = _cache_folder(package)
    with (package / changed).open("a") as source:
        source.write("# changed\n")
    assert _cache_folder(package) != before


def test_a_moved_source_has_another_folder(package):
    before = _cache_folder(package)
    (package / "model" / "outcome.py").rename(package / "lanes" / "outcome.py")
    assert _cache_folder(package) != before


def test_bounds_checks_have_another_folder(package):
    unchecked = _cache_folder(package, NUMBA_BOUNDSCHECK="0")
    assert _cache_folder(package, NUMBA_BOUNDSCHECK="1") != unchecked
