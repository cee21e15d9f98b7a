"""A service that has had a million small jobs answers as it did, and holds no more of them than it says."""

import random
import re

import psutil
import pytest

from tests.running_service import running_service
from tests.service.records.many_jobs import add_copies, id_of_copy

JOBS = 1_000_000
BASIN = {"grid": {"time": {"cells": 8}, "velocity": {"cells": 8}}, "iterations": 101}
pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]


def other(number):
    return BASIN | {"grid": {"time": {"cells": 8}, "velocity": {"cells": 8, "stop": 5.0 + number * 1e-3}}}


def mebibytes(service):
    """Of the process that answers, and of the one that runs jobs."""
    return [process.memory_info().rss / 2**20 for process in (psutil.Process(service.process.pid), service.runner())]


def test_a_million_small_jobs_take_a_bounded_part_of_memory(tmp_path):
    database = f"sqlite:///{tmp_path}/jobs.sqlite"
    with running_service(tmp_path, RATTLE_DATABASE_URL=database, RATTLE_MAX_QUEUED_EACH=20) as service:
        first = service.submit(BASIN)
        assert service.wait(first["id"])["state"] == "succeeded"
        add_copies(database, first["id"], JOBS)
        before = mebibytes(service)
        link, seen = "/v1/jobs?size=200", 0
        while link and seen < 10_000:
            page = service.request("GET", link).json()
            link, seen = page["next"], seen + len(page["jobs"])
        assert seen == 10_000
        chance = random.Random(6)
        for _ in range(500):
            job_id = id_of_copy(chance.randrange(JOBS))
            assert service.request("GET", f"/v1/jobs/{job_id}").json()["id"] == job_id
        told = re.search(r'rattle_jobs{state="succeeded"} (.+)', service.request("GET", "/metrics").text)
        assert float(told[1]) == JOBS + 1
        asked = [service.request("POST", "/v1/basins", json=other(number)) for number in range(60)]
        assert {answer.status_code for answer in asked} == {202, 429}
        last = [answer.json()["id"] for answer in asked if answer.status_code == 202][-1]
        assert service.wait(last)["state"] == "succeeded"
        assert service.request("DELETE", f"/v1/jobs/{id_of_copy(7)}").status_code == 204
        grown = [after - was for after, was in zip(mebibytes(service), before, strict=True)]
        assert max(grown) < 100.0, (before, grown)
