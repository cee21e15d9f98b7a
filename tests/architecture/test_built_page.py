"""The page of the package on an index: no link or picture of it is dead."""

import importlib.util
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()
REPOSITORY = "https://example.org/gear/rattle"


def metadata(**environment):
    """Metadata of the project, as it is built."""
    variables = {name: value for name, value in os.environ.items() if name != "RATTLE_REPOSITORY"} | environment
    command = [sys.executable, "-m", "hatchling", "metadata"]
    return json.loads(subprocess.check_output(command, cwd=ROOT, env=variables, text=True))


def targets(text):
    return re.findall(r"\]\(([^)\s]+)\)", text)


@pytest.fixture(scope="module")
def hook():
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_without_an_address_of_the_repository_no_link_is_left_that_leads_nowhere():
    built = metadata()
    text = built["readme"]["text"]
    assert targets(text) and all(target.startswith("https://") for target in targets(text))
    assert "from Python" in text and "![" not in text and "\n\n\n" not in text
    assert list(built["urls"]) == ["Paper"]


def test_with_an_address_every_link_and_picture_leads_into_the_repository():
    built = metadata(RATTLE_REPOSITORY=REPOSITORY + "/")
    text = built["readme"]["text"]
    assert len(targets(text)) == len(targets(README)) and all(each.startswith("https://") for each in targets(text))
    for kind, target in re.findall(rf"{REPOSITORY}/(blob|raw)/HEAD/([^)\s]+)", text):
        assert (ROOT / target).exists() and (kind == "raw") == target.endswith(".png")
    assert built["urls"]["Source"] == REPOSITORY and {"Documentation", "Changelog", "Paper"} < set(built["urls"])


def test_links_of_pictures_addresses_and_anchors(hook):
    text = "![a](b/c.png) [d](e.md) [f](https://g.h) [i](#j)"
    assert hook.page(text, None) == " d [f](https://g.h) [i](#j)"
    assert hook.page(text, "https://r") == (
        "![a](https://r/raw/HEAD/b/c.png) [d](https://r/blob/HEAD/e.md) [f](https://g.h) [i](#j)"
    )
