"""Runs many small tasks on a cluster with a small window in flight.

Why not one ``client.map``: with every future held, each killed worker made the scheduler compute again what was on disk
already, and marked innocent tiles as killers. So: about two tasks a thread are in flight; a future is released as soon
as its receipt is here; a lost task is submitted again under a new key (a known key would be answered with its old,
cancelled future); and after a few failures of its own a tile fails the job.
"""

import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from distributed import Client, Future, wait

from worker.errors import ClusterFailed, JobCancelled, TileFailed, WorkerError

_TRIES = 4
_POLL_SECONDS = 0.2
_NO_WORKER_SECONDS = 60.0


def _threads(client: Client) -> int:
    try:
        return sum(client.nthreads().values())
    except Exception as error:
        raise ClusterFailed(f"the scheduler cannot be reached: {error}") from error


class _Window:
    """Tasks in flight: which tile each future computes, and how often each tile was tried."""

    def __init__(self, client: Client, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        self.client, self.function, self.arguments = client, function, arguments
        self.run = uuid.uuid4().hex[:12]
        self.tile_of: dict[Future, int] = {}
        self.tries: dict[int, int] = {}

    def submit(self, tile: int) -> None:
        attempt = self.tries[tile] = self.tries.get(tile, 0) + 1
        key = f"{self.function.__name__}-{self.run}-{tile}-a{attempt}"
        self.tile_of[self.client.submit(self.function, *self.arguments, tile, key=key, pure=False)] = tile

    def take(self, future: Future) -> Any | None:
        """Receipt of a finished future, released at once; None where the tile was submitted again."""
        tile = self.tile_of.pop(future)
        error = None if future.status == "finished" else (future.exception() if future.status == "error" else None)
        receipt = future.result() if future.status == "finished" else None
        future.release()
        if receipt is not None:
            return receipt
        if isinstance(error, WorkerError):
            raise error
        if self.tries[tile] >= _TRIES:
            reason = f"{type(error).__name__}: {error}" if error else "its worker was lost"
            raise TileFailed(f"tile {tile} failed {_TRIES} times; the last time: {reason}") from error
        self.submit(tile)
        return None

    def wait(self) -> set[Future]:
        """Futures that have ended, none where none does within a fifth of a second."""
        try:
            with self.client.as_current():
                done: set[Future] = wait(list(self.tile_of), timeout=_POLL_SECONDS, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            return set()
        return done

    def cancel(self) -> None:
        self.client.cancel(list(self.tile_of), force=True)
        self.tile_of.clear()


def run_tiles(
    client: Client,
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    tiles: Iterable[int],
    cancel: threading.Event,
) -> Iterator[Any]:
    """Yield the receipt of each tile as it completes.

    Parameters
    ----------
    client : distributed.Client
    function : callable
        ``function(*arguments, tile)``: a task of `worker.tasks`.
    arguments : tuple
        What all tiles have in common.
    tiles : iterable of int
    cancel : threading.Event
        Set by whoever wants the work to stop.

    Raises
    ------
    JobCancelled, TileFailed, ClusterFailed, or the WorkerError of a task
        Whatever is still in flight has been cancelled then.
    """
    waiting = deque(tiles)
    window = _Window(client, function, arguments)
    size = 2 * max(1, _threads(client))
    last_seen = time.monotonic()
    try:
        while waiting or window.tile_of:
            if cancel.is_set():
                raise JobCancelled("cancelled on request")
            while waiting and len(window.tile_of) < size:
                window.submit(waiting.popleft())
            done = window.wait()
            last_seen = time.monotonic() if done else _check_workers(client, last_seen)
            for future in done:
                receipt = window.take(future)
                if receipt is not None:
                    yield receipt
    finally:
        window.cancel()


def _check_workers(client: Client, last_seen: float) -> float:
    """Time at which a worker was last known; fails when there has been none for a minute."""
    if client.status in ("closed", "closing", "connecting"):
        raise ClusterFailed("the connection to the scheduler is lost; submit again when it is back")
    if _threads(client) > 0:
        return time.monotonic()
    if time.monotonic() - last_seen > _NO_WORKER_SECONDS:
        raise ClusterFailed(f"no worker has been there for {_NO_WORKER_SECONDS:.0f} s")
    return last_seen
