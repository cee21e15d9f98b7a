"""Views of jobs are what the database holds, whoever has changed it."""

import pytest

from service.models.jobs import JobPage, JobView
from service.records.engine import open_database
from service.records.job_record import JobState
from service.records.jobs import Jobs
from tests.service.idle_service import idle_service

PROGRESS = {
    "stage": "mapping", "tiles_done": 1, "tiles_total": 4, "cells_done": 25, "cells_total": 100,
    "cells_per_second": 5.0, "seconds_left": 15.0,
}  # fmt: skip


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


@pytest.fixture
def elsewhere(service):
    """The job records as another replica has them."""
    engine, sessions = open_database(service.app.state.settings.database)
    yield Jobs(sessions, service.app.state.settings.quotas)
    engine.dispose()


def view_of(service, job):
    """View of a job, the same alone and in a page."""
    alone = service.request("GET", f"/v1/jobs/{job.id}").json()
    paged = [each for each in service.request("GET", "/v1/jobs").json()["jobs"] if each["id"] == job.id]
    assert paged == [alone] and alone == JobView.from_record(service.jobs.get(job.id)).model_dump(
        mode="json", exclude_unset=True
    )
    return alone


def test_a_change_is_seen_at_once_whichever_replica_has_made_it(service, elsewhere):
    job = service.add_job()
    assert view_of(service, job)["state"] == "queued"
    claimed = elsewhere.claim("other/1")
    assert claimed.id == job.id and view_of(service, job)["state"] == "running"
    elsewhere.record_progress(job.id, PROGRESS, "other/1")
    assert view_of(service, job)["progress"]["tiles_done"] == 1
    elsewhere.record_progress(job.id, PROGRESS | {"tiles_done": 2}, "other/1")
    assert view_of(service, job)["progress"]["tiles_done"] == 2
    elsewhere.request_cancel(job.id)
    assert view_of(service, job)["state"] == "cancelling"
    elsewhere.transition(job.id, JobState.CANCELLING, JobState.CANCELLED)
    assert view_of(service, job)["finished"] is not None
    elsewhere.delete(job.id)
    assert service.request("GET", f"/v1/jobs/{job.id}").status_code == 404
    assert service.request("GET", "/v1/jobs").json()["jobs"] == []


def test_a_submission_and_the_same_one_again_are_answered_as_the_job_is_view_of(service):
    body = {"grid": {"time": {"cells": 4}, "velocity": {"cells": 4}}, "iterations": 1}
    first, again = (service.request("POST", "/v1/basins", json=body) for _ in range(2))
    assert first.content == again.content == service.request("GET", first.headers["location"]).content
    cancelled = service.request("POST", first.json()["links"]["cancel"])
    assert cancelled.content == service.request("GET", first.headers["location"]).content
    assert cancelled.json()["state"] == "cancelled"


def test_pages_are_whole_and_lead_to_each_other(service):
    jobs = [service.add_job(cells) for cells in range(4, 9)]
    service.jobs.transition(jobs[2].id, JobState.QUEUED, JobState.CANCELLED)
    for only, expected in (("", jobs), ("&state=queued", jobs[:2] + jobs[3:])):
        link, seen = f"/v1/jobs?size=2{only}", []
        while link:
            page = JobPage.model_validate_json(service.request("GET", link).content)
            seen += [job.id for job in page.jobs]
            link = page.next
        assert seen == [job.id for job in reversed(expected)]
