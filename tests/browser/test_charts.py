"""Charts below the plane as instruments: points are named, views zoomed and kept, and a link asks for nothing."""

import csv
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.browser.chromium import Explorer

pytestmark = pytest.mark.browser

AXE = Path(__file__).parents[2] / "node_modules" / "axe-core" / "axe.min.js"
LINK = "?damping=0.6&eccentricity=0.1&half_backlash=0.6&grid=0,1,0,7&cells=60,60&k=101"
DIAGRAM = {"vary": {"parameter": "damping", "start": 0.55, "stop": 0.65, "count": 40}, "transient": 200, "kept": 4}


@pytest.fixture(scope="module")
def diagram(service):
    """A diagram that was computed before."""
    return service.wait(service.submit(DIAGRAM, "bifurcations")["id"])


@pytest.fixture
def charted(explorer, diagram):
    """The page with that diagram below a basin."""
    explorer.ask(f"{LINK}&diagram=damping,0.55,0.65&diagram_job={diagram['id']}").state("Complete")
    expect(explorer.page.locator("#diagram .points").first).to_be_attached(timeout=30_000)
    explorer.page.locator("#diagram .stage").scroll_into_view_if_needed()
    return explorer


def seen(page):
    """Ranges of a diagram in the address."""
    return [float(each) for each in re.search(r"[?&]diagram=\w+,([^&]*)", page.url).group(1).split(",")]


def posts(explorer, part):
    requests = []
    explorer.page.on(
        "request", lambda each: requests.append(each) if each.method == "POST" and part in each.url else None
    )
    return requests


def drag(page, start, stop, stage="#diagram .stage"):
    box = page.locator(stage).bounding_box()
    at = lambda across, down: (box["x"] + across * box["width"], box["y"] + down * box["height"])  # noqa: E731
    page.mouse.move(*at(*start))
    page.mouse.down()
    page.mouse.move(*at(*stop), steps=4)
    page.mouse.up()


def test_a_chart_is_a_part_of_the_window_and_names_the_nearest_point(charted):
    page = charted.page
    assert page.locator("#diagram .stage").bounding_box()["height"] == pytest.approx(0.4 * 980, abs=1)
    box = page.locator("#diagram path[data-motion='P(1,1,0)']").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2 + 4)
    expect(page.locator("#diagram .reading")).to_have_text(
        re.compile(r"^damping δ = 0\.\d+   v = 3\.\d+   P\(1,1,0\)$")
    )
    expect(page.locator("#diagram .mark")).to_have_attribute("visibility", "visible")


def test_a_box_zooms_both_ways_and_the_page_and_the_chart_step_back(charted):
    page = charted.page
    whole = seen(page)
    drag(page, (0.2, 0.2), (0.8, 0.7))
    expect(page).to_have_url(re.compile(r"diagram=damping,0\.\d+,0\.\d+,"))
    x0, x1, y0, y1 = zoomed = seen(page)
    assert 0.55 < x0 < x1 < 0.65 and 0 < y0 < y1 < 5
    expect(page.locator("#diagram").get_by_role("button", name="← Step back")).to_be_enabled()
    page.locator("#diagram .stage").press("Backspace")
    expect(page).to_have_url(re.compile(r"diagram=damping,0\.55,0\.65&"))
    page.go_back()
    expect(page).to_have_url(re.compile(r"diagram=damping,0\.\d+,0\.\d+,"))
    assert seen(page) == zoomed
    page.reload()
    expect(page.locator("#diagram .points").first).to_be_attached(timeout=30_000)
    assert seen(page) == zoomed != whole


def test_keys_do_all_that_the_pointer_does(charted):
    page = charted.page
    stage, reading = page.locator("#diagram .stage"), page.locator("#diagram .reading")
    assert "Backspace steps back" in stage.get_attribute("aria-label")
    stage.press("ArrowRight")
    first = reading.inner_text()
    stage.press("ArrowRight")
    assert re.match(r"damping δ = 0\.\d+   v = ", first) and reading.inner_text() != first
    stage.press("+")
    expect(page).to_have_url(re.compile(r"diagram=damping,0\.\d+,0\.\d+,"))
    stage.press("0")
    expect(page).to_have_url(re.compile(r"diagram=damping,0\.55,0\.65&"))
    value = re.match(r"damping δ = (\S+)", reading.inner_text()).group(1)
    stage.press("Enter")
    expect(page.locator("#shown")).to_contain_text(f"δ = {value.rstrip('0')}")


