"""The chart of two parameters beside the plane: a basin behind every point, which a click keeps."""

import re

import pytest
from playwright.sync_api import expect

from tests.browser.test_charts import AXE, LINK, posts

pytestmark = pytest.mark.browser

CHART = {
    "first": {"parameter": "damping", "start": 0.75, "stop": 0.78},
    "second": {"parameter": "eccentricity", "start": 0.094, "stop": 0.0995},
    "longest": 1, "lines": 2, "cells": 12, "pixels": 6, "departures": 16,
}  # fmt: skip
SEEN = "parameters=damping,eccentricity,0.75,0.78,0.094,0.0995"
STAGE, READING = "#parameters .stage", "#parameters .reading"


@pytest.fixture(scope="module")
def chart(service):
    """A chart that was computed before."""
    return service.wait(service.submit(CHART, "charts")["id"])


@pytest.fixture
def charted(explorer, chart):
    """The page with that chart beside a basin."""
    explorer.ask(f"{LINK}&{SEEN}&parameters_job={chart['id']}").state("Complete")
    expect(explorer.page.locator("#parameters [data-curve]").first).to_be_attached(timeout=30_000)
    return explorer


def machine_at(page, across, up):
    """Place on the page of a part of the frame, and its machine."""
    frame = page.locator(f"{STAGE} rect.axis").bounding_box()
    at = frame["x"] + across * frame["width"], frame["y"] + (1 - up) * frame["height"]
    return at, 0.75 + across * 0.03, 0.094 + up * 0.0055


def shown(page):
    """Damping and eccentricity of the basin that is seen."""
    text = page.locator("#shown").inner_text()
    return [float(re.search(rf"{symbol} = ([\d.]+)", text).group(1)) for symbol in "δε"]


def test_the_plane_shows_the_machine_under_the_pointer_until_it_leaves(charted):
    page = charted.page
    address, asked = page.url, posts(charted, "/v1/basins")
    at, damping, eccentricity = machine_at(page, 0.25, 0.25)
    page.mouse.move(*at)
    expect(page.locator("#shown")).to_contain_text("δ = 0.757", timeout=10_000)
    assert shown(page) == pytest.approx([damping, eccentricity], rel=2e-3)
    expect(page.locator(READING)).to_have_text(re.compile(r"damping δ = 0\.757\d+, eccentricity ε = 0\.095\d+\. "))
    assert page.url == address, "what is only passed over is not in the address"
    page.mouse.move(2, 2)
    expect(page.locator("#shown")).to_contain_text("δ = 0.6, ε = 0.1,", timeout=10_000)
    charted.state("Complete")
    assert page.url == address and asked == [], "the basin that was computed is seen again"


def test_a_drag_is_a_film_of_basins_and_no_zoom(charted):
    page = charted.page
    seen = set()
    start, *_ = machine_at(page, 0.1, 0.5)
    page.mouse.move(*start)
    page.mouse.down()
    for part in range(2, 10):
        page.mouse.move(*machine_at(page, part / 10, 0.5)[0])
        page.wait_for_timeout(400)
        seen.add(shown(page)[0])
    page.mouse.up()
    assert len(seen) >= 5 and f"{SEEN}&" in page.url


def test_a_click_keeps_a_machine_and_computes_it(charted):
    page = charted.page
    at, damping, eccentricity = machine_at(page, 0.75, 0.3)
    with page.expect_request("**/v1/basins") as asked:
        page.mouse.click(*at)
    oscillator = asked.value.post_data_json["oscillator"]
    assert oscillator["damping"] == pytest.approx(damping, abs=2e-4)
    assert oscillator["eccentricity"] == pytest.approx(eccentricity, abs=3e-5)
    page.mouse.move(2, 2)
    charted.state("Complete")
    assert shown(page) == pytest.approx([oscillator["damping"], oscillator["eccentricity"]], rel=1e-5)
    expect(page.locator("#parameters .here")).to_have_attribute("visibility", "visible")
    expect(page.locator("#parameters-watch")).to_have_text("Cancel")
    page.reload()
    expect(page.locator("#parameters [data-curve]").first).to_be_attached(timeout=30_000)


