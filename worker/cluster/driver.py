"""Runs many small tasks on a cluster, a few at a time.

A single ``client.map`` over all tasks does not work. It holds every future, so each killed worker made the scheduler
recompute results that were on disk already, and blame innocent tiles for killing workers. Instead, about two tasks per
thread are in flight. A future is released as soon as its receipt has arrived. On large clusters tasks that end together
are gathered in one message, and submitted in one: one by one they took five times as long. A lost task is submitted
again under a new key, because Dask would return the old, cancelled future for a known key. A task that fails a few
times by itself fails the job.

Jobs that run at the same time share one driver, and so its window. The scheduler takes tasks in the order in which they
were submitted. So each job gets its turn, and a job that has just begun waits for at most a few tasks of the others.
"""

import logging
import queue
import threading
import time
import uuid
from collections.abc import Callable, Generator, Sequence
from typing import Any, NamedTuple

from distributed import Client, Future

from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from worker.cluster.computed_alike import compute_alike
from worker.cluster.task import Task
from worker.errors import ClusterFailed, JobCancelled, StoreFailed, TileFailed, WorkerError

_log = logging.getLogger("rattle.driver")
_TRIES = 4
# One worker may be cut off from the store, or all of them for a while. A full disk stays full.
_STORE_TRIES = 2
_POLL_SECONDS = 0.2
# Where more tasks than a few are in flight, those that end this soon after another are taken with it.
_TOGETHER_SECONDS = 0.02
_FEW = 16
# On a busy machine a killed worker is back after a minute.
_NO_WORKER_SECONDS = 180.0
_TASKS_A_THREAD = 2
_LOST = "the connection to the scheduler is lost; submit again when it is back"


def _threads(client: Client) -> int:
    try:
        return sum(client.nthreads().values())
    except Exception as error:
        raise ClusterFailed(f"the scheduler cannot be reached: {error}") from error


