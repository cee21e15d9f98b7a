"""Events of jobs: numbered by the database, replayed, and ended with the job."""

import asyncio
import contextlib
import itertools
import json
import threading
import time

import httpx2 as httpx
import pytest

from service.answers.event_feed import EventFeed
from service.records.events import PROGRESS_KEPT, Events
from service.records.job_record import JobState
from service.records.jobs import Jobs
from tests.service.idle_service import idle_service
from tests.waiting import wait_until

PROGRESS = {
    "stage": "mapping", "tiles_done": 0, "tiles_total": 500, "cells_done": 0, "cells_total": 100,
    "cells_per_second": 1.0, "seconds_left": None, "basins_done": 0, "basins_total": 1,
}  # fmt: skip


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


def start(jobs, job):
    assert jobs.claim(f"test/{job.id}").id == job.id


def further(jobs, job, tiles):
    jobs.record_progress(job.id, PROGRESS | {"tiles_done": tiles}, f"test/{job.id}")


def end(jobs, job, state=JobState.SUCCEEDED, **values):
    assert jobs.transition(job.id, JobState.RUNNING, state, **values)


def parsed(lines):
    """Events of a stream: (number, name, data)."""
    event = {}
    for line in lines:
        if not line and event:
            yield int(event["id"]), event["event"], json.loads(event["data"])
            event = {}
        elif line and not line.startswith(":"):
            name, _, value = line.partition(": ")
            event[name] = value


@contextlib.contextmanager
def stream(service, job, last=None):
    headers = {} if last is None else {"last-event-id": str(last)}
    with httpx.stream("GET", f"{service.url}/v1/jobs/{job.id}/events", headers=headers, timeout=None) as answer:
        assert answer.status_code == 200 and answer.headers["content-type"].startswith("text/event-stream")
        yield parsed(answer.iter_lines())


def test_a_stream_tells_every_state_and_the_progress_and_ends_with_the_job(service):
    job = service.add_job()
    with stream(service, job) as events:
        number, name, data = next(events)
        assert (number, name, data["state"]) == (1, "state", "queued")
        start(service.jobs, job)
        number, name, data = next(events)
        assert (number, name, data["state"], data["progress"]) == (2, "state", "running", None)
        further(service.jobs, job, 3)
        number, name, data = next(events)
        assert (number, name, data["progress"]["tiles_done"]) == (3, "progress", 3)
        end(service.jobs, job, JobState.FAILED, error={"kind": "tile-failed", "detail": "why"})
        number, name, data = next(events)
        assert (number, name, data["state"], data["error"]["detail"]) == (4, "state", "failed", "why")
        assert list(events) == []


def test_a_client_that_comes_back_gets_what_it_has_missed_and_nothing_twice(service):
    job = service.add_job()
    start(service.jobs, job)
    for tiles in range(1, 6):
        further(service.jobs, job, tiles)
    with stream(service, job) as events:
        whole = [next(events) for _ in range(7)]
    assert [number for number, *_ in whole] == [1, 2, 3, 4, 5, 6, 7]
    with stream(service, job, last=4) as events:
        assert [next(events) for _ in range(3)] == whole[4:]
        end(service.jobs, job)
        assert [(number, data["state"]) for number, _, data in events] == [(8, "succeeded")]
    with stream(service, job) as events:
        assert [(number, data["state"]) for number, _, data in events] == [
            (1, "queued"), (2, "running"), (8, "succeeded"),
        ]  # fmt: skip


def test_a_client_that_has_seen_the_end_is_told_not_to_come_back(service):
    job = service.add_job()
    start(service.jobs, job)
    end(service.jobs, job)
    path = f"/v1/jobs/{job.id}/events"
    assert service.request("GET", path, headers={"last-event-id": "3"}).status_code == 204
    # A number that the job has not reached is no reason to keep anything from a client.
    assert len(list(parsed(service.request("GET", path, headers={"last-event-id": "99"}).text.splitlines()))) == 3
    assert service.request("GET", path, headers={"last-event-id": "last"}).status_code == 422
    assert service.request("GET", f"/v1/jobs/{'0' * 32}/events").status_code == 404


def test_events_come_from_the_database_whoever_writes_them(service, tmp_path):
    job = service.add_job()
    other_replica = Jobs(service.jobs._sessions, service.jobs._quotas)
    with stream(service, job) as events:
        next(events)
        start(other_replica, job)
        assert next(events)[2]["state"] == "running"


def test_a_deleted_job_ends_its_stream(service):
    job = service.add_job()
    with stream(service, job) as events:
        next(events)
        service.jobs.request_cancel(job.id)
        service.jobs.delete(job.id)
        assert [data["state"] for *_, data in events] in ([], ["cancelled"])
    assert Events(service.jobs._sessions).newest([job.id]) == {}


