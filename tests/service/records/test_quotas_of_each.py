"""Quotas of each submitter count what is theirs: others near their limits take nothing from it."""

import pytest

from rattle_kernels import CellGrid
from service.errors import LimitExceeded, TooMuch
from service.records.engine import open_database
from service.records.job_record import JobState
from service.records.jobs import Jobs
from service.settings import Quotas
from worker.jobs.basin_job import BasinJob


@pytest.fixture
def opened(database_url):
    engine, sessions = open_database(database_url)
    yield lambda **quotas: Jobs(
        sessions, Quotas(**({"queued": 100, "queued_each": 100, "places_each": 10**9} | quotas))
    )
    engine.dispose()


def cells(count, k=1):
    """A job of so many cells; k makes it another."""
    return BasinJob(grid=CellGrid(time_cells=count, velocity_cells=1), iterations=k)


def test_cells_of_others_do_not_count_against_a_third_submitter(opened):
    jobs = opened(places_each=250)
    jobs.submit(cells(200), "ann")
    jobs.submit(cells(201), "bob")
    assert jobs.submit(cells(250), "carol")[1]
    with pytest.raises(TooMuch, match="carol .*RATTLE_MAX_PLACES_EACH"):
        jobs.submit(cells(1), "carol")
    # Up to the last cell, and not one more.
    assert jobs.submit(cells(50), "ann")[1]
    with pytest.raises(TooMuch, match="ann"):
        jobs.submit(cells(2), "ann")
    with pytest.raises(LimitExceeded):
        jobs.submit(cells(251), "dan")


def test_running_cells_count_and_those_of_ended_jobs_do_not(opened):
    jobs = opened(places_each=100)
    first, _ = jobs.submit(cells(100), "ann")
    assert jobs.claim("one").id == first.id
    with pytest.raises(TooMuch):
        jobs.submit(cells(1), "ann")
    assert jobs.transition(first.id, JobState.RUNNING, JobState.CANCELLING)
    with pytest.raises(TooMuch):
        jobs.submit(cells(1), "ann")
    assert jobs.transition(first.id, JobState.CANCELLING, JobState.CANCELLED)
    assert jobs.submit(cells(99), "ann")[1]


def test_queued_jobs_of_others_do_not_count_against_a_third_submitter(opened):
    jobs = opened(queued_each=2)
    for k, name in enumerate(("ann", "ann", "bob", "bob")):
        jobs.submit(cells(4 + k), name)
    assert jobs.submit(cells(20), "carol")[1] and jobs.submit(cells(21), "carol")[1]
    with pytest.raises(TooMuch, match="2 jobs of carol are queued"):
        jobs.submit(cells(22), "carol")


def test_all_queued_jobs_count_against_everybody(opened):
    jobs = opened(queued=3)
    for k, name in enumerate(("ann", "bob", "carol")):
        jobs.submit(cells(4 + k), name)
    with pytest.raises(TooMuch, match="RATTLE_MAX_QUEUED\\)"):
        jobs.submit(cells(20), "dan")
