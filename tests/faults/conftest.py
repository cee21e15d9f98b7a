"""What kill tests share: requests that take some seconds, and their results undisturbed."""

import threading
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.faults.farm import ENVIRONMENT, starts
from tests.running_service import running_service
from tests.store_content import content
from worker.basins.pipeline import run_basin
from worker.cluster.connection import local_cluster
from worker.cluster.driver import Driver
from worker.jobs.basin_job import basin_job
from worker.stores.summary import summarise

BASIN = {"grid": {"time": {"cells": 300}, "velocity": {"cells": 300}}, "iterations": 15013}
SWEEP = {
    "grid": {"time": {"cells": 160}, "velocity": {"cells": 160}}, "iterations": 4999,
    "vary": [{"parameter": "damping", "values": [0.58, 0.6, 0.7]}],
}  # fmt: skip


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
            run_basin(job, place, Driver(client), report=lambda _: None, cancel=threading.Event())
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
