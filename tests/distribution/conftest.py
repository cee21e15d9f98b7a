"""The wheel and the sdist, of `make dist` (RATTLE_DIST) or built here."""

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]


class Distribution(NamedTuple):
    """Files of one version."""

    wheel: Path
    sdist: Path


def build(source, target):
    """Build both from a source tree, without a network: the build backend is in the lock."""
    command = [sys.executable, "-m", "hatchling", "build", "--directory", target]
    subprocess.run(command, cwd=source, check=True, capture_output=True, timeout=100)
    return found_in(target)


def found_in(folder):
    """The one wheel and the one sdist of a folder."""
    (wheel,), (sdist,) = Path(folder).glob("*.whl"), Path(folder).glob("*.tar.gz")
    return Distribution(wheel.resolve(), sdist.resolve())


@pytest.fixture(scope="session")
def distribution(tmp_path_factory):
    """Wheel and sdist of this source tree."""
    made = os.environ.get("RATTLE_DIST")
    return found_in(made) if made else build(ROOT, tmp_path_factory.mktemp("dist"))
