"""Commands that compute here, without a service: one basin, or a sweep of them."""

from typing import Annotated

import typer

from rattle_kernels import CellGrid
from service.cli.console import print_changes, print_seconds, print_solutions
from service.cli.local_run import run_here
from service.cli.oscillator import (
    AllowNoQuietSolution,
    Damping,
    Eccentricity,
    HalfBacklash,
    Rule,
    Stiffness,
    oscillator_of,
)
from service.models.oscillator import PermanentContact
from worker.errors import InvalidJob
from worker.jobs.basin_job import SETTLED, BasinJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import Spacing, SweptParameter
from worker.stores.summary import BasinSummary

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

    def job() -> BasinJob:
        return BasinJob(oscillator, grid, iterations or SETTLED, (), _sample(sample, seed))

    run_here(job, out_, workers, _print, quiet_or_not=allow_no_quiet_solution)


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

    run_here(job, out_, workers, _print, quiet_or_not=allow_no_quiet_solution)


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
