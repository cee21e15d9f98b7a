"""A command whose options are taken as they were meant, or refused with an example."""

from collections import Counter
from typing import Any

from typer import BadParameter
from typer._click.exceptions import BadOptionUsage

from rattle.cli.readable_help import ReadableCommand

_EXAMPLES = {"cells": "200 150"}
_EXAMPLE = "0.2 0.8"


class StrictCommand(ReadableCommand):
    """A command that refuses an option given twice, where only the last value would count."""

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
                error.message += f"; write two numbers, as in {pair.opts[0]} {_EXAMPLES.get(pair.name, _EXAMPLE)}"
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
