"""Tasks that fail are tried again or fail the job; a scheduler with other settings is warned of."""

import logging
import threading
import time
from pathlib import Path
from unittest.mock import Mock

import pytest
from distributed import CancelledError, Client, Future
from distributed.scheduler import KilledWorker

from worker.cluster.calls import Task, stop_if_cancelled
from worker.cluster.connection import _warn_of_settings
from worker.cluster.driver import Driver, _Window
from worker.cluster.threads import threads_here
from worker.errors import JobCancelled, StoreConflict, StoreFailed, TileFailed


def reach_store(location, digest, number, failures, error):
    """Fail so often with an error, then succeed."""
    with Path(location).open("a") as counted:
        counted.write(".")
    if len(Path(location).read_text()) <= failures:
        raise error(f"{location} cannot be reached")
    return number


def run(client, place, failures, error=StoreFailed):
    tasks = iter([Task(reach_store, 7, (failures, error))])
    return [
        receipt
        for _, receipt in Driver(client).run_tasks((str(place), "digest"), lambda: next(tasks, None), threading.Event())
    ]


def test_a_tile_whose_worker_could_not_reach_the_store_is_tried_once_more(client, tmp_path):
    assert run(client, tmp_path / "once", 1) == [7]
    with pytest.raises(StoreFailed, match="twice cannot be reached"):
        run(client, tmp_path / "twice", 2)
    with pytest.raises(StoreConflict):
        run(client, tmp_path / "other", 1, StoreConflict)
    assert [len((tmp_path / name).read_text()) for name in ("once", "twice", "other")] == [2, 2, 1]


def test_a_task_that_was_cancelled_while_its_driver_waits_is_submitted_again(client, tmp_path):
    assert run(client, tmp_path / "place", 1, JobCancelled) == [7]
    with pytest.raises(TileFailed, match="reach_store 7 failed 4 times; the last time: JobCancelled"):
        run(client, tmp_path / "never", 4, JobCancelled)


@pytest.mark.parametrize("lost", [KilledWorker("reach_store", None, 1), CancelledError("reach_store")], ids=repr)
def test_a_receipt_that_died_with_its_worker_is_computed_again(client, tmp_path, monkeypatch, lost):
    result, refused = Future.result, []

    def once_refused(future, *arguments):
        if not refused:
            refused.append(future.key)
            raise lost
        return result(future, *arguments)

    def never_gathered(client, futures):
        raise lost

    monkeypatch.setattr(Future, "result", once_refused)
    monkeypatch.setattr(Client, "gather", never_gathered)
    assert run(client, tmp_path / "place", 0) == [7]
    assert refused[0].endswith("-a1") and len((tmp_path / "place").read_text()) == 2


def test_tasks_that_end_together_are_gathered_together(client, tmp_path, monkeypatch):
    gather, sizes = Client.gather, []

    def counted(client, futures):
        while not sizes and any(state.status == "pending" for state in client.futures.values()):
            time.sleep(0.01)  # the first is gathered when all of its window have ended
        sizes.append(len(futures))
        return gather(client, futures)

    monkeypatch.setattr(Client, "gather", counted)
    monkeypatch.setattr(Driver, "window_size", 64)
    tasks = iter([Task(reach_store, number, (0, StoreFailed)) for number in range(200)])
    address = str(tmp_path / "place"), "digest"
    done = Driver(client).run_tasks(address, lambda: next(tasks, None), threading.Event())
    assert sorted(receipt for _, receipt in done) == list(range(200))
    assert sum(sizes) <= 200 and max(sizes) > 16


class NoCluster:
    """A client that keeps how many tasks each call has, and ends none."""

    def __init__(self, threads):
        self.threads, self.sizes = threads, []

    def nthreads(self):
        return {"worker": self.threads}

    def map(self, function, calls, key, pure):
        self.sizes += [len(call.tasks) for call in calls]
        return [Mock() for _ in calls]


