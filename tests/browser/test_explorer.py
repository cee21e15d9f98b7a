"""The explorer in a real browser, as someone who looks at basins uses it."""

import json
import re
import signal
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

from rattle_kernels import Oscillator, time_history
from tests.browser.chromium import Explorer
from tests.running_service import running_service

pytestmark = pytest.mark.browser

QUIET, CHAOS, RATTLE = (20, 31, 64), (213, 94, 0), (86, 180, 233)
SMALL = {"grid": {"time": {"cells": 140}, "velocity": {"cells": 140}}, "iterations": 211}
LONG = {"grid": {"time": {"cells": 1500}, "velocity": {"cells": 1500}}, "iterations": 15013}


@pytest.fixture(scope="module")
def finished(service):
    return service.wait(service.submit(SMALL)["id"])


@pytest.fixture
def opened(explorer, finished):
    """The page with a finished basin."""
    explorer.visit(f"?job={finished['id']}").state("Complete")
    expect(explorer.page.locator("#legend button")).to_have_count(3)
    return explorer


def test_a_newcomer_computes_an_example_and_reads_it(explorer):
    explorer.visit()
    expect(explorer.page.locator("#preset")).to_have_value("fig7bottom")
    explorer.fill(time__cells=200, velocity__cells=200, iterations=223)
    explorer.compute()
    explorer.state("Complete")
    legend = explorer.page.locator("#legend")
    for name in ("permanent contact", "chaotic", "P(1,1,0)"):
        expect(legend).to_contain_text(name)
    assert "permanent contact" in explorer.hover(0.5, 0.1) and explorer.colour(0.5, 0.1) == QUIET
    assert "P(1,1,0)" in explorer.hover(0.95, 0.52)
    assert explorer.colour(0.97, 0.53) == RATTLE
    assert re.search(r"t = 0\.\d+ +v = \d", explorer.page.locator("#reading").inner_text())


def test_tiles_come_one_by_one_and_each_is_asked_for_as_it_lands(explorer):
    asked = []
    explorer.page.on("request", lambda request: asked.append(request.url) if "/tiles/" in request.url else None)
    explorer.visit()
    explorer.fill(time__cells=400, velocity__cells=400, iterations=1499)
    explorer.compute()
    explorer.state("tiles")
    expect(explorer.page.locator("#progress")).to_be_visible()
    explorer.state("Complete")
    tiles = {url.split("/tiles/")[1].split("?")[0] for url in asked}
    assert len(tiles) >= 16
    expect(explorer.page.locator("#legend")).not_to_contain_text("so far")


def test_a_finished_job_is_drawn_and_repainted_without_blocking(explorer, service):
    body = {"grid": {"time": {"cells": 1000}, "velocity": {"cells": 1000}}, "iterations": 1}
    job = service.wait(service.submit(body)["id"])
    page = explorer.page
    page.add_init_script(
        "window.longest = 0; new PerformanceObserver(list => list.getEntries().forEach(entry => "
        "{ window.longest = Math.max(window.longest, entry.duration); })).observe({type: 'longtask', buffered: true});"
    )
    explorer.visit(f"?job={job['id']}").state("Complete")
    expect(page.locator("#legend button")).not_to_have_count(0)
    for layer in ("step", "group", "period", "solution"):
        page.locator("#layer").select_option(layer)
    page.locator("#legend button").first.click()
    tiles = "performance.getEntriesByType('resource').filter(entry => entry.name.includes('/tiles/')).length"
    page.wait_for_function(f"{tiles} >= 16")
    # What blocks does most of the work in one task, however long a machine takes for all of it.
    assert page.evaluate(tiles) == 16 and page.evaluate("window.longest < 0.5 * performance.now()")


