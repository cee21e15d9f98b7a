"""What is proven of a basin, as someone who looks at it sees it: hatched, counted and told."""

import re
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.rattle_proof.proven_store import lay_proof

pytestmark = pytest.mark.browser

AXE = Path(__file__).parents[2] / "node_modules" / "axe-core" / "axe.min.js"
CELLS = 100
SMALL = {"grid": {"time": {"cells": CELLS}, "velocity": {"cells": CELLS}}, "iterations": 181}
QUIET = (20, 31, 64)
GRAZES, SPREADS = 3, 2


@pytest.fixture(scope="module")
def job(service):
    """A basin of which the left half is not proven: the upper part as it grazes, the lower as it spreads."""
    job = service.wait(service.submit(SMALL)["id"])
    proven = np.full((CELLS, CELLS), 64)
    proven[:, : CELLS // 2] = 0
    reason = np.zeros_like(proven)
    reason[CELLS // 2 :, : CELLS // 2], reason[: CELLS // 2, : CELLS // 2] = GRAZES, SPREADS
    # A cell of which a quarter is proven.
    proven[2, 2] = 16
    lay_proof(service.store_of(job), proven, reason)
    return job


@pytest.fixture
def opened(explorer, job):
    explorer.visit(f"?job={job['id']}").state("Complete")
    expect(explorer.page.locator("#legend")).to_contain_text("Not proven")
    return explorer


def part_of(explorer, across, up, size=40):
    """Colours of a square of pixels about a place of the plot."""
    x, y = explorer.spot(across, up)
    box = explorer.page.locator("#plane").bounding_box()
    script = """(canvas, [x, y, size]) => {
        const ratio = canvas.width / canvas.clientWidth;
        const { data } = canvas.getContext("2d").getImageData(x * ratio - size / 2, y * ratio - size / 2, size, size);
        return [...data];
    }"""
    pixels = explorer.page.locator("#plane").evaluate(script, [x - box["x"], y - box["y"], size])
    return np.array(pixels).reshape(size, size, 4)[..., :3]


def hatched(explorer, across, up):
    """Whether a place is pale, with lines across; or as clean as ever."""
    pixels = part_of(explorer, across, up)
    pale, dark = (pixels.min(axis=-1) > 120).mean(), (pixels.max(axis=-1) < 100).mean()
    return pale > 0.5 and 0.02 < dark < 0.5


def proven_box(explorer):
    return explorer.page.get_by_label("Proven", exact=True)


def test_what_is_not_proven_is_hatched_at_every_zoom_and_the_rest_is_clean(opened):
    assert hatched(opened, 0.25, 0.1) and not hatched(opened, 0.75, 0.1)
    assert (part_of(opened, 0.75, 0.1) == QUIET).all()
    opened.page.locator("#anew").uncheck()
    opened.page.mouse.move(*opened.spot(0.5, 0.1))
    for _ in range(12):
        opened.page.mouse.wheel(0, -100)
    expect(opened.page).to_have_url(re.compile("window="))
    assert hatched(opened, 0.25, 0.1), "lines are no wider, and no farther apart, where cells are"
    assert (part_of(opened, 0.75, 0.1) == QUIET).all()


def test_the_switch_takes_the_hatch_away_and_the_address_knows(opened):
    proven_box(opened).uncheck()
    assert (part_of(opened, 0.25, 0.1) == QUIET).all()
    opened.page.reload()
    opened.state("Complete")
    expect(proven_box(opened)).not_to_be_checked()
    proven_box(opened).check()
    assert hatched(opened, 0.25, 0.1)


def test_the_legend_counts_what_is_proven_and_says_why_the_rest_is_not(opened):
    legend = opened.page.locator("#legend")
    expect(legend.get_by_role("heading", name="Proven: 50.00 %", exact=True)).to_be_visible()
    expect(legend.get_by_role("heading", name="Not proven: 50.00 %")).to_be_visible()
    reasons = legend.locator(".masked").nth(1).locator("li")
    expect(reasons).to_have_count(2)
    expect(reasons.first).to_contain_text("spreads too wide")
    expect(reasons.last).to_contain_text("straddles grazing")
    expect(reasons.last).to_contain_text("25.00 %")


def test_a_cell_says_whether_it_is_proven(opened):
    sentence = opened.page.locator("#reading")
    opened.hover(0.75, 0.1)
    expect(sentence).to_contain_text("Proven: every departure of this cell falls quiet.")
    opened.hover(0.25, 0.1)
    expect(sentence).to_contain_text("Not proven: this cell spreads too wide")
    opened.hover(0.25, 0.9)
    expect(sentence).to_contain_text("Not proven: this cell straddles grazing")
    opened.hover(2.5 / CELLS, 2.5 / CELLS)
    expect(sentence).to_contain_text("Proven for 16 of 64 parts")


def test_a_preview_over_a_proven_basin_is_not_taken_for_proven(opened):
    opened.page.locator("#anew").uncheck()
    expect(proven_box(opened)).to_be_visible()
    opened.fill(damping=0.61)
    opened.pictured("edited, not computed")
    expect(proven_box(opened)).to_be_hidden()
    expect(opened.page.locator("#legend")).not_to_contain_text("roven")


def test_what_is_taken_away_has_the_hatch(opened):
    opened.page.locator("#away summary").click()
    with opened.page.expect_request("**/picture.svg?*") as asked:
        opened.page.get_by_role("button", name="What is seen (SVG)").click()
    assert "overlays=proven%2Cgrazing%2Cattractors" in asked.value.url


def test_a_basin_without_a_proof_offers_none(explorer, service):
    job = service.wait(service.submit(SMALL | {"iterations": 179})["id"])
    explorer.visit(f"?job={job['id']}").state("Complete")
    expect(explorer.page.locator("#legend button")).to_have_count(3)
    expect(proven_box(explorer)).to_be_hidden()
    expect(explorer.page.locator("#legend")).not_to_contain_text("roven")


def test_a_proof_is_asked_for_by_its_box(explorer):
    """Where every motion falls quiet it takes seconds."""
    page = explorer.visit().page
    explorer.fill(eccentricity=0.05, time__cells=40, velocity__cells=40)
    box = page.get_by_label("prove it")
    box.check()
    explorer.compute()
    explorer.state("Complete", seconds=200)  # its kernels are compiled first
    expect(page.locator("#legend").get_by_role("heading", name="Proven: 100.00 %", exact=True)).to_be_visible()
    expect(page).to_have_url(re.compile("prove=3"))
    expect(box).to_be_checked()
    explorer.open_drawer()
    page.locator("[name=vary]").select_option("damping")
    expect(box).to_be_hidden()


def test_nothing_keeps_anyone_out(opened):
    opened.page.evaluate(AXE.read_text())
    found = opened.page.evaluate("axe.run().then(({ violations }) => violations)")
    assert [(each["id"], [node["html"] for node in each["nodes"]]) for each in found] == []


def test_the_legend_has_the_bounds_of_each_share(explorer, service):
    job = service.wait(
        service.submit({"grid": {"time": {"cells": 30}, "velocity": {"cells": 30}}, "iterations": 181})["id"]
    )
    solutions = service.request("GET", job["links"]["result"]).json()["solutions"]
    quiet = [each["name"] for each in solutions].index("permanent contact")
    shares = [0.1 * each["share"] for each in solutions]
    certificate = {"shares": shares, "quiet": {"motion": quiet, "level": 0.09}, "never_quiet": 0.25}
    nothing = np.zeros((30, 30))
    lay_proof(service.store_of(job), nothing, nothing + SPREADS, {"certificate": certificate})
    explorer.visit(f"?job={job['id']}").state("Complete")
    entry = explorer.page.locator("#legend .masked li", has_text="permanent contact")
    least = f"{100 * shares[quiet]:.2f} %"
    expect(entry.locator(".share")).to_have_text(f"{least} to 75.00 %")
