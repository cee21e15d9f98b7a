"""What a document's own code prints, against what the document says that it prints."""

import re
from pathlib import Path

import numpy as np

DOCUMENTS = Path(__file__).parents[1] / "docs"


def _words_and_numbers(text):
    number = r"-?\d+\.\d+"
    return re.split(number, text), np.array(re.findall(number, text), np.float64)


def demand_as_printed(name, capsys, *, after="", **tolerances):
    """Run a document's code from a heading on, up to what it first prints: same words, numbers within tolerances."""
    document = (DOCUMENTS / name).read_text()
    document = document[document.index(after) :]
    code, _, rest = document.partition("```text\n")
    names = {}
    for block in re.findall(r"```python\n(.*?)```", code, re.DOTALL):
        capsys.readouterr()
        exec(compile(block, name, "exec"), names)
    words, numbers = _words_and_numbers(capsys.readouterr().out)
    printed_words, printed = _words_and_numbers(rest.partition("```")[0])
    assert words == printed_words
    np.testing.assert_allclose(numbers, printed, **tolerances)
