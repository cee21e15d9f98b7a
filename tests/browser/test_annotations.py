"""Annotations: pinned and measured by pointer, finger and keys, and seen wherever the picture goes."""

import re
from urllib.parse import parse_qs, urlsplit

import pytest
from playwright.sync_api import expect

from tests.browser.chromium import Explorer
from tests.browser.test_help import findings

pytestmark = pytest.mark.browser


def query_of(page):
    return parse_qs(urlsplit(page.url).query)


def test_points_and_distances_travel_in_the_address_and_can_be_removed(explorer, service):
    job = service.wait(
        service.submit({"grid": {"time": {"cells": 60}, "velocity": {"cells": 60}}, "iterations": 223})["id"]
    )
    page = explorer.visit(f"?job={job['id']}").pictured("60 × 60").page
    page.get_by_role("button", name="Annotate").click()
    page.mouse.click(*explorer.spot(0.3, 0.5))
    page.keyboard.type("a fold, here")
    assert findings(page) == []
    page.keyboard.press("Enter")
    expect(page.locator("#plane")).to_be_focused()
    page.mouse.move(*explorer.spot(0.5, 0.2))
    page.mouse.down()
    page.mouse.move(*explorer.spot(0.75, 0.4), steps=4)
    page.mouse.up()
    expect(page).to_have_url(re.compile("measure="))
    (note,), (measure,) = query_of(page)["note"], query_of(page)["measure"]
    assert note.endswith(",a fold, here")
    assert [float(each) for each in note.split(",")[:2]] == pytest.approx([0.3, 3.5], abs=0.01)
    assert [float(each) for each in measure.split(",")] == pytest.approx([0.5, 1.4, 0.75, 2.8], abs=0.01)
    # White over navy, blended where it ends within a pixel.
    assert min(explorer.colour(0.5, 0.2)) > 160
    page.locator("#away summary").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="What is seen (SVG)").click()
    for words in ("a fold, here", "Δt = 0.25, Δv = 1.4"):
        assert words in download.value.path().read_text()
    page.keyboard.press("Escape")
    page.reload()
    explorer.pictured("60 × 60")
    # White over navy, blended where it ends within a pixel.
    assert min(explorer.colour(0.5, 0.2)) > 160
    page.get_by_role("button", name="Annotate").click()
    page.mouse.click(*explorer.spot(0.3, 0.5))
    expect(page.get_by_label("label of the point")).to_have_value("a fold, here")
    page.get_by_role("button", name="Remove").click()
    page.mouse.click(*explorer.spot(0.5, 0.2))
    expect(page.get_by_label("label of the line")).to_have_value("Δt = 0.25, Δv = 1.4")
    page.keyboard.press("Delete")
    page.keyboard.press("Enter")
    assert query_of(page)["measure"][0].endswith(","), "a plain line"
    page.mouse.click(*explorer.spot(0.5, 0.2))
    expect(page.get_by_label("label of the line")).to_have_value("")
    page.get_by_role("button", name="Remove").click()
    assert not {"note", "measure"} & set(query_of(page))
    assert explorer.colour(0.5, 0.2) != (255, 255, 255)


def test_all_of_it_can_be_done_with_keys(explorer):
    page = explorer.visit().pictured().page
    page.locator("#plane").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("n")
    page.keyboard.type("middle")
    page.keyboard.press("Enter")
    page.keyboard.press("d")
    for _ in range(10):
        page.keyboard.press("ArrowUp")
    page.keyboard.press("d")
    expect(page).to_have_url(re.compile("note=.*middle.*measure="))
    page.keyboard.press("Delete")
    page.keyboard.press("Delete")
    expect(page).not_to_have_url(re.compile("note=|measure="))


def test_a_finger_pins_and_measures(chromium_here, service):
    phone = Explorer(chromium_here, service.url, viewport={"width": 360, "height": 740}, has_touch=True, is_mobile=True)
    page = phone.visit().pictured().page
    page.get_by_role("button", name="Annotate").tap()
    x, y = phone.spot(0.4, 0.8)
    page.touchscreen.tap(x, y)
    box = page.locator("#label").bounding_box()
    assert box["x"] >= 0 and box["x"] + box["width"] <= 360
    page.keyboard.type("here")
    page.keyboard.press("Enter")
    assert page.locator("#plane").evaluate("canvas => getComputedStyle(canvas).touchAction") == "none"
    touch = page.context.new_cdp_session(page)
    for kind, at in (("touchStart", (x, y + 60)), ("touchMove", (x + 60, y + 90)), ("touchMove", (x + 90, y + 120))):
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": at[0], "y": at[1]}]})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    expect(page).to_have_url(re.compile("note=.*here.*measure="))
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    assert phone.unforgiven() == []
    phone.context.close()
