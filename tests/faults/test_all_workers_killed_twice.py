"""SIGKILL of all workers, and of those that come in their place as soon as they start: the job goes on without delay.

A worker that is killed twice is away for long. Dask gives up one that it misses for 15 s, here for a second.
"""

import threading

import pytest

from tests.analysis_requests import ROUTES
from tests.faults.conftest import BASIN
from tests.faults.farm import kill, local_workers, store_of
from tests.store_content import content
from tests.waiting import wait_until
from worker.cluster.driver import Driver
from worker.cluster.threads import threads_here
from worker.kinds import KINDS
from worker.run import run_job

REQUESTS = {"basins": BASIN, **ROUTES, "grazing-curves": {"order": 4}}


def undisturbed(path, place):
    """What the store of a request holds when nothing is killed."""
    (kind,) = (kind for kind in KINDS.values() if kind.path == path)
    with threads_here(2) as threads:
        job = kind.job_class.from_request(REQUESTS[path])
        run_job(job, str(place), Driver(threads), report=lambda _: None, cancel=threading.Event())
    return content(place)


@pytest.mark.parametrize("path", REQUESTS)
def test_all_workers_killed_twice_in_a_row_are_replaced_and_the_job_ends(a_service, path, tmp_path):
    with a_service(DASK_DISTRIBUTED__DEPLOY__LOST_WORKER_TIMEOUT="1s") as service:
        job = service.submit(REQUESTS[path], path)
        service.wait(job["id"], lambda job: job["state"] == "running")
        first = local_workers(service)
        assert kill(first) == 2

        def in_their_place():
            others = set(local_workers(service)) - set(first)
            return others if len(others) == 2 else None

        assert kill(wait_until("workers are there in their place", in_their_place)) == 2
        assert service.wait(job["id"])["state"] == "succeeded"
    assert content(store_of(service, job)) == undisturbed(path, tmp_path / "undisturbed.zarr")
