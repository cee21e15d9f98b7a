"""The command line: ``rattle COMMAND``. The module of a command is loaded when the command is run.

All modules together load Numba, Dask, FastAPI and Matplotlib, which takes seconds; ``rattle jobs`` needs none of these.
"""

import atexit
import gc
from importlib import import_module
from importlib.metadata import entry_points, version
from pkgutil import resolve_name
from typing import Annotated, Any

import typer

from rattle.cli.command import EXAMPLES, HELP_OPTIONS, Command, Group
from rattle.cli.console import give_up, out
from rattle.garbage import fewer_collections
from worker.kinds import KINDS

_OTHER_COMMANDS = {
    "serve": (
        "serve",
        "Start the service, its database and two local workers; Ctrl-C stops it, the next start resumes its jobs.",
    ),
    "trajectory": (
        "trajectory",
        "Follow one motion of either model: draw Phi(t) or write it down, and list its contacts.",
    ),
    "transmission-error": (
        "transmission_error",
        "Make harmonics of a measured transmission error: the options to copy, and what they leave out.",
    ),
    "submit": ("remote", "Submit a request to a service; the same request again is the same job."),
    "jobs": ("remote", "List the service's jobs, newest first."),
    "status": ("remote", "Show one job: its state, how far it is, and how long it will take."),
    "fetch": ("remote", "Copy the result of a job that has ended into a folder here, to the byte."),
    "cancel": ("remote", "Stop a job; what it has computed stays readable."),
    "delete": ("remote", "Stop a job, and delete it with its result."),
    "check": (
        "check",
        "Read every file of a store; compute anew what is damaged or missing, to the same bytes.",
    ),
    "export": (
        "export",
        "Write a finished result as a zipped RO-Crate: its request, versions, tables and pictures.",
    ),
    "keys": ("keys", "Make, list and revoke the API keys of a service."),
    "certs": ("certs", "Make certificates for the parts of a Dask cluster."),
    "plot": (
        "plot",
        "Draw a basin in the colours of its motions, a sweep side by side, or what an analysis has found.",
    ),
    "table": (
        "table",
        "Write what a result lists as CSV or JSON: motions and shares, orbits, branches, curves, departures.",
    ),
}
"""Module of each command, and what ``rattle --help`` says of it. The others compute a kind of `worker.kinds`."""

_BESIDE: dict[str, tuple[str, str, tuple[str, ...]]] = {
    each.name: each.load() for each in entry_points(group="rattle.commands")
}
"""Commands of packages that stand beside: the function, as ``module:name``, what the help says of it, and examples."""
EXAMPLES.update({name: examples for name, (_, _, examples) in _BESIDE.items()})


def _kinds_by_command() -> dict[str, str]:
    """Kind of job that a command computes."""
    return {name.replace("_", "-"): name for name, kind in KINDS.items() if kind.command}


@fewer_collections()
def _loaded(name: str) -> Any:
    """The command itself."""
    kinds = _kinds_by_command()
    if name in kinds:
        found = import_module("rattle.cli.compute").compute_command(kinds[name])
    elif name in _BESIDE:
        found = resolve_name(_BESIDE[name][0])
    else:
        found = getattr(_loaded_module(name), name.replace("-", "_"))
    if not isinstance(found, typer.Typer):
        alone = typer.Typer(add_completion=False)
        alone.command(name, cls=Command)(found)
        found = alone
    return typer.main.get_command(found)


def _loaded_module(name: str) -> Any:
    try:
        return import_module(f"rattle.cli.{_OTHER_COMMANDS[name][0]}")
    except ModuleNotFoundError as error:
        if name not in ("serve", "keys"):
            raise
        give_up(f"`rattle {name}` needs {error.name}: pip install 'gear-rattle[service]'", 2)


class _OnDemand(Group):
    """Lists commands by stand-ins, and loads a command when it is run."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        name, command, rest = super().resolve_command(ctx, args)
        return name, command if name is None else _loaded(name), rest

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except ValueError as error:
            from worker.errors import (
                InvalidSettings,
            )  # loads Numba, which commands that only call a service do not need

            if not isinstance(error, InvalidSettings):
                raise
            give_up(str(error), 2)


def _say_version(asked: bool) -> None:
    if asked:
        typer.echo(f"rattle {version('gear-rattle')}")
        raise typer.Exit


def _options_of_all(
    _: Annotated[
        bool, typer.Option("--version", callback=_say_version, is_eager=True, help="Print the version and exit")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print errors, and what is asked for by --json")] = False,
) -> None:
    out.quiet = quiet


def command_line() -> typer.Typer:
    """Application with all commands: those of every kind of job, and the others.

    Returns
    -------
    typer.Typer
    """
    app = typer.Typer(
        name="rattle", cls=_OnDemand, no_args_is_help=True, pretty_exceptions_enable=False, help=_HELP,
        context_settings=HELP_OPTIONS,
    )  # fmt: skip
    app.callback()(_options_of_all)
    commands = {name: KINDS[kind].command for name, kind in _kinds_by_command().items()}
    for name in _BESIDE.keys() & (commands.keys() | _OTHER_COMMANDS) | commands.keys() & _OTHER_COMMANDS.keys():
        raise ImportError(f"a package that is installed asks for the command {name}, which there is already")
    listed = {name: text for name, (_, text, *_) in (_OTHER_COMMANDS | _BESIDE).items()}
    for name, text in ({"serve": listed["serve"]} | commands | listed).items():
        app.command(name, help=text)(lambda: None)
    return app


_HELP = (
    "Which motion does a rattling gear end in? Basins of attraction of a backlash oscillator.\n\n"
    "Alone: `rattle basin` computes one here, `rattle sweep` many, `rattle plot` draws them; "
    "`rattle bifurcation`, `rattle orbits`, `rattle manifold` and `rattle grazing-curve` explain them; "
    "`rattle trajectory` follows one motion, `rattle transmission-error` makes harmonics of a measured curve, "
    "`rattle check` checks and mends a result, `rattle export` writes it down to hand on. "
    "With a service: `rattle serve` starts one, "
    "`rattle submit` sends it a request, `rattle jobs` and `rattle status` follow what it does, "
    "`rattle cancel` and `rattle delete` stop and remove it; "
    "`rattle keys` and `rattle certs` guard it."
)
app = command_line()


def main() -> None:
    """Run the command that the program was called with."""
    # Python would look through all that is loaded three times as it ends, for half a second. A command leaves nothing
    # to whoever collects garbage: what it has opened it closes itself.
    atexit.register(gc.freeze)
    app()
