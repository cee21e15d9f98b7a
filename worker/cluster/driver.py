"""Runs many small tasks on a cluster, a few calls at a time.

A single ``client.map`` over all tasks does not work. It holds every future, so each killed worker made the scheduler
recompute results that were on disk already, and blame innocent tiles for killing workers. Instead, about two calls per
thread are in flight. A future is released as soon as its receipt has arrived. On large clusters tasks that end together
are gathered in one message, and submitted in one: one by one they took five times as long. A lost task is submitted
again under a new key, because Dask would return the old, cancelled future for a known key. A task that fails a few
times by itself fails the job.

Driver and scheduler handle some hundreds of futures a second. So a future is a call of several tasks where tasks are
short for the number of threads: `_Window._next_call`. Stores do not change, as a tile stays a tile.

Jobs that run at the same time share one driver, and so its window. The scheduler takes tasks in the order in which they
were submitted. So each job gets its turn, and a job that has just begun waits for at most a few tasks of the others.
"""

import logging
import queue
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Generator, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from worker.cluster.calls import Call, Compiling, Receipts, Task, run_call
from worker.errors import ClusterFailed, JobCancelled, StoreFailed, TileFailed, WorkerError

if TYPE_CHECKING:
    from distributed import Client, Future

    from worker.cluster.threads import Threads

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
_CALLS_A_THREAD = 2
# Some 0.4 cores, measured with tasks that only wait (`benchmarks.waiting_workers`).
_CALLS_A_SECOND = 100
# A first picture waits for the shortest call at most. A killed worker loses the longest at most; so long wait others.
_SHORTEST_CALL_SECONDS, _LONGEST_CALL_SECONDS = 0.1, 10.0
_LOST = "the connection to the scheduler is lost; submit again when it is back"


def _threads(client: "Client | Threads") -> int:
    try:
        return sum(client.nthreads().values())
    except Exception as error:
        raise ClusterFailed(f"the scheduler cannot be reached: {error}") from error