def test_solutions_are_picked_out_and_layers_have_their_scales(opened):
    page = opened.page
    page.get_by_role("button", name="P(1,1,0)").click()
    assert opened.colour(0.97, 0.53) == RATTLE
    assert min(opened.colour(0.5, 0.1)) > 150, "the others fade"
    page.get_by_role("button", name="P(1,1,0)").click()
    assert opened.colour(0.5, 0.1) == QUIET
    page.locator("#layer").select_option("step")
    expect(page.locator("#legend")).to_contain_text("Hsu's step")
    assert opened.colour(0.5, 0.1) not in (QUIET, CHAOS, RATTLE)
    page.locator("#layer").select_option("solution")
    page.locator("#display summary").click()
    page.locator("#palette").select_option("paper")
    assert opened.colour(0.5, 0.1) == (0, 0, 128)


def test_zooming_computes_anew_and_back_and_forward_step_through_windows(opened):
    page = opened.page
    page.mouse.move(*opened.spot(0.85, 0.55))
    page.mouse.wheel(0, -200)
    expect(page).to_have_url(re.compile("window="))
    opened.state("Complete")
    first = page.url
    page.keyboard.down("Shift")
    page.mouse.move(*opened.spot(0.3, 0.3))
    page.mouse.down()
    page.mouse.move(*opened.spot(0.7, 0.7), steps=4)
    page.mouse.up()
    page.keyboard.up("Shift")
    expect(page).not_to_have_url(first)
    opened.state("Complete")
    second = page.url
    assert "not known" not in opened.hover(0.5, 0.5)
    page.locator("#back").click()
    expect(page).to_have_url(first)
    opened.state("Complete")
    page.locator("#back").click()
    expect(page).not_to_have_url(re.compile("window="))
    page.locator("#forward").click()
    page.locator("#forward").click()
    expect(page).to_have_url(second)
    opened.state("Complete")
    start, stop = (float(part) for part in re.search(r"window=([\d.]+),([\d.]+)", second).groups())
    assert 0 <= start < stop < start + 0.5


def test_the_older_picture_stays_until_the_new_one_comes(opened, service):
    page = opened.page
    page.locator("#anew").uncheck()
    before = opened.hover(0.5, 0.1)
    page.mouse.move(*opened.spot(0.5, 0.1))
    page.mouse.wheel(0, -300)
    expect(page).to_have_url(re.compile("window="))
    assert opened.colour(0.5, 0.12) == QUIET and "permanent contact" in before
    page.locator("#whole").click()
    expect(page).not_to_have_url(re.compile("window="))


def test_a_click_follows_the_motion_and_says_where_it_ends(opened):
    page = opened.page
    # The motion starts where it was clicked, not at the centre of its cell.
    page.mouse.click(*opened.spot(0.41, 0.31))
    told = page.locator("#histories")
    ending = r"A The motion from t = 0\.4\d+, v = 2\.\d+ ends in permanent contact after \d+ impacts"
    expect(told).to_contain_text(re.compile(ending))
    page.locator("#second").click()
    page.mouse.click(*opened.spot(0.95, 0.52))
    expect(told).to_contain_text(re.compile(r"B The motion .* ends in P\(1,1,0\) after \d+ impacts"))
    expect(page.locator("#histories path.first")).to_have_count(1)
    expect(page.locator("#histories path.second")).to_have_count(1)
    page.locator("#forget").click()
    expect(page.locator("#tooth-canvas")).to_be_hidden()
    expect(page.locator("#history .invitation")).to_be_visible()


def test_all_of_it_can_be_done_from_the_keyboard(opened):
    page = opened.page
    page.locator("#plane").focus()
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    expect(page.locator("#reading")).to_contain_text("v = 3.2")
    page.keyboard.press("Enter")
    expect(page.locator("#histories")).to_contain_text("The motion from t = 0.5")
    page.keyboard.press("+")
    expect(page).to_have_url(re.compile("window="))
    opened.state("Complete")
    page.keyboard.press("0")
    expect(page).not_to_have_url(re.compile("window="))


def test_a_job_is_cancelled_and_says_so(explorer, service):
    explorer.visit()
    explorer.fill(time__cells=1500, velocity__cells=1500, iterations=15017)
    explorer.compute()
    explorer.state("Mapping cells")
    explorer.page.locator("#cancel").click()
    explorer.state("Cancelled")
    expect(explorer.page.locator("#cancel")).to_be_hidden()


