"""The command: measure, print tables, write a JSON and a picture."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from benchmarks.suite import peers  # noqa: F401 - enters its methods
from benchmarks.suite.measuring import measure_all
from benchmarks.suite.methods import METHODS, Method
from benchmarks.suite.report import Failed, Measured, Run, UnusableRun, check_same_inputs, read_run
from benchmarks.suite.showing import draw, tables
from benchmarks.suite.workloads import WORKLOADS

# What `--quick` takes of each method's inputs, along each axis.
_QUICK = 25


def chosen(only: Sequence[str]) -> list[Method]:
    """Methods by names of workloads and of methods, all where none is named.

    Raises
    ------
    ValueError
        If a name is unknown, or nothing is left.
    """
    names = {method.name for method in METHODS}
    unknown = [name for name in only if name not in names | WORKLOADS.keys()]
    if unknown:
        of_workloads, of_methods = (", ".join(map(repr, each)) for each in (WORKLOADS, sorted(names)))
        raise ValueError(f"{unknown[0]!r} is neither a workload ({of_workloads}) nor a method ({of_methods})")
    workloads, methods = WORKLOADS.keys() & only or WORKLOADS.keys(), names & set(only) or names
    found = [method for method in METHODS if method.workload in workloads and method.name in methods]
    if not found:
        raise ValueError("none of these methods does any of these workloads")
    return found


def faults(run: Run) -> list[str]:
    """What went wrong in a run, a line for each method: a wrong answer, or an error."""
    found = []
    for workload, results in run.workloads.items():
        for method, told in results.methods.items():
            if isinstance(told, Failed):
                found.append(f"{workload}, {method} failed: {told.failed}")
            elif isinstance(told, Measured) and not told.agrees:
                found.append(
                    f"{workload}, {method} is wrong: error {told.error:.1e}, where {told.allowed:.1e} is allowed"
                )
    return found


def run_suite(
    only: Annotated[
        list[str] | None, typer.Option(help="Name of a workload or of a method; may be given several times.")
    ] = None,
    repeat: Annotated[int, typer.Option(min=1, help="Repetitions; the fastest counts.")] = 3,
    out: Annotated[Path, typer.Option(help="The JSON; the picture stands beside it.")] = Path("build/suite.json"),
    beside: Annotated[Path | None, typer.Option(help="JSON of another run, shown beside this one.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Few inputs: whether all runs. Its rates say little.")] = False,
) -> None:
    """Measure how fast each method does each workload, and check its answers."""
    if out.suffix != ".json":
        raise typer.BadParameter(f"a file whose name ends in .json is needed, not {out}", param_hint="--out")
    try:
        methods = chosen(only or [])
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--only") from error
    try:
        other = read_run(beside) if beside else None
        if other:
            check_same_inputs({method.workload for method in methods}, other)
    except UnusableRun as error:
        raise typer.BadParameter(str(error), param_hint="--beside") from error
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.open("ab").close()
    except OSError as error:
        raise typer.BadParameter(f"{out} cannot be written: {error.strerror}", param_hint="--out") from error
    console = Console()
    with console.status("") as status:
        run = measure_all(
            methods,
            repeat,
            thinner=_QUICK if quick else 1,
            report=lambda method: status.update(f"{method.workload}: {method.name}"),
        )
    console.print(run.machine, *([f"beside: {other.machine}"] if other else []), "", *tables(run, other), sep="\n")
    out.write_text(run.model_dump_json(indent=1) + "\n")
    picture = out.with_suffix(".png")
    draw([run, other] if other else [run], picture)
    console.print(f"{out} and {picture}")
    if found := faults(run):
        console.print(*found, sep="\n", style="red")
        raise typer.Exit(1)


app = typer.Typer(add_completion=False)
app.command()(run_suite)
