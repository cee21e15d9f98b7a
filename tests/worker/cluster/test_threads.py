"""Threads in place of a cluster: calls follow one another, leave when cancelled, and end soon in any case."""

import contextlib
import threading
import time

import pytest

from worker.cluster.calls import Task, stop_if_cancelled
from worker.cluster.driver import Driver
from worker.cluster.threads import Threads, threads_here
from worker.errors import JobCancelled

_WAIT_SECONDS = 30.0


def run(driver, function, numbers, **options):
    """Receipts of tasks with these numbers, in the order in which they end."""
    tasks = iter([Task(function, number) for number in numbers])
    ended = driver.run_tasks(("store", "digest"), lambda: next(tasks, None), threading.Event(), **options)
    return [receipt for _, receipt in ended]


def ask(threads, function):
    """The future of one call without an argument."""
    return threads.map(lambda _: function(), [None], key=None, pure=False)[0]


def until_cancelled(begun, left):
    begun.set()
    try:
        while True:
            stop_if_cancelled()
            time.sleep(0.01)
    except JobCancelled:
        left.set()
        raise


def test_a_thread_that_compiles_does_not_hide_an_error_and_leaves_its_task_afterwards():
    begun, compiled, left = threading.Event(), threading.Event(), threading.Event()

    def compile_and_go_on():
        begun.set()
        compiled.wait()
        until_cancelled(begun, left)

    with pytest.raises(ZeroDivisionError), threads_here(2) as threads:
        compiling = ask(threads, compile_and_go_on)
        assert begun.wait(_WAIT_SECONDS)
        assert not compiling.done()
        failed = ask(threads, lambda: 1 // 0)
        with pytest.raises(ZeroDivisionError):
            failed.result(_WAIT_SECONDS)
        assert failed.status == "error" and compiling.status == "pending"
        raise failed.exception()
    assert threads.status == "closed"
    compiled.set()
    assert left.wait(_WAIT_SECONDS)


def test_at_the_end_calls_leave_and_those_that_wait_never_begin():
    before, begun, left, later = threading.active_count(), threading.Event(), threading.Event(), []
    with threads_here(1) as threads:
        running = ask(threads, lambda: until_cancelled(begun, left))
        waiting = ask(threads, lambda: later.append(1))
        assert begun.wait(_WAIT_SECONDS)
    assert left.is_set() and waiting.status == "cancelled" and not later
    with pytest.raises(JobCancelled):
        running.result(_WAIT_SECONDS)
    patience = time.monotonic() + _WAIT_SECONDS
    while threading.active_count() > before and time.monotonic() < patience:
        time.sleep(0.01)
    assert threading.active_count() <= before


def test_a_call_that_waits_for_the_disk_makes_room_for_the_next():
    written, began = threading.Event(), []

    @contextlib.contextmanager
    def on_the_disk():
        yield
        assert written.wait(_WAIT_SECONDS)

    def take(location, digest, number):
        began.append(number)
        if number == 1:
            written.set()
        return number

    with threads_here(1) as threads:
        assert sorted(run(Driver(threads), take, range(2), within=on_the_disk)) == [0, 1]
    assert began == [0, 1]


def test_no_more_calls_compute_at_once_than_there_are_threads():
    lock, at_once, most = threading.Lock(), [0], [0]

    def count(location, digest, number):
        with lock:
            at_once[0] += 1
            most[0] = max(most[0], at_once[0])
        time.sleep(0.005)
        with lock:
            at_once[0] -= 1

    with threads_here(3) as threads:
        assert threads.nthreads() == {"this process": 3}
        assert len(run(Driver(threads), count, range(60))) == 60
    assert most[0] == 3


def test_what_calls_tell_is_heard_by_whoever_has_asked():
    heard, threads = [], Threads(1)
    threads.log_event("weather", "rain")
    threads.subscribe_topic("weather", lambda event: heard.append(event[1]))
    threads.log_event("weather", "sun")
    threads.log_event("news", "none")
    threads.close()
    assert heard == ["sun"]


def test_after_a_cancellation_those_that_compute_leave_and_nothing_is_held():
    numbers, cancel, left = iter(range(100)), threading.Event(), []
    both = threading.Barrier(3)

    def wait_for_ever(location, digest, number):
        both.wait(_WAIT_SECONDS)
        try:
            until_cancelled(threading.Event(), threading.Event())
        finally:
            left.append(number)

    def cancel_when_both_have_begun():
        both.wait(_WAIT_SECONDS)
        cancel.set()

    threading.Thread(target=cancel_when_both_have_begun, daemon=True).start()
    with threads_here(2) as threads:
        driver = Driver(threads)
        with pytest.raises(JobCancelled):
            list(driver.run_tasks(("store", "digest"), lambda: Task(wait_for_ever, next(numbers)), cancel))
        assert next(numbers) == 4  # two computed, two waited: a window is twice the threads
        patience = time.monotonic() + _WAIT_SECONDS
        while len(left) < 2 and time.monotonic() < patience:
            time.sleep(0.01)
        assert sorted(left) == [0, 1] and driver.share(4) == 4
        assert run(driver, lambda *task: task[2], [7]) == [7]
