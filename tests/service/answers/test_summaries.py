"""Summaries are read from their stores no more often than what they tell changes."""

import threading
import time

import pytest

from service.answers import summaries
from service.answers.summaries import Summaries
from service.records.job_record import JobState
from tests.service.idle_service import idle_service
from worker.jobs.basin_job import basin_job
from worker.stores.new_store import create_store


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


@pytest.fixture
def readings(monkeypatch):
    """One entry for each time that a store is read."""
    read, counted = summaries.result_view, []
    monkeypatch.setattr(summaries, "result_view", lambda *given: (counted.append(given), read(*given))[1])
    return counted


def running(service, cells=10):
    """A job that runs, and has a store."""
    job = service.add_job(cells)
    create_store(f"{service.results}/{job.id}.zarr", basin_job(job.request))
    assert service.jobs.move(job.id, JobState.QUEUED, JobState.RUNNING)
    return job


def test_a_running_jobs_summary_is_read_twice_a_second_and_that_of_its_end_once(service, readings):
    job = running(service)
    path, begin = f"/v1/jobs/{job.id}/result", time.monotonic()
    while time.monotonic() - begin < 1.2:
        assert service.request("GET", path).json()["complete"] is False
    assert 2 <= len(readings) <= 4
    before = len(readings)
    assert service.jobs.move(job.id, JobState.RUNNING, JobState.SUCCEEDED)
    ended = service.request("GET", path)
    assert len(readings) == before + 1  # at once, whatever was kept from before its end
    time.sleep(0.6)
    assert service.request("GET", path).content == ended.content and len(readings) == before + 1
    etag = {"if-none-match": ended.headers["etag"]}
    assert service.request("GET", path, headers=etag).status_code == 304 and len(readings) == before + 1
    assert service.request("DELETE", f"/v1/jobs/{job.id}").status_code == 204
    assert service.request("GET", path).status_code == 404


def test_many_who_ask_at_once_wait_for_one_reading(service, readings):
    path = f"/v1/jobs/{running(service).id}/result"
    answers = []
    threads = [threading.Thread(target=lambda: answers.append(service.request("GET", path))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {answer.status_code for answer in answers} == {200} and len(readings) <= 2


def test_what_was_asked_for_long_ago_makes_room(service, readings):
    jobs = [running(service, cells) for cells in (4, 5, 6)]
    for job in jobs:
        service.jobs.move(job.id, JobState.RUNNING, JobState.SUCCEEDED)
    records = [service.jobs.get(job.id) for job in jobs]
    size = len(Summaries(service.results).of(records[2]).body)
    readings.clear()
    kept = Summaries(service.results, most_bytes=2 * (1024 + size))
    for record in records:
        kept.of(record)
    kept.of(records[2])
    assert len(readings) == 3
    kept.of(records[0])
    assert len(readings) == 4
