"""Notebooks run as they stand."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

pytestmark = pytest.mark.slow
NOTEBOOKS = Path(__file__).parents[2] / "notebooks"


@pytest.fixture
def basin(service):
    body = {"grid": {"time": {"cells": 100}, "velocity": {"cells": 100}}}
    return service.wait(service.submit(body)["id"])


def outputs_of(name):
    """What a notebook prints, and how many pictures it shows."""
    notebook = nbformat.read(NOTEBOOKS / name, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "commit notebooks without outputs"
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(NOTEBOOKS)}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    text = " ".join(output.get("text", "") for output in shown)
    return text, sum("image/png" in output.get("data", {}) for output in shown)


@pytest.mark.timeout(180)
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_the_first_basin_is_read_by_path_and_over_http(service, basin, monkeypatch, tmp_path):
    monkeypatch.setenv("RATTLE_BASIN", str(service.data / "results" / f"{basin['id']}.zarr"))
    monkeypatch.setenv("RATTLE_URL", service.url)
    text, pictures = outputs_of("first_basin.ipynb")
    assert "P(1,1,0)" in text and "identical" in text
    assert pictures >= 2


@pytest.fixture
def sweep(service):
    grid = {"time": {"cells": 40}, "velocity": {"cells": 40}}
    body = {"grid": grid, "vary": [{"parameter": "damping", "values": [0.575, 0.6, 0.7]}], "iterations": 499}
    return service.wait(service.request("POST", "/v1/sweeps", json=body).json()["id"])


@pytest.mark.timeout(180)
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_a_sweep_is_read_over_http(service, sweep, monkeypatch):
    monkeypatch.setenv("RATTLE_SWEEP", service.url + sweep["links"]["zarr"])
    text, pictures = outputs_of("sweep.ipynb")
    assert "death of 2: P(1,2,0)     between damping = 0.575 and 0.6" in text
    assert pictures >= 5


@pytest.mark.timeout(180)
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_a_sweep_is_computed_where_none_is_given(monkeypatch):
    monkeypatch.delenv("RATTLE_SWEEP", raising=False)
    text, pictures = outputs_of("sweep.ipynb")
    assert "P(1,2,0)" in text and "between damping = 0.675 and 0.7" in text
    assert pictures >= 5


@pytest.mark.timeout(180)
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_the_anatomy_of_a_basin_is_built_from_what_a_service_answers(service, monkeypatch):
    monkeypatch.setenv("RATTLE_URL", service.url)
    monkeypatch.setenv("RATTLE_CELLS", "50")
    monkeypatch.setenv("RATTLE_ARCLENGTH", "10")
    text, pictures = outputs_of("anatomy.ipynb")
    assert "saddle P(1,1,0) at t = 0.6017074510, v = 3.7699111843, multipliers" in text
    assert "saddle-node of P(1,2,0) at damping = 0.5997157626" in text
    assert "both manifolds" in text and pictures == 2


@pytest.mark.timeout(180)
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_the_machine_is_told_apart_into_quiet_and_rattle(monkeypatch):
    monkeypatch.delenv("RATTLE_MACHINE", raising=False)
    monkeypatch.setenv("RATTLE_CELLS", "40")
    monkeypatch.setenv("RATTLE_POINTS", "16")
    text, pictures = outputs_of("machine.ipynb")
    assert "P(1,2,0)" in text and "chaotic" not in text and "undecided" not in text
    assert "least disturbance: between" in text and pictures == 2
