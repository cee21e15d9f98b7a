"""Summaries are read from their stores no more often than twice a second."""

import threading
import time

import pytest

from service.answers import result_view
from service.records.job_record import JobState
from tests.service.idle_service import idle_service
from worker.jobs.basin_job import basin_job
from worker.results import summary
from worker.stores.new_store import create_store


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


@pytest.fixture
def readings(monkeypatch):
    """One entry for each time that a store is read."""
    read, counted = summary.summarise, []
    monkeypatch.setattr(summary, "summarise", lambda *given: (counted.append(given), read(*given))[1])
    return counted


def running(service, cells=10):
    """A running job with a store."""
    job = service.add_job(cells)
    create_store(f"{service.results}/{job.id}.zarr", basin_job(job.request))
    assert service.jobs.transition(job.id, JobState.QUEUED, JobState.RUNNING)
    return job


def test_a_summary_is_read_twice_a_second_and_at_once_when_the_job_has_ended(service, readings):
    job = running(service)
    path, begin = f"/v1/jobs/{job.id}/result", time.monotonic()
    while len(readings) < 3:
        assert service.request("GET", path).json()["complete"] is False
    assert time.monotonic() - begin > 2 * 0.5
    before = len(readings)
    assert service.jobs.transition(job.id, JobState.RUNNING, JobState.SUCCEEDED)
    ended = service.request("GET", path)
    assert len(readings) == before + 1  # whatever was read half a second before its end
    etag = {"if-none-match": ended.headers["etag"]}
    assert service.request("GET", path, headers=etag).status_code == 304
    assert service.request("DELETE", f"/v1/jobs/{job.id}").status_code == 204
    assert service.request("GET", path).status_code == 404


def test_many_requests_at_once_wait_for_one_reading(service, readings):
    path = f"/v1/jobs/{running(service).id}/result"
    answers = []
    threads = [threading.Thread(target=lambda: answers.append(service.request("GET", path))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {answer.status_code for answer in answers} == {200} and len(readings) <= 2


def test_summaries_that_are_kept_are_bounded(service, readings, monkeypatch):
    jobs = [running(service, cells) for cells in (4, 5, 6)]
    records = [service.jobs.get(job.id) for job in jobs]
    result_view._SUMMARIES.clear()
    sizes = [len(result_view.summary_of_result(record, service.results).body) for record in records]
    assert result_view._SUMMARIES.currsize == sum(sizes)
    monkeypatch.setattr(result_view._SUMMARIES, "_Cache__maxsize", 10)
    result_view._SUMMARIES.clear()
    for record in records:
        assert result_view.summary_of_result(record, service.results).body
    assert result_view._SUMMARIES.currsize == 0