class Driver:
    """Runs the tasks of jobs on a cluster. Jobs may run at the same time, each in its own thread.

    Parameters
    ----------
    client : distributed.Client or Threads
    retried : callable
        Called whenever a lost task is submitted again.
    """

    def __init__(self, client: "Client | Threads", retried: Callable[[], None] = lambda: None) -> None:
        self.client, self.retried = client, retried
        self._lock = threading.Lock()
        self._jobs = 0
        self._seconds: dict[Callable[..., Any], float] = {}
        self._compiling = Compiling(client)

    @property
    def window_size(self) -> int:
        """Largest number of calls in flight, of all jobs together."""
        return _CALLS_A_THREAD * max(1, _threads(self.client))

    def timed(self, function: Callable[..., Any], seconds: float) -> None:
        """Take note of what a task of a function took."""
        with self._lock:
            self._seconds[function] = 0.8 * self._seconds.get(function, seconds) + 0.2 * seconds

    def tasks_a_call(self, function: Callable[..., Any], window_size: int) -> int:
        """Tasks of a function that make a call, so that all threads together end some hundred calls a second."""
        seconds = self._seconds.get(function)
        if seconds is None:
            return 1
        call = window_size / _CALLS_A_THREAD / _CALLS_A_SECOND
        call = min(max(call, _SHORTEST_CALL_SECONDS), _LONGEST_CALL_SECONDS)
        return max(1, round(call / max(seconds, 1e-4)))

    def share(self, size: int) -> int:
        """Each job's part of a window of this size."""
        return max(1, -(-size // max(1, self._jobs)))

    def add_jobs(self, more: int) -> None:
        """Change how many jobs share the window."""
        with self._lock:
            self._jobs += more

    def run_tasks(
        self,
        address: tuple[str, str],
        next_task: Callable[[], Task | None],
        cancel: threading.Event,
        within: Callable[[], AbstractContextManager[None]] = nullcontext,
        compiling: Callable[[], None] = lambda: None,
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
        within : callable
            Makes the context that a worker runs the tasks of a call in. When it has been left, receipts are sent.
        compiling : callable
            Called while nothing has completed since a worker began to compile kernels for the job.

        Yields
        ------
        Task, Any
            A completed task, and what its function returned.

        Raises
        ------
        JobCancelled, TileFailed, ClusterFailed, or the WorkerError of a task
            Tasks still in flight have then been cancelled.
        """
        self._compiling.listen()
        window = _Window(self, address, within)
        last_seen = time.monotonic()
        try:
            while True:
                if cancel.is_set():
                    raise JobCancelled("cancelled on request")
                window.fill(next_task)
                if not window.calls:
                    return
                done = window.wait()
                last_seen = time.monotonic() if done else _check_workers(self.client, last_seen)
                if self._compiling.has_begun(address) and not done:
                    compiling()
                yield from window.take(done)
        finally:
            window.close()


def _receipts_of(future: "Future") -> Receipts | Exception | None:
    """Receipts of an ended call, or the error it ended with; None if its worker was lost."""
    if future.status == "finished":
        try:
            return cast(Receipts, future.result())
        except Exception as error:  # its worker was killed before it could hand the receipts over
            return error
    return cast(Exception, future.exception()) if future.status == "error" else None


class _Sent(NamedTuple):
    """Tasks of one function that travel together, and how often they were tried."""

    tasks: Sequence[Task]
    attempt: int


class _Window:
    """A job's calls in flight: the tasks of each future; and tasks that wait to join a call."""

    def __init__(
        self,
        driver: Driver,
        address: tuple[str, str],
        within: Callable[[], AbstractContextManager[None]] = nullcontext,
    ) -> None:
        self.driver, self.client, self.address, self.within = driver, driver.client, address, within
        self.size = driver.window_size
        self.run = uuid.uuid4().hex[:12]
        self.submitted = 0
        self.calls: dict[Future, _Sent] = {}
        self.waiting: deque[Task] = deque()
        self.ended: queue.SimpleQueue[Future] = queue.SimpleQueue()
        driver.add_jobs(1)

    def fill(self, next_task: Callable[[], Task | None]) -> None:
        """Submit calls until the job's share of the window is in flight, or there is no task."""
        share = self.driver.share(self.size)
        calls: list[_Sent] = []
        while len(self.calls) + len(calls) < share and (tasks := self._next_call(next_task, share)):
            calls.append(_Sent(tasks, 1))
        self.submit(calls)

    def _next_call(self, next_task: Callable[[], Task | None], share: int) -> list[Task]:
        """Tasks of the next call. Calls become shorter as tasks run out, so that all threads end together."""
        ahead = 1
        while len(self.waiting) < ahead and (task := next_task()) is not None:
            self.waiting.append(task)
            most = self.driver.tasks_a_call(task.function, self.size)
            ahead = most * share if most > 1 else 1
        if not self.waiting:
            return []
        function = self.waiting[0].function
        most = min(self.driver.tasks_a_call(function, self.size), max(1, len(self.waiting) // share))
        tasks = [self.waiting.popleft()]
        while self.waiting and len(tasks) < most and self.waiting[0].function is function:
            tasks.append(self.waiting.popleft())
        return tasks

    def submit(self, calls: Sequence[_Sent]) -> None:
        """Submit calls, in one message."""
        if not calls:
            return
        keys, arguments = [], []
        for tasks, attempt in calls:
            self.submitted += 1
            first = tasks[0]
            keys.append(f"{first.function.__name__}-{self.run}-{first.number}-{self.submitted}-a{attempt}")
            own = [(task.number, *task.arguments) for task in tasks]
            arguments.append(Call(first.function, *self.address, own, self.within))
        futures = self.client.map(run_call, arguments, key=keys, pure=False)
        for future, each in zip(futures, calls, strict=True):
            self.calls[future] = each
            future.add_done_callback(self.ended.put)

    def wait(self) -> "list[Future]":
        """Futures that have ended; none if none ends within a fifth of a second."""
        try:
            ended = [self.ended.get(timeout=_POLL_SECONDS)]
        except queue.Empty:
            return []
        if len(self.calls) > _FEW:
            time.sleep(_TOGETHER_SECONDS)
        while not self.ended.empty():
            ended.append(self.ended.get())
        if any(future.cancelled() for future in ended):  # not by this driver: the scheduler that knew them is gone
            raise ClusterFailed(_LOST)
        return ended

    def take(self, ended: "Sequence[Future]") -> list[tuple[Task, Any]]:
        """Finished tasks and their receipts; lost ones are submitted again. Their futures are released at once."""
        taken: list[tuple[Task, Any]] = []
        again = []
        for future, receipt in zip(ended, self._receipts(ended), strict=True):
            tasks, attempt = self.calls.pop(future)
            future.release()
            if isinstance(receipt, Receipts):
                self.driver.timed(tasks[0].function, receipt.seconds / len(tasks))
                taken += zip(tasks, receipt.values, strict=True)
                continue
            # Alone, so that only the guilty one fails again.
            for task in tasks:
                _demand_another_try(task, attempt, receipt)
                self.driver.retried()
                again.append(_Sent([task], attempt + 1))
        self.submit(again)
        return taken

    def _receipts(self, ended: "Sequence[Future]") -> list[Receipts | Exception | None]:
        """What each ended call left (`_receipts_of`); of those that finished in one message."""
        if all(future.status == "finished" for future in ended):
            try:
                return list(self.client.gather(list(ended)))
            except Exception:  # a worker was killed before it could hand its receipts over: one by one
                pass
        return [_receipts_of(future) for future in ended]

    def close(self) -> None:
        """Cancel what is in flight."""
        self.driver.add_jobs(-1)
        if self.client.status == "running":
            self.client.cancel(list(self.calls), force=True)
        self.calls.clear()


def _demand_another_try(task: Task, attempt: int, error: Exception | None) -> None:
    """Raise what ends the job after this attempt, if it is not worth another.

    A task may say that it was cancelled though its driver, which waits for it, has not cancelled it. It counts as lost.
    """
    lost = isinstance(error, JobCancelled) or (isinstance(error, StoreFailed) and attempt < _STORE_TRIES)
    if isinstance(error, WorkerError) and not lost:
        raise error
    if attempt >= _TRIES:
        reason = f"{type(error).__name__}: {error}" if error else "its worker was lost"
        raise TileFailed(f"{task} failed {_TRIES} times; the last time: {reason}") from error
    _log.warning("%s is tried again", task)


def _check_workers(client: "Client | Threads", last_seen: float) -> float:
    """Time at which a worker was last known. Fails if there has been none for `_NO_WORKER_SECONDS`."""
    if client.status in ("closed", "closing", "connecting"):
        raise ClusterFailed(_LOST)
    if _threads(client) > 0:
        return time.monotonic()
    if time.monotonic() - last_seen > _NO_WORKER_SECONDS:
        raise ClusterFailed(f"no worker has been there for {_NO_WORKER_SECONDS:.0f} s")
    return last_seen
