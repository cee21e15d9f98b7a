"""The command that follows one motion: a picture or a table, and the list of its contacts."""

import csv
from pathlib import Path
from typing import Annotated, Any

import typer

from rattle import verbs
from rattle.arguments import trajectory_of
from rattle.cli.console import announced_compiling, give_up, out
from rattle.cli.options import arguments_from, options_of, with_options
from rattle_kernels import Direction, Oscillator, Outcome, TimeHistory
from worker.errors import InvalidFields
from worker.pictures.figure_file import PictureFormat, save_figure
from worker.pictures.history import history_figure

_OUTCOMES = {
    Outcome.RETURNED: "rattles on",
    Outcome.PERMANENT_CONTACT: "permanent contact",
    Outcome.NOT_CONVERGED: "undecided: a root-finder gave up at the end",
}
_MOST_SAMPLES = 2_000_000


def _write(oscillator: Oscillator, history: TimeHistory, target: Path) -> None:
    try:
        if target.suffix != ".csv":
            save_figure(history_figure(oscillator, history), target)
            return
        with target.open("w", newline="") as file:
            table = csv.writer(file)
            table.writerow(("time", "displacement", "velocity"))
            table.writerows(zip(*(field.tolist() for field in history[:3]), strict=True))
    except OSError as error:
        give_up(f"{target} cannot be written: {error.strerror}")


def _print_contacts(history: TimeHistory) -> None:
    typer.echo("       time  wall  what    speed")
    for time, wall, direction, speed in zip(*history.contacts, strict=True):
        typer.echo(f"{time:11.6f}  {wall:+4d}  {Direction(direction).name.lower():<6}  {speed:.6g}")


@with_options(options_of(verbs.trajectory))
def trajectory(
    out_: Annotated[Path, typer.Option("--out", help="Picture (.png, .svg, .pdf) or table (.csv) to write")],
    **values: Any,
) -> None:
    """Follow one motion of either model: draw Phi(t) or write it down, and list its contacts."""
    if out_.suffix not in (".csv", *(f".{each}" for each in PictureFormat)):
        give_up(f"{out_} should end in .png, .svg, .pdf or .csv", 2)
    samples = values["periods"] * values["samples_per_period"]
    if not samples <= _MOST_SAMPLES:
        give_up(f"{samples:.0f} samples are more than the limit of {_MOST_SAMPLES}", 2)
    try:
        request = trajectory_of(arguments_from(verbs.trajectory, values))
        with announced_compiling():
            history = request.follow()
    except InvalidFields as error:
        give_up("; ".join(f"{place[-1]}: {message}" for place, message in error.faults), 2)
    except ValueError as error:
        give_up(str(error), 2)
    oscillator = request.oscillator.value
    _write(oscillator, history, out_)
    _print_contacts(history)
    ends = f", truncated at {history.contacts.time.size} contacts" if history.truncated else ""
    out.print(f"t = {history.time[-1]:g}: {_OUTCOMES[history.outcome]}{ends}; {out_} is written", highlight=False)
