"""Output of commands: progress bars on a terminal, plain lines elsewhere; errors take one line and name a next step."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape

from rattle import progress
from rattle.progress import ProgressLine

out = Console()
err = Console(stderr=True)

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