def test_only_with_control_the_wheel_zooms_a_chart(charted):
    page = charted.page
    stage = page.locator("#diagram .stage")
    wheel = """(stage, ctrlKey) => {
        const { x, y, width, height } = stage.getBoundingClientRect();
        const event = new WheelEvent("wheel", {
            deltaY: -100, ctrlKey, clientX: x + width / 2, clientY: y + height / 2, bubbles: true, cancelable: true });
        stage.dispatchEvent(event);
        return event.defaultPrevented;
    }"""
    assert stage.evaluate(wheel, False) is False
    assert stage.evaluate(wheel, True) is True
    expect(page).to_have_url(re.compile(r"diagram=damping,0\.\d+,0\.\d+,"))


def test_a_narrow_range_is_computed_anew(charted):
    page = charted.page
    with page.expect_request("**/v1/bifurcations") as asked:
        drag(page, (0.4, 0.5), (0.5, 0.502))
    vary = asked.value.post_data_json["vary"]
    assert vary["parameter"] == "damping" and 0.55 < vary["start"] < vary["stop"] < 0.61
    expect(page).to_have_url(re.compile(f"diagram=damping,{vary['start']},{vary['stop']}&"))
    # The old rows stay until the new ones come.
    assert page.locator("#diagram .points").count() > 0


