"""What docs/paper/figures.md prints is what the committed numbers say, and its pictures are of modest size."""

import json
import re
from pathlib import Path

import pytest

from rattle_paper.registry import PAPER_FIGURES

DOCS = Path(__file__).parents[2] / "docs"
DOCUMENT = (DOCS / "paper" / "figures.md").read_text()


def numbers_of(name):
    return json.loads((DOCS / "figures" / f"{name}.json").read_text())


def section(name):
    return DOCUMENT.split(f"## Fig. {name.removeprefix('fig')}:")[1].split("\n## ")[0]


@pytest.mark.parametrize("name", PAPER_FIGURES)
def test_each_figure_is_documented_with_its_picture_and_its_numbers(name):
    assert numbers_of(name)["figure"] == name
    assert f"](../figures/{name}.png)" in section(name)
    assert (DOCS / "figures" / f"{name}.png").stat().st_size <= 250_000


def test_shares_are_as_printed():
    rows = {line.split("|")[1].strip(): line for line in section("fig6").splitlines() if line.startswith("| ")}
    printed = {"1e6": numbers_of("fig7")["panels"]["piecewise linear"]}
    printed["impacting"] = numbers_of("fig7")["panels"]["impacting"]
    printed |= {name.removeprefix("kappa "): basin for name, basin in numbers_of("fig6")["panels"].items()}
    for kappa, basin in printed.items():
        cells = [cell.strip() for cell in rows[kappa].split("|")]
        for solution in basin["solutions"]:
            assert any(cell.endswith(f"{100 * solution['share']:.2f}") for cell in cells), (kappa, solution["name"])


def test_differences_between_the_models_are_as_printed():
    told = [basin["differs_from_impacting"] for basin in numbers_of("fig6")["panels"].values()]
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


def numbers_in(told):
    """All numbers in what a JSON file holds."""
    if isinstance(told, dict | list):
        parts = told.values() if isinstance(told, dict) else told
        return [number for part in parts for number in numbers_in(part)]
    return [told] if isinstance(told, float) else []


LONG_NUMBERS = ["fig2", "fig3", "fig5", "fig10", "fig11", "fig12", "fig13", "fig15"]


@pytest.mark.parametrize("name", LONG_NUMBERS)
def test_every_number_of_ten_digits_is_one_of_the_json(name):
    told = numbers_in(numbers_of(name))
    printed = re.findall(r"\d+\.\d{10}\b", section(name))
    assert len(printed) >= 2
    for number in printed:
        assert any(abs(float(number) - value) <= 1e-10 for value in told), number


@pytest.mark.parametrize("name", ["fig10", "fig12", "fig13"])
def test_shares_of_basins_over_damping_are_as_printed(name):
    numbers = numbers_of(name)
    for basin in numbers.get("panels", {"": numbers}).values():
        for solution in basin["solutions"]:
            share = f"{100 * solution['share']:.2f}"
            assert share == "0.00" or re.search(rf"\b{share}\b", section(name)), (solution["name"], share)


def test_what_the_paper_states_of_special_points_is_found():
    node, points = numbers_of("fig10")["saddle_node"], numbers_of("fig11")["special_points"]
    assert abs(node["damping"] - 0.5997) < 5e-5 and node["kind"] == "saddle-node"
    assert points["B"]["orbit"] == "P(2,2,1)" and 5e-5 < 0.5819 - points["B"]["damping"] < 6e-5
    assert points["C"]["orbit"] == "P(4,4,2)" and abs(points["C"]["damping"] - 0.5922) < 5e-5
    assert all(point["residual"] < 1e-12 and point["error"] < 1e-11 for point in (node, *points.values()))


def test_curves_are_as_printed():
    fig14, fig16 = numbers_of("fig14"), numbers_of("fig16")["shares_of_boundaries"]
    shares = [order["share_of_boundaries"] for order in fig14["orders"]] + [fig14["share_of_boundaries"]]
    assert all(f"{100 * share:.1f} %" in section("fig14") for share in shares)
    assert [order["arcs"] for order in fig14["orders"]] == [1, 2, 7]
    assert fig16["both manifolds"] == numbers_of("fig15")["share_of_boundaries"] == 1.0
    assert f"{fig16['grazing curve and pre-images 1, 2']:.3f}" in section("fig16")
    branches = {label: each["branches"] for label, each in numbers_of("fig17")["manifolds"].items()}
    points = [sum(branch["points"] for branch in branches[label]) for label in "AB"]
    assert all(f"{count:,}" in section("fig17") for count in points)


def test_each_figure_is_in_the_table_with_its_command():
    rows = re.findall(r"^\| `(fig\d+)` \|", DOCUMENT, re.MULTILINE)
    assert rows == list(PAPER_FIGURES) == [f"fig{number}" for number in range(1, 18)]
