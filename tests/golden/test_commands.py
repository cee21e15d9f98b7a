"""Every command takes what it took, whatever its help says."""

import pytest

from tests.golden import commands, files, help_texts

COMMANDS = files.read("commands.json")


def test_the_commands_are_the_same():
    assert sorted(commands.commands()) == sorted(COMMANDS)


@pytest.mark.parametrize("words", COMMANDS)
def test_a_command_takes_what_it_took(words):
    by_options = [
        sorted(each, key=lambda one: one["options"])
        for each in (commands.parameters(commands.commands()[words]), COMMANDS[words])
    ]
    assert by_options[0] == by_options[1]


@pytest.mark.parametrize("words", COMMANDS)
def test_a_command_is_called_as_ever(words):
    golden = (files.FOLDER / help_texts.file_of(words)).read_text()
    assert help_texts.usage_of(help_texts.text_of(words)) == help_texts.usage_of(golden)
