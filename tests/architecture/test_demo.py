"""What a newcomer sees of ``make demo``: a little, and all that is needed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

ROOT = Path(__file__).parents[2]


def demo(tmp_path, request, **environment):
    """The demo's script with a request of its own, and no terminal."""
    (tmp_path / "request.json").write_text(json.dumps(request))
    arguments = ["--request", tmp_path / "request.json", "--out", tmp_path]
    return subprocess.run(
        [sys.executable, ROOT / "demo" / "run.py", *map(str, arguments)],
        env=os.environ | {"PYTHONPATH": str(ROOT)} | environment, capture_output=True, text=True, timeout=110,
    )  # fmt: skip


@pytest.mark.slow
def test_the_demo_says_what_it_does_what_it_has_found_and_what_to_try_next(tmp_path):
    grid = {"time": {"cells": 40}, "velocity": {"cells": 40}}
    done = demo(tmp_path, {"grid": grid, "iterations": 211})
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(done.stdout.splitlines()) <= 30 and done.stderr == ""
    for word in (
        "ready on http://127.0.0.1:",
        "mapping: ",
        "done: 1 of 1 tiles",
        "permanent contact",
        "P(1,1,0)",
        "xarray.open_zarr(",
    ):
        assert word in done.stdout, word
    for path in (tmp_path / "basin.png", tmp_path / "basin.zarr", tmp_path / "service.log"):
        assert str(path) in done.stdout and path.exists()
    assert "make serve" in done.stdout and "http://127.0.0.1:8000" in done.stdout
    assert "GET" not in done.stdout and not (tmp_path / "data").exists()
    with xr.open_zarr(tmp_path / "basin.zarr") as basin:
        assert basin.solution.shape == (40, 40)


@pytest.mark.slow
def test_a_service_of_the_demo_that_does_not_start_is_explained_by_its_log(tmp_path):
    refused = demo(tmp_path, {}, RATTLE_HOST="0.0.0.0")
    assert refused.returncode == 1 and "Traceback" not in refused.stderr
    assert "no loopback address" in refused.stderr and str(tmp_path / "service.log") in refused.stderr
