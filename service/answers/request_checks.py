"""Checks of requests, in threads of their own: the event loop computes nothing of a request.

Nearly all requests are checked within milliseconds. Those that take longer begin again in a lane where one is checked
at a time, so the others do not wait for them, and the memory of their values is that of one.
"""

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TypeVar

from service.errors import LimitExceeded, TooMuch
from worker.jobs.budget import CheckTooLong, within

_T = TypeVar("_T")
_SHORT_SECONDS, _LONGEST_SECONDS = 0.1, 5.0
_SHORT_THREADS, _SHORT_WAITING, _LONG_WAITING = 2, 256, 16


class _Lane:
    """Threads, and a bounded number of requests that wait for them."""

    def __init__(self, name: str, threads: int, waiting: int, seconds: float, stopped: threading.Event) -> None:
        self._threads = ThreadPoolExecutor(threads, f"rattle-checks-{name}")
        self._most, self._waiting, self._seconds, self._stopped = threads + waiting, waiting, seconds, stopped
        self._inside = 0

    def close(self) -> None:
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def run(self, function: Callable[[], _T]) -> _T:
        if self._inside >= self._most:
            raise TooMuch(f"{self._waiting} requests wait to be checked: try again in a second", 1)
        self._inside += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(self._threads, self._within, function)
        finally:
            self._inside -= 1

    def _within(self, function: Callable[[], _T]) -> _T:
        with within(self._seconds, self._stopped):
            return function()


class RequestChecks:
    """Runs functions that parse and check requests.

    Guarantees. Each takes a bounded processor time, and a bounded number wait. It must be used from one event loop.
    """

    def __init__(self) -> None:
        self._stopped = threading.Event()
        lane = partial(_Lane, stopped=self._stopped)
        self._short = lane("short", _SHORT_THREADS, _SHORT_WAITING, _SHORT_SECONDS)
        self._long = lane("long", 1, _LONG_WAITING, _LONGEST_SECONDS)

    def close(self) -> None:
        """End all checks when the service stops."""
        self._stopped.set()
        for lane in (self._short, self._long):
            lane.close()

    async def run(self, check: Callable[[], _T]) -> _T:
        """Result of a function that checks a request. It may be called twice.

        Parameters
        ----------
        check : callable
            It passes `worker.jobs.budget.spend` between any two of its steps.

        Returns
        -------
        object

        Raises
        ------
        LimitExceeded
            If the check takes too much processor time.
        TooMuch
            If too many requests wait.
        """
        try:
            return await self._short.run(check)
        except CheckTooLong:
            pass
        try:
            return await self._long.run(check)
        except CheckTooLong as error:
            if self._stopped.is_set():
                raise TooMuch("the service is stopping: try again when it is back", 5) from error
            raise LimitExceeded(f"{error}: ask for fewer values, fewer harmonics, or lower orders") from error
