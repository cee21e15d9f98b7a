"""How far capture reaches is as docs/machine.md prints it."""

import re
from pathlib import Path

import numpy as np

DOCUMENT = (Path(__file__).parents[2] / "docs" / "machine.md").read_text()


def block(language):
    (found,) = re.findall(rf"```{language}\n(.*?)```", DOCUMENT, re.DOTALL)
    return found


def words_and_numbers(text):
    number = r"\d+\.\d+"
    return re.split(number, text), np.array(re.findall(number, text), np.float64)


def test_what_is_captured_is_as_printed(capsys):
    exec(compile(block("python"), "docs/machine.md", "exec"), {})
    words, numbers = words_and_numbers(capsys.readouterr().out)
    printed_words, printed = words_and_numbers(block("text"))
    assert words == printed_words
    # The bound goes by steps; on another processor it may be one step off.
    np.testing.assert_allclose(numbers, printed, rtol=0.09)
