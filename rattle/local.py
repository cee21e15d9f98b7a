"""Work done here: a job is computed into a store by threads of this process, or by a cluster whose address is given."""

import contextlib
import os
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeVar

from rattle_kernels.warm_up import Report as Compiling
from rattle_kernels.warm_up import reporting_compilation
from worker.cluster.driver import Driver
from worker.cluster.settings import ClusterSettings
from worker.cluster.threads import Threads, threads_here
from worker.jobs.job import Job
from worker.kinds import KINDS
from worker.progress import Report
from worker.run import run_job

if TYPE_CHECKING:
    from distributed import Client

_T = TypeVar("_T")


def usable_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run_here(
    job: Job,
    location: str,
    report: Report,
    *,
    compiling: Compiling | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
) -> None:
    """Compute a job into a store, or continue the store that is there. Ctrl-C stops it within two seconds.

    Parameters
    ----------
    job : Job
    location : str
        The store: a folder, or ``s3://bucket/prefix``.
    report : callable
        Called with each `Progress`, in another thread. An exception that it raises stops the work.
    compiling : callable, optional
        Called with the numbers of ready and of needed kernels, while some have to be compiled.
    workers : int, optional
        Threads of this process; by default one for each core.
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads; by default that of ``RATTLE_SCHEDULER``, if it is set.

    Raises
    ------
    JobCancelled
        If it was stopped. The same call goes on from what is in the store.
    StoreConflict, StoreFailed, TileFailed, ClusterFailed, NotFound
    """
    with (
        _cluster(scheduler, workers) as client,
        reporting_compilation(compiling, analyses=KINDS[job.kind].unit == "pieces"),
    ):
        driver = Driver(client)
        run_interruptibly(lambda cancel: run_job(job, location, driver, report=report, cancel=cancel))


@contextlib.contextmanager
def _cluster(scheduler: str | None, workers: int | None) -> "Iterator[Client | Threads]":
    settings: Any = ClusterSettings() if scheduler is None else ClusterSettings(scheduler=scheduler)
    if settings.scheduler:
        from worker.cluster.connection import remote_cluster  # loads Dask, which threads do without

        with remote_cluster(settings.scheduler, settings.certificates) as client:
            yield client
    else:
        with threads_here(workers or usable_cores()) as threads:
            yield threads


def run_interruptibly(work: Callable[[threading.Event], _T]) -> _T:
    """Run work in another thread. Ctrl-C reaches this one, which then sets the event that cancels the work.

    Returns what the work returns, and raises what it raises.
    """
    cancel, ended = threading.Event(), threading.Event()
    results: list[_T] = []
    errors: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work(cancel))
        except BaseException as error:  # handed to the thread that waits
            errors.append(error)
        finally:
            ended.set()

    threading.Thread(target=run).start()
    # Not by joining: Python 3.11 takes a thread for ended once its join has been interrupted.
    try:
        ended.wait()
    except KeyboardInterrupt:
        cancel.set()
        ended.wait()
    if errors:
        raise errors[0]
    return results[0]
