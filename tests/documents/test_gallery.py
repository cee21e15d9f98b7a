"""The gallery has every figure with a line that makes it."""

import re
from pathlib import Path

import pytest

from rattle_paper.registry import ALL_FIGURES

DOCS = Path(__file__).parents[2] / "docs"
GALLERY = (DOCS / "paper" / "gallery.md").read_text()


def test_every_figure_is_there_and_no_other():
    shown = re.findall(r"\]\(\.\./figures/([\w-]+)\.png\)", GALLERY)
    assert shown == list(ALL_FIGURES)
    assert set(shown) == {path.stem for path in (DOCS / "figures").glob("*.png")}


@pytest.mark.parametrize("name", ALL_FIGURES)
def test_the_line_below_a_figure_makes_it(name):
    _, _, below = GALLERY.partition(f"../figures/{name}.png)")
    below = re.sub(r"<!--.*?-->", "", below).lstrip()  # which says that the line is not run by the tests
    assert below.startswith(f"```sh\nrattle paper {name} --out figures\n```")
