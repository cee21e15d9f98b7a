"""After the warm-ups nothing that the service does has to compile; what they compile they report."""

import importlib
import json
import os
import pkgutil
import shutil
import subprocess
import sys

import pytest
from numba.core.dispatcher import Dispatcher

import rattle_kernels
from rattle_kernels import warm_up, warm_up_analyses
from rattle_kernels.numerics.jit import cache_folder
from rattle_kernels.warm_up import FROM_PYTHON_ALONE, OF_ANALYSES

REPORTED = "import json; from rattle_kernels import warm_up; seen = []; warm_up(lambda *each: seen.append(each)); "
REPORTED += "print(json.dumps(seen))"
COMPILED = """
from numba.core.event import install_recorder
from rattle_kernels import warm_up

with install_recorder("numba:compile") as compiled:
    warm_up()
for _, each in compiled.buffer:
    print(each.data["dispatcher"].py_func.__qualname__)
"""
UNUSUAL = """
from rattle_kernels import CellGrid, Oscillator, basin, warm_up
from rattle_kernels.numerics.jit import KERNELS

warm_up()
known = {each: len(each.signatures) for each in KERNELS}
for eccentricity, rows, columns in ((0.056, 20, 20), (0.1, 1, 1), (0.1, 1, 20), (0.1, 20, 1)):
    basin(Oscillator(0.6, eccentricity), CellGrid(time_cells=columns, velocity_cells=rows))
for each, signatures in known.items():
    if len(each.signatures) > signatures:
        print(each.py_func.__qualname__)
"""


def kernels():
    """Entry points that are cached on disk, by module and name."""
    found = {}
    for each in pkgutil.walk_packages(rattle_kernels.__path__, "rattle_kernels."):
        module = importlib.import_module(each.name)
        for name, function in vars(module).items():
            if (
                isinstance(function, Dispatcher)
                and function.__module__ == module.__name__
                and function.stats.cache_path
            ):
                found[each.name.removeprefix("rattle_kernels."), name] = function
    return found


@pytest.mark.timeout(600)  # kernels of analyses are compiled here if nothing else has needed them
def test_every_kernel_of_the_service_is_compiled_by_them():
    warm_up()
    warm_up_analyses()
    cold = {place for place, function in kernels().items() if not function.signatures}
    assert len(kernels()) > 35 and {module for module, _ in cold} <= FROM_PYTHON_ALONE, cold


def test_modules_of_kernels_that_are_left_out_are_there():
    modules = {module for module, _ in kernels()}
    assert modules > OF_ANALYSES | FROM_PYTHON_ALONE and not OF_ANALYSES & FROM_PYTHON_ALONE


def test_kernels_that_have_to_be_compiled_are_reported_and_no_others(tmp_path):
    warm_up()
    folder = tmp_path / "gear-rattle" / cache_folder().name
    shutil.copytree(cache_folder(), folder)

    def reported():
        """What the warm-up reports in a process of its own."""
        command = [sys.executable, "-c", REPORTED]
        told = subprocess.run(
            command, env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}, stdout=subprocess.PIPE, check=True
        )
        return json.loads(told.stdout)

    assert reported() == []
    lost = list(folder.rglob("cell_groups._peel-*.nbi"))
    assert lost
    for each in lost:
        each.unlink()
    (before, needed), after = reported()
    assert 0 < before < needed and after == [needed, needed]


def test_a_process_that_finds_its_kernels_in_the_disk_cache_compiles_nothing():
    """No inlined function either: one that is called from Python is compiled anew in each process."""
    warm_up()
    assert subprocess.run([sys.executable, "-c", COMPILED], capture_output=True, text=True, check=True).stdout == ""


def test_basins_that_fall_quiet_or_have_few_cells_need_no_other_types():
    assert subprocess.run([sys.executable, "-c", UNUSUAL], capture_output=True, text=True, check=True).stdout == ""
