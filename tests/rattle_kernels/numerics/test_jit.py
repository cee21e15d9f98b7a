"""How kernels are compiled: whatever calls a function first, and again after every change of the sources."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

import rattle_kernels
from rattle_kernels.numerics.jit import always_inlined, inlined, inlined_as_written
from tests.processors import ROOT

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


@pytest.mark.parametrize(
    "changed", [pytest.param("warm_up.py", marks=pytest.mark.slow), "model/flight.py", "lanes/run.py"]
)
def test_any_changed_source_has_another_folder(package, changed):
    before = _cache_folder(package)
    with (package / changed).open("a") as source:
        source.write("# changed\n")
    assert _cache_folder(package) != before


def test_a_moved_source_has_another_folder(package):
    before = _cache_folder(package)
    (package / "model" / "outcome.py").rename(package / "lanes" / "outcome.py")
    assert _cache_folder(package) != before


_PRINT_FOLDERS = """
import runpy, sys
jit = runpy.run_path(sys.argv[1])
for folder in sys.argv[2:]:
    jit["key_by"](folder)
print(*(jit["cache_folder"](f"{folder}/own.py") for folder in (*sys.argv[2:], "/elsewhere")), jit["cache_folder"]())
"""


def _folders_of_all(package, *beside):
    """Cache folders of packages beside, of a test that uses them, and of the package itself."""
    command = [sys.executable, "-c", _PRINT_FOLDERS, str(package / "numerics" / "jit.py"), *map(str, beside)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()


def test_kernels_of_a_package_beside_have_a_folder_of_their_own(package, tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    for folder in (one, other):
        folder.mkdir()
        (folder / "own.py").write_text(f"# {folder.name}\n")
    before = _folders_of_all(package, one, other)
    assert len(set(before)) == 4
    (one / "own.py").write_text("# changed\n")
    changed = _folders_of_all(package, one, other)
    assert [was == now for was, now in zip(before, changed, strict=True)] == [False, True, False, True]
    with (package / "model" / "flight.py").open("a") as source:
        source.write("# changed\n")
    assert not set(changed) & set(_folders_of_all(package, one, other))


def test_bounds_checks_have_another_folder(package):
    unchecked = _cache_folder(package, NUMBA_BOUNDSCHECK="0")
    assert _cache_folder(package, NUMBA_BOUNDSCHECK="1") != unchecked


def _piece(x):
    return x * x + 1.5


def _machine_independent_code(compiled):
    (code,) = compiled.inspect_llvm().values()
    return code


@numba.njit(fastmath={"contract", "arcp"})
def _of_fast_mathematics(call, x):
    return call(x)


def test_a_piece_does_not_take_over_how_its_first_caller_is_inlined():
    """Its code would depend on what is compiled first, and so would last digits."""
    piece = inlined(_piece)
    loop = always_inlined(lambda x: piece(x))
    assert loop(2.0) == 5.5
    assert "alwaysinline" in _machine_independent_code(loop)
    assert "alwaysinline" not in _machine_independent_code(piece)


def test_a_piece_as_written_does_not_take_over_the_mathematics_of_its_first_caller():
    plain, as_written = numba.njit(_piece), inlined_as_written(_piece)
    assert _of_fast_mathematics(plain, 2.0) == _of_fast_mathematics(as_written, 2.0) == 5.5
    assert "fmul contract" in _machine_independent_code(plain).replace("arcp ", "")  # shows that the other could
    assert "contract" not in _machine_independent_code(as_written)


_NEWTON = """
import re, sys
from rattle_kernels import Oscillator, tangent_growth
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.domain import check_domain
from rattle_kernels.orbits.periodic_orbit import newton_rounds
oscillator = check_domain(Oscillator())
if "tables" in sys.argv:
    lane_tables(oscillator)
if "lanes" in sys.argv:
    tangent_growth(oscillator, [0.3], [2.0], 100)
if "newton" in sys.argv:
    newton_rounds(oscillator, 0.25, 4.0, 1, 5.0, 1)
    (code,) = newton_rounds.inspect_asm().values()
    instructions = "\\n".join(re.findall(r"^\\t[^.].*", code, re.MULTILINE))
    print(re.sub(r"B\\d+v\\d+", "", instructions))  # names without the numbers of functions in the process
"""


def _compile(folder, *kernels):
    """Compile kernels in a process of its own, one after another, or load those that are in the folder."""
    command = [sys.executable, "-c", _NEWTON, *kernels]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder)}
    return subprocess.run(command, env=environment, cwd=ROOT, check=True, capture_output=True, text=True).stdout


@pytest.mark.slow
def test_a_kernel_has_the_same_machine_code_whatever_was_compiled_before_it(tmp_path):
    """Pieces of the tables' kernels are compiled for the lanes where the former have been loaded."""
    _compile(tmp_path / "after", "tables")
    after = _compile(tmp_path / "after", "tables", "lanes", "newton")
    assert len(after.splitlines()) > 1000
    assert after == _compile(tmp_path / "alone", "newton")


def test_arguments_are_put_into_the_form_of_kernels_by_the_call_alone():
    # A second time fails where there are more than two harmonics, for which kernels are compiled in slow tests alone.
    of_the_call = {"model/oscillator.py", "numerics/jit.py"}
    package = Path(rattle_kernels.__file__).parent
    asking = {str(path.relative_to(package)) for path in package.rglob("*.py") if ".in_kernels" in path.read_text()}
    assert asking <= of_the_call
