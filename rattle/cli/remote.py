"""Commands that use a running service."""

import json
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from rich.markup import escape
from rich.padding import Padding
from rich.table import Column, Table

from rattle.cli.console import Key, give_up, out, progress_line
from rattle.cli.result_tables import print_result
from rattle.remote.failure import ServiceFailed
from rattle.remote.job import RemoteJob
from rattle.remote.service import Service

Url = Annotated[str, typer.Option(envvar="RATTLE_URL", help="Address of the service")]
_HERE = "http://127.0.0.1:8000"
_ID_DIGITS, _NEWEST = 32, 200
_WIDE = 140


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
        job = Service(url, key).submit_text(body)
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
            f"no longer following; the job goes on. Look with `rattle status {job.id}`, "
            f"stop it with `rattle cancel {job.id}`"
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
        found = [job.described for job in Service(url, key).jobs(limit)]
    except ServiceFailed as error:
        _refuse(error)
    if as_json:
        typer.echo(json.dumps(found, indent=2))
        return
    _print_jobs(found)


def _print_jobs(found: list[dict[str, Any]]) -> None:
    """Print a table of jobs, or in little room some lines for each. Ids are whole: one that is cut cannot be used."""
    if out.width < _WIDE:
        for job in found:
            _print_job(job)
        return
    names = ["job", "kind", "state", "stage", "tiles", "submitted", "oscillator"]
    table = Table(*(Column(name, no_wrap=name == "job", overflow="fold") for name in names))
    for job in found:
        progress = job["progress"] or {}
        tiles = f"{progress['tiles_done']}/{progress['tiles_total']}" if progress else ""
        cells = {
            "job": job["id"], "kind": job["kind"], "state": job["state"], "stage": progress.get("stage", ""),
            "tiles": tiles, "submitted": job["created"][:19], "oscillator": _parameters(job["request"]),
        }  # fmt: skip
        table.add_row(*(cells[name] for name in names))
    out.print(table)


def _print_job(job: dict[str, Any]) -> None:
    """Print what a row of the table says, in lines."""
    progress = job["progress"] or {}
    done = f", {progress['tiles_done']} of {progress['tiles_total']} tiles" if progress else ""
    out.print(job["id"], highlight=False)
    out.print(Padding(f"{job['kind']}, {job['state']}{done}, {job['created'][:19]}", (0, 0, 0, 2)), highlight=False)
    if parameters := _parameters(job["request"]):
        out.print(Padding(escape(parameters), (0, 0, 0, 2)), highlight=False)


def _parameters(request: dict[str, Any]) -> str:
    """Parameters of a request's oscillator, those that are swept with their ends."""
    vary, design = request.get("vary", []), request.get("design", {"parameters": {}})
    swept = {each["parameter"]: each["values"] for each in (vary if isinstance(vary, list) else [vary])}
    swept |= design["parameters"]
    return ", ".join(
        f"{name} {_span(swept[name]) if name in swept else _written(value)}"
        for name, value in request["oscillator"].items()
        if name != "model"
    )


def _written(value: Any) -> str:
    """Value of a field of an oscillator: a number, a choice or a switch."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _span(values: list[float]) -> str:
    return f"{values[0]:g} to {values[-1]:g} ({len(values)})"


JobId = Annotated[str, typer.Argument(help="Id of the job, or its first digits")]


def _job(job_id: str, url: str, key: str | None) -> RemoteJob:
    """Job with an id, or the only one of the newest whose id begins like that."""
    service = Service(url, key)
    if len(job_id) == _ID_DIGITS:
        return service.job(job_id)
    found = [job for job in service.jobs(_NEWEST) if job.id.startswith(job_id)]
    if len(found) != 1:
        give_up(f"{len(found) or 'none'} of the {_NEWEST} newest jobs has an id that begins with {job_id!r}", 2)
    return found[0]


def status(
    job_id: JobId,
    url: Url = _HERE,
    key: Key = None,
    as_json: Annotated[bool, typer.Option("--json", help="As JSON")] = False,
) -> None:
    """Show one job: its state, how far it is, and how long it will take."""
    try:
        job = _job(job_id, url, key)
    except ServiceFailed as error:
        _refuse(error)
    if as_json:
        typer.echo(json.dumps(job.described, indent=2))
        return
    progress = job.described["progress"] or {}
    done = f", {progress['stage']}: {progress['tiles_done']} of {progress['tiles_total']}" if progress else ""
    left = progress.get("seconds_left")
    done += f", some {left:.0f} s left" if left else ""
    out.print(f"job {job.id}, {job.kind}: {job.described['state']}{done}", highlight=False, soft_wrap=True)
    if job.described["error"]:
        out.print(job.described["error"]["detail"], markup=False, highlight=False, soft_wrap=True)
    out.print(job.url, highlight=False, soft_wrap=True)


def fetch(
    job_id: JobId,
    out_: Annotated[Path, typer.Option("--out", help="Folder to make")],
    url: Url = _HERE,
    key: Key = None,
) -> None:
    """Copy the result of a job that has ended into a folder here, to the byte."""
    from worker.errors import WorkerError  # loads Numba, which the other commands here do not need

    try:
        _job(job_id, url, key).fetch(out_, progress=not out.quiet)
    except ServiceFailed as error:
        _refuse(error)
    except WorkerError as error:
        give_up(str(error))
    except OSError as error:
        give_up(f"{out_} cannot be written: {error.strerror}")
    out.print(f"{out_} is written", highlight=False, soft_wrap=True)


def cancel(job_id: JobId, url: Url = _HERE, key: Key = None) -> None:
    """Stop a job; what it has computed stays readable."""
    try:
        job = _job(job_id, url, key).cancel()
    except ServiceFailed as error:
        _refuse(error)
    out.print(f"job {job.id} is {job.described['state']}", highlight=False)


def delete(job_id: JobId, url: Url = _HERE, key: Key = None) -> None:
    """Stop a job, and delete it with its result."""
    try:
        job = _job(job_id, url, key)
        job.delete()
    except ServiceFailed as error:
        _refuse(error)
    out.print(f"job {job.id} is deleted", highlight=False)
