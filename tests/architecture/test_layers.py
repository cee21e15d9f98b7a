"""Imports point one way, and the contracts notice when they do not."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = (
    "rattle_chart",
    "rattle_machine",
    "rattle_notebook",
    "rattle_paper",
    "rattle_proof",
    "rattle",
    "service",
    "worker",
    "rattle_kernels",
)


def lint_imports(folder):
    command = [str(Path(sys.executable).parent / "lint-imports"), "--no-cache"]
    environment = os.environ | {"PYTHONPATH": str(folder)}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=100)


def test_the_contracts_hold():
    answer = lint_imports(ROOT)
    assert answer.returncode == 0, answer.stdout


def test_planted_imports_are_caught(tmp_path):
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    planted = {
        "rattle_kernels/model/flight.py": ["worker.stores.layout"],
        "rattle_paper/figures/fig5.py": ["rattle_kernels.lanes.run", "worker.jobs.basin_job", "rattle.local"],
    }
    for name, modules in planted.items():
        path = tmp_path / name
        path.write_text(path.read_text() + "".join(f"\nimport {module}\n" for module in modules))
    answer = lint_imports(tmp_path)
    assert answer.returncode != 0
    told = " ".join(answer.stdout.split())
    for name, modules in planted.items():
        importer = name.removesuffix(".py").replace("/", ".")
        assert all(f"{importer} -> {module}" in told for module in modules), answer.stdout


def test_the_kernels_load_nothing_heavy():
    heavy = "('dask', 'zarr', 'fastapi', 'pydantic', 'matplotlib')"
    code = f"import sys, rattle_kernels; print([module for module in {heavy} if module in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert answer.stdout.strip() == "[]", answer.stderr
