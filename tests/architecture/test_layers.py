"""Imports point one way, and the contracts notice when they do not."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("service", "worker", "rattle_kernels")


def lint_imports(folder):
    command = [str(Path(sys.executable).parent / "lint-imports"), "--no-cache"]
    environment = os.environ | {"PYTHONPATH": str(folder)}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=100)


def test_the_contracts_hold():
    answer = lint_imports(ROOT)
    assert answer.returncode == 0, answer.stdout


def test_a_planted_import_is_caught(tmp_path):
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    flight = tmp_path / "rattle_kernels" / "model" / "flight.py"
    flight.write_text(flight.read_text() + "\nimport worker.stores.tiles\n")
    answer = lint_imports(tmp_path)
    assert answer.returncode != 0 and "rattle_kernels.model.flight" in answer.stdout


def test_the_kernels_load_nothing_heavy():
    heavy = "('dask', 'zarr', 'fastapi', 'pydantic', 'matplotlib')"
    code = f"import sys, rattle_kernels; print([module for module in {heavy} if module in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert answer.stdout.strip() == "[]", answer.stderr
