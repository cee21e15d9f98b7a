"""Rules and dashboard name metrics and labels that there are."""

import json
import re
from pathlib import Path

import pytest
import yaml
from prometheus_client.parser import text_string_to_metric_families

from service.middleware import metrics
from service.records.job_record import JobState
from service.runner import metrics as run_metrics

FOLDER = Path(__file__).parents[2] / "docker" / "monitoring"
(GROUP,) = yaml.safe_load((FOLDER / "alerts.yaml").read_text())["groups"]
PANELS = json.loads((FOLDER / "dashboard.json").read_text())["panels"]
RULES = {rule["alert"]: rule["expr"] for rule in GROUP["rules"]}
DRAWN = {f"{panel['title']} {target['refId']}": target["expr"] for panel in PANELS for target in panel["targets"]}


@pytest.fixture(scope="module")
def told():
    """Labels of each sample that a service tells."""
    metrics.record_answer("GET", "/v1/jobs/{job_id}", 200, 0.1)
    run_metrics.job_ended(JobState.FAILED)
    run_metrics._TILES.labels("mapping")
    text = metrics.exposition({}, run_metrics.exposition()).decode()
    labels = {}
    for family in text_string_to_metric_families(text):
        for sample in family.samples:
            labels.setdefault(sample.name, set()).update(sample.labels)
    return labels


@pytest.mark.parametrize("expression", [*RULES.values(), *DRAWN.values()], ids=[*RULES, *DRAWN])
def test_every_metric_is_there_with_its_labels(told, expression):
    named = re.findall(r"\b(?:rattle|process)_\w+|\bup\b", expression)
    assert named and set(named) <= set(told) | {"up"}
    for name, matched in re.findall(r"((?:rattle|process)_\w+)\{([^}=]*)[=~!]", expression):
        assert matched in told[name] | {"job", "instance"}
    for grouped in re.findall(r"by \(([^)]*)\)", expression):
        assert all(set(grouped.split(", ")) <= told[name] | {"job", "instance"} for name in named)


def test_every_rule_says_what_to_do():
    for rule in GROUP["rules"]:
        assert rule["labels"]["severity"] in ("warning", "critical")
        assert rule["annotations"].keys() == {"summary", "description"}
    assert len(RULES) == len(GROUP["rules"])


def test_panels_have_a_place_of_their_own():
    places = [(panel["gridPos"]["x"], panel["gridPos"]["y"]) for panel in PANELS]
    assert len(set(places)) == len(places) and len({panel["id"] for panel in PANELS}) == len(PANELS)
