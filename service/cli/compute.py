"""The commands that compute a job here, without a service: one for each kind of `worker.kinds`."""

from collections.abc import Callable
from typing import Annotated, Any

import typer

from service.cli.analysis_tables import print_result
from service.cli.local_run import run_here
from service.cli.options import job_options, job_request, with_options
from service.models.basin_result import ResultView
from worker.kinds import KINDS

Out = Annotated[
    str, typer.Option("--out", help="Zarr store to write, a folder or s3://BUCKET/PREFIX; an unfinished one is resumed")
]
Workers = Annotated[int, typer.Option(min=1, help="Worker processes")]


def compute_command(name: str) -> Callable[..., None]:
    """Command that computes jobs of a kind.

    Parameters
    ----------
    name : str
        Of the kind.

    Returns
    -------
    callable
        For typer.
    """
    kind = KINDS[name]

    def report(summary: Any) -> None:
        if kind.analysis is None:
            print_result(name, ResultView.from_summary(summary, "").model_dump())
        else:
            print_result(name, summary.result | {"seconds": summary.seconds})

    @with_options(job_options(kind.job_class))
    def command(out_: Out, workers: Workers = 2, **values: Any) -> None:
        run_here(lambda: kind.job_class.from_request(job_request(kind.job_class, values)), out_, workers, report)

    command.__doc__ = kind.command
    return command
