"""Commands that need no service: start one, compute a basin here, draw one."""

import signal
from pathlib import Path
from typing import Annotated

import typer
import uvicorn

from rattle_kernels import CellGrid, OutsideDomain
from service.app import create_app
from service.cli.console import announce_compiling, err, give_up, out, print_seconds, print_solutions, progress_line
from service.cli.interruptible import run_interruptibly
from service.cli.oscillator import (
    AllowNoQuietSolution,
    Damping,
    Eccentricity,
    HalfBacklash,
    Rule,
    Stiffness,
    oscillator_of,
)
from service.oscillator_model import PermanentContact
from service.settings import Settings
from worker.basin_job import BasinJob
from worker.cluster import connect
from worker.errors import InvalidJob, JobCancelled, WorkerError
from worker.picture import Layer, draw_basin
from worker.pipeline import run_basin
from worker.progress import Progress
from worker.results import BasinSummary

_LOOPBACK = ("127.0.0.1", "::1", "localhost")


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on; loopback only  [default: 127.0.0.1]")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on  [default: 8000]")] = None,
    data: Annotated[Path | None, typer.Option(help="Folder of database and results  [default: rattle-data]")] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Local worker processes  [default: 2]")] = None,
) -> None:
    """Start the service, its database and two local workers; Ctrl-C stops it, the next start resumes its jobs."""
    given = {"host": host, "port": port, "data": data, "workers": workers}
    settings = Settings(**{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]
    if settings.host not in _LOOPBACK:
        give_up(f"{settings.host} is no loopback address: the service has no log-in and listens on 127.0.0.1 only", 2)
    err.print(f"starting on http://{settings.host}:{settings.port}")
    announce_compiling()
    # Uvicorn stops gracefully, then raises the signal that it caught again: a service that was asked to stop has not
    # failed.
    for asked in (signal.SIGTERM, signal.SIGINT):
        signal.signal(asked, lambda *_: None)
    # A stream that a client holds open must not keep the service from stopping.
    uvicorn.run(
        create_app(settings), host=settings.host, port=settings.port, log_level="warning", timeout_graceful_shutdown=2
    )


def basin(
    out_: Annotated[Path, typer.Option("--out", help="Zarr store to write; an unfinished one is resumed")],
    damping: Damping = 0.6,
    eccentricity: Eccentricity = 0.1,
    half_backlash: HalfBacklash = 0.6,
    stiffness: Stiffness = None,
    rule: Rule = PermanentContact.ENVELOPE,
    allow_no_quiet_solution: AllowNoQuietSolution = False,
    cells: Annotated[tuple[int, int], typer.Option(help="Cells along time and along velocity")] = (1000, 1000),
    time: Annotated[tuple[float, float], typer.Option(help="Window of phases")] = (0.0, 1.0),
    velocity: Annotated[tuple[float, float], typer.Option(help="Window of speeds")] = (0.0, 7.0),
    iterations: Annotated[int, typer.Option(help="k of P_corr o P^k: 1 or a prime")] = 1499,
    workers: Annotated[int, typer.Option(min=1, help="Worker processes")] = 2,
) -> None:
    """Compute one basin on this machine, without a service."""
    try:
        grid = CellGrid(*time, cells[0], *velocity, cells[1])
        oscillator = oscillator_of(damping, eccentricity, half_backlash, stiffness, rule, allow_no_quiet_solution)
        job = BasinJob(oscillator, grid, iterations)
    except (OutsideDomain, InvalidJob) as error:
        give_up(str(error), 2)
    try:
        summary = _compute(job, str(out_), Settings().scheduler, workers)
    except JobCancelled:
        give_up(f"stopped; the same command goes on from what is in {out_}")
    except WorkerError as error:
        give_up(str(error))
    print_solutions(
        [
            (
                attractor.name,
                share,
                _number(attractor.lyapunov_exponent),
                list(zip(attractor.time[:1], attractor.velocity, strict=False)),
            )
            for attractor, share in zip(summary.attractors, summary.shares, strict=True)
        ]
    )
    print_seconds(summary.seconds)
    out.print(f"{out_} is complete; draw it with: rattle plot {out_} --out basin.png", highlight=False, soft_wrap=True)


def _number(value: float) -> float | None:
    return value if value == value else None


def _compute(job: BasinJob, location: str, scheduler: str | None, workers: int) -> BasinSummary:
    announce_compiling()
    with connect(scheduler, workers) as client, progress_line() as line:

        def report(progress: Progress) -> None:
            line.show(progress.stage, progress.tiles_done, progress.tiles_total, progress.cells_per_second)

        return run_interruptibly(lambda cancel: run_basin(job, location, client, report=report, cancel=cancel))


def plot(
    store: Annotated[Path, typer.Argument(help="Zarr store of a basin, complete or not")],
    out_: Annotated[Path, typer.Option("--out", help="PNG to write")],
    layer: Annotated[Layer, typer.Option(help="Solutions, or Hsu's group, period or step")] = Layer.SOLUTION,
) -> None:
    """Draw a basin in the paper's colours."""
    try:
        draw_basin(str(store), out_, layer=layer)
    except WorkerError as error:
        give_up(str(error))
    except OSError as error:
        give_up(f"{out_} cannot be written: {error.strerror}")
