"""A task: what the driver has a worker do, and how the worker leaves it when it is cancelled."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from distributed import get_worker

from worker.errors import JobCancelled


@dataclass(frozen=True)
class Task:
    """One call: ``function(location, digest, number, *arguments)``, of a function of this module or of `analysis_run`.

    ``number`` is that of a tile, a basin or a piece; ``basin`` the basin that it is for; ``name`` what it is called.
    """

    function: Callable[..., Any]
    number: int
    basin: int
    arguments: tuple[Any, ...] = ()
    name: str = ""


def stop_if_cancelled() -> None:
    """Leave a task that has been cancelled: `Future.cancel` alone does not stop a running function.

    Called several times a second, wherever a task may take longer than that.
    """
    try:
        worker = get_worker()
        state = worker.state.tasks.get(worker.get_current_task())
    except ValueError:  # not on a worker: called as a plain function
        return
    if state is not None and state.state in ("cancelled", "resumed"):
        raise JobCancelled("cancelled while a tile was computed")
