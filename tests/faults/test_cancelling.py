"""Cancelling stops the computing, not only the waiting."""

import time

import psutil
import pytest

from tests.faults.farm import local_workers
from tests.waiting import wait_until

MAPPING = {"grid": {"time": {"cells": 2000}, "velocity": {"cells": 2000}}, "iterations": 15013}
SAMPLE = {"sample": {"points": 50000}, "iterations": 200003}
LABELLING = {"grid": {"time": {"cells": 2000}, "velocity": {"cells": 2000}}, "iterations": 1}


def seconds_used(workers):
    return sum(sum(worker.cpu_times()[:2]) for worker in workers)


@pytest.mark.parametrize(
    ("request_", "stage"),
    [(MAPPING, "mapping"), (SAMPLE, "mapping"), (LABELLING, "assembling"), (LABELLING, "labelling")],
)
def test_workers_at_full_load_are_idle_two_seconds_after_a_cancellation(a_service, request_, stage):
    with a_service() as service:
        workers = [
            psutil.Process(pid)
            for pid in wait_until("workers are there", lambda: local_workers(service), service.why_not)
        ]
        job = service.submit(request_)
        service.wait(job["id"], lambda job: job["progress"] and job["progress"]["stage"] == stage)
        before = seconds_used(workers)
        time.sleep(1.0)
        assert stage == "assembling" or seconds_used(workers) - before > 0.1, "they were not at work"
        assert service.request("POST", job["links"]["cancel"]).status_code == 202
        time.sleep(2.0)
        before = seconds_used(workers)
        time.sleep(2.0)
        assert seconds_used(workers) - before < 0.25  # of 4: what heartbeats take
        job = service.wait(job["id"])
        assert job["state"] == "cancelled"
        assert not service.request("GET", job["links"]["result"]).json()["complete"]


def test_workers_yield_to_the_service(a_service):
    with a_service() as service:
        own = psutil.Process(service.process.pid).nice()
        workers = wait_until("workers are there", lambda: local_workers(service), service.why_not)
        assert all(psutil.Process(pid).nice() >= min(19, own + 10) for pid in workers)
