"""Help that fits the terminal: in frames where there is room, plain lines below that, and nothing is cut."""

from typing import Any

from typer.core import TyperCommand, TyperGroup

from rattle.cli.console import out
from rattle.cli.examples import epilog_of

HELP_OPTIONS = {"help_option_names": ["-h", "--help"]}
# In less room frames cut names and choices of options.
_ROOM = 120


class ReadableCommand(TyperCommand):
    """A command whose help ends with examples, and is not cut in little room."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        self.epilog = epilog_of(self.name or "")
        if out.width < _ROOM:
            self.rich_markup_mode = None
            for parameter in self.params:
                if text := getattr(parameter, "help", None):
                    parameter.help = text.replace(r"\[", "[")  # type: ignore[attr-defined]  # escaped for Rich
        super().format_help(ctx, formatter)


class ReadableGroup(TyperGroup):
    """A command that has commands: its help ends with examples."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        self.epilog = epilog_of(self.name or "")
        super().format_help(ctx, formatter)