def test_a_waiting_job_knows_its_place_in_the_queue(explorer, service):
    # More than run at once.
    jobs = [
        service.submit(LONG | {"iterations": iterations}) for iterations in (15031, 15053, 15061, 15073, 15077, 15083)
    ]
    try:
        explorer.visit(f"?job={jobs[-1]['id']}").state("Waiting: number", seconds=30)
    finally:
        for each in reversed(jobs):
            service.request("POST", each["links"]["cancel"])
    explorer.state("Cancelled")


@pytest.mark.parametrize(
    ("fields", "where", "words"),
    [
        ({"half_backlash": 0}, "half_backlash", "must be above 0"),
        ({"damping": "much"}, "damping", "not a valid number"),
        ({"iterations": 1500}, "iterations", "nearest: 1499 or 1511"),
        ({"time__stop": 0}, "time.stop", "must be above 0"),
        ({"harmonics": "2 times 0.01"}, "harmonics", "as in 2: 0.01, 0.25"),
        ({"time__start": 0.5, "time__stop": 2}, "time.start", "by at most one period"),
        ({"time__cells": 90000, "velocity__cells": 90000}, "", "cells or points are more than the limit of"),
    ],
)
def test_what_would_be_refused_is_explained_before_it_is_sent(explorer, fields, where, words):
    explorer.visit()
    explorer.fill(**fields)
    expect(explorer.page.locator("main")).to_contain_text(words)
    expect(explorer.page.locator("#compute")).to_be_disabled()
    if where:
        expect(explorer.page.locator(f"[name='{where}']")).to_have_attribute("aria-invalid", "true")
    expect(explorer.page.locator("body")).not_to_contain_text(re.compile("Input should be|tuple|RATTLE_"))


def test_compute_leads_to_the_field_that_is_refused(explorer):
    page = explorer.visit().pictured("Preview").page
    explorer.fill(damping="much", half_backlash=0)
    expect(page.locator("#hint-damping")).to_have_text("not a valid number: write one as 0.6")
    page.locator("#open-drawer").click()
    expect(page.locator("#verdict")).to_contain_text("Half backlash β: must be above 0.")
    page.locator("#compute").click(force=True)
    expect(page.locator("[name=damping]")).to_be_focused()
    explorer.fill(damping=0.6, half_backlash=0.6)
    expect(page.locator("#compute")).to_be_enabled()
    expect(page.locator("#ask [aria-invalid]")).to_have_count(0)


def test_bounds_are_shown_live(explorer):
    explorer.visit()
    hint = explorer.page.locator("#hint-eccentricity")
    expect(hint).to_have_text("loose from 0.19012")
    explorer.fill(damping=0.5)
    expect(hint).to_have_text("loose from 0.15865")
    explorer.page.locator("[name=model]").select_option("piecewise_linear")
    explorer.fill(stiffness=100, damping=0.6)
    expect(hint).to_have_text("below 0.15263")


def test_every_example_is_one_that_the_service_takes(explorer):
    explorer.visit()
    names = explorer.page.locator("#preset option").evaluate_all("options => options.map(option => option.value)")
    assert {"fig6a", "fig7bottom", "fig8", "fig9", "fig12", "fig13b"} <= set(names)
    for name in names[1:]:
        explorer.page.locator("#preset").select_option(name)
        expect(explorer.page.locator("#verdict")).to_contain_text("of computing")
        expect(explorer.page.locator("#compute")).to_be_enabled()


def test_examples_are_chosen_by_their_pictures_under_headings(explorer):
    page = explorer.visit().pictured("Preview").page
    gallery = page.locator("#examples")
    expect(gallery.get_by_role("heading")).to_have_text(["Impacts", "From soft to stiff contacts", "Sweeps"])
    gallery.get_by_role("button", name="Fig. 12 δ = 0.527").click()
    expect(page.locator("#preset")).to_have_value("fig12")
    expect(page.locator("#preset-note")).to_contain_text("P(3,3,2)")
    expect(page.locator("#shown")).to_contain_text("δ = 0.527")


