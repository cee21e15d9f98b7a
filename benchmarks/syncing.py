"""What it costs that a power cut takes nothing: ``python -m benchmarks.syncing [SECONDS [ROUNDS]]``.

Panels of 1000 x 1000 cells, k = 1499, are computed by two threads, in turns with syncing and without. Two ratios within
each panel say what syncing costs, so that what else the machine does counts little: the part of the threads' time in
which they do not compute, and the processor time that the panel takes for each second of computing. With SECONDS every
sync takes so much longer, as on a slower disk.
"""

import os
import shutil
import statistics
import sys
import tempfile
import time
from unittest import mock

from rattle.local import run_here
from worker.cluster import calls
from worker.jobs.basin_job import BasinJob

WORKERS = 2
RECEIPTS, FSYNC = calls.Receipts, os.fsync


def panel(place, sync):
    """Compute a panel. Return the part of the threads' time in which they do not compute, and syncs."""
    computing, syncs = [], []

    def receipts(values, seconds):
        computing.append(seconds)
        return RECEIPTS(values, seconds)

    def counted(opened):
        sync(opened)
        syncs.append(opened)

    with mock.patch.object(calls, "Receipts", receipts), mock.patch.object(os, "fsync", counted):
        begin = time.perf_counter()
        run_here(BasinJob(), place, lambda progress: None, workers=WORKERS)
        wall = time.perf_counter() - begin
    shutil.rmtree(place)
    return 1.0 - sum(computing) / WORKERS / wall, wall, len(syncs)


def main(slower, rounds):
    """Print what both kinds of panels take."""

    def slow(opened):
        FSYNC(opened)
        time.sleep(slower)

    kinds = {"with syncing": slow, "without": lambda opened: None}
    found = {kind: [] for kind in kinds}
    with tempfile.TemporaryDirectory() as place:
        for _ in range(rounds):
            for kind, sync in kinds.items():
                found[kind].append(panel(f"{place}/panel.zarr", sync))
    for kind, panels in found.items():
        idle, wall, syncs = (statistics.median(values) for values in zip(*panels, strict=True))
        print(f"{kind}: {100 * idle:.2f} % of the threads' time not computing, {wall:.2f} s, {syncs:.0f} syncs")


if __name__ == "__main__":
    main(float((sys.argv[1:] or ["0"])[0]), int((sys.argv[2:] or ["5"])[0]))
