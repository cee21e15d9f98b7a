"""Where a result or the database was removed by somebody, answers say so, and the same request computes it again."""

import shutil
import time

import pytest

from service.records.job_record import JobState
from tests.service.idle_service import idle_service
from tests.service.routes.problems import assert_problem
from worker.jobs.basin_job import BasinJob
from worker.storage.location import remove_rootless, result_location
from worker.stores.new_store import create_store

BODY = {"grid": {"time": {"cells": 4}, "velocity": {"cells": 4}}, "iterations": 1}


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


def succeeded(service):
    """A job that has succeeded, and the location of its store."""
    job = service.request("POST", "/v1/basins", json=BODY).json()
    location = result_location(service.results, job["id"])
    create_store(location, BasinJob.from_request(BODY))
    claimed = service.jobs.claim("somebody/1")
    assert claimed.id == job["id"] and service.jobs.transition(job["id"], JobState.RUNNING, JobState.SUCCEEDED)
    return job, location


def test_a_result_that_is_gone_is_said_to_be_and_is_computed_anew(service):
    job, location = succeeded(service)
    assert service.request("POST", "/v1/basins", json=BODY).json()["id"] == job["id"]
    shutil.rmtree(location)
    for path in ("result", "picture.png", "result.json", "outline", "result.zarr/zarr.json", "certificate.json"):
        told = service.request("GET", f"/v1/jobs/{job['id']}/{path}")
        assert_problem(told, 404, "is gone: send its request again")
    anew = service.request("POST", "/v1/basins", json=BODY).json()
    assert anew["id"] != job["id"] and anew["state"] == "queued"
    assert service.request("POST", "/v1/basins", json=BODY).json()["id"] == anew["id"]
    assert service.request("GET", f"/v1/jobs/{job['id']}").json()["state"] == "succeeded"


def test_a_job_that_waits_is_not_said_to_be_gone(service):
    job = service.request("POST", "/v1/basins", json=BODY).json()
    assert_problem(service.request("GET", f"/v1/jobs/{job['id']}/result"), 404, "queued and has no result yet")


def test_a_store_without_its_root_is_removed_and_any_other_is_kept(tmp_path):
    location = tmp_path / "basin.zarr"
    job = BasinJob.from_request(BODY)
    create_store(str(location), job)
    before = sorted(path for path in location.rglob("*"))
    remove_rootless(str(location))
    assert sorted(path for path in location.rglob("*")) == before
    (location / "zarr.json").unlink()
    remove_rootless(str(location))
    assert not location.exists()
    remove_rootless(str(location))
    create_store(str(location), job)


def test_a_database_that_was_removed_is_not_ready_and_takes_nothing(service, tmp_path):
    assert service.request("GET", "/readyz").json()["database"] is True
    for path in tmp_path.glob("jobs.sqlite*"):
        path.unlink()
    patience = time.monotonic() + 10.0
    while service.request("GET", "/readyz").json()["database"]:
        assert time.monotonic() < patience
    assert service.request("GET", "/readyz").status_code == 503
    for answer in (service.request("POST", "/v1/basins", json=BODY), service.request("GET", "/v1/jobs")):
        assert_problem(answer, 503, "removed or replaced while the service ran")
    assert service.request("GET", "/healthz").status_code == 200


def test_a_database_that_was_replaced_takes_nothing(service, tmp_path):
    copy = tmp_path / "copy"
    shutil.copy(tmp_path / "jobs.sqlite", copy)
    copy.rename(tmp_path / "jobs.sqlite")
    assert_problem(service.request("POST", "/v1/basins", json=BODY), 503, "start it again")
