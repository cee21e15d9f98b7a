"""SIGKILL of the service: at random moments, and between the steps of a job's life."""

import random
import time

import pytest

from tests.faults.conftest import BASIN, SWEEP
from tests.faults.farm import begun, store_of
from tests.running_service import RunningService
from tests.waiting import wait_until

# Tiles in flight, and those whose receipts came after the ledger was last written.
_LOST_AT_ONCE = 8


def kill_alone(service):
    """Kill the process that answers; the one that runs jobs notices, and gives them back."""
    service.process.kill()
    service.process.wait(10)


def test_a_service_killed_at_random_moments_loses_nothing(a_service, right):
    chance, kills, job = random.Random(4), 4, None
    for kill in (RunningService.kill, kill_alone) * (kills // 2):
        with a_service() as service:
            job = service.submit(BASIN)
            service.wait(job["id"], lambda job: job["state"] != "queued")
            time.sleep(chance.uniform(0.1, 2.0))
            kill(service)
    with a_service() as service:
        assert service.submit(BASIN)["id"] == job["id"]
        assert service.wait(job["id"])["state"] == "succeeded"
        right(store_of(service, job), "basin", _LOST_AT_ONCE * kills)


def test_a_killed_runner_is_started_again_while_the_service_answers(a_service, right):
    kills = 2
    with a_service() as service:
        job = service.submit(BASIN)
        for _ in range(kills):
            begun(service, job)
            runner = service.runner()
            runner.kill()
            wait_until("/readyz answers 503", lambda: service.request("GET", "/readyz").status_code == 503)
            assert service.request("GET", f"/v1/jobs/{job['id']}").json()["state"] == "running"
            wait_until("/readyz answers 200", lambda: service.request("GET", "/readyz").status_code == 200)
            assert service.runner().pid != runner.pid
        assert service.wait(job["id"])["state"] == "succeeded"
        right(store_of(service, job), "basin", _LOST_AT_ONCE * kills)


def progressed(**reached):
    """Whether a job's progress has come so far."""

    def check(job):
        progress = job["progress"] or {}
        return job["state"] == "succeeded" or all(
            progress.get(name, 0) >= least if name != "stage" else progress.get(name) == least
            for name, least in reached.items()
        )

    return check


STEPS = {
    "basin": [
        lambda job: True,
        lambda job: job["state"] != "queued",
        progressed(tiles_done=1),
        progressed(stage="assembling"),
        progressed(stage="labelling"),
        progressed(stage="labelling", tiles_done=20),
    ],
    "sweep": [progressed(basins_done=1), progressed(basins_done=2)],
}


@pytest.mark.parametrize(("kind", "request_"), [("basin", BASIN), ("sweep", SWEEP)], ids=["basin", "sweep"])
def test_a_service_killed_at_the_steps_of_a_jobs_life_loses_nothing(a_service, right, kind, request_):
    for reached in STEPS[kind]:
        with a_service() as service:
            job = service.submit(request_)
            service.wait(job["id"], reached)
            service.kill()
    with a_service() as service:
        assert service.wait(service.submit(request_)["id"])["state"] == "succeeded"
        right(store_of(service, job), kind, _LOST_AT_ONCE * len(STEPS[kind]))
