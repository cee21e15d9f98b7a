"""The commands that compute a job here, without a service: one for each kind of `worker.kinds`."""

import inspect
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from rattle.arguments import job_of
from rattle.cli.console import Scheduler, err, give_up, out, progress_line
from rattle.cli.options import Values, arguments_from, option, options_of, with_options
from rattle.cli.result_tables import print_result, what_is_missing
from rattle.garbage import fewer_collections
from rattle.local import run_here, usable_cores
from rattle.verbs import VERBS
from rattle_kernels import OutsideDomain
from worker.errors import InvalidJob, JobCancelled, WorkerError
from worker.estimate import estimate
from worker.jobs.job import Job
from worker.kinds import KINDS
from worker.stores.opening import is_complete

# From these on the estimate is printed; above ten minutes the command asks.
_LARGE_SECONDS, _LARGE_BYTES = 60.0, 1 << 30
_ASKED_SECONDS = 600.0

Out = Annotated[
    str, typer.Option("--out", help="Zarr store to write, a folder or s3://BUCKET/PREFIX; an unfinished one is resumed")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print what is found as JSON alone")]
Yes = Annotated[bool, typer.Option("--yes", "-y", help="Do not ask before work of more than ten minutes")]
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
    options, job_from = _asked(name)

    @with_options(options)
    def command(
        out_: Out, workers: Workers = 2, scheduler: Scheduler = None, as_json: AsJson = False, yes: Yes = False,
        **values: Any,
    ) -> None:  # fmt: skip
        try:
            job = job_from(values)
        except (OutsideDomain, InvalidJob) as error:
            give_up(str(error), 2)
        out.quiet |= as_json
        try:
            with fewer_collections():
                if not is_complete(out_, job.digest):  # else nothing is started for a table that is there
                    _announce(job, workers, ask=not yes)
                    _compute(job, out_, workers, scheduler)
                result = KINDS[job.kind].summarise(out_).model_dump(mode="json", exclude={"zarr"})
            print_result(job.kind, result, as_json=as_json)
        except JobCancelled:
            give_up(f"stopped; the same command goes on from what is in {out_}")
        except WorkerError as error:
            give_up(str(error))
        missing = what_is_missing(job.kind, result)
        if missing is not None:
            give_up(missing)
        out.print(
            f"{out_} is complete; draw it with: rattle plot {out_} --out picture.png",
            highlight=False, soft_wrap=True,
        )  # fmt: skip

    command.__doc__ = kind.command
    return command


def _asked(name: str) -> tuple[list[inspect.Parameter], Callable[[Values], Job]]:
    """Options that describe a job of a kind, and the job that their values make."""
    verb = VERBS.get(name)
    if verb is not None:
        return options_of(verb), lambda values: job_of(name, arguments_from(verb, values))
    # A kind that is no verb of this package, as of an extension, is asked for as in a service.
    request = option("request", Path, inspect.Parameter.empty, help="JSON file of the request")
    return [request], lambda values: KINDS[name].job_class.from_request(_request_in(values["request"]))


def _request_in(file: Path) -> dict[str, Any]:
    try:
        request: dict[str, Any] = json.loads(file.read_text())
    except (OSError, ValueError) as error:
        raise InvalidJob(f"--request {file}: {error}") from error
    return request


def _announce(job: Job, workers: int, ask: bool) -> None:
    """Say what large work takes, and ask before it on a terminal. Elsewhere nobody could answer, so it begins."""
    expected = estimate(job, min(workers, usable_cores()))
    if expected.seconds < _LARGE_SECONDS and expected.bytes < _LARGE_BYTES:
        return
    err.print(f"this takes {expected}", highlight=False, soft_wrap=True)
    if ask and expected.seconds > _ASKED_SECONDS and sys.stdin.isatty():
        typer.confirm("go on?", abort=True, err=True)


def _compute(job: Job, location: str, workers: int, scheduler: str | None) -> None:
    """Compute a job into a store, with its progress."""
    with progress_line(KINDS[job.kind].unit) as line:
        run_here(job, location, line.report, compiling=line.compiling, workers=workers, scheduler=scheduler)
