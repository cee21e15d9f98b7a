"""The command line: ``rattle COMMAND``; each command's module is loaded when it is asked for, and not before.

All of them together load Numba, Dask, FastAPI and Matplotlib, which takes seconds; ``rattle jobs`` needs none of these.
"""

from importlib import import_module
from typing import Any

import typer
from typer.core import TyperGroup

_COMMANDS = {
    "serve": (
        "local",
        "Start the service, its database and two local workers; Ctrl-C stops it, the next start resumes its jobs.",
    ),
    "basin": ("compute", "Compute one basin on this machine, without a service."),
    "sweep": ("compute", "Compute basins over one or two parameters into one store, on this machine."),
    "bifurcation": (
        "analyses",
        "Compute a bifurcation diagram: last departures at each value, the very last seeding the next value.",
    ),
    "orbits": (
        "analyses",
        "Find periodic orbits, stable or not; follow them in a parameter and locate special points.",
    ),
    "manifold": ("analyses", "Grow stable and unstable manifolds of saddles of the impacting model."),
    "grazing-curve": ("analyses", "Draw the grazing curve of the impacting model and its pre-images."),
    "trajectory": (
        "trajectory",
        "Follow one motion of either model: draw Phi(t) or write it down, and list its contacts.",
    ),
    "paper": (
        "paper",
        "Recompute a figure of the paper and its numbers; basins that are there already are used, unfinished resumed.",
    ),
    "submit": ("remote", "Submit a request to a service; the same request again is the same job."),
    "jobs": ("remote", "List the service's jobs, newest first."),
    "cancel": ("remote", "Stop a job; what it has computed stays readable."),
    "keys": ("keys", "Make, list and revoke the keys to a service's doors."),
    "certs": ("certs", "Make the certificates by which the parts of a Dask cluster know each other."),
    "plot": (
        "local",
        "Draw a basin in the paper's colours, a sweep side by side, or what an analysis has found.",
    ),
}
"""In which module a command is, and what ``rattle --help`` says of it."""


def _loaded(name: str) -> Any:
    """The command itself: a function of its name, or an application of that name where it has commands of its own."""
    module, _ = _COMMANDS[name]
    found = getattr(import_module(f"service.cli.{module}"), name.replace("-", "_"))
    if not isinstance(found, typer.Typer):
        alone = typer.Typer(add_completion=False)
        alone.command(name)(found)
        found = alone
    return typer.main.get_command(found)


class _OnDemand(TyperGroup):
    """Lists commands by their stand-ins, and puts the command itself in the place of the one that is run."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        name, command, rest = super().resolve_command(ctx, args)
        return name, _loaded(name) if name in _COMMANDS else command, rest


app = typer.Typer(
    name="rattle",
    cls=_OnDemand,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Which motion does a rattling gear end in? Basins of attraction of a backlash oscillator.\n\n"
    "Alone: `rattle basin` computes one here, `rattle sweep` many, `rattle plot` draws them; "
    "`rattle bifurcation`, `rattle orbits`, `rattle manifold` and `rattle grazing-curve` explain them; "
    "`rattle trajectory` follows one motion, `rattle paper` recomputes a figure of the paper. "
    "With a service: `rattle serve` starts one, "
    "`rattle submit` sends it a request, `rattle jobs` and `rattle cancel` follow and stop what it does; "
    "`rattle keys` and `rattle certs` guard it.",
)
for _name, (_, _help) in _COMMANDS.items():
    app.command(_name, help=_help)(lambda: None)
