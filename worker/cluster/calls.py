"""Calls of a worker: the tasks that they carry, and what a worker does with them.

A worker tells the driver before it compiles the first kernel for a job. Kernels for one, two and more harmonics are
compiled when a job first needs them, and nothing else happens for a minute or so.
"""

import contextlib
import contextvars
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from rattle_kernels.numerics.compiled_apart import compiled_apart
from rattle_kernels.numerics.jit import watch_compiling
from worker.errors import JobCancelled

if TYPE_CHECKING:
    from distributed import Client

    from worker.cluster.threads import Threads

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


class Place(ABC):
    """Where a call runs, and what it can say there."""

    @abstractmethod
    def is_cancelled(self) -> bool:
        """Whether nobody waits for the call any longer."""

    @abstractmethod
    def tell(self, topic: str, address: Address) -> None:
        """Tell the driver of something that concerns a job."""

    @abstractmethod
    def leave(self) -> None:
        """Make room for the next call: this one only waits for the disk."""


class _OnWorker(Place):
    """A worker of Dask. A process of threads alone does without Dask, so it is loaded here."""

    def __init__(self) -> None:
        from distributed import get_worker

        self._worker = get_worker()
        self._key = self._worker.get_current_task()
        self._outside = contextvars.copy_context()

    def is_cancelled(self) -> bool:
        state = self._worker.state.tasks.get(self._key)
        # `Future.cancel` alone does not stop a running function.
        return state is not None and state.state in ("cancelled", "resumed")

    def tell(self, topic: str, address: Address) -> None:
        self._worker.log_event(topic, list(address))

    def leave(self) -> None:
        from distributed import secede

        # The event loop starts the next call in the context that this one leaves in. If that is its own, the next call
        # takes this place for its place, and does not see that it is cancelled.
        self._outside.run(secede)


place: ContextVar[Place | None] = ContextVar("place", default=None)
"""Where this thread's call runs; None outside of one. Threads of a driver set it, a worker of Dask's is found."""


def stop_if_cancelled() -> None:
    """Leave a task that has been cancelled; called as a plain function, do nothing.

    Called several times a second, wherever a task may take longer than that.

    Raises
    ------
    JobCancelled
    """
    here = place.get()
    if here is not None and here.is_cancelled():
        raise JobCancelled("cancelled while a tile was computed")


@contextlib.contextmanager
def _telling_of_compilation(here: Place, address: Address) -> Iterator[None]:
    """Tell the driver once if a kernel is compiled while a context lasts."""
    sent = False

    def tell() -> None:
        nonlocal sent
        if not sent:
            sent = True
            here.tell(_TOPIC, address)

    with watch_compiling(tell):
        yield


class Compiling:
    """Jobs of which a worker has said that it compiles kernels, and that have not been asked about since.

    Parameters
    ----------
    client : distributed.Client or Threads
    """

    def __init__(self, client: "Client | Threads") -> None:
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
    here, values, address = place.get() or _OnWorker(), [], (call.location, call.digest)
    outside = place.set(here)
    try:
        with _telling_of_compilation(here, address), compiled_apart(stop_if_cancelled), call.within():
            for task in call.tasks:
                stop_if_cancelled()
                values.append(call.function(*address, *task))
            seconds = time.perf_counter() - begin
            # What is left to do is to wait for the disk. This thread's place is free meanwhile for the next call.
            here.leave()
    finally:
        place.reset(outside)
    return Receipts(values, seconds)