def test_a_saddle_under_the_pointer_is_named(opened, service, finished):
    page = opened.page
    page.get_by_label("Saddles", exact=True).check()
    expect(page.locator("#overlays .key").first).to_contain_text("saddle P(1,1,0)", timeout=120_000)
    path = f"/v1/jobs/{finished['id']}/overlays/saddles"
    ((saddle,),) = [service.request("GET", path).json()["overlays"][0]["pieces"]]
    ((t,), (v,)) = saddle["time"], saddle["velocity"]
    told = opened.hover(t, v / 7)
    assert "saddle P(1,1,0)" in told and "motions beside it leave" in told
    assert "saddle" not in opened.hover(t, v / 7 + 0.1)


def test_a_reload_in_mid_job_finds_it_again(explorer, service):
    explorer.visit()
    explorer.fill(time__cells=700, velocity__cells=700, iterations=2003)
    explorer.compute()
    explorer.state("cells")
    address = explorer.page.url
    explorer.page.reload()
    assert explorer.page.url == address
    explorer.state("Complete")
    expect(explorer.page.locator("[name=iterations]")).to_have_value("2003")


def test_a_sweep_has_a_slider_and_a_chart_that_opens_its_basins(explorer, service):
    body = {
        "oscillator": {"eccentricity": 0.1}, "vary": [{"parameter": "damping", "values": [0.55, 0.6, 0.65]}],
        "grid": {"time": {"cells": 40}, "velocity": {"cells": 40}}, "iterations": 211,
    }  # fmt: skip
    job = service.wait(service.request("POST", "/v1/sweeps", json=body).json()["id"])
    page = explorer.page
    explorer.visit(f"?job={job['id']}").state("Complete")
    slider = page.locator("#sliders input")
    expect(slider).to_have_attribute("aria-valuetext", "0.55")
    slider.focus()
    page.keyboard.press("ArrowRight")
    expect(page).to_have_url(re.compile("panel=1"))
    chart = page.locator("#shares .target")
    width = page.locator("#shares").bounding_box()["width"]
    chart.click(position={"x": width - 90, "y": 60})
    expect(page).to_have_url(re.compile("panel=2"))
    expect(slider).to_have_attribute("aria-valuetext", "0.65")
    page.go_back()
    expect(slider).to_have_attribute("aria-valuetext", "0.6")
    expect(page.locator("#legend .note")).to_contain_text("On average over the window:")
    page.locator("#loudness .target").click(position={"x": width - 90, "y": 40})
    expect(slider).to_have_attribute("aria-valuetext", "0.65")


def test_what_is_taken_away_is_what_made_the_picture(opened, finished):
    page = opened.page
    page.locator("#away summary").click()
    blocks = page.locator("#takeaway pre").all_inner_texts()
    assert json.loads(blocks[-1]) == finished["request"]
    assert any(finished["links"]["zarr"] in block and "rattle.open" in block for block in blocks)
    files = {
        "What is seen (PNG)": b"\x89PNG",
        "What is seen (SVG)": b"<?xml",
        "What is seen (PDF)": b"%PDF",
        "Whole job (PNG)": b"\x89PNG",
        "Whole job (SVG)": b"<?xml",
        "Whole job (PDF)": b"%PDF",
        "Table (CSV)": b"name,share,kind",
        "Result (NetCDF)": b"CDF",
    }
    for name, first in files.items():
        with page.expect_download() as download:
            page.get_by_role("button", name=name, exact=True).click()
        assert download.value.path().read_bytes().startswith(first)


def test_a_picture_of_what_is_seen_has_its_window_layer_colours_and_overlays(opened):
    page = opened.page
    page.locator("#anew").uncheck()
    page.locator("#in").click()
    page.locator("#layer").select_option("step")
    page.locator("#overlays").get_by_label("Attractors").uncheck()
    window = re.search(r"window=([^&]+)", page.url)[1]
    page.locator("#away summary").click()
    with page.expect_request(re.compile(r"/picture\.svg")) as asked:
        page.get_by_role("button", name="What is seen (SVG)").click()
    query = parse_qs(urlsplit(asked.value.url).query)
    assert query.pop("colours")[0].startswith("P(1,1,0):56b4e9")
    assert query == {
        "layer": ["step"], "palette": ["colour_blind"], "window": [window], "overlays": ["grazing"], "panel": ["0"],
        "editable": ["true"], "overlay_key": ["true"], "caption": ["true"],
    }  # fmt: skip
    assert asked.value.response().ok


