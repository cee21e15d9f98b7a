"""The page has words for each member of the enums that it puts into words."""

import re
from pathlib import Path

import pytest

from rattle_kernels import AttractorKind
from service.records.job_record import JobState
from worker.additions import additions
from worker.pictures.colours import Palette
from worker.pictures.overlay_kind import OverlayKind
from worker.progress import Stage
from worker.results.panel import Layer

JS = Path(__file__).parents[2] / "service" / "explorer" / "js"
HTML = (JS.parent / "index.html").read_text()


def keys_of(module, name):
    """Keys of an object that is a constant of a module."""
    (body,) = re.findall(
        rf"^(?:export )?const {name} = \{{(.*?)^\}};", (JS / module).read_text(), re.DOTALL | re.MULTILINE
    )
    return set(re.findall(r"(?:^|[,{\n])\s*(\w+): ", re.sub(r'"[^"]*"', '""', body)))


def options_of(name):
    (body,) = re.findall(rf'<select id="{name}".*?</select>', HTML, re.DOTALL)
    return set(re.findall(r'<option value="(\w+)"', body))


# What packages add has its words in what the service says of it.
ADDED = [addition.page() for addition in additions()]
STAGES, MASKS = {stage for each in ADDED for stage in each["stages"]}, {each["mask"]["name"] for each in ADDED}
MOTIONS = {kind.name.lower() for kind in AttractorKind if kind != AttractorKind.PERIODIC}


@pytest.mark.parametrize(
    ("told", "wanted"),
    [
        (keys_of("jobs/words.js", "DOING") | STAGES, set(Stage)),
        (keys_of("look/explain.js", "KINDS"), MOTIONS),
        (keys_of("look/explain.js", "CENTRES"), MOTIONS),
        (keys_of("look/explain.js", "MARKS") & set(OverlayKind) | MASKS, set(OverlayKind)),
        (keys_of("panels/legend.js", "MEANINGS"), set(Layer) - {Layer.SOLUTION}),
        (set(re.findall(r'name: "(\w+)"', (JS / "plane/overlays.js").read_text())) | MASKS, set(OverlayKind)),
        (set(re.findall(r'case "(\w+)"', (JS / "jobs/words.js").read_text())), set(JobState) - {JobState.SUCCEEDED}),
        (options_of("layer"), set(Layer)),
        (options_of("palette"), set(Palette)),
    ],
    ids=["stages", "kinds", "centres", "marks", "layers", "overlays", "states", "layer options", "palettes"],
)
def test_each_member_has_words(told, wanted):
    assert told == {str(each) for each in wanted}
