"""How every job is run, whatever its kind: its work in progress gives tasks, a driver runs them, it takes the receipts.

The store is authoritative: what it says is done is done, and it says so after that is on the disk. After any crash or
cancellation the same call computes only what is missing, and the result is the same to the byte.
"""

import contextlib
import threading
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import Any, Protocol

from worker.cluster.calls import Task
from worker.cluster.driver import Driver
from worker.fence import Fence, unfenced
from worker.jobs.job import Job
from worker.kinds import KINDS
from worker.progress import Progress, Report, Stage


class Run(Protocol):
    """Work in progress: it takes the receipts of its tasks and says which tasks come next."""

    address: tuple[str, str]
    """Location of the store, and digest of the job that tasks expect there."""

    @property
    def within(self) -> Callable[[], AbstractContextManager[None]]:
        """What makes the context that a worker runs tasks in. When that has been left, receipts are sent."""

    @property
    def seconds(self) -> Mapping[str, float]:
        """Time spent in kernels."""

    def next_task(self) -> Task | None:
        """The next task; None if there is none yet."""

    def take(self, task: Task, receipt: Any) -> None:
        """Take the receipt of a task."""

    def progress(self, stage: Stage | None = None) -> Progress:
        """How far a stage is, by default the current one; `Stage.DONE` stands for the whole job."""

    def leave(self) -> None:
        """Write what has to be in the store also if the work was stopped."""

    def finish(self) -> None:
        """Write what is written last."""


def run_job(
    job: Job, location: str, driver: Driver, *, report: Report, cancel: threading.Event, fence: Fence = unfenced
) -> None:
    """Compute a job into a store, or continue the store that is there.

    Parameters
    ----------
    job : Job
    location : str
        The store.
    driver : Driver
    report : callable
        Called with a `Progress` after every task.
    cancel : threading.Event
        Set it to stop. The store stays readable and can be resumed.
    fence : Fence
        Needed if another driver may take over the job.

    Raises
    ------
    JobCancelled, LeaseLost, NotFound, StoreConflict, StoreFailed, TileFailed, ClusterFailed, UnlikeWorkers
    """
    first: Run | None = None
    for run in KINDS[job.kind].runs(job, location, driver, fence):
        first = first or run
        report(run.progress())
        tasks = driver.run_tasks(
            run.address, run.next_task, cancel, within=run.within,
            compiling=lambda run=run: report(run.progress().while_compiling()),  # type: ignore[misc]
        )  # fmt: skip
        try:
            with contextlib.closing(tasks) as done:
                for task, receipt in done:
                    run.take(task, receipt)
                    report(run.progress())
        finally:
            run.leave()
        run.finish()
    if first is not None:
        report(first.progress(Stage.DONE))
