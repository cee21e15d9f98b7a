"""What docs/paper/machine.md prints is what is computed, or what the committed numbers say."""

import itertools
import json

import pytest

from tests.printed import DOCUMENTS, demand_as_printed

FIGURES = DOCUMENTS / "figures"
DOCUMENT = (DOCUMENTS / "paper" / "machine.md").read_text()


def test_what_is_captured_is_as_printed(capsys):
    # The bound goes by steps; on another processor it may be one step off.
    demand_as_printed("paper/machine.md", capsys, rtol=0.09)


def numbers_of(name):
    return json.loads((FIGURES / f"{name}.json").read_text())


def table_under(heading):
    """Cells of the first table below a heading, row by row, the head and its line left out."""
    lines = DOCUMENT.split(f"\n## {heading}\n")[1].split("\n## ")[0].splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("|"))
    rows = itertools.takewhile(lambda line: line.startswith("|"), lines[first + 2 :])
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]


@pytest.mark.parametrize(
    ("name", "heading"),
    [("machine", "What motions end in: impacting"), ("machine-soft", "What motions end in: kappa = 1000")],
)
def test_shares_are_as_printed_and_nothing_is_left_open(name, heading):
    basins = list(numbers_of(name)["panels"].values())
    assert f"](../figures/{name}.png)" in DOCUMENT and (FIGURES / f"{name}.png").stat().st_size < 700_000
    printed = {row[0]: row[1:] for row in table_under(heading)}
    for place, basin in enumerate(basins):
        shares = {}
        for motion in basin["solutions"]:
            shares[motion["name"]] = shares.get(motion["name"], 0.0) + motion["share"]
        assert sum(shares.values()) == pytest.approx(1.0)
        assert shares.get("undecided", 0.0) <= 1e-4 and basin["image_counts"]["undecided"] == 0
        assert not any("chaotic" in motion for motion in shares)
        assert printed["motions in all"][place] == str(len(basin["solutions"]))
        for motion, share in shares.items():
            if share >= 0.01:
                assert printed[motion][place] == f"{100.0 * share:.2f}", motion


@pytest.mark.parametrize(
    ("heading", "key", "scale", "digits"),
    [
        ("Share of quiet over damping and eccentricity", "quiet", 100.0, 1),
        ("Least disturbance over damping and eccentricity", "least_rattle", 1e4, 2),
    ],
)
def test_the_sweep_is_as_printed(heading, key, scale, digits):
    numbers = numbers_of("machine-sweep")
    rows = iter(table_under(heading))
    basins = numbers["panels"]
    for _, group in itertools.groupby(basins, lambda basin: basin["damping"]):
        for cell, basin in zip(next(rows)[1:], group, strict=True):
            value = basin[key]
            assert cell == ("> 9" if value is None else f"{scale * value:.{digits}f}")
            assert basin["least_rattle"] is None or basin["proven_quiet_below"] < basin["least_rattle"]
