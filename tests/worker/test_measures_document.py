"""The numbers that docs/measures.md prints are those that its own code finds."""

import re
import threading
from pathlib import Path

import numpy as np

from rattle_kernels import CellGrid
from worker.basin_job import BasinJob
from worker.pipeline import run_basin

DOCUMENT = (Path(__file__).parents[2] / "docs" / "measures.md").read_text()


def block(language):
    (found,) = re.findall(rf"```{language}\n(.*?)```", DOCUMENT, re.DOTALL)
    return found


def words_and_numbers(text):
    number = r"-?\d+\.\d+"
    return re.split(number, text), np.array(re.findall(number, text), np.float64)


def test_the_measures_of_the_papers_panel_are_as_printed(client, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    job = BasinJob(grid=CellGrid(time_cells=300, velocity_cells=300))
    run_basin(job, str(tmp_path / "basin.zarr"), client, report=lambda _: None, cancel=threading.Event())
    exec(compile(block("python"), "docs/measures.md", "exec"), {})
    words, numbers = words_and_numbers(capsys.readouterr().out)
    printed_words, printed = words_and_numbers(block("text"))
    assert words == printed_words
    # A cell on a boundary may go the other way on another processor.
    np.testing.assert_allclose(numbers, printed, rtol=5e-3, atol=5e-3)
