"""The command that checks a store, and mends it."""

import json
from dataclasses import asdict
from typing import Annotated

import typer

from rattle.cli.console import Scheduler, give_up, out, progress_line
from rattle.stores import Check
from rattle.stores import check as check_and_mend
from worker.errors import JobCancelled, WorkerError

_MOST_LISTED = 40


def check(
    store: Annotated[str, typer.Argument(help="Zarr store of any kind: a folder or s3://BUCKET/PREFIX")],
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what is damaged; exit with 1 if anything is")] = (
        False
    ),
    workers: Annotated[int, typer.Option(min=1, help="Threads that compute")] = 2,
    scheduler: Scheduler = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what is found as JSON alone")] = False,
) -> None:
    """Read every file of a store; compute anew what is damaged or missing, to the same bytes."""
    out.quiet |= as_json
    try:
        with progress_line() as line:
            found = check_and_mend(
                store, dry_run=dry_run, workers=workers, scheduler=scheduler, computing=line.report,
                reading=lambda done, total: line.show("reading", (done, total), unit="chunks"),
            )  # fmt: skip
    except JobCancelled:
        give_up(f"stopped; the same command goes on from what is in {store}")
    except WorkerError as error:
        give_up(str(error))
    if as_json:
        typer.echo(json.dumps(asdict(found), indent=2))
    _say(found)
    if not found.mended:
        raise typer.Exit(1)


def _say(found: Check) -> None:
    for damage in found.damages[:_MOST_LISTED]:
        _line(str(damage))
    if len(found.damages) > _MOST_LISTED:
        _line(f"and {len(found.damages) - _MOST_LISTED} more")
    _line(f"{found.store}: {found.files} files read, {_verdict(found)}")
    if not found.complete:
        _line("its job has not finished; the command that began it goes on from what is there")


def _verdict(found: Check) -> str:
    if not found.damages:
        return "none is damaged or missing"
    count = f"{len(found.damages)} damaged or missing"
    if not found.mended:
        return f"{count}; without --dry-run they are computed anew"
    return f"{count}, computed anew" if found.complete else f"{count}, taken out"


def _line(text: str) -> None:
    out.print(text, highlight=False, soft_wrap=True, markup=False)
