"""Stores as the installed Zarr writes them, in an archive named after it."""

import contextlib
import shutil
import tempfile
import threading
from importlib.metadata import version
from pathlib import Path

from rattle_kernels import CellGrid
from worker.cluster.connection import local_cluster
from worker.cluster.driver import Driver
from worker.errors import JobCancelled
from worker.jobs.basin_job import SweepJob
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.jobs.swept_parameter import SweptParameter
from worker.run import run_job

HERE = Path(__file__).parent
SWEEP = SweepJob(
    grid=CellGrid(time_cells=8, velocity_cells=6), iterations=7, vary=(SweptParameter("damping", (0.7, 0.8)),)
)
GRAZING = GrazingCurveJob(order=1)


def write_stores(folder, client):
    """A sweep, the same when it was cancelled at once, and an analysis."""
    cancel, driver = threading.Event(), Driver(client)
    run_job(SWEEP, str(folder / "sweep"), driver, report=lambda _: None, cancel=cancel)
    run_job(GRAZING, str(folder / "grazing"), driver, report=lambda _: None, cancel=cancel)
    cancel.set()
    with contextlib.suppress(JobCancelled):
        run_job(SWEEP, str(folder / "begun"), driver, report=lambda _: None, cancel=cancel)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder, local_cluster(workers=1) as client:
        write_stores(Path(folder), client)
        shutil.make_archive(str(HERE / f"zarr-{version('zarr')}"), "zip", folder)
