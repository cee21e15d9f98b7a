"""The command that exports the tables of a result."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from rattle.cli.console import Key, give_up, out
from rattle.results import opening
from worker.errors import InvalidJob, StoreConflict, WorkerError
from worker.results.tables import TableFormat, Units, table_of, write_table


def table(
    store: Annotated[str, typer.Argument(help="Zarr store of any kind, or a service's address of one")],
    out_: Annotated[
        Path | None, typer.Option("--out", help="File to write: .csv or .json; standard output by default")
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Which table: a dimension or an array of the store; a wrong name lists them")
    ] = None,
    units: Annotated[
        Units, typer.Option(help="Of a machine: SI units beside those of the model, or in their place")
    ] = Units.BOTH,
    as_json: Annotated[bool, typer.Option("--json", help="As JSON on standard output")] = False,
    key: Key = None,
) -> None:
    """Write what a result lists as CSV or JSON: motions and shares, orbits, branches, curves, departures."""
    try:
        table_format = TableFormat.JSON if as_json else TableFormat.CSV
        table_format = table_format if out_ is None else TableFormat.of_file(out_)
        text = write_table(table_of(opening.open(store, key=key), name, units), table_format)
        if out_ is None:
            sys.stdout.write(text)
            return
        out_.write_text(text)
    except InvalidJob as error:
        give_up(str(error), 2)
    except (WorkerError, StoreConflict) as error:
        give_up(str(error))
    except OSError as error:
        give_up(f"{out_ or store}: {error.strerror or error}")
    out.print(f"{out_} is written", highlight=False, soft_wrap=True)
