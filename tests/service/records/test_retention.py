"""What nobody reads makes room: by age and by size, never what runs, waits or is being read."""

from datetime import UTC, datetime, timedelta

import pytest

from rattle_kernels import CellGrid
from service.errors import JobNotFound
from service.records.engine import open_database
from service.records.job_record import JobState
from service.records.jobs import Jobs
from service.runner.retention import Retention
from service.settings import Quotas
from tests.service.idle_service import idle_service
from worker.jobs.basin_job import BasinJob
from worker.stores.new_store import create_store

BYTES = 1000


@pytest.fixture
def jobs(database_url):
    engine, sessions = open_database(database_url)
    yield Jobs(sessions, Quotas(1000, 1000, 10**9))
    engine.dispose()


@pytest.fixture
def ended(jobs, tmp_path):
    """Make a job of a kilobyte that has ended, in the order of the calls."""
    numbers = iter(range(10, 1000))

    def make(state=JobState.SUCCEEDED):
        cells = next(numbers)
        job = jobs.submit(BasinJob(grid=CellGrid(time_cells=cells, velocity_cells=cells), iterations=1), "local")[0]
        folder = tmp_path / f"{job.store}.zarr" / "group"
        folder.mkdir(parents=True)
        (folder / "0").write_bytes(bytes(BYTES))
        jobs.transition(job.id, JobState.QUEUED, JobState.RUNNING)
        if state is not JobState.RUNNING:
            jobs.transition(job.id, JobState.RUNNING, state)
        return job.id

    return make


@pytest.fixture
def retention(jobs, tmp_path):
    return lambda days=None, kilobytes=None: Retention(
        jobs, jobs.reads, str(tmp_path), days, None if kilobytes is None else kilobytes * BYTES / 1e9
    )


def in_time(**span):
    """The time that long from now: what was just read or has just ended is as old then."""
    return datetime.now(UTC) + timedelta(**span)


def stores(tmp_path):
    return {path.stem for path in tmp_path.glob("*.zarr")}


def test_what_nobody_has_read_for_days_is_deleted_with_its_job(ended, jobs, retention, tmp_path):
    old, failed, running = ended(), ended(JobState.FAILED), ended(JobState.RUNNING)
    assert retention(days=2.0).look(in_time(days=1.9)) == []
    assert retention(days=2.0).look(in_time(days=2.1)) == [old, failed]
    assert stores(tmp_path) == {running} and jobs.get(running).state is JobState.RUNNING
    with pytest.raises(JobNotFound):
        jobs.get(old)


def test_the_longest_unread_make_room_and_no_more_of_them_than_it_takes(ended, jobs, retention, tmp_path):
    first, second, third, running = ended(), ended(), ended(), ended(JobState.RUNNING)
    jobs.reads.note(first)
    later = in_time(hours=2)
    assert retention(kilobytes=3).look(later) == []
    assert retention(kilobytes=2.5).look(later) == [second]
    assert retention(kilobytes=1).look(later) == [third]
    assert stores(tmp_path) == {first, running}
    assert jobs.reads.last(second) is None and jobs.reads.last(first) is not None


def test_what_is_being_read_stays_whatever_the_limits(ended, jobs, retention, tmp_path):
    read, other = ended(), ended()
    jobs.reads.note(read)
    assert retention(days=0.001, kilobytes=0.001).look(in_time(minutes=59)) == [other]
    assert stores(tmp_path) == {read}
    assert retention(kilobytes=0.001).look(in_time(minutes=62)) == [read]


def test_a_store_that_a_waiting_job_goes_on_from_stays(ended, jobs, retention, tmp_path):
    failed = ended(JobState.CANCELLED)
    again, _ = jobs.submit(BasinJob.from_request(jobs.get(failed).request), "local")
    assert again.store == failed
    assert retention(days=1.0, kilobytes=0.001).look(in_time(days=2)) == [failed]
    assert stores(tmp_path) == {failed} and jobs.get(again.id).store == failed


def test_without_limits_nothing_is_deleted(ended, retention, tmp_path):
    kept = ended()
    assert retention().look(in_time(days=10_000)) == [] and stores(tmp_path) == {kept}


@pytest.mark.parametrize("days", [None, 1.0])
def test_every_reading_over_http_is_noted_where_results_may_be_deleted(monkeypatch, tmp_path, days):
    with idle_service(monkeypatch, tmp_path, keep_days=days) as service:
        job = service.add_job()
        create_store(f"{service.results}/{job.id}.zarr", BasinJob.from_request(job.request))
        assert service.request("GET", f"/v1/jobs/{job.id}").status_code == 200
        assert service.jobs.reads.last(job.id) is None
        assert service.request("GET", f"/v1/jobs/{job.id}/result.zarr/zarr.json").status_code == 200
        assert (service.jobs.reads.last(job.id) is not None) == (days is not None)
