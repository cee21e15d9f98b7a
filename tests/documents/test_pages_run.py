"""Every block of the pages runs as printed: in an empty folder, with the wheel alone, beside `rattle serve`."""

import json
import os
import re
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path

import pytest
import yaml

from tests.documents.blocks import PAGES, ROOT, RUN, blocks_of
from tests.documents.run_page import HEAD
from tests.running_service import RunningService

ADDRESS = "http://127.0.0.1:8000"
WITH_BLOCKS = [page for page in PAGES if any(block.language in RUN and not block.exempt for block in blocks_of(page))]


def without_paths_to_the_sources(**more):
    """Variables of a reader who has installed the wheel."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "RATTLE", "VIRTUAL"))}
    return kept | more


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """Programs of an environment that has the wheel; what the wheel depends on is that of these tests."""
    folder = tmp_path_factory.mktemp("environment")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "--directory", folder]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "venv"], check=True)
    (packages,) = (folder / "venv" / "lib").glob("python*/site-packages")
    (packages / "beside.pth").write_text(sysconfig.get_path("purelib") + "\n")
    (wheel,) = folder.glob("*.whl")
    bin_folder = folder / "venv" / "bin"
    pip = [sys.executable, "-m", "pip", "--python", bin_folder / "python", "install", "--quiet", "--no-deps"]
    subprocess.run(
        [*pip, "--no-index", "--ignore-installed", wheel], env=without_paths_to_the_sources(), check=True, timeout=300
    )
    return bin_folder


@pytest.fixture
def reader(programs, tmp_path):
    """An empty folder, and the variables of who works there. Compiled kernels are shared with other tests."""
    there = tmp_path / "folder"
    there.mkdir()
    path = f"{programs}{os.pathsep}{os.environ['PATH']}"
    variables = without_paths_to_the_sources(PATH=path, RATTLE_CACHE=str(tmp_path / "kept"), MPLBACKEND="agg")
    return there, variables


@pytest.fixture
def serve(programs, reader, tmp_path):
    """Start `rattle serve` at the address that the pages print."""
    started = []

    def start():
        folder, variables = reader
        command = [programs / "rattle", "serve", "--data", tmp_path / "data"]
        with (tmp_path / "serve.log").open("wb") as log:
            process = subprocess.Popen(command, cwd=folder, env=variables, stdout=log, stderr=log)
        started.append(process)
        RunningService(ADDRESS, tmp_path, process, "").wait_until_ready()

    yield start
    for process in started:
        process.terminate()
        process.wait(60)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("page", WITH_BLOCKS, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_blocks_of_a_page_run_in_order(page, programs, reader, serve):
    folder, variables = reader
    blocks = [block for block in blocks_of(page) if block.language in RUN and not block.exempt]
    if any(ADDRESS in block.text or "rattle jobs" in block.text for block in blocks):
        serve()
    described = json.dumps([block._asdict() for block in blocks])
    command = [programs / "python", "-P", Path(__file__).parent / "run_page.py"]
    done = subprocess.run(command, input=described, cwd=folder, env=variables, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count(HEAD) == len(blocks)


@pytest.mark.slow
def test_what_runs_is_the_wheel(programs, reader):
    folder, variables = reader
    code = "import rattle, rattle_kernels, service, worker; print(*(m.__file__ for m in (rattle, service, worker)))"
    told = subprocess.run([programs / "python", "-c", code], cwd=folder, env=variables, capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    assert all(place.startswith(str(programs.parent)) for place in told.stdout.split())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_blocks_that_are_not_run_say_so(page):
    """Those of other languages are read at least: a block without a language could be anything."""
    for block in blocks_of(page):
        if block.language == "yaml":
            yaml.safe_load(block.text)
        elif block.language == "json":
            json.loads(block.text)
        elif block.language == "toml":
            tomllib.loads(block.text)
        else:
            assert block.exempt or block.language in (*RUN, "text"), f"{block.file}:{block.line}"
            assert not (block.exempt and re.fullmatch("text|yaml|json|toml", block.language)), (
                f"{block.file}:{block.line}"
            )