def window_of(threads, tasks, seconds=None):
    """A window that is filled from so many tasks, which took some seconds before."""
    driver = Driver(NoCluster(threads))
    if seconds is not None:
        driver.timed(reach_store, seconds)
    queue = iter([Task(reach_store, number) for number in range(tasks)])
    return _Window(driver, ("place", "digest")), lambda: next(queue, None)


@pytest.mark.parametrize(
    ("threads", "seconds", "most"),
    [
        (2, None, 1),
        (1000, None, 1),
        (2, 0.25, 1),
        (2, 0.01, 10),
        (100, 0.25, 4),
        (1000, 0.25, 40),
        pytest.param(10_000, 0.25, 40, marks=pytest.mark.slow),
    ],
)
def test_threads_end_a_hundred_calls_a_second_none_longer_than_ten(threads, seconds, most):
    window, next_task = window_of(threads, 3 * 2 * threads * most, seconds)
    window.fill(next_task)
    sizes = window.client.sizes
    assert len(sizes) == 2 * threads and sizes[0] == most


def test_calls_become_shorter_as_tasks_run_out():
    window, next_task = window_of(1000, 5000, 0.25)
    window.fill(next_task)
    sizes = window.client.sizes
    assert sizes[0] == 2 and sizes[-1] == 1 and len(sizes) == 2000
    assert len(window.waiting) == 5000 - sum(sizes)


def fail_at_three(location, digest, number):
    """Fail the first time at the number 3; write down who was asked."""
    asked = Path(location).read_text().split() if Path(location).exists() else []
    with Path(location).open("a") as told:
        told.write(f"{number} ")
    if number == 3 and asked.count("3") == 0:
        raise OSError("3 is unlucky")
    return number


def test_what_a_task_took_is_known_afterwards(client, tmp_path):
    """Calls of one task each become calls of many, where tasks end soon."""
    driver, place = Driver(client), tmp_path / "place"
    tasks = iter([Task(reach_store, number, (0, StoreFailed)) for number in range(3)])
    begun = time.perf_counter()
    assert len(list(driver.run_tasks((str(place), "digest"), lambda: next(tasks, None), threading.Event()))) == 3
    took = driver._seconds
    assert list(took) == [reach_store] and 0.0 < took[reach_store] < time.perf_counter() - begun


def test_tasks_of_a_call_that_failed_are_tried_alone(client, tmp_path):
    driver, again = Driver(client, lambda: again.append(1)), []
    driver.timed(fail_at_three, 1e-4)
    tasks = iter([Task(fail_at_three, number) for number in range(24)])
    done = driver.run_tasks((str(tmp_path / "asked"), "digest"), lambda: next(tasks, None), threading.Event())
    assert sorted(receipt for _, receipt in done) == list(range(24))
    assert 1 < len(again) < 24


def always_fail(location, digest, number):
    """Write down that it was tried, and fail."""
    with Path(location).open("a") as tried:
        tried.write(".")
    raise OSError("out of luck")


def test_a_task_that_keeps_failing_is_tried_four_times(tmp_path):
    again, tasks = [], iter([Task(always_fail, 7)])
    with threads_here(1) as threads:
        driver = Driver(threads, lambda: again.append(1))
        with pytest.raises(TileFailed, match="always_fail 7 failed 4 times; the last time: OSError: out of luck"):
            list(driver.run_tasks((str(tmp_path / "tried"), "digest"), lambda: next(tasks, None), threading.Event()))
    assert len((tmp_path / "tried").read_text()) == 4 and len(again) == 3


def wait_for_ever(location, digest, number):
    """Leave when cancelled."""
    Path(location, f"began-{number}").touch()
    try:
        while True:
            stop_if_cancelled()
            time.sleep(0.01)
    finally:
        Path(location, f"left-{number}").touch()


