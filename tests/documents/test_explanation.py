"""What the page on a basin's way says of the code is there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "explanation" / "how-a-basin-is-computed.md").read_text()
NAMED = sorted(set(re.findall(r"`((?:rattle|worker|service)\w*/[\w/.]+)`", PAGE)))


def test_the_page_names_files():
    assert len(NAMED) > 25


@pytest.mark.parametrize("name", NAMED)
def test_a_file_that_is_named_is_there(name):
    assert (ROOT / name).exists()
