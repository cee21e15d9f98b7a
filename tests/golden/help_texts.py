"""What ``rattle ... --help`` shows."""

from typer.testing import CliRunner

from tests.golden.adapter import app

FRAME = " ─│╭╮╰╯"


def text_of(words):
    """Help of a command, by its words, without the frames around it."""
    answer = CliRunner().invoke(app, [*words.split()[1:], "--help"])
    assert answer.exit_code == 0, answer.output
    lines = [line.strip(FRAME) for line in answer.output.splitlines()]
    return "".join(f"{line}\n" for line in lines if line)


def file_of(words):
    """Golden file of a command's help."""
    return f"help/{words.replace(' ', '_')}.txt"


def usage_of(text):
    """The line of a help that says how the command is called."""
    (usage,) = [line.strip() for line in text.splitlines() if "Usage:" in line]
    return usage
