"""Words at the word: the glossary, the overview of keys, and the tour."""

from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.browser.chromium import Explorer

pytestmark = pytest.mark.browser

AXE = Path(__file__).parents[2] / "node_modules" / "axe-core" / "axe.min.js"


def findings(page):
    page.evaluate(AXE.read_text())
    found = page.evaluate("axe.run().then(({violations}) => violations)")
    return [(each["id"], [node["html"] for node in each["nodes"]]) for each in found]


def within(page, selector):
    box, view = page.locator(selector).bounding_box(), page.viewport_size
    return (
        box["x"] >= 0
        and box["y"] >= 0
        and box["x"] + box["width"] <= view["width"]
        and box["y"] + box["height"] <= view["height"]
    )


@pytest.mark.parametrize(("width", "height"), [(1440, 980), (360, 740)])
def test_a_tour_is_taken_in_five_steps_and_left_at_any_time(chromium_here, service, width, height):
    explorer = Explorer(chromium_here, service.url, viewport={"width": width, "height": height})
    page = explorer.visit().pictured().page
    tour = page.locator("#tour")
    expect(tour).to_be_hidden()
    page.locator("#help summary").click()
    page.get_by_role("button", name="Show me around").click()
    for step in range(1, 6):
        expect(tour.locator("[data-tour=place]")).to_have_text(f"{step} of 5")
        expect(page.locator(".pointed")).to_have_count(1)
        expect(tour.locator("[data-tour=next]")).to_be_focused()
        assert within(page, "#tour")
        if step in (1, 5):
            assert findings(page) == []
        page.keyboard.press("Enter")
    expect(tour).to_be_hidden()
    expect(page.locator("#help summary")).to_be_focused()
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Show me around").click()
    page.keyboard.press("Enter")
    expect(tour.locator("[data-tour=place]")).to_have_text("2 of 5")
    page.keyboard.press("Escape")
    expect(tour).to_be_hidden()
    expect(page.locator(".pointed")).to_have_count(0)
    assert explorer.unforgiven() == []
    explorer.context.close()


def test_words_are_explained_where_they_stand_and_all_in_the_menu(explorer):
    page = explorer.visit().pictured().page
    page.get_by_role("button", name="What is grazing curve?").click()
    term = page.locator("#term")
    expect(term).to_have_text("grazing curve: departures faster than v* reach −β.")
    assert within(page, "#term")
    assert findings(page) == []
    page.keyboard.press("Escape")
    expect(term).to_be_hidden()
    page.locator("#help summary").click()
    expect(page.locator("#words dt")).to_have_count(6)
    assert findings(page) == []


def test_a_question_mark_opens_the_overview_of_keys_but_is_a_letter_in_a_field(explorer):
    page = explorer.visit().pictured().page
    keys = page.locator("#keys")
    page.locator("#plane").focus()
    page.keyboard.press("?")
    expect(keys).to_be_visible()
    expect(keys).to_contain_text("follow the motion from the cross-hair")
    assert findings(page) == []
    page.keyboard.press("Escape")
    expect(keys).to_be_hidden()
    explorer.open_drawer()
    page.locator("#harmonics").press("?")
    expect(keys).to_be_hidden()
    expect(page.locator("#harmonics")).to_have_value("?")
