"""A job that a command computes here, without a service: refused in a line, with progress, stopped in order."""

from collections.abc import Callable
from typing import Any

from rattle_kernels import OutsideDomain
from service.cli.console import announce_compiling, give_up, out, progress_line
from service.cli.interruptible import run_interruptibly
from service.models.oscillator import demand_quiet
from service.settings import Settings
from worker.analyses.kinds import ANALYSES
from worker.analyses.run import summarise_analysis
from worker.cluster.connection import connect
from worker.cluster.driver import Driver
from worker.errors import InvalidJob, JobCancelled, WorkerError
from worker.fence import unfenced
from worker.job import Job
from worker.kinds import JOB_KINDS
from worker.progress import Progress
from worker.stores.summary import summarise


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
        _compute(job, location, Settings(), workers)
        summary = _summary(job, location)
    except JobCancelled:
        give_up(f"stopped; the same command goes on from what is in {location}")
    except WorkerError as error:
        give_up(str(error))
    tell(summary)
    out.print(
        f"{location} is complete; draw it with: rattle plot {location} --out picture.png",
        highlight=False, soft_wrap=True,
    )  # fmt: skip


def _compute(job: Job, location: str, settings: Settings, workers: int) -> None:
    announce_compiling()
    cluster = connect(settings.scheduler, workers, settings.certificates)
    with cluster as client, progress_line("pieces" if job.kind in ANALYSES else "tiles") as line:

        def report(progress: Progress) -> None:
            line.show(
                progress.stage,
                (progress.tiles_done, progress.tiles_total),
                (progress.basins_done, progress.basins_total),
                progress.cells_per_second,
            )

        run = JOB_KINDS[job.kind].run
        driver = Driver(client)
        run_interruptibly(lambda cancel: run(job, location, driver, report=report, cancel=cancel, fence=unfenced))


def _summary(job: Job, location: str) -> object:
    analysis = ANALYSES.get(job.kind)
    return summarise(location) if analysis is None else summarise_analysis(analysis, location)
