"""A task: one call on a worker, and what the driver does with its result; how a worker leaves a cancelled task."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from distributed import get_worker

from worker.errors import JobCancelled


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
