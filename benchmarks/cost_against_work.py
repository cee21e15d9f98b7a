"""Cost against work, as a picture: ``python -m benchmarks.cost_against_work``.

One basin or sweep after another is computed by two workers of an embedded cluster, from request to complete store. One
quantity grows at a time: cells, applications k, basins. Then workers: each of ever more threads sleeps for a minute, a
second a task, so that two cores stand for a large cluster. The seconds go to ``docs/cost-against-work.json``, the
picture to ``docs/pictures``.
"""

import json
import tempfile
import threading
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from benchmarks import processor
from benchmarks.waiting_workers import RUN_SECONDS, cluster_of, keep_busy
from rattle_kernels import CellGrid
from worker.cluster.connection import local_cluster
from worker.cluster.driver import Driver
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter
from worker.run import run_job

SIDES = (32, 100, 316, 1000)
ITERATIONS = (1, 11, 101, 1499)
BASINS = (2, 10, 100, 1000)
THREADS = (1, 10, 100, 1000)
WAITING = f"threads that sleep for {RUN_SECONDS:g} s"
ROUNDS = 2


def square(side, iterations=1499):
    """A basin of the paper's plane."""
    return BasinJob(grid=CellGrid(time_cells=side, velocity_cells=side), iterations=iterations)


def sampled(basins):
    """Basins of 1,000 points each, over the damping."""
    damping = SweptParameter("damping", tuple(np.linspace(0.5, 0.7, basins).tolist()))
    return SweepJob(vary=[damping], sample=Sample(1000), iterations=1499)


SERIES = {
    "cells, k = 1499": [(side * side, square(side)) for side in SIDES],
    "applications k, 562 x 562 cells": [(k, square(562, k)) for k in ITERATIONS],
    "basins of 1,000 points, k = 1499": [(basins, sampled(basins)) for basins in BASINS],
}


def seconds_of(job, client):
    """Seconds from job to complete store, the least of some rounds."""
    taken = []
    for _ in range(ROUNDS):
        with tempfile.TemporaryDirectory() as folder:
            begin = time.perf_counter()
            run_job(job, f"{folder}/store", Driver(client), report=lambda _: None, cancel=threading.Event())
            taken.append(time.perf_counter() - begin)
    return min(taken)


def seconds_of_waiting(threads):
    """Seconds until all threads have slept for their minute."""
    with cluster_of(threads) as client:
        return RUN_SECONDS / keep_busy(client, sum(client.nthreads().values()), 1.0)["busy"]


def draw(measured, path):
    """One panel for each quantity, both axes logarithmic; the line is cost in proportion, or no cost beside sleep."""
    _, panels = plt.subplots(1, len(measured), figsize=(4 * len(measured), 3.4), sharey=True, layout="constrained")
    for panel, (name, series) in zip(panels, measured.items(), strict=True):
        work, seconds = np.array(series).T
        panel.loglog(work, seconds, "o-", label="measured")
        ideal = np.full(work.size, RUN_SECONDS) if name == WAITING else seconds[-1] * work / work[-1]
        panel.loglog(work, ideal, "--", color="grey", label="in proportion")
        panel.set(xlabel=name, title="")
    panels[0].set_ylabel("seconds, two workers")
    panels[0].legend()
    plt.savefig(path, dpi=120)


def main():
    """Measure, write down, draw."""
    docs = Path(__file__).parents[1] / "docs"
    measured = {}
    with local_cluster(2) as client:
        seconds_of(square(60), client)
        for name, series in SERIES.items():
            measured[name] = [(work, seconds_of(job, client)) for work, job in series]
    measured[WAITING] = [(threads, seconds_of_waiting(threads)) for threads in THREADS]
    for name, series in measured.items():
        print(name, [f"{work:g}: {seconds:.3g} s" for work, seconds in series])
    told = {"processor": processor(), "seconds": measured}
    (docs / "cost-against-work.json").write_text(json.dumps(told, indent=1) + "\n")
    draw(measured, docs / "pictures" / "cost-against-work.png")


if __name__ == "__main__":
    main()
