"""The command that writes a result as an RO-Crate."""

from pathlib import Path
from typing import Annotated

import typer

from rattle.cli.console import give_up, out
from rattle.stores import export as export_crate
from worker.errors import InvalidJob, WorkerError


def export(
    store: Annotated[str, typer.Argument(help="Zarr store of any kind: a folder or s3://BUCKET/PREFIX")],
    zip_: Annotated[Path, typer.Option("--zip", help="File to write, whose name ends in .zip")],
    creator: Annotated[str | None, typer.Option(help="Who made the result; nobody is named by default")] = None,
    license_: Annotated[
        str | None, typer.Option("--license", help="SPDX name of the result's licence  [default: CC0-1.0]")
    ] = None,
) -> None:
    """Write a finished result as a zipped RO-Crate: its request, versions, tables and pictures."""
    try:
        export_crate(store, zip_, creator=creator, license=license_)
    except InvalidJob as error:
        give_up(str(error), 2)
    except WorkerError as error:
        give_up(str(error))
    except OSError as error:
        give_up(f"{zip_} cannot be written: {error.strerror or error}")
    out.print(f"{zip_} is written", highlight=False, soft_wrap=True)
