"""The command `rattle chart`."""

import json
from typing import Annotated, Any

import typer
from rich.table import Table

from rattle.cli.console import give_up, out, progress_line
from rattle.local import run_here
from rattle_chart.chart import job_of
from rattle_kernels import OutsideDomain
from worker.errors import InvalidJob, WorkerError
from worker.kinds import KINDS

_SPAN = "a number, or from where to where: 0.75:0.78"


def chart(
    out_: Annotated[str, typer.Option("--out", help="Zarr store to write; an unfinished one is resumed")],
    damping: Annotated[str, typer.Option(help=f"delta: {_SPAN}")] = "0.6",
    eccentricity: Annotated[str, typer.Option(help=f"epsilon: {_SPAN}")] = "0.1",
    half_backlash: Annotated[str, typer.Option(help=f"beta: {_SPAN}")] = "0.6",
    stiffness: Annotated[str | None, typer.Option(help="kappa; without it, the impacting model")] = None,
    restitution: Annotated[str | None, typer.Option(help="r of the impacting model; 1 is elastic")] = None,
    contact_damping: Annotated[str | None, typer.Option(help="zeta, with a stiffness")] = None,
    longest: Annotated[int, typer.Option(min=1, help="Greatest n+ of the orbits that are searched for")] = 2,
    lines: Annotated[int, typer.Option(min=1, help="Orbits are followed along so many lines each way")] = 3,
    velocity: Annotated[str, typer.Option(help="Speeds of departure among which orbits are searched for")] = "0:7",
    cells: Annotated[int, typer.Option(min=1, help="The search starts from so many cells each way")] = 16,
    pixels: Annotated[int, typer.Option(min=0, help="Machines each way below the curves; 0 for none")] = 40,
    departures: Annotated[int, typer.Option(min=1, help="Departures of each of them, so many each way")] = 16,
    workers: Annotated[int, typer.Option(min=1, help="Threads that compute")] = 2,
    scheduler: Annotated[str | None, typer.Option(help="Address of a Dask scheduler, in place of threads")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what is found as JSON alone")] = False,
) -> None:
    """Chart two parameters: curves of special points, points of codimension two, and what machines do."""
    texts = {
        "damping": damping, "eccentricity": eccentricity, "half_backlash": half_backlash, "stiffness": stiffness,
        "restitution": restitution, "contact_damping": contact_damping,
    }  # fmt: skip
    try:
        numbers = {name: None if text is None else _read(name, text) for name, text in texts.items()}
        speeds = _read("velocity", velocity)
        if not isinstance(speeds, tuple):
            raise InvalidJob(f"--velocity {velocity}: write from where to where, as in 0:7", ("velocity",))
        job = job_of(
            numbers, (), longest=longest, lines=lines, cells=cells, pixels=pixels, departures=departures,
            region={"velocity": {"start": speeds[0], "stop": speeds[1]}},
        )  # fmt: skip
    except (InvalidJob, OutsideDomain) as error:
        give_up(str(error), 2)
    out.quiet |= as_json
    try:
        with progress_line(KINDS["chart"].unit) as line:
            run_here(job, out_, line.report, compiling=line.compiling, workers=workers, scheduler=scheduler)
        found = KINDS["chart"].summarise(out_).model_dump(mode="json", exclude={"zarr"})
    except WorkerError as error:
        give_up(str(error))
    if as_json:
        typer.echo(json.dumps(found, indent=2))
        return
    _print(found)
    out.print(f"{out_} is complete; draw it with: rattle plot {out_} --out chart.png", highlight=False, soft_wrap=True)


def _read(name: str, text: str) -> float | tuple[float, float]:
    try:
        parts = [float(part) for part in text.split(":")]
    except ValueError:
        parts = []
    if len(parts) == 1:
        return parts[0]
    if len(parts) == 2:
        return parts[0], parts[1]
    option = name.replace("_", "-")
    raise InvalidJob(f"--{option} {text}: write a number, or from where to where, as in 0.75:0.78", (name,))


def _print(found: dict[str, Any]) -> None:
    first, second = found["parameters"]
    points = Table("point of codimension two", "orbit", first, second)
    for point in found["points"]:
        angle = f" {point['turns']}/{point['order']} pi" if point["order"] > 1 else ""
        points.add_row(point["kind"] + angle, point["orbit"], *(f"{value:.10g}" for value in point["values"]))
    out.print(points)
    curves = Table("curve", "orbit", f"{first} from", "to", f"{second} from", "to")
    for curve in found["curves"]:
        ends = (*curve["first"], *curve["second"])
        curves.add_row(curve["kind"], curve["orbit"], *(f"{value:.6g}" for value in ends))
    out.print(curves)
    if found["lines_without_orbits"]:
        out.print(f"lines along which no orbit was found: {found['lines_without_orbits']}", highlight=False)
