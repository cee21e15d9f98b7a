"""Threads of this process that run a driver's calls: what it asks of a Dask client, without Dask.

To load Dask takes longer than a small basin, and threads need no scheduler, no messages and no pickles. A call that has
left its place, since it only waits for the disk, is followed by the next one in another thread, as on Dask's workers.
"""

import concurrent.futures
import contextlib
import queue
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from worker.cluster.calls import Address, Place, place

# Tasks look several times a second whether they are cancelled.
_LEAVE_SECONDS = 1.0


class ThreadFuture(concurrent.futures.Future[Any]):
    """A call, as `distributed.Future` shows it."""

    def __init__(self) -> None:
        super().__init__()
        self.stops = False

    @property
    def status(self) -> str:
        """``pending``, ``cancelled``, ``error`` or ``finished``."""
        if not self.done():
            return "pending"
        if self.cancelled():
            return "cancelled"
        return "error" if self.exception() else "finished"

    def release(self) -> None:
        """Nothing holds what a call has left but the future itself."""


class _InThread(Place):
    def __init__(self, threads: "Threads", future: ThreadFuture) -> None:
        self._threads, self._future, self.left = threads, future, False

    def is_cancelled(self) -> bool:
        return self._future.stops

    def tell(self, topic: str, address: Address) -> None:
        self._threads.log_event(topic, list(address))

    def leave(self) -> None:
        self.left = True
        self._threads.start()


class Threads:
    """Threads that take one call after another.

    Parameters
    ----------
    number : int
        Calls that compute at the same time.
    """

    def __init__(self, number: int) -> None:
        self._number, self.status = number, "running"
        self._calls: queue.SimpleQueue[tuple[ThreadFuture, Callable[..., Any], Any] | None] = queue.SimpleQueue()
        self._handlers: dict[str, Callable[[Any], None]] = {}
        self._executing: set[ThreadFuture] = set()
        for _ in range(number):
            self.start()

    def start(self) -> None:
        """Start one more thread. The process does not wait for it to end."""
        threading.Thread(target=self._work, name="rattle-worker", daemon=True).start()

    def nthreads(self) -> dict[str, int]:
        """How many there are."""
        return {"this process": self._number}

    def map(
        self, function: Callable[[Any], Any], arguments: Iterable[Any], key: object, pure: bool
    ) -> list[ThreadFuture]:
        """Have a function called with each argument, the first one first; ``key`` and ``pure`` mean nothing here."""
        futures = []
        for argument in arguments:
            futures.append(ThreadFuture())
            self._calls.put((futures[-1], function, argument))
        return futures

    def gather(self, futures: Sequence[ThreadFuture]) -> list[Any]:
        """What calls that have finished returned."""
        return [future.result() for future in futures]

    def cancel(self, futures: Iterable[ThreadFuture], force: bool) -> None:
        """Let calls leave that have begun, and forget the others."""
        for future in futures:
            future.stops = True
            future.cancel()

    def subscribe_topic(self, topic: str, handler: Callable[[Any], None]) -> None:
        """Hear what calls tell."""
        self._handlers[topic] = handler

    def log_event(self, topic: str, event: Any) -> None:
        """Tell something to whoever hears it."""
        if topic in self._handlers:
            self._handlers[topic]((time.time(), event))

    def close(self) -> None:
        """Cancel what there is, and end once calls have left, or soon: one that compiles a kernel cannot leave."""
        self.status = "closed"
        with contextlib.suppress(queue.Empty):
            while waiting := self._calls.get_nowait():
                waiting[0].cancel()
        self.cancel(list(self._executing), force=True)
        for _ in range(self._number):
            self._calls.put(None)
        concurrent.futures.wait(list(self._executing), _LEAVE_SECONDS)

    def _work(self) -> None:
        while (call := self._calls.get()) is not None:
            future, function, argument = call
            if not future.set_running_or_notify_cancel():
                continue
            here = _InThread(self, future)
            self._executing.add(future)
            place.set(here)
            try:
                future.set_result(function(argument))
            except BaseException as error:  # handed to whoever asks for the result
                future.set_exception(error)
            finally:
                self._executing.discard(future)
            if here.left:
                return


@contextlib.contextmanager
def threads_here(number: int) -> Iterator[Threads]:
    """Threads of this process, which end with the context.

    Kernels release the GIL. They are compiled, or loaded from the disk cache, when a task first needs them.

    Parameters
    ----------
    number : int
        Calls that compute at the same time.

    Yields
    ------
    Threads
    """
    threads = Threads(number)
    try:
        yield threads
    finally:
        threads.close()
