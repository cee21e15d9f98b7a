"""Previews: small basins that are computed while the client waits, in a few threads of their own.

Kernels release the GIL, so the event loop goes on answering. A preview waits for other previews alone, never for jobs.
"""

import asyncio
import os
import sys
import threading
import time
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from anyio import create_task_group

from rattle_kernels.numerics.compiled_apart import compiled_apart
from rattle_kernels.numerics.jit import timing_compilation
from service.errors import LimitExceeded, TooMuch
from worker.errors import JobCancelled
from worker.jobs.preview_request import Preview, PreviewRequest, preview_basin

MOST_CELLS = 65_536
MOST_APPLICATIONS = 50_000_000
_MOST_SECONDS = 20.0
_THREADS = 2
_MOST_WAITING = 16
# Above the jobs and below the event loop. At 300 requests a second and ten previews, while jobs compute on two cores,
# status reads waited for seconds when previews were as important as responses.
_NICENESS = 4


class Timed(NamedTuple):
    """A preview and how long it took, without compilation.

    Parameters
    ----------
    preview : Preview
    seconds, processor_seconds : float
        That went by, and that its thread had of a processor. On a busy machine the first is the longer.
    """

    preview: Preview
    seconds: float
    processor_seconds: float


def _yield_to_responses() -> None:
    # On Linux a thread has a priority of its own.
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), os.getpriority(os.PRIO_PROCESS, 0) + _NICENESS)


class Previews:
    """Computes previews."""

    def __init__(self) -> None:
        self._threads = ThreadPoolExecutor(_THREADS, "rattle-previews", _yield_to_responses)
        self._asked: set[threading.Event] = set()

    def close(self) -> None:
        """Stop all previews."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for stopped in self._asked:
            stopped.set()

    async def compute(self, request: PreviewRequest, gone: Callable[[], Awaitable[None]]) -> Timed:
        """Compute a preview, until it is done or its client goes.

        Parameters
        ----------
        request : PreviewRequest
        gone : callable
            Waits until the client has closed its connection.

        Returns
        -------
        Timed

        Raises
        ------
        OutsideDomain, InvalidJob, LimitExceeded
            Naming what is wrong with the request, or the limit.
        TooMuch
            If too many previews wait.
        JobCancelled
            If the client is gone.
        """
        if len(self._asked) >= _THREADS + _MOST_WAITING:
            raise TooMuch(f"{_MOST_WAITING} previews are waiting: try again in a second, or submit a job", 1)
        stopped = threading.Event()
        outcome: Timed | Exception = JobCancelled("the client of this preview is gone")

        async def stop_when_gone() -> None:
            await gone()
            stopped.set()
            group.cancel_scope.cancel()

        self._asked.add(stopped)
        try:
            # An exception that left the group would arrive as an ExceptionGroup, for which there is no response.
            async with create_task_group() as group:
                group.start_soon(stop_when_gone)
                try:
                    outcome = await asyncio.get_running_loop().run_in_executor(
                        self._threads, _compute, request, stopped
                    )
                except Exception as error:
                    outcome = error
                group.cancel_scope.cancel()
        finally:
            self._asked.remove(stopped)
        if isinstance(outcome, Exception):
            raise outcome
        return outcome


def _compute(request: PreviewRequest, stopped: threading.Event) -> Timed:
    _demand_small(request)
    begun, begun_on_processor = time.monotonic(), time.thread_time()

    # The first preview with harmonics compiles kernels, half a minute or more. That is no fault of its own.
    def leave() -> None:
        if stopped.is_set():
            raise JobCancelled("the client of this preview is gone")

    with timing_compilation() as compiling, compiled_apart(leave):

        def pause() -> None:
            leave()
            if time.monotonic() - begun - compiling() > _MOST_SECONDS:
                raise LimitExceeded(
                    f"this preview takes longer than the limit of {_MOST_SECONDS:.0f} s: ask for fewer cells, or for "
                    "a job"
                )

        basin = preview_basin(request, pause)
        # Kernels are compiled by a process apart, which this thread waits for.
        seconds = time.monotonic() - begun - compiling()
    return Timed(basin, seconds, time.thread_time() - begun_on_processor)


def _demand_small(request: PreviewRequest) -> None:
    checked = request.checked()
    limits = (
        ("cells", checked.grid.cells, MOST_CELLS),
        ("cells times iterations", checked.applications, MOST_APPLICATIONS),
    )
    for what, size, most in limits:
        if size > most:
            raise LimitExceeded(f"{size} {what} are more than the limit of {most} for a preview: submit a job")
