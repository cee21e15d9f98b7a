"""A command whose options are taken as they were meant, or refused with an example."""

from collections import Counter
from typing import Any

from typer import BadParameter
from typer._click.exceptions import BadOptionUsage
from typer.core import TyperCommand

_EXAMPLES = {"cells": "200 150"}
_EXAMPLE = "0.2 0.8"


class StrictCommand(TyperCommand):
    """A command that refuses an option given twice, where only the last value would count."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse arguments; `ctx.fail` ends the command with code 2."""
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

    def _pair_at_fault(self, error: Any) -> Any:
        """The option at fault, if it takes two numbers."""
        names = {getattr(error, "option_name", None), *getattr(getattr(error, "param", None), "opts", ())}
        return next((each for each in self.params if each.nargs == 2 and names & set(each.opts)), None)


def _takes_one_value(parameter: Any) -> bool:
    return not getattr(parameter, "multiple", True) and not getattr(parameter, "is_flag", False)
