"""What kill tests share: requests that take some seconds, and their results undisturbed."""

import json
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.faults.farm import ENVIRONMENT, starts
from tests.running_service import running_service
from tests.store_content import content
from worker.cluster.connection import local_cluster
from worker.cluster.driver import Driver
from worker.jobs.basin_job import basin_job
from worker.results.summary import summarise
from worker.run import run_job

BASIN = {"grid": {"time": {"cells": 300}, "velocity": {"cells": 300}}, "iterations": 15013}
SWEEP = {
    "grid": {"time": {"cells": 160}, "velocity": {"cells": 160}}, "iterations": 4999,
    "vary": [{"parameter": "damping", "values": [0.58, 0.6, 0.7]}],
}  # fmt: skip
_SAMPLER = """
import contextlib, glob, json, select, socket, sys, time

def computed():
    total = 0
    for path in glob.glob(f"/proc/{sys.argv[2]}/task/*/schedstat"):
        with contextlib.suppress(OSError):
            total += int(open(path).read().split()[0])
    return total / 1e9

waits, line = [], socket.create_connection(("127.0.0.1", int(sys.argv[1])), timeout=60)
print("ready", flush=True)
while not select.select([sys.stdin], [], [], 0.01)[0]:
    before, begun = computed(), time.perf_counter()
    line.sendall(b"GET /healthz HTTP/1.1\\r\\nhost: localhost\\r\\n\\r\\n")
    answer = b""
    while not answer.endswith(b"}"):
        answer += line.recv(65536)
    waited = time.perf_counter() - begun
    waits.append(1e3 * min(waited, computed() - before or waited))
print(json.dumps(waits))
"""


def pytest_collection_modifyitems(items):
    """Everything here kills something: `make test-faults` runs it."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.faults)
            item.add_marker(pytest.mark.timeout(300))


@dataclass
class Expected:
    """What a job's store holds when nothing was disturbed, and how many tiles there are."""

    content: dict
    tiles: int


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory):
    """By kind of request."""
    folder, found = tmp_path_factory.mktemp("undisturbed"), {}
    with local_cluster(workers=2) as client:
        for name, job in (("basin", basin_job(BASIN)), ("sweep", basin_job(SWEEP))):
            place = str(folder / f"{name}.zarr")
            run_job(job, place, Driver(client), report=lambda _: None, cancel=threading.Event())
            found[name] = Expected(content(place), summarise(place).tiles)
    return found


@pytest.fixture
def starts_file(tmp_path):
    """Where workers write down what they start."""
    return tmp_path / "starts.log"


@pytest.fixture
def a_service(tmp_path, starts_file):
    """Start a service whose workers write down what they start, in this test's folder."""

    def start(data=tmp_path, **environment):
        return running_service(data, **(ENVIRONMENT | {"RATTLE_STARTS": starts_file} | environment))

    return start


@pytest.fixture
def right(undisturbed, starts_file):
    """Check an ended job: right to the byte, no file too many, no tile started too often for what was disturbed."""

    def check(store, kind, disturbed):
        expected = undisturbed[kind]
        assert content(store) == expected.content
        started = starts(starts_file)
        assert len(started) == expected.tiles
        assert sum(started.values()) - expected.tiles <= 2 * disturbed, (started, disturbed)

    return check


@pytest.fixture
def health(request):
    """Waits for `/healthz` in milliseconds, sampled in another process until they are asked for.

    A wait counts as far as the service's process computed meanwhile: on a busy machine it gets no processor for longer.
    """

    def sample(service):
        port = service.url.rpartition(":")[2]
        process = subprocess.Popen(
            [sys.executable, "-c", _SAMPLER, port, str(service.process.pid)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        request.addfinalizer(process.kill)
        assert process.stdout.readline() == "ready\n"
        return lambda: json.loads(process.communicate("\n", timeout=60)[0])

    return sample
