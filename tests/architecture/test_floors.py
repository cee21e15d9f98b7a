"""The first lines of a package say its floors as the contracts in pyproject.toml hold them."""

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
FLOORS = {
    container: contract["layers"]
    for contract in CONTRACTS
    if contract["type"] == "layers"
    for container in contract.get("containers", ())
}


@pytest.mark.parametrize("package", FLOORS)
def test_a_package_names_its_floors(package):
    text = (ROOT / package.replace(".", "/") / "__init__.py").read_text()
    said = ast.get_docstring(ast.parse(text)).partition(
        "Floors, the highest first; each imports from lower ones alone ::"
    )
    assert said[2].strip().splitlines()[: len(FLOORS[package])] == [
        f"    {floor}" if number else floor for number, floor in enumerate(FLOORS[package])
    ]


def test_large_packages_have_floors():
    assert {"rattle_kernels", "worker", "worker.basins", "worker.stores", "service", "rattle", "rattle_proof"} <= set(
        FLOORS
    )
