"""A large basin in the explorer: it is shown by one of its levels, and looked at more closely by finer ones."""

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.browser

LONG = {"grid": {"time": {"cells": 4200}, "velocity": {"cells": 300}}, "iterations": 211}


def test_a_large_basin_is_shown_by_a_level_and_closer_by_a_finer_one(explorer, service):
    job = service.wait(service.submit(LONG)["id"])
    asked = []
    explorer.page.on("request", lambda request: asked.append(request.url) if "/jobs" in request.url else None)
    with explorer.page.expect_response(lambda answer: "/tiles/" in answer.url):
        explorer.visit(f"?job={job['id']}").state("Complete")
    expect(explorer.page.locator("#legend button")).to_have_count(3)
    explorer.page.wait_for_load_state("networkidle")
    tiles = [url.rpartition("?")[2] for url in asked if "/tiles/" in url]
    assert tiles and set(tiles) == {"level=2"}
    assert "permanent contact" in explorer.hover(0.5, 0.1)

    asked.clear()
    explorer.page.mouse.move(*explorer.spot(0.5, 0.5))
    with explorer.page.expect_response(lambda answer: "level=1" in answer.url or "level=0" in answer.url):
        explorer.page.mouse.wheel(0, -400)
    explorer.page.wait_for_load_state("networkidle")
    finer = {url.rpartition("?")[2] for url in asked if "/tiles/" in url}
    assert finer and finer <= {"level=0", "level=1"}
    # The store has these cells: nothing is computed anew.
    assert not [url for url in asked if url.endswith("/v1/jobs")] and f"job={job['id']}" in explorer.page.url
    shown = explorer.hover(0.5, 0.5)
    assert "t = " in shown
