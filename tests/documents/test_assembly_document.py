"""What docs/guide/transmission-error.md prints is what its code gives, and what the committed numbers say."""

import json
import re

import nbformat
import pytest

from rattle_paper.figures import assembly
from tests.printed import DOCUMENTS, demand_as_printed

DOCUMENT = (DOCUMENTS / "guide" / "transmission-error.md").read_text()
NUMBERS = json.loads((DOCUMENTS / "figures" / "assembly.json").read_text())
NOTEBOOKS = DOCUMENTS.parent / "notebooks"


def test_the_code_gives_what_is_printed(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    demand_as_printed("guide/transmission-error.md", capsys, rtol=1e-11)


def test_shares_are_as_printed():
    quiet = dict(zip(NUMBERS["phases"], NUMBERS["quiet"], strict=True))
    printed = re.findall(r"^\| ([\d.]+) \| (0\.\d{3}) \|$", DOCUMENT, re.MULTILINE)
    assert len(printed) == 6
    for phase, share in printed:
        assert share == f"{quiet[float(phase)]:.3f}"
    assert f"| the first gear alone | {NUMBERS['one_gear']['quiet']:.3f} |" in DOCUMENT
    assert max(NUMBERS["quiet_error"]) < 0.0085


def test_the_basins_shown_are_those_of_most_and_of_least_quiet_and_agree_with_the_sample():
    quiet = dict(zip(NUMBERS["phases"], NUMBERS["quiet"], strict=True))
    assert min(quiet, key=quiet.get) == assembly._WORST and max(quiet, key=quiet.get) == assembly._BEST
    for name, phase in (("worst", assembly._WORST), ("best", assembly._BEST)):
        panel = NUMBERS["panels"][name]
        (share,) = [each["share"] for each in panel["solutions"] if each["name"] == "permanent contact"]
        assert panel["assembly"] == phase and share == pytest.approx(quiet[phase], abs=3 * 0.008)
    # The phase is one of a circle.
    assert quiet[0.0] == quiet[1.0]


def test_what_the_notebook_finds_is_what_the_page_says():
    notebook = nbformat.read(NOTEBOOKS / "assembly.ipynb", as_version=4)
    text = "".join(output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", []))
    measured, best = (re.search(rf"{name}: tooth (\d+), quiet (0\.\d+)", text) for name in ("as measured", "best"))
    assert (measured[1], best[1]) == ("0", "17") and "Seventeen teeth further" in DOCUMENT
    for found in (measured, best):
        assert f"{100 * float(found[2]):.0f} %" in DOCUMENT
