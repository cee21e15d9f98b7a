"""From a job to a complete store: each basin is mapped, assembled and labelled, and solutions are numbered in order.

The store is authoritative: a tile is done if the ledger says so, and the ledger is written after the tile is on the
disk, since its receipt is sent after that. Basins are
completed in order. After any crash the same call computes only what is missing, and the result is the same to the byte.
"""

import contextlib
import threading
from functools import partial
from typing import Any, Protocol

from worker.additions import asked_of
from worker.basins.ledger import Ledger
from worker.basins.pace import Pace
from worker.basins.schedule import Schedule
from worker.cluster.calls import Task
from worker.cluster.driver import Driver
from worker.fence import Fence, unfenced
from worker.jobs.basin_job import BasinJob
from worker.progress import Progress, Report, Stage
from worker.storage.folder import synced_together
from worker.stores.basin_store import BasinStore
from worker.stores.changes import list_changes
from worker.stores.opening import demand_all_known

# Basins in progress for each task in flight. A slow basin delays the numbering of the next ones, whose results wait in
# memory.
_BASINS_A_TASK = 4


class Run(Protocol):
    """Work that a package adds: it takes the receipts of its tasks and says which tasks come next."""

    seconds: dict[str, float]
    """Time spent in kernels."""

    def next_task(self) -> Task | None:
        """The next task; None if there is none yet."""

    def take(self, task: Task, receipt: Any) -> None:
        """Take the receipt of a task."""

    def progress(self) -> Progress:
        """How far it is."""

    def finish(self) -> None:
        """Write what is written last."""


def run_basin(
    job: BasinJob,
    location: str,
    driver: Driver,
    *,
    report: Report,
    cancel: threading.Event,
    fence: Fence = unfenced,
) -> None:
    """Compute a job's basins into a store, or continue the store that is there.

    `worker.results.summary.summarise` reads the result.

    Parameters
    ----------
    job : BasinJob
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
    JobCancelled, LeaseLost, StoreConflict, StoreFailed, TileFailed, ClusterFailed, UnlikeWorkers
    """
    demand_all_known(location, job.unread)
    store = BasinStore.create_or_resume(location, job, fence)
    if store.complete:
        return
    ledger = Ledger(store)
    schedule = Schedule(store, ledger, _BASINS_A_TASK * driver.window_size)
    pace = Pace(store, ledger, schedule)
    report(pace.progress())
    try:
        within = partial(synced_together, location)
        tasks = driver.run_tasks(
            (location, store.digest), schedule.next_task, cancel, within=within,
            compiling=lambda: report(pace.progress().while_compiling()),
        )  # fmt: skip
        with contextlib.closing(tasks) as done:
            for task, receipt in done:
                schedule.take(task, receipt)
                ledger.save_sometimes()
                report(pace.progress())
    finally:
        ledger.save()
        store.sweep_orphans()
    if job.axes:
        store.solutions.write_changes(list_changes(job, ledger.table))
    seconds = pace.finish()
    for addition in asked_of(job):
        run = addition.run(store, ledger.catalogue(0).attractors)
        seconds |= _added(run, store, driver, report, cancel)
    store.finish(seconds)
    report(pace.progress(Stage.DONE))


def _added(run: Run, store: BasinStore, driver: Driver, report: Report, cancel: threading.Event) -> dict[str, float]:
    """Do what a package adds to a basin whose tiles have their solutions; return the kernels' time."""
    report(run.progress())
    within = partial(synced_together, store.location)
    tasks = driver.run_tasks(
        (store.location, store.digest), run.next_task, cancel, within=within,
        compiling=lambda: report(run.progress().while_compiling()),
    )  # fmt: skip
    with contextlib.closing(tasks) as done:
        for task, receipt in done:
            run.take(task, receipt)
            report(run.progress())
    run.finish()
    return dict(run.seconds)