def test_a_picture_for_a_paper_has_its_size_a_caption_and_a_key(opened, finished):
    page = opened.page
    page.locator("#away summary").click()
    caption = page.locator("#takeaway pre[aria-label=Caption]").inner_text()
    for words in (
        "δ = 0.6",
        "v from 0 to 7",
        f"k = {finished['request']['iterations']}",
        "doi:10.1142/S021812740902283X",
    ):
        assert words in caption
    page.get_by_label("Width, mm").fill("86")
    page.get_by_label("Letters, points").fill("7")
    with page.expect_download() as download:
        page.get_by_role("button", name="What is seen (PNG)").click()
    picture = Image.open(download.value.path())
    picture.load()
    assert picture.width == 1016 and round(picture.info["dpi"][0]) == 300
    assert picture.info["Description"] == caption
    # The sign of the grazing curve has a ground of its own, which nothing else has.
    assert (0x48, 0x50, 0x5C) in {colour for _, colour in picture.convert("RGB").getcolors(1 << 24)}
    with page.expect_request("**/picture.svg?*") as asked:
        page.get_by_role("button", name="What is seen (SVG)").click()
    query = parse_qs(urlsplit(asked.value.url).query)
    assert (query["width"], query["dpi"], query["font_size"]) == (["86"], ["300"], ["7"])
    page.get_by_label("Width, mm").fill("1200")
    page.get_by_label("Dots per inch").fill("1200")
    page.get_by_role("button", name="What is seen (PNG)").click()
    expect(page.locator("#state")).to_contain_text("A picture has at most 40 million pixels")


def test_light_and_dark_follow_the_system_and_the_switch(opened):
    page, root = opened.page, opened.page.locator("html")
    expect(root).to_have_attribute("data-theme", "light")
    page.emulate_media(color_scheme="dark")
    expect(root).to_have_attribute("data-theme", "dark")
    page.locator("#display summary").click()
    page.locator("#theme").select_option("light")
    expect(root).to_have_attribute("data-theme", "light")


@pytest.mark.parametrize(
    ("path", "request_", "alt"),
    [
        ("/v1/basins", {"sample": {"points": 200, "seed": 1}, "iterations": 211}, "Sample of a basin"),
        ("/v1/grazing-curves", {"order": 1}, "Grazing curve and its pre-images"),
    ],
)
def test_what_has_no_cells_is_shown_as_the_service_draws_it(explorer, service, path, request_, alt):
    job = service.request("POST", path, json=request_).json()
    explorer.visit(f"?job={job['id']}").state("Complete")
    still = explorer.page.locator("#still")
    expect(still).to_be_visible()
    expect(still).to_have_attribute("alt", f"{alt}, as the service draws it")
    assert explorer.page.evaluate("document.getElementById('still').naturalWidth") > 400
    expect(explorer.page.locator("#whole")).to_be_disabled()
    explorer.page.locator("#away summary").click()
    expect(explorer.page.locator("#takeaway")).to_contain_text(path)


def test_a_job_that_is_not_there_is_told_in_words(explorer):
    explorer.forgiven += ("404",)
    explorer.visit("?job=nothing").state("There is no job nothing")


def test_the_key_is_asked_for_once_and_kept_in_memory_alone(explorer):
    def locked(route):
        if route.request.headers.get("authorization") == "Bearer sesame":
            route.fallback()
        else:
            route.fulfill(status=401, json={"detail": "this key is not known"})

    explorer.forgiven += ("401",)
    page = explorer.page
    page.route("**/v1/**", locked)
    page.goto(f"{explorer.url}/")
    page.get_by_label("Key", exact=True).fill("wrong")
    page.keyboard.press("Enter")
    expect(page.locator("#login-note")).to_contain_text("not known")
    page.get_by_label("Key", exact=True).fill("sesame")
    page.keyboard.press("Enter")
    expect(page.locator("#verdict")).to_contain_text("of computing")
    expect(page.locator("#login")).to_be_hidden()
    assert page.evaluate("JSON.stringify([localStorage, sessionStorage, document.cookie])") == '[{},{},""]'


