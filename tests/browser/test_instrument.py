"""The explorer as an instrument: a picture at once, sliders, the tooth, one state in the address."""

import re
import time
from pathlib import Path

import pytest
from playwright.sync_api import expect

from rattle_kernels import Oscillator, grazing_velocity
from tests.browser.chromium import Explorer

pytestmark = pytest.mark.browser

AXE = Path(__file__).parents[2] / "node_modules" / "axe-core" / "axe.min.js"
SMALL = {"grid": {"time": {"cells": 120}, "velocity": {"cells": 120}}, "iterations": 211}
LONG = {"grid": {"time": {"cells": 1400}, "velocity": {"cells": 1400}}, "iterations": 15013}


def link(k=211, cells=100, **more):
    """Address of a basin that the page has not asked for yet."""
    more = {"damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6, "grid": "0,1,0,7"} | more
    return "?" + "&".join(f"{name}={value}" for name, value in (more | {"cells": f"{cells},{cells}", "k": k}).items())


@pytest.fixture(scope="module")
def finished(service):
    return service.wait(service.submit(SMALL)["id"])


@pytest.fixture
def opened(explorer, finished):
    """The page with a finished basin."""
    explorer.visit(f"?job={finished['id']}").state("Complete")
    expect(explorer.page.locator("#legend button")).to_have_count(3)
    return explorer


def wheel(explorer, notches, across=0.5, up=0.5):
    explorer.page.mouse.move(*explorer.spot(across, up))
    for _ in range(abs(notches)):
        explorer.page.mouse.wheel(0, 100 if notches > 0 else -100)


def drag(explorer, start, stop):
    explorer.page.mouse.move(*explorer.spot(*start))
    explorer.page.mouse.down()
    explorer.page.mouse.move(*explorer.spot(*stop), steps=4)
    explorer.page.mouse.up()


def sent(explorer, part, method="POST"):
    """Requests to addresses with this part, from now on."""
    requests = []
    explorer.page.on(
        "request", lambda each: requests.append(each) if part in each.url and each.method == method else None
    )
    return requests


def test_the_page_begins_with_a_picture(explorer):
    jobs = sent(explorer, "/v1/basins")
    explorer.visit().pictured("Preview")
    expect(explorer.page.locator("#legend button")).to_have_count(3)
    assert explorer.colour(0.5, 0.1) == (20, 31, 64)
    expect(explorer.page).to_have_title(re.compile("Impacts: δ = 0.6"))
    assert jobs == [], "looking asks for no job"


def test_a_first_look_comes_before_slow_motions_have_names(explorer):
    held = []

    def hold(route):
        if route.request.post_data_json["quick"]:
            return route.fallback()
        return held.append(route)

    explorer.page.route("**/v1/previews", hold)
    explorer.visit().pictured("First look")
    assert explorer.colour(0.5, 0.1) == (20, 31, 64)
    explorer.page.wait_for_function("() => document.querySelectorAll('#legend button').length === 3")
    for route in held:
        route.fallback()
    explorer.pictured("Preview")


def test_what_would_be_refused_is_not_asked_for(explorer):
    explorer.visit().pictured("Preview")
    previews = sent(explorer, "/v1/previews")
    explorer.open_drawer()
    explorer.page.locator("[name=model]").select_option("piecewise_linear")
    explorer.fill(stiffness=100, eccentricity=0.3)
    expect(explorer.page.locator("#verdict")).to_contain_text("Eccentricity must be below")
    assert {each.post_data_json["oscillator"]["eccentricity"] for each in previews if each.post_data} <= {0.1}
    explorer.page.locator("[name=model]").select_option("impacting")
    explorer.fill(eccentricity=0.11)
    expect(explorer.page.locator("#shown")).to_contain_text("ε = 0.11")


def test_the_plane_stays_where_it_is_under_the_pointer_when_a_motion_is_followed(opened):
    before = opened.page.locator("#plane").bounding_box()
    opened.page.mouse.click(*opened.spot(0.95, 0.52))
    expect(opened.page.locator("#histories")).to_contain_text("ends in")
    assert opened.page.locator("#plane").bounding_box() == before


def test_where_there_is_no_picture_a_slider_stops_and_the_old_picture_is_dimmed(explorer):
    """Below a damping of 0.315 at this eccentricity there is no quiet solution of the piecewise linear model."""
    page = explorer.page
    explorer.visit().pictured("Preview")
    explorer.open_drawer()
    page.locator("[name=model]").select_option("piecewise_linear")
    explorer.fill(stiffness=1e4)
    expect(page.locator("#shown")).to_contain_text("κ = ")
    slider = page.locator("[data-turn=damping]")
    expect(page.locator(".turn", has=slider).locator(".refused")).to_have_count(1)
    previews = sent(explorer, "/v1/previews")

    def slide(damping):
        move = "(input, value) => { input.value = value; input.dispatchEvent(new Event('input', {bubbles: true})); }"
        slider.evaluate(move, damping)

    slide("0.2")
    expect(slider).to_have_value("0.316")
    stops = "Damping δ stops here: below it there is no quiet solution (Eq. 3)."
    expect(page.locator("#turn .note")).to_have_text(stops)
    expect(page.locator("#shown")).to_contain_text("δ = 0.316")
    expect(page.locator("#frame")).not_to_have_class("old")
    slide("0.55")
    expect(page.locator("#turn .note")).to_have_text("")
    expect(page.locator("#shown")).to_contain_text("δ = 0.55")
    # What is typed is not stopped, nor asked for.
    explorer.fill(damping=0.2)
    expect(page.locator("#frame")).to_have_class("old")
    expect(page.locator("#standing")).to_contain_text("There is no picture of what the request says")
    expect(page.locator("#shown")).to_contain_text("δ = 0.55")
    expect(page.locator("#compute")).to_be_disabled()
    expect(page.locator("#verdict")).to_contain_text("Eccentricity must be below")
    assert min(each.post_data_json["oscillator"]["damping"] for each in previews if each.post_data) > 0.315
    explorer.fill(damping=0.5)
    expect(page.locator("#shown")).to_contain_text("δ = 0.5")
    expect(page.locator("#frame")).not_to_have_class("old")
    expect(page.locator("#compute")).to_be_enabled()


def test_an_outage_of_the_service_is_said_and_ends_with_a_picture(explorer):
    explorer.forgiven += ("ERR_FAILED",)
    explorer.visit().pictured("Preview")
    explorer.page.route("**/v1/**", lambda route: route.abort())
    explorer.page.locator("#anew").uncheck()
    explorer.page.locator("#preset").select_option("fig13a")
    explorer.state("The service does not answer")
    explorer.page.unroute("**/v1/**")
    expect(explorer.page.locator("#shown")).to_contain_text("δ = 0.575")
    expect(explorer.page.locator("#state")).not_to_contain_text("does not answer")


def test_a_slider_redraws_the_picture_while_it_moves_and_asks_for_a_job_when_let_go(explorer):
    explorer.visit().pictured("Preview")
    previews, jobs = sent(explorer, "/v1/previews"), sent(explorer, "/v1/basins")
    explorer.fill(time__cells=60, velocity__cells=60, iterations=61)
    box = explorer.page.locator("[data-turn=damping]").bounding_box()
    y = box["y"] + box["height"] / 2
    explorer.page.mouse.move(box["x"] + 0.48 * box["width"], y)
    explorer.page.mouse.down()
    for step in range(4):
        explorer.page.mouse.move(box["x"] + (0.5 + 0.02 * step) * box["width"], y)
        with explorer.page.expect_response("**/v1/previews"):
            pass
    moved = [each.post_data_json["oscillator"]["damping"] for each in previews]
    assert len(set(moved)) > 2 and jobs == []
    explorer.page.mouse.up()
    explorer.state("Complete")
    assert len(jobs) == 1
    damping = jobs[0].post_data_json["oscillator"]["damping"]
    assert damping != 0.6
    expect(explorer.page.locator("#shown")).to_contain_text(f"δ = {damping:g}")
    expect(explorer.page.locator("[name=damping]")).to_have_value(f"{damping:g}")
    explorer.pictured("60 × 60 cells")


def test_a_click_moves_a_tooth_in_step_with_the_history_and_a_dot(opened):
    page = opened.page
    page.mouse.click(*opened.spot(0.95, 0.52))
    expect(page.locator("#histories")).to_contain_text("ends in")
    expect(page.locator("#tooth-canvas")).to_be_visible()
    cursor = page.locator("#histories .cursor")
    expect(cursor).to_have_attribute("visibility", "visible")
    first = cursor.get_attribute("d")
    expect(cursor).not_to_have_attribute("d", first)
    page.locator("#play").click()
    held = cursor.get_attribute("d")
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert cursor.get_attribute("d") == held
    dots = "canvas => [...canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data].some(Boolean)"
    assert page.locator("#marks").evaluate(dots), "a dot is on the basin"


def test_the_motion_under_the_pointer_is_drawn_and_explained(opened):
    with opened.page.expect_response("**/v1/trajectories"):
        opened.page.mouse.move(*opened.spot(0.95, 0.52))
    expect(opened.page.locator("#reading")).to_contain_text("P(1,1,0) repeats every forcing period, with 1 contact")


def test_panning_at_full_width_is_never_refused(opened):
    opened.page.locator("#anew").check()
    for across in (0.13, 0.29, 0.61, 0.07):
        before = opened.page.url
        drag(opened, (0.9, 0.5), (0.9 - across, 0.5))
        expect(opened.page).not_to_have_url(before)
        expect(opened.page).to_have_url(re.compile("window="))
        opened.state("Complete")


def test_after_quick_zooms_back_shows_what_was_zoomed_away_from(explorer, service):
    explorer.ask(link(k=3001, cells=700)).state("tiles")
    addresses = []
    for _ in range(3):
        before = explorer.page.url
        wheel(explorer, -2)
        expect(explorer.page).not_to_have_url(before)
        addresses.append(explorer.page.url)
    explorer.page.locator("#back").click()
    explorer.state("Complete", seconds=100)
    explorer.page.reload()
    explorer.state("Complete", seconds=100)
    explorer.pictured("700 × 700 cells")


def test_a_zoom_in_one_tab_does_not_stop_the_picture_in_another(chromium_here, explorer, service):
    address = link(k=3011, cells=700, damping=0.63)
    explorer.ask(address).state("cells")
    other = Explorer(chromium_here, service.url)
    other.ask(address).state("cells")
    wheel(explorer, -3)
    explorer.page.wait_for_url(re.compile("window="))
    explorer.pictured("Preview")
    other.state("Complete", seconds=100)
    other.context.close()


def test_the_form_the_window_and_the_picture_are_one(opened):
    opened.open_drawer()
    wheel(opened, -4, 0.5, 0.5)
    start = opened.page.locator("[name='velocity.start']")
    expect(start).not_to_have_value("0")
    assert 0 < float(start.input_value()) < 3.5
    opened.state("Complete")
    opened.fill(damping=0.57)
    expect(opened.page.locator("#standing")).to_contain_text("edited, not computed")
    expect(opened.page.locator("#shown")).to_contain_text("δ = 0.57")
    expect(opened.page.locator("[data-turn=damping]")).to_have_value("0.57")


def test_an_edit_right_after_a_zoom_stays(opened):
    opened.open_drawer()
    wheel(opened, -4, 0.5, 0.5)
    opened.fill(damping=0.57)
    expect(opened.page.locator("#shown")).to_contain_text("δ = 0.57")
    # Longer than a zoom rests before it asks.
    opened.page.wait_for_timeout(600)
    expect(opened.page.locator("[name=damping]")).to_have_value("0.57")
    expect(opened.page.locator("[data-turn=damping]")).to_have_value("0.57")


def test_a_refused_zoom_leaves_the_running_job_and_is_tried_again(explorer):
    cancelled = sent(explorer, "/withdraw")
    refusals = []

    def full(route):
        if len(refusals) < 1:
            refusals.append(route.request)
            return route.fulfill(status=429, headers={"retry-after": "1"}, json={"detail": "too many jobs are queued"})
        return route.fallback()

    explorer.forgiven += ("429",)
    explorer.ask(link(k=3019, cells=600, damping=0.62)).state("cells")
    explorer.page.route("**/v1/basins", full)
    wheel(explorer, -2)
    explorer.state("Too many jobs are queued. Trying again in 1 s.")
    assert cancelled == []
    explorer.state("Complete", seconds=100)
    assert len(refusals) == 1
    expect(explorer.page).to_have_url(re.compile("window="))


def test_a_queued_job_is_followed_by_its_events_at_once(explorer, service):
    explorer.visit().pictured("Preview")
    explorer.fill(time__cells=77, velocity__cells=77, iterations=331)
    reads = sent(explorer, "/v1/jobs/", "GET")
    explorer.compute()
    explorer.state("Complete")
    assert reads[0].url.endswith("/events"), "the job is not read again before its events are asked for"


def test_a_flat_box_and_a_click_in_box_mode_zoom_nowhere(opened):
    opened.page.locator("#box").click()
    before = opened.page.url
    asked = sent(opened, "/v1/basins")
    drag(opened, (0.2, 0.5), (0.8, 0.5))
    opened.page.wait_for_timeout(600)
    assert opened.page.url == before and asked == []


def test_zooming_out_ends_at_a_speed_that_is_said(opened):
    opened.page.locator("#anew").uncheck()
    wheel(opened, 30, 0.5, 0.0)
    opened.state("Speeds are shown up to 100")
    assert float(re.search(r"window=[^,]+,[^,]+,[^,]+,([^&]+)", opened.page.url)[1]) <= 100


def test_many_notches_are_one_entry_and_back_never_leaves_the_page(opened):
    page = opened.page
    page.locator("#anew").uncheck()
    expect(page.locator("#back")).to_be_disabled()
    entries = page.evaluate("history.length")
    wheel(opened, -12)
    expect(page).to_have_url(re.compile("window="))
    assert page.evaluate("history.length") == entries + 1
    page.locator("#back").click()
    expect(page).not_to_have_url(re.compile("window="))
    expect(page.locator("#back")).to_be_disabled()


def test_a_shared_link_of_a_zoom_knows_the_whole(opened, chromium_here, service):
    wheel(opened, -5)
    expect(opened.page).to_have_url(re.compile("whole="))
    opened.state("Complete")
    other = Explorer(chromium_here, service.url)
    other.page.goto(opened.page.url)
    other.state("Complete")
    other.page.locator("#whole").click()
    expect(other.page).not_to_have_url(re.compile("window="))
    assert other.hover(0.5, 0.999).startswith("t = 0.5")
    assert float(re.search(r"v = ([\d.]+)", other.hover(0.5, 0.999))[1]) == pytest.approx(7, abs=0.05)
    other.context.close()


def test_a_link_shows_a_preview_and_asks_for_nothing_until_compute_is_pressed(explorer):
    """Nor does the link to a job that this service does not know."""
    explorer.forgiven += ("404",)
    jobs = sent(explorer, "/v1/basins")
    seen = {"k": 61, "cells": 50, "window": "0.2,0.6,1,3", "layer": "step", "motion": "0.4,2.5"}
    explorer.visit(link(**seen, job="0" * 32)).pictured("Compute refines it")
    explorer.state("There is no job")
    explorer.visit(link(**seen)).pictured("Compute refines it")
    expect(explorer.page.locator("#histories")).to_contain_text("The motion from t = 0.4")
    expect(explorer.page.locator("#layer")).to_have_value("step")
    assert jobs == []
    explorer.compute()
    explorer.state("Complete")
    explorer.pictured("50 × 50 cells")
    assert len(jobs) == 1
    assert "t = 0.2" in explorer.hover(0.001, 0.5)


def test_a_link_of_a_sweep_over_two_numbers_computes_all_of_it(explorer):
    sweeps = sent(explorer, "/v1/sweeps")
    query = link(k=61, cells=20) + "&vary=damping,0.55,0.6&vary=eccentricity,0.05,0.1"
    explorer.ask(query).state("Complete")
    expect(explorer.page.locator("#sliders input")).to_have_count(2)
    assert len(sweeps) == 1


def test_a_highlight_stays_with_its_motion(opened):
    opened.page.get_by_role("button", name="P(1,1,0)").click()
    opened.open_drawer()
    opened.fill(damping=0.575)
    expect(opened.page.get_by_role("button", name="P(2,2,1)")).to_be_visible()
    expect(opened.page.get_by_role("button", name="P(1,1,0)")).to_have_attribute("aria-pressed", "true")
    expect(opened.page.get_by_role("button", name="P(1,2,0)")).to_have_attribute("aria-pressed", "false")


def test_after_an_outage_the_form_recovers(explorer):
    explorer.forgiven += ("ERR_FAILED",)
    explorer.visit().pictured("Preview")
    explorer.page.route("**/v1/checks", lambda route: route.abort())
    explorer.fill(iterations=1511)
    expect(explorer.page.locator("#verdict")).to_contain_text("does not answer")
    explorer.page.unroute("**/v1/checks")
    expect(explorer.page.locator("#verdict")).to_contain_text("of computing", timeout=10_000)
    expect(explorer.page.locator("#compute")).to_be_enabled()


def test_a_bifurcation_diagram_is_a_live_chart(opened):
    page = opened.page
    page.locator("[data-diagram=damping]").click()
    expect(page.locator("#diagram-note")).to_contain_text("Click to look", timeout=120_000)
    assert page.locator("#diagram .points").count() >= 2
    expect(page.locator("#diagram-motions")).to_contain_text("no period within 12 impacts")
    expect(page.locator("#diagram path[data-motion='P(1,1,0)']")).to_have_attribute("stroke", "#56b4e9")
    expect(page.locator("#diagram .here")).to_have_attribute("visibility", "visible")
    page.locator("#diagram .target").click(position={"x": 40, "y": 60})
    expect(page.locator("#shown")).to_contain_text("δ = 0.5")


@pytest.mark.timeout(700)
def test_diagrams_go_over_restitution_and_harmonics_too(opened):
    page = opened.page
    buttons = page.locator("#diagrams button")
    expect(buttons).to_have_text(
        ["Over damping δ", "Over eccentricity ε", "Over half backlash β", "Over restitution r"]
    )
    opened.fill(harmonics="2: 0.008, 0.3")
    expect(buttons).to_have_text(
        ["Over damping δ", "Over eccentricity ε", "Over half backlash β", "Over restitution r", "Over amplitude ε₂",
         "Over phase φ₂"],
        timeout=120_000,  # kernels for one more harmonic may have to be compiled
    )  # fmt: skip
    page.locator("[data-diagram=restitution]").click()
    expect(page.locator("#diagram-note")).to_contain_text("Click to look", timeout=400_000)  # and more for names
    expect(page.locator("#diagram-title")).to_have_text("Bifurcation diagram over restitution r")
    expect(page.locator("#diagram .here")).to_have_attribute("visibility", "visible")
    with page.expect_request("**/v1/bifurcations") as asked:
        page.locator("[data-diagram=phase_2]").click()
    assert asked.value.post_data_json["vary"] == {"parameter": "phase_2", "start": 0, "stop": 1, "count": 300}


@pytest.mark.timeout(700)
def test_a_diagram_over_a_phase_turns_the_harmonic(explorer, service):
    oscillator = {"harmonics": [{"order": 2, "amplitude": 0.008, "phase": 0.3}]}
    vary = {"parameter": "phase_2", "start": 0, "stop": 1, "count": 9}
    body = {"oscillator": oscillator, "vary": vary, "transient": 50, "kept": 4}
    job = service.request("POST", "/v1/bifurcations", json=body).json()
    service.wait(job["id"])
    explorer.visit(f"?job={job['id']}")
    page = explorer.page
    expect(page.locator("#diagram-note")).to_contain_text("Click to look", timeout=400_000)
    page.locator("#diagram .target").click(position={"x": 200, "y": 60})
    expect(page.locator("[name=harmonics]")).to_have_value(re.compile(r"^2: 0\.008, 0\.\d+$"))
    assert page.locator("[name=harmonics]").input_value() != "2: 0.008, 0.3"


def test_a_bifurcation_opened_by_its_address_is_a_chart_too(explorer, service):
    body = {"vary": {"parameter": "damping", "start": 0.55, "stop": 0.6, "count": 20}, "transient": 200, "kept": 4}
    job = service.request("POST", "/v1/bifurcations", json=body).json()
    service.wait(job["id"])
    explorer.visit(f"?job={job['id']}")
    expect(explorer.page.locator("#diagram .points").first).to_be_attached(timeout=60_000)
    explorer.pictured("Preview")


def test_orbits_are_a_chart_whose_marks_are_followed(explorer, service):
    job = service.request("POST", "/v1/orbits", json={"longest": 1}).json()
    found = service.wait(job["id"])
    orbits = service.request("GET", found["links"]["result"]).json()["orbits"]
    explorer.visit(f"?job={job['id']}")
    marks = explorer.page.locator("#orbits-chart .orbit")
    expect(marks).to_have_count(sum(len(orbit["departures"]) for orbit in orbits), timeout=60_000)
    explorer.pictured("Preview")
    expect(explorer.page.locator("#shown")).to_contain_text("δ = 0.6")
    marks.last.click()
    expect(explorer.page.locator("#histories")).to_contain_text("The motion from t = 0.898")


def test_two_basins_are_swiped_over_each_other(opened):
    page = opened.page
    page.locator("#keep").click()
    opened.fill(eccentricity=0.02)
    expect(page.locator("#legend button")).to_have_count(1)
    page.locator("#swipe").fill("0.5")
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert opened.colour(0.25, 0.5) == (20, 31, 64)
    assert opened.colour(0.97, 0.53) == (86, 180, 233), "the basin that was kept"
    page.locator("#keep").click()
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert opened.colour(0.97, 0.53) == (20, 31, 64)


def test_each_half_of_a_comparison_is_a_whole_plane(opened):
    page = opened.page
    page.locator("#keep").click()
    opened.fill(eccentricity=0.02)
    expect(page.locator("#legend button")).to_have_count(1)
    expect(page.locator("#kept-label")).to_contain_text("ε = 0.1")
    expect(page.locator("#kept-legend button")).to_have_count(3)
    assert opened.hover(0.97, 0.53).startswith("kept: ") and "P(1,1,0)" in opened.hover(0.97, 0.53)
    assert "permanent contact" in opened.hover(0.25, 0.53) and "kept" not in opened.hover(0.25, 0.53)
    for across, eccentricity in ((0.97, 0.1), (0.25, 0.02)):
        with page.expect_request("**/v1/trajectories?end=true") as asked:
            page.mouse.click(*opened.spot(across, 0.53))
        assert asked.value.post_data_json["oscillator"]["eccentricity"] == eccentricity
    page.mouse.click(*opened.spot(0.97, 0.53))
    expect(page.locator("#histories")).to_contain_text("of the kept basin from t = 0.97")
    opened.hover(0.3, 0.9)
    for t, eccentricity, other in ((0.8, 0.1, 0.02), (0.3, 0.02, 0.1)):
        own, wrong = (float(grazing_velocity(Oscillator(eccentricity=each), [t])[0]) for each in (eccentricity, other))
        assert whitest(opened, t, own / 7) > 150, "the grazing curve of this half"
        assert whitest(opened, t, wrong / 7) < 150, "and not that of the other"
    page.reload()
    expect(page.locator("#kept-legend button")).to_have_count(3, timeout=60_000)
    expect(page.locator("#histories")).to_contain_text("of the kept basin from t = 0.97")


def whitest(opened, across, up, plane="#plane"):
    """Least of red, green and blue, greatest within a pixel: of a motion's colour it is below 100."""
    pixel = 1 / opened.page.locator(plane).bounding_box()["height"]
    return max(min(opened.colour(across, up + offset * pixel, plane)) for offset in (-1, 0, 1))


def drawn(page):
    """Wait until what was asked for is drawn."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def test_two_basins_lie_side_by_side_with_one_pointer(opened):
    page, kept = opened.page, "#plane-kept"
    expect(page.locator("#side")).to_be_hidden()
    page.locator("#keep").click()
    opened.fill(eccentricity=0.02)
    expect(page.locator("#legend button")).to_have_count(1)
    page.locator("#side").click()
    expect(page.locator("#swipe")).to_be_hidden()
    expect(page).to_have_url(re.compile("compare=side"))
    drawn(page)
    left, right = page.locator("#plane").bounding_box(), page.locator(kept).bounding_box()
    assert left["width"] == right["width"] and left["x"] + left["width"] <= right["x"] + 1
    # The same place of both: quiet in the one, P(1,1,0) in the other. Each has its own grazing curve, all along.
    assert opened.colour(0.97, 0.53) == (20, 31, 64)
    assert opened.colour(0.97, 0.53, kept) == (86, 180, 233)
    for plane, *both in (("#plane", 0.02, 0.1), (kept, 0.1, 0.02)):
        for t in (0.3, 0.8):
            own, wrong = (float(grazing_velocity(Oscillator(eccentricity=each), [t])[0]) for each in both)
            assert whitest(opened, t, own / 7, plane) > 150, "the grazing curve of this basin"
            assert whitest(opened, t, wrong / 7, plane) < 150, "and not that of the other"
    # The pointer of one is a cross in the other, at the same departure, and both are read.
    for here, there, marks in (("#plane", kept, "#marks-kept"), (kept, "#plane", "#marks")):
        told = opened.hover(0.97, 0.53, here)
        assert ("kept: " if here == kept else "") + "t = 0.97" in told
        assert "P(1,1,0)" in told and "permanent contact" in told
        drawn(page)
        assert min(opened.colour(0.97, 0.53, there, marks)) > 100, "a white line, where else nothing is drawn"
    for plane, eccentricity in (("#plane", 0.02), (kept, 0.1)):
        with page.expect_request("**/v1/trajectories?end=true") as asked:
            page.mouse.click(*opened.spot(0.97, 0.53, plane))
        assert asked.value.post_data_json["oscillator"]["eccentricity"] == eccentricity
    expect(page.locator("#histories")).to_contain_text("of the kept basin from t = 0.97")
    page.reload()
    expect(page.locator("#kept-legend button")).to_have_count(3, timeout=60_000)
    expect(page.locator("#side")).to_have_attribute("aria-pressed", "true")
    expect(page.locator(kept)).to_be_visible()
    expect(page.locator("#histories")).to_contain_text("of the kept basin from t = 0.97")


def test_basins_side_by_side_share_the_window_and_the_keys(opened):
    page, kept = opened.page, "#plane-kept"
    page.locator("#keep").click()
    opened.fill(eccentricity=0.02)
    expect(page.locator("#legend button")).to_have_count(1)
    page.locator("#side").click()
    expect(page.locator(kept)).to_have_attribute("aria-label", re.compile("kept: Impacts: .*ε = 0.1"))
    page.locator(kept).focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#reading")).to_contain_text("kept: t = 0.51")
    expect(page.locator("#reading")).to_contain_text("seen there: permanent contact")
    with page.expect_request("**/v1/trajectories?end=true") as asked:
        page.keyboard.press("Enter")
    assert asked.value.post_data_json["oscillator"]["eccentricity"] == 0.1
    # Its history has a panel of its own, which moves what lies above it: a place of the screen holds only after that.
    expect(page.locator("#histories")).to_contain_text("of the kept basin")
    page.keyboard.press("+")
    expect(page).to_have_url(re.compile("window="))
    drawn(page)
    told, boxes = [], []
    for plane in ("#plane", kept):
        told.append(re.search(r"t = \S+ +v = \S+", opened.hover(0.25, 0.5, plane))[0])
        drawn(page)
        boxes.append(page.locator("#frame").bounding_box())
    assert told[0] == told[1]
    assert boxes[0] == boxes[1], "the words under the planes do not move them under the pointer"
    page.evaluate(AXE.read_text())
    findings = page.evaluate("axe.run().then(({violations}) => violations)")
    assert [(each["id"], [node["html"] for node in each["nodes"]]) for each in findings] == []


def test_what_is_kept_right_after_the_end_is_what_was_computed(explorer, service):
    """Its cells come late, and the page has gone on to another machine by then."""
    page = explorer.page
    explorer.ask("?damping=0.61&eccentricity=0.1&half_backlash=0.6&grid=0,1,0,7&cells=150,150&k=211")
    page.route("**/tiles/**", lambda route: (time.sleep(0.3), route.continue_()))
    explorer.state("Complete")
    page.locator("#keep").click()
    explorer.fill(eccentricity=0.02)
    job = page.evaluate("() => new URLSearchParams(new URLSearchParams(location.search).get('beside')).get('job')")
    result = service.request("GET", f"/v1/jobs/{job}/result").json()
    shares = {each["name"]: each["share"] for each in result["solutions"] if each["share"]}
    for name, share in shares.items():
        entry = page.locator("#kept-legend button", has_text=name)
        expect(entry).to_contain_text(f"{100 * share:.2f} %", timeout=60_000)


def test_a_phone_pinches_scrolls_and_is_not_wider_than_its_screen(chromium_here, service, finished):
    phone = Explorer(chromium_here, service.url, viewport={"width": 400, "height": 800}, has_touch=True, is_mobile=True)
    phone.visit(f"?job={finished['id']}").state("Complete")
    assert phone.page.evaluate("document.documentElement.scrollWidth") <= 400
    assert phone.page.locator("#plane").evaluate("canvas => getComputedStyle(canvas).touchAction") == "pan-y"
    pinch = """async (canvas) => {
        const box = canvas.getBoundingClientRect();
        const at = (type, pointerId, x) => canvas.dispatchEvent(new PointerEvent(type, {
            pointerId, pointerType: "touch", button: type === "pointerdown" ? 0 : -1, bubbles: true,
            clientX: box.x + x * box.width, clientY: box.y + box.height / 2 }));
        canvas.setPointerCapture = () => {};
        at("pointerdown", 5, 0.45); at("pointerdown", 6, 0.6);
        for (let i = 1; i <= 5; i++) { at("pointermove", 5, 0.45 - 0.03 * i); at("pointermove", 6, 0.6 + 0.03 * i); }
        at("pointerup", 5, 0.3); at("pointerup", 6, 0.75);
    }"""
    phone.page.locator("#plane").evaluate(pinch)
    expect(phone.page).to_have_url(re.compile("window="))
    t0, t1 = map(float, re.search(r"window=([^,]+),([^,]+)", phone.page.url).groups())
    assert t1 - t0 < 0.6
    assert phone.unforgiven() == []
    phone.context.close()


@pytest.mark.parametrize("width", [360, 768])
def test_on_a_narrow_screen_nothing_lies_over_the_request_or_out_of_reach(chromium_here, service, finished, width):
    narrow = Explorer(chromium_here, service.url, viewport={"width": width, "height": 740}, has_touch=True)
    narrow.visit(f"?job={finished['id']}").state("Complete")
    page = narrow.page
    narrow.open_drawer()
    form, look = page.locator("#ask").bounding_box(), page.locator("#shown").bounding_box()
    last = page.locator("#recent").bounding_box()
    assert last["y"] + last["height"] <= form["y"] + form["height"] <= look["y"]
    page.locator("#open-drawer").click()
    for menu in ("away", "display"):
        page.locator(f"#{menu} summary").click()
        box = page.locator(f"#{menu} .menu").bounding_box()
        assert 0 <= box["x"] and box["x"] + box["width"] <= width
        page.keyboard.press("Escape")
    assert narrow.unforgiven() == []
    narrow.context.close()


@pytest.mark.parametrize(("width", "height"), [(360, 740), (768, 900), (640, 400)])
def test_on_a_narrow_screen_plane_tooth_and_sliders_are_seen_together(chromium_here, service, finished, width, height):
    """The last is a screen of 1280 pixels at a zoom of 200 %."""
    narrow = Explorer(chromium_here, service.url, viewport={"width": width, "height": height}, has_touch=True)
    narrow.visit(f"?job={finished['id']}").state("Complete")
    page = narrow.page
    plane = page.locator("#plane")
    assert plane.bounding_box()["height"] == pytest.approx(0.45 * height, abs=1)
    page.mouse.click(*narrow.spot(0.4, 0.3))
    expect(page.locator("#histories")).to_contain_text("The motion")
    page.locator("[data-turn=damping]").evaluate("slider => slider.scrollIntoView({block: 'end'})")
    plane, tooth = plane.bounding_box(), page.locator("#tooth-canvas").bounding_box()
    slider = page.locator("[data-turn=damping]").bounding_box()
    assert plane["y"] == pytest.approx(0, abs=1), "it stays at the top"
    assert plane["y"] + plane["height"] <= slider["y"] and slider["y"] + slider["height"] <= height + 1
    assert plane["x"] < tooth["x"] and tooth["x"] + tooth["width"] < plane["x"] + plane["width"]
    assert plane["y"] < tooth["y"] and tooth["y"] + tooth["height"] < plane["y"] + plane["height"]
    # Nothing but the plane lies over what scrolls: neither over pictures of examples nor over any button.
    covered = """() => [...document.querySelectorAll("#tell :is(button, input, select)")].filter((one) => {
        if (!one.checkVisibility()) return false;
        one.scrollIntoView({block: "end"});
        const {x, y, width, height} = one.getBoundingClientRect();
        const [left, top] = [x + width / 2, y + height / 2];
        return left < innerWidth && left > 0 && !one.contains(document.elementFromPoint(left, top));
    }).map((one) => one.outerHTML)"""
    assert page.evaluate(covered) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert narrow.unforgiven() == []
    narrow.context.close()


@pytest.mark.parametrize("width", [360, 768, 1280, 1440])
def test_no_two_lines_are_printed_over_each_other(chromium_here, service, finished, width):
    wide = Explorer(chromium_here, service.url, viewport={"width": width, "height": 800})
    wide.visit(f"?job={finished['id']}").state("Complete")
    page = wide.page
    wide.open_drawer()
    for number, place in enumerate(((0.4, 0.3), (0.95, 0.52)), 1):
        page.locator("#plane").scroll_into_view_if_needed()
        page.mouse.click(*wide.spot(*place))
        expect(page.locator("#histories .ends")).to_have_count(number)
        page.locator("#second").click()
    page.locator("#plane").scroll_into_view_if_needed()
    wide.hover(0.95, 0.52)
    over = """() => {
        const texts = [], walk = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
        for (let node = walk.nextNode(); node; node = walk.nextNode()) {
            const parent = node.parentElement;
            const seen = parent.checkVisibility({visibilityProperty: true}) && !parent.closest("option");
            if (!seen || !node.data.trim()) continue;
            const range = document.createRange();
            range.selectNodeContents(node);
            const part = parent.closest("section, form, aside");
            for (const box of range.getClientRects()) texts.push([part, node.data.trim(), box]);
        }
        const across = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const down = (a, b) => Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        return texts.flatMap(([part, text, box], i) => texts.slice(i + 1)
            .filter(([other, , beside]) => part === other && across(box, beside) > 2 && down(box, beside) > 4)
            .map(([, beside]) => [text, beside]));
    }"""
    assert page.evaluate(over) == []
    wide.context.close()


def test_forward_can_be_pressed_only_where_it_leads_somewhere(opened):
    page = opened.page
    expect(page.locator("#forward")).to_be_disabled()
    page.locator("#in").click()
    expect(page).to_have_url(re.compile("window="))
    expect(page.locator("#back")).to_be_enabled()
    expect(page.locator("#forward")).to_be_disabled()
    page.locator("#back").click()
    expect(page.locator("#forward")).to_be_enabled()
    page.reload()
    expect(page.locator("#forward")).to_be_enabled()
    page.locator("#forward").click()
    expect(page).to_have_url(re.compile("window="))
    expect(page.locator("#forward")).to_be_disabled()


def test_the_text_of_a_history_keeps_its_size_when_the_drawer_opens(opened):
    page = opened.page
    page.mouse.click(*opened.spot(0.4, 0.3))
    label = page.locator("#histories svg text").first
    before = label.bounding_box()["height"]
    opened.open_drawer()
    page.wait_for_function(
        """() => document.querySelector("#histories svg").viewBox.baseVal.width
            === document.querySelector("#histories .chart").clientWidth"""
    )
    assert abs(label.bounding_box()["height"] - before) < 1.0


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing(opened, theme):
    page = opened.page
    page.emulate_media(color_scheme=theme, reduced_motion="reduce")
    page.mouse.click(*opened.spot(0.4, 0.3))
    expect(page.locator("#tooth-canvas")).to_be_visible()
    opened.open_drawer()
    page.locator("#away summary").click()
    page.evaluate(AXE.read_text())
    findings = page.evaluate("axe.run().then(({violations}) => violations)")
    assert [(each["id"], [node["html"] for node in each["nodes"]]) for each in findings] == []
