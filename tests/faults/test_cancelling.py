"""Cancelling stops the computing, not only the waiting."""

import time

import psutil
import pytest

from tests.faults.farm import local_workers, wait_for

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
        workers = [psutil.Process(pid) for pid in wait_for(lambda: local_workers(service), 10)]
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
        job = service.wait(job["id"], seconds=1.0)
        assert job["state"] == "cancelled"
        assert not service.request("GET", job["links"]["result"]).json()["complete"]


def test_workers_yield_to_the_service(a_service):
    with a_service() as service:
        own = psutil.Process(service.process.pid).nice()
        workers = wait_for(lambda: local_workers(service), 10)
        assert all(psutil.Process(pid).nice() >= min(19, own + 10) for pid in workers)
