"""A job that a command computes here, without a service: refused in a line, with progress, stopped in order."""

import contextlib
from collections.abc import Callable
from typing import Any

from rattle_kernels import OutsideDomain, warm_up_analyses
from service.cli.console import give_up, out, progress_line
from service.cli.interruptible import run_interruptibly
from service.models.oscillator import demand_quiet
from service.settings import Settings
from worker.analyses.kinds import ANALYSES
from worker.cluster.connection import connect
from worker.errors import InvalidJob, JobCancelled, WorkerError
from worker.fence import unfenced
from worker.job import Job
from worker.kinds import JOB_KINDS
from worker.progress import Progress


def run_here(
    describe: Callable[[], Job], location: str, workers: int, tell: Callable[[Any], None], *, quiet_or_not: bool
) -> None:
    """Compute a job into a store and tell what it has found.

    Parameters
    ----------
    describe : callable
        Makes the job, or raises what is wrong with the command's options.
    location : str
        The store; an unfinished one is resumed.
    workers : int
    tell : callable
        Prints the job's summary.
    quiet_or_not : bool
        Whether a job is taken that has no quiet solution.
    """
    try:
        job = describe()
        demand_quiet(job.demand_quiet, unless=quiet_or_not)
    except (OutsideDomain, InvalidJob) as error:
        give_up(str(error), 2)
    try:
        summary = _compute(job, location, Settings(), workers)
    except JobCancelled:
        give_up(f"stopped; the same command goes on from what is in {location}")
    except WorkerError as error:
        give_up(str(error))
    tell(summary)
    out.print(
        f"{location} is complete; draw it with: rattle plot {location} --out picture.png",
        highlight=False, soft_wrap=True,
    )  # fmt: skip


def _compute(job: Job, location: str, settings: Settings, workers: int) -> object:
    with contextlib.ExitStack() as stack:
        line = stack.enter_context(progress_line("pieces" if job.kind in ANALYSES else "tiles"))
        if job.kind in ANALYSES and not settings.scheduler:
            warm_up_analyses(line.compiling)  # here, before every worker would do it for itself
        client = stack.enter_context(connect(settings.scheduler, workers, settings.certificates, line.compiling))

        def report(progress: Progress) -> None:
            line.show(
                progress.stage,
                (progress.tiles_done, progress.tiles_total),
                (progress.basins_done, progress.basins_total),
                progress.cells_per_second,
            )

        run = JOB_KINDS[job.kind].run
        return run_interruptibly(
            lambda cancel: run(job, location, client, report=report, cancel=cancel, fence=unfenced)
        )