def test_what_is_saved_needs_no_style_sheet_and_has_the_rows(charted, tmp_path):
    page = charted.page
    for ending in ("SVG", "PNG", "CSV"):
        with page.expect_download() as saved:
            page.locator("#diagram").get_by_role("button", name=ending).click()
        saved.value.save_as(tmp_path / f"chart.{ending.lower()}")
    root = ET.parse(tmp_path / "chart.svg").getroot()
    drawn = list(root.iter())
    assert not any("class" in each.attrib or "style" in each.attrib for each in drawn)
    texts = [each for each in drawn if each.tag.endswith("text")]
    assert {"damping δ", "velocity v of departure", "P(1,1,0)"} <= {each.text for each in texts}
    assert all(each.get("fill") and each.get("font-size") and each.get("font-family") for each in texts)
    assert "#56b4e9" in {each.get("stroke") for each in drawn} or "rgb(86, 180, 233)" in {
        each.get("stroke") for each in drawn
    }
    assert (tmp_path / "chart.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    columns, *rows = csv.reader((tmp_path / "chart.csv").read_text().splitlines())
    assert columns == ["damping", "velocity", "motion"]
    assert {len(row) for row in rows} == {3} and "P(1,1,0)" in {row[2] for row in rows}


def test_a_link_asks_for_no_diagram_and_offers_to_compute_it(explorer):
    asked = posts(explorer, "/v1/bifurcations")
    explorer.ask(f"{LINK}&diagram=damping,0.5512,0.6513").state("Complete")
    page = explorer.page
    button = page.get_by_role("button", name="Compute this diagram")
    expect(button).to_be_visible()
    assert asked == []
    with page.expect_request("**/v1/bifurcations") as request:
        button.click()
    vary = request.value.post_data_json["vary"]
    assert (vary["start"], vary["stop"]) == (0.5512, 0.6513)
    expect(page).to_have_url(re.compile("diagram_job="))
    page.locator("#diagram-watch").get_by_role("button", name="Cancel").click()
    expect(page.locator("#diagram-watch")).to_contain_text("Cancelled.", timeout=60_000)
    expect(button).to_be_visible()


def test_a_reload_asks_for_no_diagram_again(charted):
    asked = posts(charted, "/v1/bifurcations")
    charted.page.reload()
    expect(charted.page.locator("#diagram .points").first).to_be_attached(timeout=30_000)
    assert asked == []


def test_a_diagram_of_another_machine_says_so(charted):
    page = charted.page
    charted.fill(damping=0.58)
    charted.pictured("edited, not computed")
    expect(page.locator("#diagram-watch")).to_have_text("Cancel")
    charted.fill(eccentricity=0.09)
    expect(page.locator("#diagram-watch")).to_contain_text(
        "not of the basin that is seen, but of impacts: ε = 0.1, β = 0.6", timeout=20_000
    )
    with page.expect_request("**/v1/bifurcations") as asked:
        page.get_by_role("button", name="Compute it anew").click()
    assert asked.value.post_data_json["oscillator"]["eccentricity"] == 0.09


def test_a_closed_chart_comes_back_with_the_page(charted):
    page = charted.page
    page.locator("#diagram").get_by_role("button", name="Close").click()
    expect(page.locator("#diagram")).to_be_hidden()
    assert "diagram" not in page.url
    page.go_back()
    expect(page.locator("#diagram .points").first).to_be_attached(timeout=30_000)


def test_orbits_come_back_and_are_followed_from_the_keyboard(explorer, service):
    job = service.wait(service.submit({"longest": 1}, "orbits")["id"])
    explorer.ask(f"{LINK}&orbits=1&orbits_job={job['id']}").state("Complete")
    page = explorer.page
    expect(page.locator("#orbits-chart .orbit").first).to_be_attached(timeout=30_000)
    stage = page.locator("#orbits .stage")
    stage.press("ArrowRight")
    expect(page.locator("#orbits .reading")).to_have_text(re.compile(r"^t = 0\.\d+   v = \d\.\d+   P\("))
    stage.press("Enter")
    expect(page.locator("#histories")).to_contain_text("The motion from t = ")
    assert "orbits=1" in page.url


def test_charts_of_a_sweep_are_zoomed_and_kept_by_the_address(explorer, service):
    vary = [{"parameter": "damping", "values": [0.55, 0.6, 0.65]}]
    body = {"grid": {"time": {"cells": 60}, "velocity": {"cells": 60}}, "iterations": 101, "vary": vary}
    job = service.wait(service.submit(body)["id"])
    explorer.visit(f"?job={job['id']}").state("Complete")
    page = explorer.page
    expect(page.locator("#shares .line").first).to_be_attached()
    stage = page.locator("#shares .stage")
    stage.press("ArrowRight")
    expect(page.locator("#shares .reading")).to_have_text(re.compile(r"damping δ = 0\.65   [\d.]+ %   \w"))
    stage.press("Enter")
    expect(page.locator("#sliders output")).to_have_text("0.65")
    stage.press("+")
    expect(page).to_have_url(re.compile(r"shares=0\.\d+,0\.65"))
    page.reload()
    expect(page.locator("#shares .line").first).to_be_attached(timeout=30_000)
    expect(page).to_have_url(re.compile(r"shares=0\.\d+,0\.65"))


def test_a_tap_names_a_point_and_a_second_one_does_what_a_click_does(chromium_here, service, diagram):
    phone = Explorer(chromium_here, service.url, viewport={"width": 360, "height": 740}, has_touch=True, is_mobile=True)
    phone.ask(f"{LINK}&diagram=damping,0.55,0.65&diagram_job={diagram['id']}").state("Complete")
    page = phone.page
    line = page.locator("#diagram path[data-motion='P(1,1,0)']")
    expect(line).to_be_attached(timeout=30_000)
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    line.scroll_into_view_if_needed()
    box = line.bounding_box()
    spot = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.touchscreen.tap(*spot)
    expect(page.locator("#diagram .reading")).to_contain_text("P(1,1,0)")
    shown = page.locator("#shown").inner_text()
    page.touchscreen.tap(*spot)
    expect(page.locator("#shown")).not_to_have_text(shown)
    assert phone.unforgiven() == []
    phone.context.close()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_charts_keep_nobody_out(charted, theme):
    page = charted.page
    page.emulate_media(color_scheme=theme, reduced_motion="reduce")
    page.locator("#diagram .stage").press("ArrowRight")
    page.evaluate(AXE.read_text())
    findings = page.evaluate("axe.run().then(({violations}) => violations)")
    assert [(each["id"], [node["html"] for node in each["nodes"]]) for each in findings] == []


def test_loudness_is_a_layer_with_numbers_also_of_a_preview(explorer):
    explorer.ask(f"{LINK}&layer=loudness")
    explorer.state("Complete")
    page = explorer.page
    expect(page.locator("#layer")).to_have_value("loudness")
    legend = page.locator("#legend")
    expect(page.locator("#legend-title")).to_have_text("How loud it ends")
    expect(legend.locator(".heard li").first).to_contain_text("chaotic")
    expect(legend.locator(".heard li").first).to_contain_text("10.7")
    expect(legend.locator(".heard li").last).to_have_text("permanent contact0")
    assert explorer.colour(0.5, 0.1) == (68, 1, 84), "silence is dark"
    explorer.fill(damping=0.62)
    explorer.pictured("Preview")
    expect(legend).to_contain_text("Impact power of the motion")
    assert explorer.colour(0.5, 0.1) == (68, 1, 84)
    assert "layer=loudness" in page.url


def test_steps_are_told_in_impacts(explorer):
    explorer.ask(f"{LINK}&layer=step").state("Complete")
    expect(explorer.page.locator("#legend .ends span").first).to_have_text("101")
    expect(explorer.page.locator("#legend .ends span").last).to_have_text(re.compile(r"^\d[\d\u202f]+ impacts$"))
    assert explorer.colour(0.5, 0.1) == (68, 1, 84)


def test_the_uncertainty_exponent_is_told_on_request(explorer):
    explorer.ask(LINK).state("Complete")
    page = explorer.page
    page.locator("#uncertainty").click()
    words = page.locator("#explain + .note")
    expect(words).to_have_text(re.compile(r"Final-state uncertainty exponent 0\.\d+ ± 0\.\d+"), timeout=60_000)
    explorer.fill(damping=0.62)
    explorer.pictured("Preview")
    expect(page.locator("#uncertainty")).to_be_disabled()
    expect(words).to_be_empty()
