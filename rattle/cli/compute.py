"""The commands that compute a job here, without a service: one for each kind of `worker.kinds`."""

from collections.abc import Callable
from typing import Annotated, Any

import typer

from rattle.arguments import job_of
from rattle.cli.console import give_up, out, progress_line
from rattle.cli.options import arguments_from, job_options, with_options
from rattle.cli.result_tables import print_result
from rattle.here import run_here
from rattle_kernels import OutsideDomain
from worker.analyses.run import summarise_analysis
from worker.errors import InvalidJob, JobCancelled, WorkerError
from worker.jobs.job import Job
from worker.kinds import KINDS
from worker.stores.opening import is_complete
from worker.stores.summary import summarise

Out = Annotated[
    str, typer.Option("--out", help="Zarr store to write, a folder or s3://BUCKET/PREFIX; an unfinished one is resumed")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print what is found as JSON alone")]
Workers = Annotated[int, typer.Option(min=1, help="Threads that compute")]


def compute_command(name: str) -> Callable[..., None]:
    """Command that computes jobs of a kind.

    Parameters
    ----------
    name : str
        Name of the kind.

    Returns
    -------
    callable
        Command for typer.
    """
    kind = KINDS[name]

    @with_options(job_options(kind.job_class))
    def command(out_: Out, workers: Workers = 2, as_json: AsJson = False, **values: Any) -> None:
        try:
            job = job_of(kind.job_class, arguments_from(kind.job_class, values), name)
        except (OutsideDomain, InvalidJob) as error:
            give_up(str(error), 2)
        _compute(job, out_, workers, as_json)

    command.__doc__ = kind.command
    return command


def _compute(job: Job, location: str, workers: int, as_json: bool) -> None:
    """Compute a job into a store, and print what it has found."""
    try:
        out.quiet |= as_json
        with progress_line("tiles" if KINDS[job.kind].analysis is None else "pieces") as line:
            if not is_complete(location, job.digest):  # else nothing is started for a table that is there
                run_here(job, location, line, workers=workers)
        print_result(job.kind, _result(job, location), as_json=as_json)
    except JobCancelled:
        give_up(f"stopped; the same command goes on from what is in {location}")
    except WorkerError as error:
        give_up(str(error))
    out.print(
        f"{location} is complete; draw it with: rattle plot {location} --out picture.png",
        highlight=False, soft_wrap=True,
    )  # fmt: skip


def _result(job: Job, location: str) -> dict[str, Any]:
    """Summary of a store as JSON."""
    kind = KINDS[job.kind]
    if kind.analysis is None:
        return summarise(location).as_json()
    summary = summarise_analysis(kind.loaded_analysis, location)
    return summary.result | {"seconds": summary.seconds}
