"""Runs many small tasks on a cluster with a small window in flight.

Why not one ``client.map``: with every future held, each killed worker made the scheduler compute again what was on disk
already, and marked innocent tiles as killers. So: about two tasks a thread are in flight; a future is released as soon
as its receipt is here; a lost task is submitted again under a new key (a known key would be answered with its old,
cancelled future); and after a few failures of its own a task fails the job.

Jobs that run on one client at the same time share its window: the scheduler takes tasks in the order in which they were
submitted, so each job gets its turn, and one that has just begun waits for a few tasks of the others at the most.
"""

import logging
import threading
import time
import uuid
from collections.abc import Callable, Generator
from typing import Any
from weakref import WeakKeyDictionary

from distributed import CancelledError, Client, Future, wait

from rattle_kernels import fuses_multiply_add
from worker.cluster.computed_alike import compute_alike
from worker.cluster.task import Task
from worker.errors import ClusterFailed, JobCancelled, StoreFailed, TileFailed, WorkerError

_log = logging.getLogger("rattle.driver")
_TRIES = 4
# A worker may be cut off from the store alone, or for a while; a disk that is full stays so.
_STORE_TRIES = 2
_POLL_SECONDS = 0.2
# On a busy machine a worker that was killed is back after a minute.
_NO_WORKER_SECONDS = 180.0
_TASKS_A_THREAD = 2
_LOST = "the connection to the scheduler is lost; submit again when it is back"


def _threads(client: Client) -> int:
    try:
        return sum(client.nthreads().values())
    except Exception as error:
        raise ClusterFailed(f"the scheduler cannot be reached: {error}") from error


def window_size(client: Client) -> int:
    """How many tasks of all jobs are in flight at the most."""
    return _TASKS_A_THREAD * max(1, _threads(client))


class _Windows:
    """How many jobs share each client."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._open: WeakKeyDictionary[Client, int] = WeakKeyDictionary()

    def add(self, client: Client, more: int) -> None:
        with self._lock:
            self._open[client] = self._open.get(client, 0) + more

    def share(self, client: Client, size: int) -> int:
        """Part of a window of some size that each job has."""
        return max(1, -(-size // max(1, self._open.get(client, 1))))


_windows = _Windows()


class _Retries:
    """How many tasks this process has submitted again."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self.total = 0

    def add(self) -> None:
        with self._lock:
            self.total += 1


_retries = _Retries()


def tasks_retried() -> int:
    """How many tasks this process has submitted again after they were lost."""
    return _retries.total


def _outcome(future: Future) -> tuple[bool, Any]:
    """Whether a task that has ended left a receipt, and that one; else its error, None where its worker was lost."""
    if future.status == "finished":
        try:
            return True, future.result()
        except Exception as error:  # its worker was killed before it could hand the receipt over
            return False, error
    return False, future.exception() if future.status == "error" else None


class _Window:
    """Tasks in flight: which task each future is, and how often that was tried."""

    def __init__(self, client: Client, address: tuple[str, str]) -> None:
        self.client, self.address = client, address
        self.size = window_size(client)
        self.run = uuid.uuid4().hex[:12]
        self.submitted = 0
        self.task_of: dict[Future, tuple[Task, int]] = {}
        _windows.add(client, 1)

    @property
    def full(self) -> bool:
        return len(self.task_of) >= _windows.share(self.client, self.size)

    def submit(self, task: Task, attempt: int = 1) -> None:
        self.submitted += 1
        key = f"{task.function.__name__}-{self.run}-{task.number}-{self.submitted}-a{attempt}"
        call = fuses_multiply_add(), task.function, *self.address, task.number, *task.arguments
        self.task_of[self.client.submit(compute_alike, *call, key=key, pure=False)] = task, attempt

    def take(self, future: Future) -> tuple[Task, Any] | None:
        """A finished task and its receipt, its future released at once; None where it was submitted again."""
        task, attempt = self.task_of.pop(future)
        finished, receipt_or_error = _outcome(future)
        future.release()
        if finished:
            return task, receipt_or_error
        error = receipt_or_error
        if isinstance(error, WorkerError) and not (isinstance(error, StoreFailed) and attempt < _STORE_TRIES):
            raise error
        if attempt >= _TRIES:
            reason = f"{type(error).__name__}: {error}" if error else "its worker was lost"
            what = task.name or f"{task.function.__name__} {task.number} of basin {task.basin}"
            raise TileFailed(f"{what} failed {_TRIES} times; the last time: {reason}") from error
        _log.warning("%s %d of basin %d is tried again", task.function.__name__, task.number, task.basin)
        _retries.add()
        self.submit(task, attempt + 1)
        return None

    def wait(self) -> set[Future]:
        """Futures that have ended, none where none does within a fifth of a second."""
        try:
            with self.client.as_current():
                done: set[Future] = wait(list(self.task_of), timeout=_POLL_SECONDS, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            return set()
        except CancelledError as error:  # by nobody here: the scheduler that knew them is gone
            raise ClusterFailed(_LOST) from error
        return done

    def close(self) -> None:
        """Cancel what is in flight."""
        _windows.add(self.client, -1)
        if self.client.status == "running":
            self.client.cancel(list(self.task_of), force=True)
        self.task_of.clear()


def run_tasks(
    client: Client, address: tuple[str, str], following: Callable[[], Task | None], cancel: threading.Event
) -> Generator[tuple[Task, Any], None, None]:
    """Yield each task with its receipt as it completes.

    Parameters
    ----------
    client : distributed.Client
    address : (str, str)
        What tasks find the store by: its location, and the digest of the job they expect there.
    following : callable
        The next task; None where there is none until another one has completed, or at all.
    cancel : threading.Event
        Set by whoever wants the work to stop.

    Raises
    ------
    JobCancelled, TileFailed, ClusterFailed, or the WorkerError of a task
        Whatever is still in flight has been cancelled then.
    """
    window = _Window(client, address)
    last_seen = time.monotonic()
    try:
        while True:
            if cancel.is_set():
                raise JobCancelled("cancelled on request")
            while not window.full and (task := following()) is not None:
                window.submit(task)
            if not window.task_of:
                return
            done = window.wait()
            last_seen = time.monotonic() if done else _check_workers(client, last_seen)
            for future in done:
                taken = window.take(future)
                if taken is not None:
                    yield taken
    finally:
        window.close()


def _check_workers(client: Client, last_seen: float) -> float:
    """Time at which a worker was last known; fails when there has been none for a minute."""
    if client.status in ("closed", "closing", "connecting"):
        raise ClusterFailed(_LOST)
    if _threads(client) > 0:
        return time.monotonic()
    if time.monotonic() - last_seen > _NO_WORKER_SECONDS:
        raise ClusterFailed(f"no worker has been there for {_NO_WORKER_SECONDS:.0f} s")
    return last_seen
