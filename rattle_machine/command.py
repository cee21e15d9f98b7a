"""The commands of studies of a machine."""

import json
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

from rattle.cli.console import announced_compiling, give_up, out
from rattle_kernels import OutsideDomain
from rattle_machine import pulses as of_pulses
from rattle_machine import report as of_reports
from rattle_machine import threshold as of_thresholds
from rattle_machine import tolerances as of_tolerances
from worker.errors import InvalidJob, WorkerError

Machine = Annotated[Path, typer.Argument(help="TOML file of a machine in its own units")]
Distribution = Annotated[
    of_pulses.Distribution | None,
    typer.Option(help="Of the sizes: normal about 0 with this deviation, which is the default, or with this mean"),
]
Pressing = Annotated[
    of_pulses.Pressing, typer.Option(help="What a pulse that presses the teeth together does, without a mesh stiffness")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the sample")]
AsJson = Annotated[bool, typer.Option("--json", help="Print what is found as JSON alone")]
_SIZE = 'Torque pulse on the driven shaft, as in "0.05 N m s"; or a CSV file of sizes in N m s'


def pulses(
    machine: Machine,
    rate: Annotated[str, typer.Option(help='How often pulses come, as in "3 / hour"')],
    size: Annotated[str, typer.Option(help=_SIZE)],
    distribution: Distribution = None,
    pressing: Pressing = "bounces",
    departures: Annotated[int, typer.Option(min=2, help="Pulses that are followed")] = 10_000,
    seed: Seed = 0,
    out_: Annotated[Path | None, typer.Option("--out", help="CSV file of the pulses, one in each line")] = None,
    as_json: AsJson = False,
) -> None:
    """How often torque pulses make a quiet machine rattle, for how long, and with what power."""
    try:
        with announced_compiling():
            found = of_pulses.pulses(
                machine, rate=_number(rate), size=_number(size), distribution=distribution,
                pressing=pressing, departures=departures, seed=seed,
            )  # fmt: skip
    except (WorkerError, OutsideDomain) as error:
        give_up(str(error), 2)
    _write(found.table, out_)
    _print(json.dumps(found.to_dict(), indent=2) if as_json else str(found), as_json)


def threshold(
    machine: Machine,
    parameter: Annotated[str, typer.Argument(help="speed, backlash, drag_torque, transmission_error.1.amplitude, ...")],
    share: Annotated[float, typer.Option(help="The share to be reached, between 0 and 1")],
    between: Annotated[tuple[str, str], typer.Option(help="Two values, as in --between 40um 200um")],
    motion: Annotated[str, typer.Option(help="Whose share, by its name")] = of_thresholds.QUIET,
    size: Annotated[str | None, typer.Option(help=_SIZE + "; without it departures are uniform over a window")] = None,
    distribution: Distribution = None,
    pressing: Pressing = "bounces",
    fastest: Annotated[float | None, typer.Option(help="Upper end of the window of departures, m/s")] = None,
    departures: Annotated[int, typer.Option(min=2, help="Departures of the sample")] = 4096,
    seed: Seed = 0,
    scan: Annotated[int, typer.Option(min=2, help="Values at which crossings are looked for")] = 9,
    as_json: AsJson = False,
) -> None:
    """The value of a machine's parameter at which a share of quiet, or of another motion, is reached."""
    try:
        with announced_compiling():
            found = of_thresholds.threshold(
                machine, parameter, share, between=(_number(between[0]), _number(between[1])), motion=motion,
                size=None if size is None else _number(size), distribution=distribution,
                pressing=pressing, fastest=fastest, departures=departures, seed=seed, scan=scan,
            )  # fmt: skip
    except (WorkerError, OutsideDomain) as error:
        give_up(str(error), 2)
    _print(json.dumps(found.to_dict(), indent=2) if as_json else str(found), as_json)


def tolerances(
    machine: Machine,
    number: Annotated[
        list[str],
        typer.Option(help='backlash="35 +- 10 um", "... , normal", or transmission_error.2.phase=any; several'),
    ],
    machines: Annotated[int, typer.Option(help="Machines that are computed, at most")] = 1024,
    departures: Annotated[int, typer.Option(min=2, help="Departures that each machine meets")] = 1000,
    size: Annotated[str | None, typer.Option(help=_SIZE + "; without it departures are uniform over a window")] = None,
    distribution: Distribution = None,
    pressing: Pressing = "bounces",
    rate: Annotated[str | None, typer.Option(help='How often pulses come, as in "3 / hour"')] = None,
    fastest: Annotated[float | None, typer.Option(help="Upper end of the window of departures, m/s")] = None,
    limit: Annotated[float, typer.Option(help="Quiet share below which a machine is bad")] = 0.99,
    tighten: Annotated[float, typer.Option(help="Part of its width to which the guilty tolerance is tightened")] = 0.5,
    prove: Annotated[
        bool, typer.Option("--prove", help="Prove how fast teeth may part and fall quiet in every machine then")
    ] = False,
    seed: Seed = 0,
    out_: Annotated[Path | None, typer.Option("--out", help="CSV file of the machines, one in each line")] = None,
    as_json: AsJson = False,
) -> None:
    """How quiet the machines of a production are, and which tolerance is to blame for those that are not."""
    try:
        with announced_compiling():
            found = of_tolerances.tolerances(
                machine, dict(map(_named, number)), machines=machines, departures=departures,
                size=None if size is None else _number(size),
                distribution=distribution, pressing=pressing,
                rate=None if rate is None else _number(rate), fastest=fastest, limit=limit, tighten=tighten,
                prove=prove, seed=seed,
            )  # fmt: skip
    except (WorkerError, OutsideDomain) as error:
        give_up(str(error), 2)
    _write(found.table, out_)
    _print(json.dumps(found.to_dict(), indent=2) if as_json else str(found), as_json)


def report(
    machine: Machine,
    out_: Annotated[Path | None, typer.Option("--out", help="HTML file; by default beside the TOML file")] = None,
    rate: Annotated[str | None, typer.Option(help='How often torque pulses come, as in "3 / hour"')] = None,
    size: Annotated[str | None, typer.Option(help=_SIZE)] = None,
    distribution: Distribution = None,
    pressing: Pressing = "bounces",
    number: Annotated[
        list[str] | None,
        typer.Option(help='A tolerance, as in backlash="35 +- 10 um"; several'),
    ] = None,
    machines: Annotated[int, typer.Option(help="Machines of the production, at most")] = 1024,
    departures: Annotated[int, typer.Option(min=4, help="Departures at each speed, and pulses")] = 2000,
    cells: Annotated[int, typer.Option(min=1, help="Of the basin, each way")] = 300,
    speeds: Annotated[int, typer.Option(min=2, help="At which the machine is looked at")] = 16,
    limit: Annotated[float, typer.Option(help="Quiet share below which a machine is bad")] = 0.99,
    prove: Annotated[
        bool | None,
        typer.Option(
            help="Prove how fast teeth may part in every machine of the production", show_default="if installed"
        ),
    ] = None,
    seed: Seed = 0,
    title: Annotated[str | None, typer.Option(help="By default the name of the TOML file")] = None,
) -> None:
    """Write one page that prints: what a machine does, how loud, how often, and which tolerance is to blame."""
    path = out_ or machine.with_suffix(".html")
    try:
        with announced_compiling():
            written = of_reports.report(
                machine, path, rate=None if rate is None else _number(rate),
                size=None if size is None else _number(size),
                distribution=distribution, pressing=pressing,
                numbers=dict(map(_named, number or ())) or None, machines=machines, departures=departures, cells=cells,
                speeds=speeds, limit=limit, prove=prove, seed=seed, title=title, progress=not out.quiet,
            )  # fmt: skip
    except (WorkerError, OutsideDomain) as error:
        give_up(str(error), 2)
    except OSError as error:
        give_up(f"{path} cannot be written: {error.strerror}")
    out.print(f"{written} is written", highlight=False, soft_wrap=True, markup=False)


def _named(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise InvalidJob(f'--number {text}: write a name and its tolerance, as in backlash="35 +- 10 um"')
    return name.strip().replace("-", "_"), value.strip()


def _write(table: pd.DataFrame, path: Path | None) -> None:
    if path is not None:
        try:
            table.to_csv(path, index=False)
        except OSError as error:
            give_up(f"{path} cannot be written: {error.strerror}")


def _number(text: str) -> float | str:
    """A number is in SI units, as in Python; anything else has its unit."""
    try:
        return float(text)
    except ValueError:
        return text


def _print(text: str, as_json: bool) -> None:
    if as_json:
        typer.echo(text)
    else:
        out.print(text, highlight=False, soft_wrap=True, markup=False)