def test_the_table_stays_small_however_long_a_job_runs(service):
    job, events = service.add_job(), Events(service.jobs._sessions)
    start(service.jobs, job)
    for tiles in range(3 * PROGRESS_KEPT):
        further(service.jobs, job, tiles)
    kept = events.after(job.id, 0)
    assert len(kept) == PROGRESS_KEPT + 2
    assert [event.sequence for event in kept[2:]] == list(range(2 * PROGRESS_KEPT + 3, 3 * PROGRESS_KEPT + 3))
    end(service.jobs, job)
    assert [event.state for event in events.after(job.id, 0)] == ["queued", "running", "succeeded"]
    further(service.jobs, job, 5)  # late, from a thread that does not know yet
    assert len(events.after(job.id, 0)) == 3


def test_numbers_have_no_twins_when_threads_write_together(service):
    job = service.add_job()
    start(service.jobs, job)
    threads = [
        threading.Thread(target=lambda: [further(service.jobs, job, tiles) for tiles in range(10)]) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    numbers = [event.sequence for event in Events(service.jobs._sessions).after(job.id, 0)]
    assert numbers == list(range(1, 43))


def test_progress_and_numbers_go_on_where_a_service_was_stopped(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as first:
        job = first.add_job()
        start(first.jobs, job)
        further(first.jobs, job, 7)
        with stream(first, job) as events:
            assert [next(events)[0] for _ in range(3)] == [1, 2, 3]
    with idle_service(monkeypatch, tmp_path) as second:
        assert second.request("GET", f"/v1/jobs/{job.id}").json()["progress"]["tiles_done"] == 7
        with stream(second, job, last=3) as events:
            further(second.jobs, job, 8)
            assert next(events)[0] == 4


def test_many_followers_cost_one_question_at_a_time_and_leave_nothing_behind(service, monkeypatch):
    job, feed = service.add_job(), service.app.state.feed
    asked = itertools.count()
    newest = feed._events.newest
    monkeypatch.setattr(feed._events, "newest", lambda ids: (next(asked), newest(ids))[1])
    with contextlib.ExitStack() as stack:
        streams = [stack.enter_context(stream(service, job)) for _ in range(20)]
        for events in streams:
            assert next(events)[0] == 1
        assert feed.followed == 1
        for _ in streams:
            next(asked)
        before, begin = next(asked), time.monotonic()
        time.sleep(1.0)
        assert next(asked) - before <= (time.monotonic() - begin) / 0.25 + 2
        start(service.jobs, job)
        assert [next(events)[0] for events in streams] == [2] * 20
    wait_until("nobody is followed", lambda: feed.followed == 0)
    wait_until("nobody asks any more", lambda: feed._polling.done())


def test_a_service_stops_at_once_with_open_streams(monkeypatch, tmp_path):
    monkeypatch.setattr("service.server._STOP_SECONDS", 3600)  # what it would wait for a stream that goes on
    with contextlib.ExitStack() as stack:
        with idle_service(monkeypatch, tmp_path) as service:
            job = service.add_job()
            events = stack.enter_context(stream(service, job))
            next(events)
        assert list(events) == []


def test_a_follower_that_lags_still_gets_every_change_of_state(service):
    """Followers of one job share what is read: one that is too far behind for that asks the database itself."""
    job, feed = service.add_job(), EventFeed(Events(service.jobs._sessions))

    async def follow():
        slow = feed.follow(job.id, 0)
        seen = [await anext(slow)]
        await asyncio.to_thread(start, service.jobs, job)
        for tiles in range(PROGRESS_KEPT + 10):
            await asyncio.to_thread(further, service.jobs, job, tiles)
            if tiles % 30 == 0:
                await asyncio.sleep(0.3)
        await asyncio.to_thread(end, service.jobs, job)
        return seen + [event async for event in slow]

    seen = asyncio.run(follow())
    numbers = [event.sequence for event in seen]
    assert numbers == sorted(set(numbers)) and numbers[:2] == [1, 2] and numbers[-1] == PROGRESS_KEPT + 13
    assert feed.followed == 0


def test_a_job_that_has_not_changed_is_not_sent_again(service):
    job = service.add_job()
    path = f"/v1/jobs/{job.id}"
    first = service.request("GET", path)
    etag = first.headers["etag"]
    for known in (etag, f"W/{etag}", f'"other", {etag}', "*"):
        again = service.request("GET", path, headers={"if-none-match": known})
        assert again.status_code == 304 and again.content == b"" and again.headers["etag"] == etag
    start(service.jobs, job)
    changed = service.request("GET", path, headers={"if-none-match": etag})
    assert changed.status_code == 200 and changed.headers["etag"] != etag
