"""What the notes of examples say against what a computed basin of each has in its legend."""

import json
import re
from pathlib import Path

import pytest

PRESETS = json.loads((Path(__file__).parents[2] / "service" / "explorer" / "presets.json").read_text())
SINGLE = [each for each in PRESETS if "vary" not in each["request"]]
KINDS = {
    r"permanent contact": "permanent_contact", r"chaotic transient": "chaotic_transient",
    r"chaos|chaotic(?! transient)": "chaotic",
}  # fmt: skip


def motions_in(words):
    """Names of periodic motions, and kinds of others, that a note speaks of. What "looks like chaos" is none."""
    words = words.replace("looks like chaos", "").lower()
    kinds = {kind for pattern, kind in KINDS.items() if re.search(pattern, words)}
    return set(re.findall(r"P\(\d+,\d+,\d+\)", words.upper())), kinds


@pytest.mark.slow
@pytest.mark.parametrize("preset", SINGLE, ids=[each["name"] for each in SINGLE])
def test_the_legend_has_every_motion_that_a_note_names(service, preset):
    names, kinds = motions_in(preset["label"] + ". " + preset["note"])
    if not names | kinds:
        return
    job = service.wait(service.submit(preset["request"])["id"])
    solutions = service.request("GET", job["links"]["result"]).json()["solutions"]
    shares = {each["name"]: each["share"] for each in solutions}
    assert names <= set(shares)
    assert kinds <= {each["kind"] for each in solutions if each["share"] > 0.01}
    # What only looks like chaos is not called so.
    assert "chaotic" in kinds or "chaotic" not in {each["kind"] for each in solutions}


def test_examples_are_told_apart_by_their_names():
    for names in zip(*((each["name"], each["short"], each["label"]) for each in PRESETS), strict=True):
        assert len(set(names)) == len(PRESETS)
    headings = [each["heading"] for each in PRESETS]
    assert sorted(set(headings), key=headings.index) == [
        heading for heading, before in zip(headings, [None, *headings[:-1]], strict=True) if heading != before
    ]
