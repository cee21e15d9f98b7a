"""Every command takes what it took, whatever its help says."""

import pytest

from tests.golden import commands, files, help_texts

COMMANDS = files.read("commands.json")


def test_every_command_is_still_there():
    assert set(commands.commands()) >= set(COMMANDS)


@pytest.mark.parametrize("words", COMMANDS)
def test_a_command_takes_what_it_took(words):
    """Options may be added; those that there were, and the arguments by position, stay."""
    here, golden = commands.parameters(commands.commands()[words]), COMMANDS[words]
    assert [each for each in golden if each not in here] == []
    assert [each for each in here if "options" not in each] == [each for each in golden if "options" not in each]


@pytest.mark.parametrize("words", COMMANDS)
def test_a_command_is_called_as_ever(words):
    golden = (files.FOLDER / help_texts.file_of(words)).read_text()
    assert help_texts.usage_of(help_texts.text_of(words)) == help_texts.usage_of(golden)
