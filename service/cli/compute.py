"""Commands that compute here, without a service: one basin, or a sweep of them."""

from collections.abc import Callable
from typing import Annotated

import typer

from rattle_kernels import CellGrid, OutsideDomain
from service.cli.console import (
    announce_compiling,
    give_up,
    out,
    print_changes,
    print_seconds,
    print_solutions,
    progress_line,
)
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
from service.oscillator_model import PermanentContact, demand_quiet
from service.settings import Settings
from worker.basin_job import SETTLED, BasinJob
from worker.cluster import connect
from worker.errors import InvalidJob, JobCancelled, WorkerError
from worker.pipeline import run_basin
from worker.progress import Progress
from worker.results import BasinSummary
from worker.sample import Sample
from worker.swept_parameter import Spacing, SweptParameter

Out = Annotated[
    str, typer.Option("--out", help="Zarr store to write, a folder or s3://BUCKET/PREFIX; an unfinished one is resumed")
]
Cells = Annotated[tuple[int, int], typer.Option(help="Cells along time and along velocity")]
Time = Annotated[tuple[float, float], typer.Option(help="Window of phases")]
Velocity = Annotated[tuple[float, float], typer.Option(help="Window of speeds")]
Iterations = Annotated[
    int | None,
    typer.Option(
        min=1, help="k of P_corr o P^k: 1 or a prime; default 1499 at a damping of 0.5 or more, else 900/damping"
    ),
]
Points = Annotated[int | None, typer.Option("--sample", help="Start from so many points in place of cells")]
Seed = Annotated[int, typer.Option(help="Of the sample: the same seed gives the same points")]
Workers = Annotated[int, typer.Option(min=1, help="Worker processes")]


def basin(
    out_: Out,
    damping: Damping = 0.6,
    eccentricity: Eccentricity = 0.1,
    half_backlash: HalfBacklash = 0.6,
    stiffness: Stiffness = None,
    rule: Rule = PermanentContact.ENVELOPE,
    allow_no_quiet_solution: AllowNoQuietSolution = False,
    cells: Cells = (1000, 1000),
    time: Time = (0.0, 1.0),
    velocity: Velocity = (0.0, 7.0),
    iterations: Iterations = None,
    sample: Points = None,
    seed: Seed = 0,
    workers: Workers = 2,
) -> None:
    """Compute one basin on this machine, without a service."""
    oscillator = oscillator_of(damping, eccentricity, half_backlash, stiffness, rule)
    grid = CellGrid(*time, cells[0], *velocity, cells[1])
    _run(
        lambda: BasinJob(oscillator, grid, iterations or SETTLED, (), _sample(sample, seed)),
        allow_no_quiet_solution,
        out_,
        workers,
    )


def sweep(
    out_: Out,
    vary: Annotated[
        list[str],
        typer.Option(help="damping=0.5,0.55,0.6 or damping=0.5:0.7:21[:geometric]; once or twice, the last fastest"),
    ],
    damping: Damping = 0.6,
    eccentricity: Eccentricity = 0.1,
    half_backlash: HalfBacklash = 0.6,
    stiffness: Stiffness = None,
    rule: Rule = PermanentContact.ENVELOPE,
    allow_no_quiet_solution: AllowNoQuietSolution = False,
    cells: Cells = (200, 200),
    time: Time = (0.0, 1.0),
    velocity: Velocity = (0.0, 7.0),
    iterations: Iterations = None,
    sample: Points = None,
    seed: Seed = 0,
    workers: Workers = 2,
) -> None:
    """Compute basins over one or two parameters into one store, on this machine."""
    oscillator = oscillator_of(damping, eccentricity, half_backlash, stiffness, rule)
    grid = CellGrid(*time, cells[0], *velocity, cells[1])

    def job() -> BasinJob:
        swept = tuple(swept_of(text) for text in vary)
        if stiffness is None and any(each.parameter == "stiffness" for each in swept):
            # The model is the piecewise linear one; its stiffness is the sweep's.
            return BasinJob(
                oscillator._replace(stiffness=1.0), grid, iterations or SETTLED, swept, _sample(sample, seed)
            )
        return BasinJob(oscillator, grid, iterations or SETTLED, swept, _sample(sample, seed))

    _run(job, allow_no_quiet_solution, out_, workers)


def _sample(points: int | None, seed: int) -> Sample | None:
    return Sample(points, seed) if points is not None else None


def swept_of(text: str) -> SweptParameter:
    """Swept parameter as the command line writes it."""
    parameter, _, values = text.partition("=")
    try:
        if ":" not in values:
            return SweptParameter(parameter, tuple(float(value) for value in values.split(",") if value))
        start, stop, count, *spacing = values.split(":")
        return SweptParameter.spaced(parameter, float(start), float(stop), int(count), Spacing(*spacing or ["linear"]))
    except (ValueError, TypeError) as error:
        raise InvalidJob(f"--vary {text}: write damping=0.5,0.55,0.6 or damping=0.5:0.7:21 ({error})") from error


def _run(describe: Callable[[], BasinJob], allow_no_quiet_solution: bool, out_: str, workers: int) -> None:
    try:
        job = describe()
        demand_quiet(job.demand_quiet, unless=allow_no_quiet_solution)
    except (OutsideDomain, InvalidJob) as error:
        give_up(str(error), 2)
    try:
        summary = _compute(job, out_, Settings(), workers)
    except JobCancelled:
        give_up(f"stopped; the same command goes on from what is in {out_}")
    except WorkerError as error:
        give_up(str(error))
    _print(summary)
    out.print(f"{out_} is complete; draw it with: rattle plot {out_} --out basin.png", highlight=False, soft_wrap=True)


def _print(summary: BasinSummary) -> None:
    print_solutions(
        [
            (
                attractor.name,
                share,
                _number(attractor.lyapunov_exponent),
                _number(attractor.mean_life),
                list(zip(attractor.time[:1], attractor.velocity, strict=False)),
            )
            for attractor, share in zip(summary.attractors, summary.shares, strict=True)
        ]
    )
    names = [attractor.name for attractor in summary.attractors]
    print_changes(
        [
            (
                change.kind.name.lower(),
                change.solution,
                names[change.solution],
                change.parameter,
                change.before,
                change.after,
            )
            for change in summary.changes
        ]
    )
    print_seconds(summary.seconds)


def _number(value: float) -> float | None:
    return value if value == value else None


def _compute(job: BasinJob, location: str, settings: Settings, workers: int) -> BasinSummary:
    announce_compiling()
    cluster = connect(settings.scheduler, workers, settings.certificates)
    with cluster as client, progress_line() as line:

        def report(progress: Progress) -> None:
            line.show(
                progress.stage,
                (progress.tiles_done, progress.tiles_total),
                (progress.basins_done, progress.basins_total),
                progress.cells_per_second,
            )

        return run_interruptibly(lambda cancel: run_basin(job, location, client, report=report, cancel=cancel))
