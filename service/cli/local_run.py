"""Compute a job on this machine: errors take one line, progress is shown, Ctrl-C stops it in order."""

import contextlib
from collections.abc import Callable
from typing import Any

from rattle_kernels import OutsideDomain, warm_up_analyses
from service.cli.console import give_up, out, progress_line
from service.cli.interruptible import run_interruptibly
from service.settings import Settings
from worker.analyses.run import summarise_analysis
from worker.cluster.connection import connect
from worker.cluster.driver import Driver
from worker.errors import InvalidJob, JobCancelled, WorkerError
from worker.fence import unfenced
from worker.jobs.job import Job
from worker.kinds import KINDS
from worker.progress import Progress
from worker.stores.summary import summarise


def run_here(describe: Callable[[], Job], location: str, workers: int, report: Callable[[Any], None]) -> None:
    """Compute a job into a store and print what it has found.

    Parameters
    ----------
    describe : callable
        Makes the job, or raises an error that says what is wrong with the command's options.
    location : str
        The store; an unfinished one is resumed.
    workers : int
    report : callable
        Prints the job's summary.
    """
    try:
        job = describe()
    except (OutsideDomain, InvalidJob) as error:
        give_up(str(error), 2)
    try:
        _compute(job, location, Settings(), workers)
        summary = _summary(job, location)
    except JobCancelled:
        give_up(f"stopped; the same command goes on from what is in {location}")
    except WorkerError as error:
        give_up(str(error))
    report(summary)
    out.print(
        f"{location} is complete; draw it with: rattle plot {location} --out picture.png",
        highlight=False, soft_wrap=True,
    )  # fmt: skip


def _compute(job: Job, location: str, settings: Settings, workers: int) -> None:
    kind = KINDS[job.kind]
    with contextlib.ExitStack() as stack:
        line = stack.enter_context(progress_line("tiles" if kind.analysis is None else "pieces"))
        if kind.analysis is not None and not settings.scheduler:
            warm_up_analyses(line.compiling)  # here, before every worker would compile them for itself
        client = stack.enter_context(connect(settings.scheduler, workers, settings.certificates, line.compiling))

        def show(progress: Progress) -> None:
            line.show(
                progress.stage,
                (progress.tiles_done, progress.tiles_total),
                (progress.basins_done, progress.basins_total),
                progress.cells_per_second,
            )

        driver = Driver(client)
        run_interruptibly(lambda cancel: kind.run(job, location, driver, report=show, cancel=cancel, fence=unfenced))


def _summary(job: Job, location: str) -> object:
    kind = KINDS[job.kind]
    return summarise(location) if kind.analysis is None else summarise_analysis(kind.loaded_analysis, location)
