"""The numbers that docs/manifolds.md prints are those that its own code finds."""

import re
from pathlib import Path

import numpy as np

DOCUMENT = (Path(__file__).parents[2] / "docs" / "manifolds.md").read_text()


def block(language):
    (found,) = re.findall(rf"```{language}\n(.*?)```", DOCUMENT, re.DOTALL)
    return found


def words_and_numbers(text):
    number = r"-?\d+\.\d+"
    return re.split(number, text), np.array(re.findall(number, text), np.float64)


def test_saddles_manifolds_and_shares_are_as_printed(capsys):
    exec(compile(block("python"), "docs/manifolds.md", "exec"), {})
    words, numbers = words_and_numbers(capsys.readouterr().out)
    printed_words, printed = words_and_numbers(block("text"))
    assert words == printed_words
    # A cell on a boundary may go the other way on another processor.
    np.testing.assert_allclose(numbers, printed, rtol=5e-3, atol=5e-3)
