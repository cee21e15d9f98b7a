"""What docs/paper.md prints is what the committed numbers say, and its pictures are of modest size."""

import json
from pathlib import Path

import pytest

from worker.paper.registry import PAPER_FIGURES

DOCS = Path(__file__).parents[3] / "docs"
DOCUMENT = (DOCS / "paper.md").read_text()


def numbers_of(name):
    return json.loads((DOCS / "figures" / f"{name}.json").read_text())


def section(name):
    return DOCUMENT.split(f"## Fig. {name.removeprefix('fig')}:")[1].split("\n## ")[0]


@pytest.mark.parametrize("name", PAPER_FIGURES)
def test_each_figure_is_documented_with_its_picture_and_its_numbers(name):
    assert numbers_of(name)["figure"] == name
    assert f"](figures/{name}.png)" in section(name)
    assert (DOCS / "figures" / f"{name}.png").stat().st_size <= 250_000


def test_shares_are_as_printed():
    rows = {line.split("|")[1].strip(): line for line in section("fig6").splitlines() if line.startswith("| ")}
    printed = {"1e6": numbers_of("fig7")["panels"]["piecewise linear"]}
    printed["impacting"] = numbers_of("fig7")["panels"]["impacting"]
    printed |= {name.removeprefix("kappa "): panel for name, panel in numbers_of("fig6")["panels"].items()}
    for kappa, panel in printed.items():
        cells = [cell.strip() for cell in rows[kappa].split("|")]
        for solution in panel["solutions"]:
            assert any(cell.endswith(f"{100 * solution['share']:.2f}") for cell in cells), (kappa, solution["name"])


def test_differences_between_the_models_are_as_printed():
    told = [panel["differs_from_impacting"] for panel in numbers_of("fig6")["panels"].values()]
    told.append(numbers_of("fig7")["differs_from_impacting"])
    for measure, row in (
        ("by_name", "| by name |"),
        ("after_k", "| by name, what"),
        ("quiet_or_not", "| quiet in one"),
    ):
        (line,) = [line for line in section("fig6").splitlines() if line.startswith(row)]
        printed = [float(cell) for cell in line.split("|")[2:-1]]
        assert printed == pytest.approx([100 * difference[measure] for difference in told], abs=0.0051)


def test_the_transient_of_fig7_and_the_departures_of_fig1_are_as_printed():
    fig7, fig1 = section("fig7"), section("fig1")
    left = numbers_of("fig7")["panels"]["piecewise linear"]["transient"]["left_after_legs"]
    assert ", ".join(str(count) for count in left[1:]) in " ".join(fig7.split())
    numbers = numbers_of("fig1")
    settled = sum(motion["departures"] for motion in numbers["rattling"])
    assert f"{numbers['quiet']['departures']} fall quiet, {settled} rattle on one of {len(numbers['rattling'])}" in fig1
