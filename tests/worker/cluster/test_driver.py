"""Tasks that fail are tried again or fail the job; a scheduler with other settings is warned of."""

import logging
import threading
import time
from pathlib import Path

import pytest
from distributed import CancelledError, Client, Future
from distributed.scheduler import KilledWorker

from worker.cluster.connection import _warn_of_settings
from worker.cluster.driver import Driver
from worker.cluster.task import Task
from worker.errors import StoreConflict, StoreFailed


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
    assert sum(sizes) == 200 and max(sizes) > 16


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
