"""Commands whose help fits the terminal and ends with examples, and whose options are taken as they were meant."""

from collections import Counter
from typing import Any

from typer import BadParameter
from typer._click.exceptions import BadOptionUsage
from typer.core import TyperCommand, TyperGroup

from rattle.cli.console import out

HELP_OPTIONS = {"help_option_names": ["-h", "--help"]}
# In less room frames cut names and choices of options.
_ROOM = 120
# Of options that take two numbers.
_PAIRS, _PAIR = {"cells": "200 150"}, "0.2 0.8"

EXAMPLES: dict[str, tuple[str, ...]] = {
    "rattle": ("rattle basin --out basin.zarr", "rattle plot basin.zarr --out basin.png"),
    "serve": ("rattle serve --data runs --workers 8", "rattle serve --scheduler tcp://host:8786"),
    "basin": (
        "rattle basin --damping 0.6 --eccentricity 0.1 --out basin.zarr",
        "rattle basin --cells 200 150 --velocity 0 5 --out small.zarr",
        "rattle basin --sample 100000 --out shares.zarr",
    ),
    "sweep": (
        "rattle sweep --vary damping=0.5:0.7:21 --cells 100 --out sweep.zarr",
        "rattle sweep --vary half-backlash=0.5,0.6,0.7 --out sweep.zarr",
        "rattle sweep --machine m.toml --vary speed=600:6000rpm:200 --out rpm.zarr",
    ),
    "bifurcation": ("rattle bifurcation --vary damping=0.5:0.6:201 --seed 0.6,3.77 --out b.zarr",),
    "orbits": (
        "rattle orbits --longest 3 --out orbits.zarr",
        "rattle orbits --follow damping=0.45:0.7 --out branches.zarr",
    ),
    "manifold": ("rattle manifold --saddle 0.6017,3.7699 --arclength 20 --out manifold.zarr",),
    "grazing-curve": ("rattle grazing-curve --order 4 --out grazing.zarr",),
    "trajectory": ("rattle trajectory --velocity 3.77 --time 0.6 --out motion.png",),
    "transmission-error": ("rattle transmission-error te.csv --unit degrees --scale 0.01",),
    "submit": ("rattle submit request.json --wait", "rattle submit - --json < request.json"),
    "jobs": ("rattle jobs --limit 50", "rattle jobs --json"),
    "status": ("rattle status 3f2a",),
    "fetch": ("rattle fetch 3f2a --out basin.zarr",),
    "cancel": ("rattle cancel 3f2a",),
    "delete": ("rattle delete 3f2a",),
    "check": ("rattle check basin.zarr --dry-run", "rattle check s3://results/basin.zarr"),
    "export": ("rattle export basin.zarr --zip basin.zip",),
    "keys": ("rattle keys add alice", "rattle keys list"),
    "add": ("rattle keys add alice", "rattle keys add monitor --scope read"),
    "list": ("rattle keys list --json",),
    "revoke": ("rattle keys revoke alice",),
    "certs": ("rattle certs certificates --days 365",),
    "plot": ("rattle plot basin.zarr --out basin.png", "rattle plot sweep.zarr --shares --out shares.svg"),
    "table": ("rattle table basin.zarr", "rattle table orbits.zarr --name orbit --out orbits.csv"),
}
"""Lines that call a command, by its last word; ``rattle`` for all of them."""


class Command(TyperCommand):
    """A command whose help ends with examples and is not cut in little room, and that refuses an option given twice."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        self.epilog = _epilog_of(self.name)
        if out.width < _ROOM:
            self.rich_markup_mode = None
            for parameter in self.params:
                if text := getattr(parameter, "help", None):
                    parameter.help = text.replace(r"\[", "[")  # type: ignore[attr-defined]  # escaped for Rich
        super().format_help(ctx, formatter)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse arguments; `ctx.fail` ends the command with code 2."""
        args = self._with_cells_of_both(list(args))
        try:
            _, _, order = self.make_parser(ctx).parse_args(args=list(args))
            for name, times in Counter(each.opts[0] for each in order if _takes_one_value(each)).items():
                if times > 1:
                    ctx.fail(f"{name} is given {times} times, and takes one value")
            return super().parse_args(ctx, args)
        except (BadParameter, BadOptionUsage) as error:
            pair = self._pair_at_fault(error)
            if pair is not None:
                error.message += f"; write two numbers, as in {pair.opts[0]} {_PAIRS.get(pair.name, _PAIR)}"
            raise

    def _with_cells_of_both(self, args: list[str]) -> list[str]:
        """Arguments in which one number of cells, as in ``--cells 200``, stands for time and velocity alike."""
        if not any(each.name == "cells" and each.nargs == 2 for each in self.params):
            return args
        found: list[str] = []
        for place, word in enumerate(args):
            found.append(word)
            alone = place + 1 == len(args) or not args[place + 1].isdecimal()
            if word.isdecimal() and alone and place and args[place - 1] == "--cells":
                found.append(word)
        return found

    def _pair_at_fault(self, error: Any) -> Any:
        """The option at fault, if it takes two numbers."""
        names = {getattr(error, "option_name", None), *getattr(getattr(error, "param", None), "opts", ())}
        return next((each for each in self.params if each.nargs == 2 and names & set(each.opts)), None)


def _takes_one_value(parameter: Any) -> bool:
    return not getattr(parameter, "multiple", True) and not getattr(parameter, "is_flag", False)


class Group(TyperGroup):
    """A command that has commands: its help ends with examples."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        self.epilog = _epilog_of(self.name)
        super().format_help(ctx, formatter)


def _epilog_of(name: str | None) -> str | None:
    """What the help of a command ends with."""
    lines = EXAMPLES.get(name or "", ())
    return "\n\n".join(("Examples:" if len(lines) > 1 else "Example:", *lines)) if lines else None