def test_a_restart_of_the_service_in_mid_job_is_waited_out(chromium_here, tmp_path):
    body = {"grid": {"time": {"cells": 600}, "velocity": {"cells": 600}}, "iterations": 1499}
    with running_service(tmp_path) as first:
        explorer = Explorer(chromium_here, first.url)
        explorer.forgiven += ("ERR_CONNECTION", "503")
        job = first.submit(body)
        explorer.visit(f"?job={job['id']}").state("tiles")
        first.process.send_signal(signal.SIGTERM)
        first.process.wait(30)
        explorer.state("does not answer; trying again")
        port = int(first.url.rsplit(":", 1)[1])
    with running_service(tmp_path, port=port):
        explorer.state("Complete", seconds=90)
        expect(explorer.page.locator("#legend")).to_contain_text("chaotic")
        explorer.context.close()
    assert explorer.unforgiven() == []


def test_the_sentence_is_of_the_motion_that_is_followed(opened, service):
    """At places all over the plane, whatever the colour of their cells, against the impact map and the histories."""
    page = opened.page
    random = np.random.default_rng(7)
    for across, up in random.uniform(0.02, 0.98, (20, 2)).tolist():
        with page.expect_request("**/v1/trajectories?end=true") as asked:
            page.mouse.click(*opened.spot(across, up))
        start = asked.value.post_data_json["start"]
        told = page.locator("#histories")
        expect(told).to_contain_text(f"t = {start['time']:g}, v = {start['velocity']:g} ")
        oscillator = Oscillator(0.6, 0.1, 0.6)
        history = time_history(oscillator, start["time"], 0.6, -start["velocity"], periods=1000, samples_per_period=1)
        sentence = told.inner_text().split(" This cell's centre")[0]
        if np.isfinite(history.permanent_from):
            after = f"{history.permanent_from - start['time']:.2f}".rstrip("0").rstrip(".")
            assert (
                f"ends in permanent contact after {np.sum(history.contacts.time <= history.permanent_from)} "
                in sentence
            )
            assert f" {after} forcing periods" in sentence
            continue
        speeds = history.contacts.speed[history.departures[-8:]]
        repeats = np.ptp(speeds) < 0.01
        assert ("ends in P(1,1,0)" if repeats else "still rattles after") in sentence


def test_an_address_with_unknown_values_is_shown_without_them_and_says_so(explorer, finished):
    explorer.visit(f"?job={finished['id']}&palette=bar&layer=foo").state("Complete")
    expect(explorer.page.locator("#standing")).to_contain_text("palette=bar")
    expect(explorer.page.locator("#legend button")).to_have_count(3)  # of the outline, after which tiles are painted
    assert "permanent contact" in explorer.hover(0.5, 0.1) and explorer.colour(0.5, 0.1) == QUIET
    explorer.visit("?damping=0.55&eccentricity=0.09")
    expect(explorer.page.locator("#shown")).to_contain_text("δ = 0.55, ε = 0.09, β = 0.6")
    expect(explorer.page.locator("#standing")).to_contain_text("lacks half_backlash")
    expect(explorer.page).to_have_url(re.compile(r"half_backlash=0\.6"))
    explorer.visit("?palette=bar").pictured("palette=bar").pictured("Compute refines it")
    expect(explorer.page).to_have_url(re.compile(r"damping=0\.6"))
    expect(explorer.page).not_to_have_url(re.compile("palette"))


def test_a_link_that_is_refused_says_so_in_words_of_the_page(explorer):
    explorer.forgiven += ("422",)
    explorer.visit("?damping=-1&eccentricity=0.1&half_backlash=0.6&grid=0,1,0,7&cells=50,50&k=61")
    explorer.pictured("There is no picture of what the request says.")
    expect(explorer.page.locator("#verdict")).to_have_text("Damping δ: must be above 0.")
    expect(explorer.page.locator("#state")).to_have_text("")
