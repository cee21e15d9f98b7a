"""Job records under concurrency: one truth, final states final."""

import subprocess
import sys
import threading

import pytest

from rattle_kernels import CellGrid
from service.errors import JobNotFound, LimitExceeded, TooMuch
from service.records.engine import open_database
from service.records.job_record import JobState
from service.records.jobs import Jobs, LargeJobsOf
from service.records.replica import replica_name
from service.settings import Quotas
from worker.jobs.basin_job import BasinJob

ROOM = Quotas(queued=1000, queued_each=1000, places_each=10**9)


@pytest.fixture
def jobs(database_url):
    engine, sessions = open_database(database_url)
    yield Jobs(sessions, ROOM)
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
    names = iter(range(6))
    claimed = [record.id for record in together(6, lambda: jobs.claim(f"claim {next(names)}")) if record is not None]
    assert len(claimed) == len(set(claimed)) == 3
    assert jobs.claim("later") is None


def test_only_one_of_two_contradictory_changes_wins(jobs):
    record, _ = jobs.submit(a_job(), "local")
    moves = together(4, lambda: jobs.transition(record.id, JobState.QUEUED, JobState.RUNNING))
    assert moves.count(True) == 1


@pytest.mark.parametrize("final", [JobState.SUCCEEDED, JobState.FAILED, JobState.CANCELLED])
def test_a_final_state_never_changes(jobs, final):
    record, _ = jobs.submit(a_job(), "local")
    jobs.transition(record.id, JobState.QUEUED, final)
    assert jobs.request_cancel(record.id).state == final
    assert jobs.get(record.id).state == final and jobs.claim("any") is None


def test_after_a_failure_the_request_is_a_new_job(jobs):
    first, _ = jobs.submit(a_job(), "local")
    jobs.transition(first.id, JobState.QUEUED, JobState.FAILED, error={"kind": "tile-failed", "detail": "why"})
    second, new = jobs.submit(a_job(), "local")
    assert new and second.id != first.id


def run_out(jobs, monkeypatch, owner):
    """Let a lease be one that ran out a second ago."""
    with monkeypatch.context() as patch:
        patch.setattr("service.records.jobs.LEASE_SECONDS", -1.0)
        jobs.renew([owner])


def test_a_job_whose_lease_has_run_out_is_taken_over_and_is_lost_to_its_first_owner(jobs, monkeypatch):
    record, _ = jobs.submit(a_job(), "local")
    first = jobs.claim("first")
    assert jobs.renew(["first"]) == {"first": JobState.RUNNING}
    assert jobs.claim("second") is None
    run_out(jobs, monkeypatch, "first")
    assert jobs.claim("second").id == first.id
    assert jobs.renew(["first"]) == {}
    jobs.record_progress(record.id, {"stage": "done"}, "first")
    assert not jobs.transition(record.id, JobState.RUNNING, JobState.FAILED, owner="first")
    assert jobs.get(record.id).progress is None and jobs.get(record.id).lease_owner == "second"
    assert jobs.transition(record.id, JobState.RUNNING, JobState.SUCCEEDED, owner="second")
    assert jobs.get(record.id).lease_owner is None


def test_what_nobody_is_left_to_cancel_is_cancelled(jobs, monkeypatch):
    record, _ = jobs.submit(a_job(), "local")
    jobs.claim("first")
    assert jobs.request_cancel(record.id).state == JobState.CANCELLING
    jobs.end_dead_leases()
    assert jobs.get(record.id).state == JobState.CANCELLING
    run_out(jobs, monkeypatch, "first")
    jobs.end_dead_leases()
    assert jobs.get(record.id).state == JobState.CANCELLED


def test_leases_of_a_process_that_is_seen_to_be_dead_end_at_once(jobs):
    named = subprocess.run(
        [sys.executable, "-c", "from service.records.replica import replica_name; print(replica_name())"],
        capture_output=True, text=True, check=True,
    ).stdout.strip()  # fmt: skip
    left, _ = jobs.submit(a_job(10), "local")
    jobs.claim(f"{named}/1")
    living, _ = jobs.submit(a_job(11), "local")
    jobs.claim(f"{replica_name()}/1")
    far, _ = jobs.submit(a_job(12), "local")
    jobs.claim("of.another.machine.1.2/1")
    jobs.end_dead_leases()
    assert jobs.claim("mine").id == left.id
    assert jobs.claim("mine") is None


