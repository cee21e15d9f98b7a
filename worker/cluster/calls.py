"""Calls of a worker: the tasks that they carry, and what a worker does with them.

A worker tells the driver, by an event of Dask's, before it compiles the first kernel for a job. Kernels for one, two
and more harmonics are compiled when a job first needs them, and nothing else happens for a minute or so.
"""

import contextlib
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, NamedTuple

from distributed import Client, get_worker, secede

from rattle_kernels.numerics.compiled_apart import compiled_apart
from rattle_kernels.numerics.jit import watch_compiling
from worker.errors import JobCancelled

Address = tuple[str, str]
"""Location of a job's store, and digest of the job."""
_TOPIC = "rattle-compiling"


def _nothing_next(number: int, receipt: Any) -> "Iterable[Task]":
    return ()


@dataclass(frozen=True)
class Task:
    """One call on a worker: ``function(location, digest, number, *arguments)``.

    Only the function and its arguments travel to the worker. The rest stays with the driver.

    Parameters
    ----------
    function : callable
    number : int
        Number of a tile, a basin or a part.
    arguments : tuple
    then : callable
        ``then(number, receipt)`` takes what the function returned, and returns the tasks that can run now.
    name : str
        Name in messages.
    priority : int
        Tasks with a lower number go first.
    """

    function: Callable[..., Any]
    number: int
    arguments: tuple[Any, ...] = ()
    then: "Callable[[int, Any], Iterable[Task]]" = _nothing_next
    name: str = ""
    priority: int = 0

    def __str__(self) -> str:
        return self.name or f"{self.function.__name__} {self.number}"


def stop_if_cancelled() -> None:
    """Leave a task that has been cancelled. `Future.cancel` alone does not stop a running function.

    Called several times a second, wherever a task may take longer than that.

    Raises
    ------
    JobCancelled
    """
    try:
        worker = get_worker()
        state = worker.state.tasks.get(worker.get_current_task())
    except ValueError:  # not on a worker: called as a plain function
        return
    if state is not None and state.state in ("cancelled", "resumed"):
        raise JobCancelled("cancelled while a tile was computed")


@contextlib.contextmanager
def telling_of_compilation(address: Address) -> Iterator[None]:
    """Tell the driver once if a kernel is compiled while a context lasts. Called on a worker.

    Parameters
    ----------
    address : (str, str)
        The job's.
    """
    worker, sent = get_worker(), False

    def tell() -> None:
        nonlocal sent
        if not sent:
            sent = True
            worker.log_event(_TOPIC, list(address))

    with watch_compiling(tell):
        yield


class Compiling:
    """Jobs of which a worker has said that it compiles kernels, and that have not been asked about since.

    Parameters
    ----------
    client : distributed.Client
    """

    def __init__(self, client: Client) -> None:
        self._client, self._jobs = client, set[Address]()
        self._lock, self._listens = threading.Lock(), False

    def listen(self) -> None:
        """Hear what workers say from now on."""
        with self._lock:
            if not self._listens:
                self._client.subscribe_topic(_TOPIC, self._take)
            self._listens = True

    def _take(self, event: tuple[float, Any]) -> None:
        location, digest = event[1]
        self._jobs.add((location, digest))

    def has_begun(self, address: Address) -> bool:
        """Whether a worker has begun to compile for a job since this was last asked."""
        if address not in self._jobs:
            return False
        self._jobs.discard(address)
        return True


class Call(NamedTuple):
    """Tasks of one function that travel to a worker together.

    Each of ``tasks`` holds a number and further arguments. All run inside ``within()``.
    """

    function: Callable[..., Any]
    location: str
    digest: str
    tasks: Sequence[tuple[Any, ...]]
    within: Callable[[], AbstractContextManager[None]]


class Receipts(NamedTuple):
    """What the tasks of a call returned, and the seconds that they took together."""

    values: list[Any]
    seconds: float


def run_call(call: Call) -> Receipts:
    """Run the tasks of a call on a worker, one after another.

    Parameters
    ----------
    call : Call

    Returns
    -------
    Receipts
    """
    begin = time.perf_counter()
    values = []
    address = call.location, call.digest
    with telling_of_compilation(address), compiled_apart(stop_if_cancelled), call.within():
        for task in call.tasks:
            stop_if_cancelled()
            values.append(call.function(call.location, call.digest, *task))
        seconds = time.perf_counter() - begin
        # What is left to do is to wait for the disk. This thread's place is free meanwhile for the next call.
        secede()
    return Receipts(values, seconds)
