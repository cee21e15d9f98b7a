"""The commands of proofs."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.table import Table

from rattle.cli.console import announced_compiling, give_up, out, progress_line
from rattle_kernels import Oscillator, OutsideDomain
from rattle_proof.proving_chaos import prove_chaos as chaos_proven
from rattle_proof.proving_orbits import prove_orbits as orbits_proven
from rattle_proof.verification.verdict import Verification
from rattle_proof.verifying import verify as prove_again
from worker.errors import WorkerError

_Machine = Annotated[
    Path | None, typer.Argument(help="TOML file of a machine in its own units; without it, these numbers")
]
_Damping = Annotated[float, typer.Option(help="delta")]
_Eccentricity = Annotated[float, typer.Option(help="epsilon")]
_HalfBacklash = Annotated[float, typer.Option(help="beta")]
_AsJson = Annotated[bool, typer.Option("--json", help="Print what is found as JSON alone")]


def verify(
    store: Annotated[str, typer.Argument(help="Basin with a proof: a folder or s3://BUCKET/PREFIX")],
    cells: Annotated[str, typer.Option(help="Cells to try, of those with a proven part: a number, or all")] = "10000",
    boxes: Annotated[str, typer.Option(help="Boxes of the lattice to try: a number, or all (hours)")] = "10000",
    seed: Annotated[int, typer.Option(min=0, help="Of the random sample")] = 0,
    processes: Annotated[int, typer.Option(min=1, help="Processes that work")] = 2,
    anew: Annotated[bool, typer.Option("--anew", help="Try also what earlier runs have tried")] = False,
    as_json: _AsJson = False,
) -> None:
    """Prove again, by Arb balls, what a basin's store claims to be proven; exit with 1 if anything is not."""
    counts = _count("--cells", cells), _count("--boxes", boxes)
    out.quiet |= as_json
    try:
        with progress_line(unit="") as line:
            found = prove_again(
                store, cells=counts[0], boxes=counts[1], seed=seed, processes=processes, anew=anew,
                progress=lambda what, done, total: line.show(what, (done, total)),
            )  # fmt: skip
    except KeyboardInterrupt:
        give_up("stopped; the same command goes on from what was tried")
    except ImportError as error:
        give_up(str(error), 2)
    except WorkerError as error:
        give_up(str(error))
    if as_json:
        typer.echo(json.dumps(asdict(found), indent=2))
    _say(found)
    if not found.holds:
        raise typer.Exit(1)


def prove_chaos(
    machine: _Machine = None,
    damping: _Damping = 0.6,
    eccentricity: _Eccentricity = 0.1,
    half_backlash: _HalfBacklash = 0.6,
    restitution: Annotated[float, typer.Option(help="r; 1 is elastic")] = 1.0,
    tolerance: Annotated[
        list[str] | None, typer.Option(help="For every machine within, as in damping=0.59999:0.60001; several")
    ] = None,
    columns: Annotated[int, typer.Option(help="Boxes for a period, at least: a power of two")] = 2048,
    leaves: Annotated[int, typer.Option(help="Curves across the set that are tried")] = 200,
    cycles: Annotated[int, typer.Option(help="Impacts of the longest cycles that are looked at")] = 3,
    seed: Annotated[int, typer.Option(min=0, help="Of the departures from which chaos is sought")] = 0,
    as_json: _AsJson = False,
) -> None:
    """Prove that chaos is chaos: its topological entropy is positive, and its short cycles repel."""
    out.quiet |= as_json
    try:
        with announced_compiling():
            found = chaos_proven(
                machine or Oscillator(damping, eccentricity, half_backlash, restitution=restitution),
                tolerances=dict(map(_tolerance, tolerance or ())), columns=columns, leaves=leaves, cycles=cycles,
                seed=seed,
            )  # fmt: skip
    except (WorkerError, OutsideDomain) as error:
        give_up(str(error), 2)
    if as_json:
        typer.echo(json.dumps(found.to_dict(), indent=2))
    _line(str(found))


def prove_orbits(
    machine: _Machine = None,
    damping: _Damping = 0.6,
    eccentricity: _Eccentricity = 0.1,
    half_backlash: _HalfBacklash = 0.6,
    stiffness: Annotated[float, typer.Option(help="kappa")] = 1e4,
    contact_damping: Annotated[float, typer.Option(help="zeta")] = 0.0,
    departures: Annotated[int, typer.Option(help="Random departures from which motions are sought")] = 400,
    seed: Annotated[int, typer.Option(min=0, help="Of these")] = 0,
    as_json: _AsJson = False,
) -> None:
    """Prove that motions of finite stiffness attract: permanent contact and periodic orbits."""
    out.quiet |= as_json
    numbers = Oscillator(damping, eccentricity, half_backlash, stiffness, contact_damping=contact_damping)
    try:
        with announced_compiling():
            found = orbits_proven(machine or numbers, departures=departures, seed=seed)
    except (WorkerError, OutsideDomain, ImportError) as error:
        give_up(str(error), 2)
    if as_json:
        typer.echo(json.dumps(found.to_dict(), indent=2))
    _line(str(found))


def _tolerance(text: str) -> tuple[str, tuple[float, float]]:
    name, _, ends = text.partition("=")
    try:
        least, greatest = map(float, ends.split(":"))
    except ValueError:
        give_up(f"--tolerance {text}: write it as in damping=0.59999:0.60001", 2)
    return name.strip().replace("-", "_"), (least, greatest)


def _count(option: str, text: str) -> int | Literal["all"]:
    if text == "all":
        return "all"
    if not text.isdecimal():
        give_up(f"{option} takes a number or all, not {text}", 2)
    return int(text)


def _say(found: Verification) -> None:
    table = Table("", "of", "tried", "proven again", "contradicted", "not decided")
    for part in found.parts:
        numbers = part.of, part.tried, part.proven, part.contradicted, part.undecided
        table.add_row(part.name, *(f"{number:,}" for number in numbers))
    out.print(table)
    for part in found.parts:
        for failure in part.failures:
            what = "contradicted" if failure.contradicted else "not decided"
            _line(f"{what}: {part.name}, {failure.place}: {failure.why}")
    sampled = any(part.tried < part.of for part in found.parts)
    _line("all that was tried is proven again" if found.holds else "not all that was tried is proven again")
    earlier = sum(part.earlier for part in found.parts)
    if earlier:
        _line(f"{earlier:,} were tried by earlier runs of this code, and not again: --anew tries all")
    if sampled:
        _line("a sample was tried: the rest was not looked at")


def _line(text: str) -> None:
    out.print(text, highlight=False, soft_wrap=True, markup=False)
