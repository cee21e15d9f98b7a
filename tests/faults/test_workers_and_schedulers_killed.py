"""SIGKILL at random moments, again and again, of workers, of all of them, and of the scheduler."""

import random
import time

import pytest

from tests.faults.conftest import BASIN
from tests.faults.farm import Farm, begun, has_mapped, kill, local_workers, store_of
from tests.waiting import wait_until


@pytest.mark.parametrize(("at_once", "seed"), [(1, 1), (2, 2)], ids=["a worker", "all workers"])
def test_killed_workers_cost_their_own_tiles_alone(a_service, right, at_once, seed):
    chance, killed = random.Random(seed), 0
    with a_service() as service:
        job = service.submit(BASIN)
        begun(service, job)
        for _ in range(5):
            time.sleep(chance.uniform(0.2, 1.5))
            victims = wait_until("workers are there", lambda: local_workers(service), service.why_not)
            killed += kill(chance.sample(victims, min(at_once, len(victims))))
        assert service.wait(job["id"])["state"] == "succeeded"
        # A worker that dies with a receipt that nobody has fetched yet takes two tiles with it.
        right(store_of(service, job), "basin", 2 * killed)


def test_a_killed_scheduler_is_waited_for_and_the_job_goes_on(a_service, right, tmp_path, starts_file):
    chance, kills = random.Random(3), 3
    with Farm(tmp_path, starts_file) as farm, a_service(RATTLE_SCHEDULER=farm.address) as service:
        job = service.submit(BASIN)
        for part in range(kills):
            # At some moment of the first quarter of the tiles, of the second, of the third.
            share = (part + chance.uniform(0.2, 0.8)) / (kills + 1)
            service.wait(job["id"], lambda job, share=share: has_mapped(job, share))
            farm.scheduler.kill()
            wait_until("/readyz answers 503", lambda: service.request("GET", "/readyz").status_code == 503)
            assert service.request("GET", f"/v1/jobs/{job['id']}").json()["state"] in ("queued", "running")
            wait_until("/readyz answers 200", lambda: service.request("GET", "/readyz").status_code == 200)
        assert service.wait(job["id"])["state"] == "succeeded"
        # In flight are two tiles a worker, and the ledger is written twice a second.
        right(store_of(service, job), "basin", 8 * kills)


def test_separate_workers_come_back_and_the_service_waits_for_them(a_service, right, tmp_path, starts_file):
    with Farm(tmp_path, starts_file) as farm, a_service(RATTLE_SCHEDULER=farm.address) as service:
        job = service.submit(BASIN)
        for _ in range(3):
            begun(service, job)
            time.sleep(0.5)
            for worker in farm.workers:
                worker.kill()
        assert service.wait(job["id"])["state"] == "succeeded"
        right(store_of(service, job), "basin", 2 * 3 * len(farm.workers))
