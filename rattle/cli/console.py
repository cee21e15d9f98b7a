"""Output of commands: progress bars on a terminal, plain lines elsewhere; errors take one line and name a next step."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from rattle import progress
from rattle.progress import ProgressLine
from worker.additions import additions
from worker.motion_words import ends_in_words

out = Console()
err = Console(stderr=True)
_MOST_CHANGES = 20

Key = Annotated[
    str | None, typer.Option(envvar="RATTLE_KEY", show_envvar=True, help="Key, if the service requires one")
]
"""Option of commands that read from a service."""

Scheduler = Annotated[
    str | None,
    typer.Option(
        envvar="RATTLE_SCHEDULER", show_envvar=True,
        help="Address of a Dask scheduler, tcp://host:8786 or tls://host:8786, whose workers compute",
    ),
]  # fmt: skip
"""Option of commands that compute."""


def give_up(message: str, code: int = 1) -> NoReturn:
    """Print an error and exit: with code 2 if the command was wrong, 1 if the work failed."""
    err.print(f"[bold red]error:[/] {escape(message)}", highlight=False, soft_wrap=True)
    raise typer.Exit(code)


@contextmanager
def announced_compiling(console: Console = err) -> Iterator[None]:
    """Announce a wait, once, as soon as a kernel has to be compiled."""
    from rattle_kernels.numerics.jit import (
        watch_compiling,  # loads Numba, which commands that only call a service do not need
    )

    said = False

    def say() -> None:
        nonlocal said
        if not said:
            said = True
            progress.say_compiling(console)

    with watch_compiling(say):
        yield


@contextmanager
def progress_line(unit: str = "tiles") -> Iterator[ProgressLine]:
    """Progress of a command on standard output."""
    with progress.progress_line(out, unit) as line:
        yield line


def print_solutions(solutions: Sequence[Mapping[str, Any]], errors: Mapping[int, float | None] | None = None) -> None:
    """Print a table of solutions: name, share (and what packages say of it), exponent, power, life of chaos, a point.

    `errors` are the standard errors of shares that come from a sample, by number.
    """
    table = Table("", "solution", "share", "Lyapunov exponent", "impact power", "a departure (t, v)")
    names = [str(solution["name"]) for solution in solutions]
    for number, solution in enumerate(solutions):
        share, exponent, points = solution["share"], solution["lyapunov_exponent"], solution["points"]
        power = solution["impact_power"]
        life, error = solution["mean_life"], solution["mean_life_error"]
        # A service of an earlier version does not say what transients end in.
        ends = ends_in_words([(end["solution"], end["share"]) for end in solution.get("ends", ())], names)
        ends = f", {ends}" if ends else ""
        table.add_row(
            str(number),
            solution["name"] if life is None else f"{solution['name']} for some {life:.1g} ± {error:.1g} impacts{ends}",
            _share(share, (errors or {}).get(number)) + "".join(each.in_words(solution) for each in additions()),
            "" if exponent is None else f"{exponent:.4f}",
            "" if power is None else f"{power:.4g}",
            f"({points[0][0]:.6f}, {points[0][1]:.6f})" if points else "",
        )
    out.print(table)


def _share(share: float | None, error: float | None) -> str:
    if share is None:
        return "not known yet"
    return f"{100 * share:.3f} %" if error is None else f"{100 * share:.3f} ± {100 * error:.2g} %"


def print_expected(expected: Mapping[str, float]) -> None:
    """Print how loud a basin is on average, and the share of cells that count as silent as they are undecided."""
    rate, speed, power = (expected[name] for name in ("impacts_per_period", "largest_impact_speed", "impact_power"))
    left = expected["undecided_share"]
    note = f" ({100 * left:.3g} % undecided, counted as silent)" if left else ""
    line = f"expected: {rate:.4g} impacts a period, largest impact speed {speed:.4g}, impact power {power:.4g}{note}"
    out.print(line, highlight=False, soft_wrap=True)


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
