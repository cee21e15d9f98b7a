"""Commands that speak to a running service."""

import contextlib
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import httpx2 as httpx
import typer
from rich.table import Table

from service.cli.analysis_tables import print_result
from service.cli.console import ProgressLine, give_up, out, progress_line
from worker.kinds import KINDS

Url = Annotated[str, typer.Option(envvar="RATTLE_URL", help="Address of the service")]
Key = Annotated[
    str | None, typer.Option(envvar="RATTLE_KEY", show_envvar=True, help="Key, if the service requires one")
]
_HERE = "http://127.0.0.1:8000"
# An idle stream sends a comment every 15 s.
_SILENCE_SECONDS = 40.0
_PATIENCE_SECONDS = 60.0
_PAUSE_SECONDS = 0.5


def _ask(method: str, url: str, path: str, key: str | None, **options: Any) -> Any:
    """JSON answer of the service. If there is none, print an error and exit."""
    headers = options.pop("headers", {}) | ({"authorization": f"Bearer {key}"} if key else {})
    try:
        response = httpx.request(method, url.rstrip("/") + path, timeout=30.0, headers=headers, **options)
    except httpx.HTTPError as error:
        give_up(f"no service answers at {url} ({error}); start one with `rattle serve`, or name another with --url")
    if response.is_error:
        problem = response.json()
        hint = "; give it by --key or RATTLE_KEY" if response.status_code == 401 else ""
        give_up(problem["detail"] + hint, 2 if response.status_code in (400, 401, 403, 404, 422) else 1)
    return response.json()


def submit(
    request: Annotated[Path, typer.Argument(help="JSON file of a request; - reads standard input")],
    wait: Annotated[bool, typer.Option("--wait", help="Follow the job to its end")] = False,
    url: Url = _HERE,
    key: Key = None,
) -> None:
    """Submit a request to a service; the same request again is the same job."""
    try:
        body = typer.get_text_stream("stdin").read() if str(request) == "-" else request.read_text()
    except OSError as error:
        give_up(f"{request} cannot be read: {error.strerror}", 2)
    job = _ask("POST", url, f"/v1/{_route_of(body)}", key, content=body, headers={"content-type": "application/json"})
    out.print(f"job {job['id']} is {job['state']}", highlight=False)
    if wait:
        _follow(url, job["id"], key)


def _route_of(body: str) -> str:
    """Route of a request: that of the kind it names, else of a sweep if it varies something, else of a basin."""
    request: Any = {}
    with contextlib.suppress(ValueError):
        request = json.loads(body)
    request = request if isinstance(request, dict) else {}
    unnamed = KINDS["sweep" if "vary" in request else "basin"]
    return KINDS.get(str(request.get("kind")), unnamed).path


def _follow(url: str, job_id: str, key: str | None) -> None:
    try:
        with progress_line() as line:
            job = until_the_end(url, job_id, key, line)
    except KeyboardInterrupt:
        out.print(
            f"no longer following; the job goes on. Look with `rattle jobs`, stop it with `rattle cancel {job_id}`"
        )
        raise typer.Exit(130) from None
    if job["state"] != "succeeded":
        detail = f": {job['error']['detail']}" if job["error"] else ""
        give_up(f"job {job_id} is {job['state']}{detail}")
    result = _ask("GET", url, f"/v1/jobs/{job_id}/result", key)
    print_result(job["kind"], result)
    out.print(f"xarray.open_zarr({(url.rstrip('/') + result['zarr'])!r})", highlight=False, soft_wrap=True)


def until_the_end(url: str, job_id: str, key: str | None, line: ProgressLine) -> dict[str, Any]:
    """Wait for a job's end. Its events are shown as they come; a stream that breaks is opened again.

    Parameters
    ----------
    url : str
        Address of the service.
    job_id : str
    key : str or None
        Key of a service that requires one.
    line : ProgressLine

    Returns
    -------
    dict
        The job, as the service describes it.
    """
    seen, patience = "0", time.monotonic() + _PATIENCE_SECONDS
    while True:
        try:
            for number, event in _events(url, job_id, key, seen):
                seen = number
                _show(event["progress"], line)
                if event["state"] in ("succeeded", "failed", "cancelled"):
                    job: dict[str, Any] = _ask("GET", url, f"/v1/jobs/{job_id}", key)
                    _show(job["progress"], line)  # the last one is written with the end, and may have no event
                    return job
                patience = time.monotonic() + _PATIENCE_SECONDS
        except httpx.HTTPError as error:  # the service is being restarted, perhaps
            if time.monotonic() > patience:
                give_up(f"{url} does not answer any more ({error}); the job goes on: look with `rattle jobs`")
        time.sleep(_PAUSE_SECONDS)


def _events(url: str, job_id: str, key: str | None, seen: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Numbers and data of a job's events after the last one seen, as long as the stream lasts."""
    headers = {"last-event-id": seen} | ({"authorization": f"Bearer {key}"} if key else {})
    address, fields = f"{url.rstrip('/')}/v1/jobs/{job_id}/events", {}
    with httpx.stream("GET", address, headers=headers, timeout=_SILENCE_SECONDS) as answer:
        if answer.is_client_error:
            give_up(json.loads(answer.read())["detail"], 2)
        answer.raise_for_status()
        for text in answer.iter_lines():
            name, _, value = text.partition(": ")
            fields[name] = value
            if not text and "data" in fields:
                yield fields["id"], json.loads(fields["data"])
                fields = {}


def _show(progress: dict[str, Any] | None, line: ProgressLine) -> None:
    if progress:
        tiles, basins = ((progress[f"{what}_done"], progress[f"{what}_total"]) for what in ("tiles", "basins"))
        line.show(progress["stage"], tiles, basins, progress["cells_per_second"])


def jobs(
    url: Url = _HERE,
    key: Key = None,
    limit: Annotated[int, typer.Option(min=1, max=200, help="How many")] = 20,
    as_json: Annotated[bool, typer.Option("--json", help="As JSON")] = False,
) -> None:
    """List the service's jobs, newest first."""
    page = _ask("GET", url, f"/v1/jobs?size={limit}", key)
    if as_json:
        typer.echo(json.dumps(page["jobs"], indent=2))
        return
    table = Table("job", "kind", "state", "stage", "tiles", "submitted", "oscillator")
    for job in page["jobs"]:
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
    job = _ask("POST", url, f"/v1/jobs/{job_id}/cancel", key)
    out.print(f"job {job['id']} is {job['state']}", highlight=False)
