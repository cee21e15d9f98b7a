"""The numbers that docs/guide/measures.md prints are those that its own code finds."""

import threading

from rattle_kernels import CellGrid
from tests.printed import demand_as_printed
from worker.basins.pipeline import run_basin
from worker.cluster.driver import Driver
from worker.jobs.basin_job import BasinJob


def test_the_measures_of_the_papers_panel_are_as_printed(client, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    job = BasinJob(grid=CellGrid(time_cells=300, velocity_cells=300))
    run_basin(job, str(tmp_path / "basin.zarr"), Driver(client), report=lambda _: None, cancel=threading.Event())
    # A cell on a boundary may go the other way on another processor.
    demand_as_printed("guide/measures.md", capsys, rtol=5e-3, atol=5e-3)