def test_submitters_take_turns_and_each_ones_jobs_go_in_their_order(jobs):
    many = [jobs.submit(a_job(cells), "many")[0].id for cells in (10, 11, 12, 13)]
    few = [jobs.submit(a_job(cells), "few")[0].id for cells in (20, 21)]
    one = jobs.submit(a_job(30), "one")[0].id
    claimed = [jobs.claim(f"claim {i}").id for i in range(7)]
    assert claimed == [many[0], few[0], one, many[1], few[1], many[2], many[3]]


def test_who_was_served_longest_ago_is_next_where_jobs_end_at_once(jobs):
    for cells in (10, 11, 12):
        jobs.submit(a_job(cells), "many")
    for cells in (20, 21):
        jobs.submit(a_job(cells), "few")
    turns = []
    for i in range(5):
        record = jobs.claim(f"claim {i}")
        turns.append(record.submitter)
        jobs.transition(record.id, JobState.RUNNING, JobState.SUCCEEDED)
    assert turns == ["many", "few", "many", "few", "many"]


def test_places_for_newcomers_and_for_small_jobs_are_not_for_large_jobs_of_who_has_some_running(jobs):
    large = [jobs.submit(a_job(cells), "many")[0].id for cells in (600, 601)]
    assert jobs.claim("first", large=LargeJobsOf.NOBODY) is None
    assert jobs.claim("first", large=LargeJobsOf.IDLE).id == large[0]
    assert jobs.claim("second", large=LargeJobsOf.IDLE) is None
    small, _ = jobs.submit(a_job(10), "many")
    new, _ = jobs.submit(a_job(602), "new")
    assert jobs.claim("second", large=LargeJobsOf.IDLE).id == new.id
    assert jobs.claim("third", large=LargeJobsOf.NOBODY).id == small.id
    assert jobs.claim("fourth").id == large[1]


def refusal(jobs, job, submitter):
    with pytest.raises(TooMuch) as refused:
        jobs.submit(job, submitter)
    assert 1 <= refused.value.seconds <= 60
    return str(refused.value)


def test_each_quota_refuses_what_is_too_much_by_name_until_there_is_room(jobs):
    tight = Jobs(jobs._sessions, Quotas(queued=3, queued_each=2, places_each=1000))
    first, _ = tight.submit(a_job(10), "a")
    tight.submit(a_job(11), "a")
    assert "RATTLE_MAX_QUEUED_EACH" in refusal(tight, a_job(12), "a")
    known, new = tight.submit(a_job(10), "a")
    assert known.id == first.id and not new
    tight.submit(a_job(13), "b")
    assert "RATTLE_MAX_QUEUED)" in refusal(tight, a_job(14), "b")
    tight.claim("any")
    assert "RATTLE_MAX_PLACES_EACH" in refusal(tight, a_job(30), "a")
    assert tight.submit(a_job(15), "c")[1]
    with pytest.raises(LimitExceeded, match="RATTLE_MAX_PLACES_EACH"):
        tight.submit(a_job(32), "d")


def test_simultaneous_submissions_do_not_exceed_a_quota(jobs):
    tight = Jobs(jobs._sessions, Quotas(queued=3, queued_each=3, places_each=1000))
    cells = iter(range(5, 13))

    def submit():
        try:
            return tight.submit(a_job(next(cells)), "a")[1]
        except TooMuch:
            return False

    assert together(8, submit).count(True) == 3


def test_a_new_job_goes_on_from_the_store_of_the_one_that_failed(jobs):
    first, _ = jobs.submit(a_job(), "local")
    jobs.claim("any")
    jobs.transition(first.id, JobState.RUNNING, JobState.FAILED, error={"kind": "store-failed", "detail": "full"})
    second, _ = jobs.submit(a_job(), "local")
    assert second.id != first.id and second.store == first.store == first.id
    assert jobs.release_store(first.id) is None
    jobs.delete(first.id)
    jobs.request_cancel(second.id)
    assert jobs.release_store(second.id) == first.id
    third, _ = jobs.submit(a_job(), "local")
    assert third.store == third.id


def test_a_queued_job_is_cancelled_at_once(jobs):
    record, _ = jobs.submit(a_job(), "local")
    assert jobs.request_cancel(record.id).state == JobState.CANCELLED
    assert jobs.claim("any") is None


def test_a_live_job_is_not_deleted(jobs):
    record, _ = jobs.submit(a_job(), "local")
    jobs.delete(record.id)
    assert jobs.get(record.id).id == record.id
    jobs.request_cancel(record.id)
    jobs.delete(record.id)
    with pytest.raises(JobNotFound, match=record.id):
        jobs.get(record.id)
