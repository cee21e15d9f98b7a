"""Commands that use a running service."""

import json
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.table import Table

from rattle.cli.console import give_up, out, progress_line
from rattle.cli.result_tables import print_result
from rattle.remote.client import ServiceClient
from rattle.remote.failure import ServiceFailed
from rattle.remote.job import RemoteJob

Url = Annotated[str, typer.Option(envvar="RATTLE_URL", help="Address of the service")]
Key = Annotated[
    str | None, typer.Option(envvar="RATTLE_KEY", show_envvar=True, help="Key, if the service requires one")
]
_HERE = "http://127.0.0.1:8000"


def _refuse(error: ServiceFailed) -> NoReturn:
    hints = {401: " by --key or RATTLE_KEY", None: " with --url"}
    give_up(f"{error}{hints.get(error.status, '')}", 2 if error.request_is_wrong else 1)


def submit(
    request: Annotated[Path, typer.Argument(help="JSON file of a request; - reads standard input")],
    wait: Annotated[bool, typer.Option("--wait", help="Follow the job to its end")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the job, or with --wait its result, as JSON")] = False,
    url: Url = _HERE,
    key: Key = None,
) -> None:
    """Submit a request to a service; the same request again is the same job."""
    try:
        body = typer.get_text_stream("stdin").read() if str(request) == "-" else request.read_text()
    except OSError as error:
        give_up(f"{request} cannot be read: {error.strerror}", 2)
    try:
        job = ServiceClient(url, key).submit_text(body)
        out.quiet |= as_json
        out.print(f"job {job.id} is {job.described['state']}", highlight=False)
        if wait:
            _follow(job, as_json)
        elif as_json:
            typer.echo(json.dumps(job.described, indent=2))
    except ServiceFailed as error:
        _refuse(error)


def _follow(job: RemoteJob, as_json: bool) -> None:
    try:
        with progress_line() as line:
            job.follow(line)
    except KeyboardInterrupt:
        out.print(
            f"no longer following; the job goes on. Look with `rattle jobs`, stop it with `rattle cancel {job.id}`"
        )
        raise typer.Exit(130) from None
    job.demand_success()
    print_result(job.kind, job.result(), as_json=as_json)
    out.print(f"xarray.open_zarr({job.url!r})", highlight=False, soft_wrap=True)


def jobs(
    url: Url = _HERE,
    key: Key = None,
    limit: Annotated[int, typer.Option(min=1, max=200, help="How many")] = 20,
    as_json: Annotated[bool, typer.Option("--json", help="As JSON")] = False,
) -> None:
    """List the service's jobs, newest first."""
    try:
        found = [job.described for job in ServiceClient(url, key).jobs(limit)]
    except ServiceFailed as error:
        _refuse(error)
    if as_json:
        typer.echo(json.dumps(found, indent=2))
        return
    table = Table("job", "kind", "state", "stage", "tiles", "submitted", "oscillator")
    for job in found:
        progress = job["progress"] or {}
        oscillator = job["request"]["oscillator"]
        tiles = f"{progress['tiles_done']}/{progress['tiles_total']}" if progress else ""
        vary = job["request"].get("vary", [])
        swept = {each["parameter"]: each["values"] for each in (vary if isinstance(vary, list) else [vary])}
        parameters = ", ".join(
            f"{name} {value:g}" if name not in swept else f"{name} {_span(swept[name])}"
            for name, value in oscillator.items()
            if name != "model"
        )
        table.add_row(
            job["id"], job["kind"], job["state"], progress.get("stage", ""), tiles, job["created"][:19], parameters
        )
    out.print(table)


def _span(values: list[float]) -> str:
    return f"{values[0]:g} to {values[-1]:g} ({len(values)})"


def cancel(job_id: Annotated[str, typer.Argument(help="Id of the job")], url: Url = _HERE, key: Key = None) -> None:
    """Stop a job; what it has computed stays readable."""
    service = ServiceClient(url, key)
    try:
        job = RemoteJob(service, service.ask("POST", f"/v1/jobs/{job_id}/cancel"))
    except ServiceFailed as error:
        _refuse(error)
    out.print(f"job {job.id} is {job.described['state']}", highlight=False)
