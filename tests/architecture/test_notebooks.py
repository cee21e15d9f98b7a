"""Notebooks run as they stand."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).parents[2] / "notebooks"


@pytest.fixture
def basin(service):
    body = {"grid": {"time": {"cells": 100}, "velocity": {"cells": 100}}}
    return service.wait(service.submit(body)["id"])


@pytest.mark.timeout(180)
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_the_first_basin_is_read_by_path_and_over_http(service, basin, monkeypatch, tmp_path):
    monkeypatch.setenv("RATTLE_BASIN", str(service.data / "results" / f"{basin['id']}.zarr"))
    monkeypatch.setenv("RATTLE_URL", service.url)
    notebook = nbformat.read(NOTEBOOKS / "first_basin.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "commit notebooks without outputs"
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(NOTEBOOKS)}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    text = " ".join(output.get("text", "") for output in shown)
    assert "P(1,1,0)" in text and "identical" in text
    assert sum("image/png" in output.get("data", {}) for output in shown) >= 2
