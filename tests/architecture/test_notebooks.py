"""Notebooks run as they stand, use the front door alone, and show what running them gives."""

import ast
import json
import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))
ALLOWED = {"os", "rattle", "numpy", "matplotlib"}
# nbclient tells the kernel what it has put into a bar's place, also after the bar has been taken away.
LATE = re.compile(r"^No such comm: \w+\n", re.MULTILINE)
WIDGET = "application/vnd.jupyter.widget-view+json"


def outputs_of(notebook):
    """What the cells print and list, and how many pictures each shows."""
    texts, pictures = [], []
    for cell in notebook.cells:
        # Progress bars are widgets, and leave nothing.
        shown = [each for each in cell.get("outputs", []) if WIDGET not in each.get("data", {})]
        listed = [
            each.get("data", {}).get("text/plain", "") for each in shown if "image/png" not in each.get("data", {})
        ]
        texts += ["".join(each.get("text", "") for each in shown), *listed]
        pictures.append(sum("image/png" in each.get("data", {}) for each in shown))
    # Kernels for harmonics may be compiled here for the first time, which is announced.
    texts = [LATE.sub("", text) for text in texts if not text.startswith("compiling the kernels")]
    return [text for text in texts if text], pictures


NUMBER = re.compile(r"-?\d+\.\d+(?:e[-+]\d+)?")


def numbers_in(texts):
    """Numbers with a point, and the words between them. Tables are as wide as their numbers."""
    text = "\n".join(texts)
    return [float(number) for number in NUMBER.findall(text)], NUMBER.sub("#", text).split()


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_uses_the_front_door_alone_and_carries_its_outputs(path):
    notebook = nbformat.read(path, as_version=4)
    code = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "code")
    names = {
        (node.module if isinstance(node, ast.ImportFrom) else node.names[0].name).split(".")[0]
        for node in ast.walk(ast.parse(code))
        if isinstance(node, ast.Import | ast.ImportFrom)
    }
    assert names <= ALLOWED
    assert sum(outputs_of(notebook)[1]) >= 2 and "/home" not in json.dumps(notebook) + code


@pytest.mark.timeout(600)
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_shows_what_running_it_gives(path, service, monkeypatch, tmp_path):
    monkeypatch.setenv("RATTLE_URL", service.url)
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path))
    committed = nbformat.read(path, as_version=4)
    here = nbformat.read(path, as_version=4)
    NotebookClient(here, timeout=300, resources={"metadata": {"path": str(path.parent)}}).execute()
    (texts, pictures), (texts_then, pictures_then) = outputs_of(here), outputs_of(committed)
    (found, words), (then, words_then) = numbers_in(texts), numbers_in(texts_then)
    assert words == words_then and pictures == pictures_then
    # Orbits come from LAPACK, whose rounding differs from processor to processor; residuals are nothing else.
    assert found == pytest.approx(then, rel=1e-5, abs=1e-9)


# What is printed is sent on after 0.2 s. A bar that is redrawn without a pause meanwhile would catch it.
PRINTS = """
import time
from rich.console import Console
from rattle.progress import progress_line
print("before")
with progress_line(Console(stderr=True)) as line:
    begun = time.monotonic()
    while time.monotonic() - begun < 0.5:
        line.stage = ""
        line.show("mapping", (1, 2))
"""


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_what_a_cell_prints_before_a_bar_stays():
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(PRINTS)])
    NotebookClient(notebook, timeout=60).execute()
    (cell,) = notebook.cells
    assert [each.text for each in cell.outputs if each.get("name") == "stdout"] == ["before\n"]
