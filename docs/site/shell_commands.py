"""The directive ``{shell-commands}``: every command with its arguments and options, as Typer describes them."""

from collections.abc import Iterator
from functools import cache

import typer
from docutils.nodes import Node
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from typer.cli import get_docs_for_click

from rattle.cli import command_line


class ShellCommands(SphinxDirective):
    """All commands, in the order of ``rattle --help``."""

    def run(self) -> list[Node]:
        """Typer writes Markdown."""
        return self.parse_text_to_nodes(_markdown(), allow_section_headings=True)


@cache
def _markdown() -> str:
    return "\n".join(_commands())


def _commands() -> Iterator[str]:
    group = typer.main.get_command(command_line())
    context = typer.Context(group, info_name="rattle")
    for name in group.list_commands(context):
        # Commands are stand-ins until they are resolved.
        _, command, _ = group.resolve_command(context, [name])
        inner = typer.Context(command, info_name=name, parent=context)
        yield get_docs_for_click(obj=command, ctx=inner, indent=1, name=f"rattle {name}")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    # Before autodoc reads any class: it writes annotations into pydantic's BaseModel, after which FastAPI, which
    # `rattle serve` loads, can no longer be imported.
    _markdown()
    app.add_directive("shell-commands", ShellCommands)
    return {"parallel_read_safe": True}