def test_a_click_while_what_was_seen_before_is_opened_again_is_not_lost(charted):
    page = charted.page
    at, damping, _ = machine_at(page, 0.6, 0.4)
    page.mouse.move(*at)
    expect(page.locator("#shown")).to_contain_text("δ = 0.768", timeout=10_000)
    held, holding = [], [True]
    page.route("**/v1/jobs/*", lambda route: held.append(route) if holding else route.continue_())
    page.mouse.move(2, 2)
    page.wait_for_timeout(300)
    page.mouse.click(*at)
    page.wait_for_timeout(300)
    assert held, "the job of the address is asked for"
    with page.expect_request("**/v1/basins") as asked:
        holding.clear()
        for route in held:
            route.continue_()
    assert asked.value.post_data_json["oscillator"]["damping"] == pytest.approx(damping, abs=2e-4)
    page.mouse.move(2, 2)
    charted.state("Complete")
    assert shown(page)[0] == pytest.approx(damping, abs=2e-4)


def test_a_curve_says_what_happens_there_and_is_named(charted, chart, service):
    page = charted.page
    curves = service.request("GET", chart["links"]["result"]).json()["curves"]
    assert page.locator("#parameters .name").count() > 0
    keys = page.locator("#parameters-key .key").all_inner_texts()
    assert {f"{curve['kind']} of {curve['orbit']}" for curve in curves} <= set(keys)
    stage = page.locator(STAGE)
    stage.press("ArrowRight")
    said = page.locator(READING).inner_text()
    assert any(said.endswith(curve["says"]) for curve in curves)
    with page.expect_request("**/v1/basins"):
        stage.press("Enter")


def test_with_shift_a_box_zooms_and_the_part_can_be_computed(charted):
    page = charted.page
    asked = posts(charted, "/v1/charts")
    page.keyboard.down("Shift")
    page.mouse.move(*machine_at(page, 0.2, 0.2)[0])
    page.mouse.down()
    page.mouse.move(*machine_at(page, 0.7, 0.8)[0], steps=4)
    page.mouse.up()
    page.keyboard.up("Shift")
    expect(page).not_to_have_url(re.compile(SEEN))
    zoomed = page.url
    page.mouse.move(2, 2)
    expect(page.locator("#shown")).to_contain_text("δ = 0.6, ε = 0.1,", timeout=10_000)
    assert asked == [] and page.url == zoomed
    button = page.get_by_role("button", name="Compute this part")
    with page.expect_request("**/v1/charts") as request:
        button.click()
    first = request.value.post_data_json["first"]
    assert first["parameter"] == "damping" and first["start"] == pytest.approx(0.756, abs=3e-4)
    page.locator("#parameters-watch").get_by_role("button", name="Cancel").click()
    expect(page.locator("#parameters-watch")).to_contain_text("Cancelled.", timeout=60_000)


def test_what_lies_below_can_be_chosen(charted):
    page = charted.page
    exponents = page.locator("#parameters .machines").count()
    page.locator("#parameters-field").select_option("motion")
    expect(page.locator("#parameters-key")).to_contain_text("chaotic")
    assert page.locator("#parameters .machines").count() != 0 != exponents
    page.mouse.move(*machine_at(page, 0.1, 0.3)[0])
    expect(page.locator(READING)).to_contain_text("What most departures end in")


@pytest.mark.parametrize("size", [(1600, 1000), (1280, 800), (1024, 768), (768, 1024), (360, 740)], ids=str)
def test_it_is_accessible_and_on_the_screen_with_the_plane(charted, size):
    page = charted.page
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.wait_for_timeout(300)
    stage, plane = page.locator(STAGE).bounding_box(), page.locator("#plane").bounding_box()
    assert stage["width"] >= 240 and plane["width"] >= 240
    beside = stage["x"] + stage["width"] <= plane["x"]
    assert beside == (size[0] > 1200)
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    page.evaluate(AXE.read_text())
    found = page.evaluate("axe.run().then(({violations}) => violations)")
    assert [(each["id"], [node["html"] for node in each["nodes"]]) for each in found] == []


def test_a_service_asks_for_any_two_parameters(explorer):
    explorer.ask(LINK).state("Complete")
    page = explorer.page
    page.locator("#parameters-first").select_option("eccentricity")
    page.locator("#parameters-second").select_option("half_backlash")
    with page.expect_request("**/v1/charts") as asked:
        page.locator("#parameters-ask").click()
    body = asked.value.post_data_json
    assert (body["first"]["parameter"], body["second"]["parameter"]) == ("eccentricity", "half_backlash")
    expect(page.locator("#parameters-title")).to_have_text("Chart of eccentricity ε and half backlash β")
    page.locator("#parameters-watch").get_by_role("button", name="Cancel").click()
    expect(page.locator("#parameters-watch")).to_contain_text("Cancelled.", timeout=60_000)
