"""The command that recomputes a figure of the paper."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from rattle.cli.console import Scheduler, announced_compiling, give_up, out, progress_line
from worker.errors import InvalidJob, JobCancelled, WorkerError

if TYPE_CHECKING:
    from rattle_kernels import CellGrid
    from rattle_paper.figure import PaperFigure
    from rattle_paper.production import Produced


def paper(
    figure: Annotated[str, typer.Argument(help="Which one, as in fig7; another name lists them")],
    out_: Annotated[Path, typer.Option("--out", help="Folder of the PNG, its numbers (JSON) and the basins' stores")],
    cells: Annotated[tuple[int, int], typer.Option(help="Cells of basins along time and along velocity")] = (
        1000,
        1000,
    ),
    workers: Annotated[int, typer.Option(min=1, help="Threads that compute")] = 2,
    scheduler: Scheduler = None,
) -> None:
    """Recompute a figure of the paper and its numbers; basins that are there already are used, unfinished resumed."""
    # They load xarray and Numba, which other commands need not wait for.
    from rattle_kernels import CellGrid
    from rattle_paper.registry import figure_named

    try:
        grid = CellGrid(time_cells=cells[0], velocity_cells=cells[1])
        produced = _produce(figure_named(figure), out_, grid, workers, scheduler)
    except InvalidJob as error:
        give_up(str(error), 2)
    except (JobCancelled, KeyboardInterrupt):
        give_up(f"stopped; the same command goes on with the basins that are in {out_}")
    except WorkerError as error:
        give_up(str(error))
    except OSError as error:
        give_up(f"{out_} cannot be written: {error.strerror}")
    if produced.printed:
        table = Table("", "the paper", "found")
        for each in produced.printed:
            table.add_row(each["what"], f"{each['paper']:g}", f"{each['found']:.10g}")
        out.print(table)
    out.print(f"{produced.picture} is drawn; its numbers are in {produced.numbers}", highlight=False, soft_wrap=True)


def _produce(figure: "PaperFigure", folder: Path, grid: "CellGrid", workers: int, scheduler: str | None) -> "Produced":
    from rattle_paper.production import produce

    with progress_line(unit="") as line, announced_compiling(out):
        return produce(
            figure, folder, grid, report=lambda what, done, total: line.show(what, (done, total)),
            workers=workers, scheduler=scheduler,
        )  # fmt: skip
