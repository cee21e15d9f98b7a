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
# Plain lines come ever more seldom, from every few seconds on to one a minute.
_PLAIN_LINE_SECONDS = 5.0
_SELDOM_SECONDS = 60.0
_MOST_CHANGES = 20


def give_up(message: str, code: int = 1) -> NoReturn:
    """Print an error and exit: with code 2 if the command was wrong, 1 if the work failed."""
    err.print(f"[bold red]error:[/] {message}", highlight=False, soft_wrap=True)
    raise typer.Exit(code)


def _say_compiling(console: Console) -> None:
    console.print("compiling the kernels, the first time only: a minute or so", highlight=False)


@contextmanager
def announced_compiling(console: Console = err) -> Iterator[None]:
    """Say why nothing happens for a while, once, as soon as a kernel has to be compiled."""
    from rattle_kernels.numerics.jit import (
        watch_compiling,  # loads Numba, which commands that only ask a service do without
    )

    said = False

    def say() -> None:
        nonlocal said
        if not said:
            said = True
            _say_compiling(console)

    with watch_compiling(say):
        yield


class ProgressLine:
    """Shows the stages of a job as they pass."""

    def __init__(self, bar: Progress | None, unit: str) -> None:
        self.bar, self.unit = bar, unit
        self.task = bar.add_task("waiting", total=None, unit=unit, pace="") if bar else None
        self.stage, self.said, self.pause = "", 0.0, _PLAIN_LINE_SECONDS

    def compiling(self, done: int, total: int) -> None:
        """Show how many kernels are compiled, of how many."""
        if self.stage != "compiling":
            _say_compiling(out)
        self.show("compiling", (done, total), unit="kernels")

    def show(
        self,
        stage: str,
        done: tuple[int, int],
        basins: tuple[int, int] = (1, 1),
        cells_per_second: float = 0.0,
        unit: str | None = None,
    ) -> None:
        """Show the progress of a stage: units and basins that are done, and their totals."""
        unit = self.unit if unit is None else unit
        pace = f"{cells_per_second:,.0f} cells/s" if cells_per_second else ""
        if basins[1] > 1:
            pace = f"{basins[0]} of {basins[1]} basins {pace}"
        if self.bar is not None and self.task is not None:
            if stage != self.stage:
                self.bar.reset(self.task)  # or the time left would be reckoned by the pace of another stage
            self.bar.update(self.task, description=stage, completed=done[0], total=done[1], unit=unit, pace=pace)
        elif self._plain_line_is_due(stage):
            out.print(" ".join(f"{stage}: {done[0]} of {done[1]} {unit} {pace}".split()), highlight=False)
        self.stage = stage

    def _plain_line_is_due(self, stage: str) -> bool:
        now = time.monotonic()
        if stage != self.stage:
            self.said, self.pause = now, _PLAIN_LINE_SECONDS
            return True
        if now - self.said <= self.pause:
            return False
        self.said, self.pause = now, min(2.0 * self.pause, _SELDOM_SECONDS)
        return True


@contextmanager
def progress_line(unit: str = "tiles") -> Iterator[ProgressLine]:
    """Progress bar on a terminal, a plain line now and then elsewhere; `unit` names what is counted."""
    if not out.is_terminal:
        yield ProgressLine(None, unit)
        return
    columns = (
        TextColumn("{task.description:<11}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[unit]}"),
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
