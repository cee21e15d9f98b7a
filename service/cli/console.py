"""Output of commands: progress bars on a terminal, plain lines elsewhere; errors take one line and name a next step."""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

out = Console()
err = Console(stderr=True)
_PLAIN_LINE_SECONDS = 2.0
_MOST_CHANGES = 20


def give_up(message: str, code: int = 1) -> NoReturn:
    """Print an error and exit: with code 2 if the command was wrong, 1 if the work failed."""
    err.print(f"[bold red]error:[/] {message}", highlight=False, soft_wrap=True)
    raise typer.Exit(code)


def announce_compiling() -> None:
    """Say why nothing happens for some seconds, where kernels have not been compiled on this machine yet."""
    from rattle_kernels import compiled_before  # loads Numba, which commands that only ask a service do without

    if not compiled_before():
        err.print("compiling the kernels: some ten seconds, the first time only")


class ProgressLine:
    """Shows the stages of a job as they pass."""

    def __init__(self, bar: Progress | None, unit: str) -> None:
        self.bar, self.unit = bar, unit
        self.task = bar.add_task("waiting", total=None, pace="") if bar else None
        self.stage, self.said = "", 0.0

    def show(
        self, stage: str, done: tuple[int, int], basins: tuple[int, int] = (1, 1), cells_per_second: float = 0.0
    ) -> None:
        """Show the progress of a stage: units and basins that are done, and their totals."""
        pace = f"{cells_per_second / 1e3:,.0f} thousand cells/s" if cells_per_second else ""
        if basins[1] > 1:
            pace = f"{basins[0]} of {basins[1]} basins {pace}"
        if self.bar is not None and self.task is not None:
            self.bar.update(self.task, description=stage, completed=done[0], total=done[1], pace=pace)
        elif stage != self.stage or time.monotonic() - self.said > _PLAIN_LINE_SECONDS:
            self.said = time.monotonic()
            out.print(" ".join(f"{stage}: {done[0]} of {done[1]} {self.unit} {pace}".split()), highlight=False)
        self.stage = stage


@contextmanager
def progress_line(unit: str = "tiles") -> Iterator[ProgressLine]:
    """Progress bar on a terminal, a plain line every other second elsewhere; `unit` names what is counted."""
    if not out.is_terminal:
        yield ProgressLine(None, unit)
        return
    columns = (
        TextColumn("{task.description:<11}"), BarColumn(), MofNCompleteColumn(), TextColumn(unit),
        TimeRemainingColumn(), TextColumn("{task.fields[pace]}"),
    )  # fmt: skip
    with Progress(*columns, console=out) as bar:
        yield ProgressLine(bar, unit)


def print_solutions(
    rows: Sequence[tuple[str, float | None, float | None, float | None, Sequence[tuple[float, float]]]],
) -> None:
    """Print a table of solutions: name, share, Lyapunov exponent, mean life of a chaotic transient, first point."""
    table = Table("", "solution", "share", "Lyapunov exponent", "a departure (t, v)")
    for number, (name, share, exponent, life, points) in enumerate(rows):
        table.add_row(
            str(number),
            name if life is None else f"{name} for some {life:.1g} impacts",
            "not known yet" if share is None else f"{100 * share:.3f} %",
            "" if exponent is None else f"{exponent:.4f}",
            f"({points[0][0]:.6f}, {points[0][1]:.6f})" if points else "",
        )
    out.print(table)


def print_changes(rows: Sequence[tuple[str, int, str, str, float, float]]) -> None:
    """Print births and deaths of solutions: kind, number, name, parameter, its values before and after."""
    for kind, number, name, parameter, before, after in rows[:_MOST_CHANGES]:
        out.print(f"{kind} of {number}: {name} between {parameter} {before:g} and {after:g}", highlight=False)
    if len(rows) > _MOST_CHANGES:
        out.print(f"and {len(rows) - _MOST_CHANGES} more births and deaths", highlight=False)


def print_seconds(seconds: Mapping[str, Any]) -> None:
    """Print how long each stage took."""
    if seconds:
        stages = ", ".join(f"{name.replace('_', ' ')} {value:.2f} s" for name, value in seconds.items())
        out.print(stages, highlight=False, soft_wrap=True)
