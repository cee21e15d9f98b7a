"""Job records under concurrency: one truth, final states final."""

import threading

import pytest

from rattle_kernels import CellGrid
from service.database import open_database
from service.errors import JobNotFound
from service.job_record import JobState
from service.jobs import Jobs
from worker.basin_job import BasinJob


@pytest.fixture
def jobs(database_url):
    engine, sessions = open_database(database_url)
    yield Jobs(sessions)
    engine.dispose()


def a_job(cells=10):
    return BasinJob(grid=CellGrid(time_cells=cells, velocity_cells=cells), iterations=1)


def together(count, function):
    results, barrier = [], threading.Barrier(count)

    def work():
        barrier.wait()
        results.append(function())

    threads = [threading.Thread(target=work) for _ in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == count
    return results


def test_simultaneous_submissions_of_one_request_are_one_job(jobs):
    answers = together(8, lambda: jobs.submit(a_job(), "local"))
    assert len({record.id for record, _ in answers}) == 1
    assert [new for _, new in answers].count(True) == 1


def test_a_job_is_claimed_once(jobs):
    for cells in (10, 11, 12):
        jobs.submit(a_job(cells), "local")
    claimed = [record.id for record in together(6, jobs.claim) if record is not None]
    assert len(claimed) == len(set(claimed)) >= 1
    while (record := jobs.claim()) is not None:
        claimed.append(record.id)
    assert len(set(claimed)) == len(claimed) == 3


def test_only_one_of_two_contradictory_changes_wins(jobs):
    record, _ = jobs.submit(a_job(), "local")
    moves = together(4, lambda: jobs.move(record.id, JobState.QUEUED, JobState.RUNNING))
    assert moves.count(True) == 1


@pytest.mark.parametrize("final", [JobState.SUCCEEDED, JobState.FAILED, JobState.CANCELLED])
def test_a_final_state_never_changes(jobs, final):
    record, _ = jobs.submit(a_job(), "local")
    jobs.move(record.id, JobState.QUEUED, final)
    assert jobs.request_cancel(record.id).state == final
    jobs.recover()
    assert jobs.get(record.id).state == final and jobs.claim() is None


def test_after_a_failure_the_request_is_a_new_job(jobs):
    first, _ = jobs.submit(a_job(), "local")
    jobs.move(first.id, JobState.QUEUED, JobState.FAILED, error={"kind": "tile-failed", "detail": "why"})
    second, new = jobs.submit(a_job(), "local")
    assert new and second.id != first.id


def test_a_crash_leaves_no_job_running(jobs):
    running, _ = jobs.submit(a_job(10), "local")
    jobs.claim()
    stopping, _ = jobs.submit(a_job(11), "local")
    jobs.claim()
    jobs.request_cancel(stopping.id)
    jobs.recover()
    assert jobs.get(running.id).state == JobState.QUEUED
    assert jobs.get(stopping.id).state == JobState.CANCELLED


def test_a_queued_job_is_cancelled_at_once(jobs):
    record, _ = jobs.submit(a_job(), "local")
    assert jobs.request_cancel(record.id).state == JobState.CANCELLED
    assert jobs.claim() is None


def test_a_live_job_is_not_deleted(jobs):
    record, _ = jobs.submit(a_job(), "local")
    jobs.delete(record.id)
    assert jobs.get(record.id).id == record.id
    jobs.request_cancel(record.id)
    jobs.delete(record.id)
    with pytest.raises(JobNotFound, match=record.id):
        jobs.get(record.id)
