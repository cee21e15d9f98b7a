"""Every command takes what it took, whatever its help says."""

import pytest

from tests.golden import commands, files, help_texts

COMMANDS = files.read("commands.json")


def test_the_commands_are_the_same():
    assert sorted(commands.commands()) == sorted(COMMANDS)


def in_order(parameters):
    """Arguments by position, then options by name: the order of options means nothing."""
    arguments = [each for each in parameters if "options" not in each]
    return arguments + sorted((each for each in parameters if "options" in each), key=lambda each: each["options"])


@pytest.mark.parametrize("words", COMMANDS)
def test_a_command_takes_what_it_took(words):
    assert in_order(commands.parameters(commands.commands()[words])) == in_order(COMMANDS[words])


@pytest.mark.parametrize("words", COMMANDS)
def test_a_command_is_called_as_ever(words):
    golden = (files.FOLDER / help_texts.file_of(words)).read_text()
    assert help_texts.usage_of(help_texts.text_of(words)) == help_texts.usage_of(golden)
