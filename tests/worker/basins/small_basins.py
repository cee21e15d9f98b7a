"""Computes small basins in this process alone: ``python -m tests.worker.basins.small_basins FOLDER``."""

import sys
import threading
from pathlib import Path

from distributed import Client

from rattle_kernels import CellGrid, Oscillator
from worker.cluster.driver import Driver
from worker.jobs.basin_job import BasinJob
from worker.results.summary import summarise
from worker.run import run_job

_GRID = CellGrid(time_cells=32, velocity_cells=32)
# Little damped: trajectories are trapped, and traps are made with NumPy's linear algebra.
_WEAK = Oscillator(damping=0.05, eccentricity=0.008, half_backlash=0.05)
JOBS = {
    "impacting": BasinJob(grid=_GRID),
    "piecewise linear": BasinJob(oscillator=Oscillator(stiffness=1e4), grid=_GRID),
    "weakly damped": BasinJob(oscillator=_WEAK, grid=CellGrid(time_cells=32, velocity_stop=0.6, velocity_cells=32)),
}


def compute_all(folder):
    """Images, landing points, groups and solutions of each basin, in a store of its name."""
    with Client(processes=False, n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0") as client:
        for name, job in JOBS.items():
            store = str(folder / name)
            run_job(job, store, Driver(client), report=lambda _: None, cancel=threading.Event())
            print(name, *(solution.name for solution in summarise(store).solutions), sep=", ")


if __name__ == "__main__":
    compute_all(Path(sys.argv[1]))
