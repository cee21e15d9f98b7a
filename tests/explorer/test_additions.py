"""What the tests of the page take for a description of additions is what a service says."""

import json
import re
from pathlib import Path

from worker.additions import additions

PAGE = Path(__file__).parents[2] / "service" / "explorer"


def test_the_description_is_the_services():
    written = json.loads((Path(__file__).parent / "additions.json").read_text())
    assert written == json.loads(json.dumps([addition.page() for addition in additions()]))


def test_a_description_has_what_the_page_reads():
    """Names of `Addition` and `Mask` as the type check knows them."""
    types = (PAGE / "types.d.ts").read_text()
    for addition in (each.page() for each in additions()):
        for name, told in (("Addition", addition), ("Mask", addition["mask"])):
            (body,) = re.findall(rf"^interface {name} \{{(.*?)^\}}", types, re.DOTALL | re.MULTILINE)
            outer = re.sub(r"\{.*?\}", "", body)
            assert set(re.findall(r"(\w+):", outer)) == set(told)