class Driver:
    """Runs the tasks of jobs on a cluster. Jobs may run at the same time, each in its own thread.

    Parameters
    ----------
    client : distributed.Client
    retried : callable
        Called whenever a lost task is submitted again.
    """

    def __init__(self, client: Client, retried: Callable[[], None] = lambda: None) -> None:
        self.client, self.retried = client, retried
        self._lock = threading.Lock()
        self._jobs = 0

    @property
    def window_size(self) -> int:
        """Largest number of tasks in flight, of all jobs together."""
        return _TASKS_A_THREAD * max(1, _threads(self.client))

    def share(self, size: int) -> int:
        """Each job's part of a window of this size."""
        return max(1, -(-size // max(1, self._jobs)))

    def add_jobs(self, more: int) -> None:
        """Change how many jobs share the window."""
        with self._lock:
            self._jobs += more

    def run_tasks(
        self, address: tuple[str, str], next_task: Callable[[], Task | None], cancel: threading.Event
    ) -> Generator[tuple[Task, Any], None, None]:
        """Run the tasks of one job, and yield each with its receipt as it completes.

        Parameters
        ----------
        address : (str, str)
            Location of the store, and digest of the job that tasks expect there.
        next_task : callable
            Returns the next task. None means that there is none, at least until another one has completed.
        cancel : threading.Event
            Set it to stop the work.

        Yields
        ------
        Task, Any
            A completed task, and what its function returned.

        Raises
        ------
        JobCancelled, TileFailed, ClusterFailed, or the WorkerError of a task
            Tasks still in flight have then been cancelled.
        """
        window = _Window(self, address)
        last_seen = time.monotonic()
        try:
            while True:
                if cancel.is_set():
                    raise JobCancelled("cancelled on request")
                window.fill(next_task)
                if not window.task_of:
                    return
                done = window.wait()
                last_seen = time.monotonic() if done else _check_workers(self.client, last_seen)
                yield from window.take(done)
        finally:
            window.close()


def _receipt(future: Future) -> Any:
    """Receipt of an ended task, or the error it ended with; None if its worker was lost."""
    if future.status == "finished":
        try:
            return _Receipt(future.result())
        except Exception as error:  # its worker was killed before it could hand the receipt over
            return error
    return future.exception() if future.status == "error" else None


class _Receipt(NamedTuple):
    """What a task returned."""

    value: Any


class _Window:
    """A job's tasks in flight: the task of each future, and how often it was tried."""

    def __init__(self, driver: Driver, address: tuple[str, str]) -> None:
        self.driver, self.client, self.address = driver, driver.client, address
        self.size = driver.window_size
        self.run = uuid.uuid4().hex[:12]
        self.submitted = 0
        self.task_of: dict[Future, tuple[Task, int]] = {}
        self.ended: queue.SimpleQueue[Future] = queue.SimpleQueue()
        driver.add_jobs(1)

    def fill(self, next_task: Callable[[], Task | None]) -> None:
        """Submit tasks until the job's share of the window is in flight, or there is no task."""
        tasks: list[tuple[Task, int]] = []
        share = self.driver.share(self.size)
        while len(self.task_of) + len(tasks) < share and (task := next_task()) is not None:
            tasks.append((task, 1))
        self.submit(tasks)

    def submit(self, tasks: Sequence[tuple[Task, int]]) -> None:
        """Submit tasks, each with the number of the attempt."""
        if not tasks:
            return
        keys, calls = [], []
        for task, attempt in tasks:
            self.submitted += 1
            keys.append(f"{task.function.__name__}-{self.run}-{task.number}-{self.submitted}-a{attempt}")
            calls.append((fuses_multiply_add(), task.function, *self.address, task.number, *task.arguments))
        for future, each in zip(self.client.map(compute_alike, calls, key=keys, pure=False), tasks, strict=True):
            self.task_of[future] = each
            future.add_done_callback(self.ended.put)

    def wait(self) -> list[Future]:
        """Futures that have ended; none if none ends within a fifth of a second."""
        try:
            ended = [self.ended.get(timeout=_POLL_SECONDS)]
        except queue.Empty:
            return []
        if len(self.task_of) > _FEW:
            time.sleep(_TOGETHER_SECONDS)
        while not self.ended.empty():
            ended.append(self.ended.get())
        if any(future.cancelled() for future in ended):  # not by this driver: the scheduler that knew them is gone
            raise ClusterFailed(_LOST)
        return ended

    def take(self, ended: Sequence[Future]) -> list[tuple[Task, Any]]:
        """Finished tasks and their receipts; lost ones are submitted again. Their futures are released at once."""
        receipts, again, taken = self._receipts(ended), [], []
        for future, receipt in zip(ended, receipts, strict=True):
            task, attempt = self.task_of.pop(future)
            future.release()
            if isinstance(receipt, _Receipt):
                taken.append((task, receipt.value))
            else:
                _demand_another_try(task, attempt, receipt)
                self.driver.retried()
                again.append((task, attempt + 1))
        self.submit(again)
        return taken

    def _receipts(self, ended: Sequence[Future]) -> list[Any]:
        """What each ended task left (`_receipt`); of those that finished in one message."""
        if all(future.status == "finished" for future in ended):
            try:
                return [_Receipt(value) for value in self.client.gather(list(ended))]
            except Exception:  # a worker was killed before it could hand its receipts over: one by one
                pass
        return [_receipt(future) for future in ended]

    def close(self) -> None:
        """Cancel what is in flight."""
        self.driver.add_jobs(-1)
        if self.client.status == "running":
            self.client.cancel(list(self.task_of), force=True)
        self.task_of.clear()


def _demand_another_try(task: Task, attempt: int, error: Exception | None) -> None:
    """Raise what ends the job after this attempt, if it is not worth another."""
    if isinstance(error, WorkerError) and not (isinstance(error, StoreFailed) and attempt < _STORE_TRIES):
        raise error
    if attempt >= _TRIES:
        reason = f"{type(error).__name__}: {error}" if error else "its worker was lost"
        raise TileFailed(f"{task} failed {_TRIES} times; the last time: {reason}") from error
    _log.warning("%s is tried again", task)


def _check_workers(client: Client, last_seen: float) -> float:
    """Time at which a worker was last known. Fails if there has been none for `_NO_WORKER_SECONDS`."""
    if client.status in ("closed", "closing", "connecting"):
        raise ClusterFailed(_LOST)
    if _threads(client) > 0:
        return time.monotonic()
    if time.monotonic() - last_seen > _NO_WORKER_SECONDS:
        raise ClusterFailed(f"no worker has been there for {_NO_WORKER_SECONDS:.0f} s")
    return last_seen
