"""What a look at a store costs: ``python -m benchmarks.open_stores [BASINS [LOOKS]]``, on a quiet machine.

A service computes a sweep of 1,000 basins of a few cells each, and is then asked for tiles and outlines of it, in turns
with the status of the job, which opens no store. Ratios to that status count, so that what else the machine does counts
little. The first tile of a basin is measured from its submission on, with the kernels in memory.
"""

import itertools
import random
import statistics
import sys
import tempfile
import time

import httpx2 as httpx

from tests.running_service import running_service

BASINS, LOOKS = 1000, 300
CELLS = {"time": {"cells": 8}, "velocity": {"cells": 8}}
# Of the basins whose first tiles are waited for: each is another job. The first one warms up.
PRIMES = (101, 103, 107, 109, 113, 127, 131, 137, 139)


def seconds_of(client, path):
    """Time of one answer."""
    begin = time.perf_counter()
    answer = client.get(path)
    assert answer.status_code == 200, answer.text
    return time.perf_counter() - begin


def looks(client, job, basins, count):
    """Median time of each kind of look at a sweep, asked for by turns."""
    path = f"/v1/jobs/{job['id']}"
    numbers = random.Random(0)
    kinds = {
        "status": lambda: path,
        "tile": lambda: f"{path}/tiles/{numbers.randrange(basins)}",
        "outline": lambda: f"{path}/outline?panel={numbers.randrange(basins)}",
        "chunk": lambda: f"{path}/result.zarr/solution/c/{numbers.randrange(basins)}/0/0",
    }
    found = {kind: [] for kind in kinds}
    for _ in range(count):
        for kind, address in kinds.items():
            found[kind].append(seconds_of(client, address()))
    return {kind: statistics.median(times) for kind, times in found.items()}


def first_tile(client, iterations):
    """Seconds from the submission of a basin to its first tile."""
    begin = time.perf_counter()
    job = client.post("/v1/basins", json={"grid": CELLS, "iterations": iterations}).json()
    for pause in itertools.repeat(0.002):
        if client.get(f"/v1/jobs/{job['id']}/tiles/0").status_code == 200:
            return time.perf_counter() - begin
        time.sleep(pause)
    raise AssertionError


def main(basins=BASINS, count=LOOKS):
    """Print the time of each look, and its ratio to the status."""
    vary = [{"parameter": "damping", "start": 0.5, "stop": 0.7, "count": basins}]
    with tempfile.TemporaryDirectory() as folder, running_service(folder) as service:
        job = service.wait(service.submit({"grid": CELLS, "iterations": 101, "vary": vary})["id"])
        assert job["state"] == "succeeded", job
        with httpx.Client(base_url=service.url, timeout=30.0) as client:
            found = looks(client, job, basins, count)
            found["first tile"] = statistics.median([first_tile(client, iterations) for iterations in PRIMES][1:])
    for kind, median in found.items():
        print(f"{kind:10} {1000 * median:8.2f} ms, {median / found['status']:6.2f} times the status")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
