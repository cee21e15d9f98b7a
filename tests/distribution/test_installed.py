"""Wheel and sdist in empty environments of the oldest and the newest Python here: they compute, draw and serve."""

import contextlib
import os
import re
import subprocess
import time
from pathlib import Path
from typing import NamedTuple

import httpx2 as httpx
import pytest

from tests.distribution.conftest import ROOT
from tests.ports import free_port

pytestmark = [pytest.mark.distribution, pytest.mark.timeout(1500)]


def pythons():
    """The oldest and the newest Python that this machine has."""
    listed = subprocess.run([ROOT / ".ci" / "pythons"], check=True, capture_output=True, text=True).stdout
    found = [line.split() for line in listed.splitlines() if len(line.split()) == 2]
    return dict([found[0], found[-1]])


class Environment(NamedTuple):
    """An environment that has the locked packages and the wheel, and a folder outside the source tree."""

    programs: Path
    folder: Path

    def run(self, program, *arguments):
        """What a program prints."""
        command = [self.programs / program, *map(str, arguments)]
        done = subprocess.run(command, cwd=self.folder, env=self.variables, capture_output=True, text=True, timeout=900)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    @property
    def variables(self):
        """Without what would lead Python back to the source tree."""
        return {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "RATTLE"))}

    def pip(self, *arguments):
        """Install packages."""
        self.run("python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *arguments)


@pytest.fixture(scope="module", params=pythons().items(), ids=lambda item: item[0])
def environment(request, distribution, tmp_path_factory):
    folder = tmp_path_factory.mktemp("installed")
    subprocess.run([request.param[1], "-m", "venv", folder / "venv"], check=True)
    made = Environment(folder / "venv" / "bin", folder)
    made.pip("--require-hashes", "--only-binary=:all:", "-r", ROOT / "requirements" / "image.txt")
    made.pip("--no-deps", "--no-index", distribution.wheel)
    return made


@contextlib.contextmanager
def serving(environment):
    """Address of ``rattle serve``."""
    port = free_port()
    command = [environment.programs / "rattle", "serve", "--port", str(port), "--data", environment.folder / "data"]
    process = subprocess.Popen(command, cwd=environment.folder, env=environment.variables)
    try:
        yield f"http://127.0.0.1:{port}"
    finally:
        process.terminate()
        process.wait(60)


def answer(url):
    """Answer of a service that may still be starting."""
    patience = time.monotonic() + 90.0
    while True:
        with contextlib.suppress(httpx.TransportError):
            return httpx.get(url, timeout=30.0)
        assert time.monotonic() < patience, "the service does not answer"
        time.sleep(0.2)


def test_what_it_depends_on_is_there(environment):
    environment.run("python", "-m", "pip", "check")


def test_it_is_imported_from_where_it_is_installed(environment):
    told = environment.run("python", "-c", "import rattle, service; print(rattle.__version__, service.__file__)")
    version, place = told.split()
    assert version in environment.run("rattle", "--version") and place.startswith(str(environment.folder))


def test_the_help_lists_commands(environment):
    assert {"basin", "serve", "paper"} <= set(re.findall(r"[\w-]+", environment.run("rattle", "--help")))


def test_it_computes_and_draws_a_basin(environment):
    told = environment.run("rattle", "basin", "--cells", 24, 24, "--out", "basin.zarr")
    assert "P(1,1,0)" in told
    environment.run("rattle", "plot", "basin.zarr", "--out", "basin.png")
    assert (environment.folder / "basin.png").read_bytes().startswith(b"\x89PNG")


def test_it_serves_with_its_page_its_scripts_and_its_database(environment):
    with serving(environment) as url:
        assert answer(url + "/healthz").status_code == 200
        page = answer(url + "/")
        scripts = re.findall(r'(?:src|href)="(explorer/[^"]+)"', page.text)
        assert page.status_code == 200 and scripts
        assert {answer(f"{url}/{script}").status_code for script in scripts} == {200}
        assert answer(url + "/docs").status_code == 200
        assert answer(url + "/v1/jobs").json()["jobs"] == []


def test_the_sdist_installs_as_well(environment, distribution):
    environment.pip("--no-deps", "--no-index", "--no-build-isolation", "--force-reinstall", distribution.sdist)
    assert "Usage" in environment.run("rattle", "basin", "--help")