def test_after_a_cancellation_scheduler_and_workers_hold_nothing_of_the_job(client, tmp_path):
    driver, cancel, scheduler = Driver(client), threading.Event(), client.cluster.scheduler
    numbers, held = iter(range(100)), []

    def cancel_when_both_have_begun():
        while len(list(tmp_path.glob("began-*"))) < 2:
            time.sleep(0.01)
        held.append(len(scheduler.tasks))
        cancel.set()

    threading.Thread(target=cancel_when_both_have_begun, daemon=True).start()
    with pytest.raises(JobCancelled):
        list(driver.run_tasks((str(tmp_path), "digest"), lambda: Task(wait_for_ever, next(numbers)), cancel))
    # Two run, two wait: a window is twice the threads.
    assert held == [4] and next(numbers) == 4
    # Nothing but the cancellation ends them.
    patience = time.monotonic() + 60.0
    while (scheduler.tasks or len(list(tmp_path.glob("left-*"))) < 2) and time.monotonic() < patience:
        time.sleep(0.01)
    assert not scheduler.tasks and not any(each.processing for each in scheduler.workers.values())
    assert {each.name for each in tmp_path.iterdir()} == {"began-0", "began-1", "left-0", "left-1"}
    # Nor does the driver count the job any longer.
    assert driver.share(4) == 4


def wait_unless_first(location, digest, number):
    """End at once on either of two workers; leave when cancelled on the next call there."""
    if number > 1:
        wait_for_ever(location, digest, number)


def test_a_call_that_follows_another_on_its_worker_leaves_when_cancelled(client, tmp_path):
    cancel, numbers = threading.Event(), iter(range(4))

    def seen(what):
        patience = time.monotonic() + 60.0
        while len(list(tmp_path.glob(f"{what}-*"))) < 2 and time.monotonic() < patience:
            time.sleep(0.01)
        return {each.name for each in tmp_path.glob(f"{what}-*")}

    def next_task():
        number = next(numbers, None)
        return None if number is None else Task(wait_unless_first, number)

    threading.Thread(target=lambda: (seen("began"), cancel.set()), daemon=True).start()
    with pytest.raises(JobCancelled):
        list(Driver(client).run_tasks((str(tmp_path), "digest"), next_task, cancel))
    assert seen("began") == {"began-2", "began-3"}
    assert seen("left") == {"left-2", "left-3"}


@pytest.mark.parametrize(("saturation", "failures", "lines"), [(1.0, 1, 0), (1.1, 1, 1), (float("inf"), 3, 2)])
def test_a_scheduler_with_other_settings_is_warned_of(saturation, failures, lines, caplog):
    settings = {
        "distributed.scheduler.worker-saturation": saturation, "distributed.scheduler.allowed-failures": failures,
    }  # fmt: skip

    class Far:
        def run_on_scheduler(self, function, name):
            return settings[name]

    with caplog.at_level(logging.WARNING, "rattle.cluster"):
        _warn_of_settings(Far(), "tls://far:8786")
    # Dask's own lines arrive here, too, whenever an earlier test's client ends.
    lines_logged = [record.getMessage() for record in caplog.records if record.name == "rattle.cluster"]
    assert len(lines_logged) == lines
    assert all("tls://far:8786" in line and "DASK_DISTRIBUTED__SCHEDULER__" in line for line in lines_logged)


def test_jobs_that_run_at_the_same_time_share_the_window():
    driver = Driver(None)
    assert driver.share(4) == 4
    driver.add_jobs(2)
    assert driver.share(4) == 2
    driver.add_jobs(3)
    assert driver.share(4) == 1


def test_what_comes_next_stays_with_the_driver(client, tmp_path):
    taken, lock = [], threading.Lock()  # a lock cannot be pickled
    tasks = iter([Task(reach_store, 7, (0, StoreFailed), then=lambda *receipt: taken.append((lock, *receipt)) or ())])
    done = Driver(client).run_tasks((str(tmp_path / "x"), "digest"), lambda: next(tasks, None), threading.Event())
    for task, receipt in done:
        assert not list(task.then(task.number, receipt))
    assert taken == [(lock, 7, 7)]
