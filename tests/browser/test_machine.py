"""A machine in its own units on the page: the oscillator follows it, and what is heard is in m/s and W."""

import json
import re
from pathlib import Path

import pytest
from playwright.sync_api import expect

import rattle

pytestmark = pytest.mark.browser

AXE = Path(__file__).parents[2] / "node_modules" / "axe-core" / "axe.min.js"
# Nearly the paper's numbers, so that all motions are there at once.
NEAR = {"speed": "955 rpm", "inertia": "0.01 kg m^2", "drag_torque": "9.55 N m", "base_radius": "100 mm",
        "backlash": "120 mm", "transmission_error": "10 mm"}  # fmt: skip


def fill(explorer, machine):
    explorer.page.locator("#machine summary").click()
    for name, text in machine.items():
        number, unit = text.split(" ", 1)
        explorer.page.locator(f"#machine-{name}").fill(number)
        explorer.page.locator(f"#machine-{name} + select").select_option(unit)


@pytest.fixture
def filled(explorer):
    explorer.ask("?damping=0.7&eccentricity=0.1&half_backlash=0.6&grid=0,1,0,7&cells=100,100&k=211").state("Complete")
    fill(explorer, NEAR)
    expect(explorer.page.locator("#machine-said")).to_contain_text("Γ =")
    return explorer


def test_the_oscillator_follows_the_machine_and_its_numbers_are_those_of_the_package(filled):
    pair = rattle.GearPair(**NEAR)
    shown = filled.page.get_by_role("status", name="Damping δ")
    expect(shown).to_have_text(f"{pair.oscillator.damping:.6g}".rstrip("0"))
    rpm = round(pair.threshold_speed * 30.0 / 3.141592653589793)
    expect(filled.page.locator("#machine-said")).to_contain_text(f"It reaches 1 at {rpm} rpm.")


def test_what_is_under_the_pointer_and_in_the_legend_is_in_units(filled):
    motion = filled.page.locator("#legend button", has_text="P(1,1,0)")
    expect(motion).to_have_attribute("title", re.compile(r"impacts a second, the fastest at .* m/s, impact power .* W"))
    filled.page.mouse.move(*filled.spot(0.5, 0.5))
    expect(filled.page.locator("#reading")).to_contain_text(re.compile(r"t = 0\.\d+ +v = \d\.\d+ \(.* ms, .* m/s\)"))


def test_the_layer_of_loudness_is_in_watts(filled):
    filled.page.locator("#layer").select_option("loudness")
    expect(filled.page.locator("#legend .ends span").last).to_have_text(re.compile(r"^[\d.]+ k?W$"), timeout=20_000)


# What is written on canvases from now on.
WRITTEN = """() => {
    window.written = [];
    const write = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
        window.written.push(text);
        write.call(this, text, ...place);
    };
}"""


def test_axes_count_units_of_the_machine_as_long_as_one_is_seen(filled):
    page = filled.page
    page.evaluate(WRITTEN)
    page.locator("#display summary").click()
    page.locator("#axes").select_option("machine")
    pair = rattle.GearPair(**NEAR)
    period, fastest = 1000.0 * pair.scales.time, 7.0 * pair.scales.speed
    page.wait_for_function("() => window.written.includes('time t of departure (ms)')")
    written = page.evaluate("() => window.written")
    assert "velocity v of departure (m/s)" in written
    numbers = [float(text) for text in written if re.fullmatch(r"[\d.]+", text)]
    assert 0.8 * period < max(numbers) <= period and any(0.5 * fastest < number <= fastest for number in numbers)
    expect(page).to_have_url(re.compile("axes=machine"))
    page.reload()
    expect(page.locator("#axes")).to_have_value("machine")
    expect(page.locator("#machine-said")).to_contain_text("Γ =")
    page.mouse.move(*filled.spot(0.5, 0.5))
    expect(page.locator("#reading")).to_contain_text("m/s")
    page.evaluate(WRITTEN)
    # Another oscillator is none of the machine.
    page.locator("[data-turn=damping]").fill("0.65")
    page.wait_for_function("() => window.written.includes('time t of departure (forcing periods)')")


def test_an_address_opens_the_machine_again(filled):
    expect(filled.page).to_have_url(re.compile("machine=speed"))
    filled.page.reload()
    expect(filled.page.locator("#machine-speed")).to_have_value("955")
    expect(filled.page.locator("#machine-said")).to_contain_text("Γ =")
    filled.page.mouse.move(*filled.spot(0.5, 0.5))
    expect(filled.page.locator("#reading")).to_contain_text("m/s")


def test_a_job_keeps_the_machine_wherever_it_is_opened(filled, service, tmp_path, monkeypatch):
    page = filled.page
    page.locator("#compute").click()
    expect(page).to_have_url(re.compile("job="))
    filled.state("Complete")
    job = service.wait(re.search(r"job=([\w-]+)", page.url)[1])
    assert rattle.GearPair(**job["request"]["machine"]) == rattle.GearPair(**NEAR)
    page.locator("#away summary").click()
    (code,) = (block for block in page.locator("#takeaway pre").all_inner_texts() if "rattle.basin(" in block)
    # What the page says is the same, from Python: the same request.
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path))
    said = {}
    exec(code, said)
    assert said["basin"].attrs["request"] == json.dumps(job["request"])
    with page.expect_download() as download:
        page.get_by_role("button", name="Table (CSV)", exact=True).click()
    assert "impact_power_w" in download.value.path().read_text().splitlines()[0]
    filled.visit(f"?job={job['id']}").state("Complete")
    expect(page.locator("#machine-speed")).to_have_value("955")
    expect(page.locator("#machine-said")).to_contain_text("Γ =")
    filled.page.mouse.move(*filled.spot(0.5, 0.5))
    expect(page.locator("#reading")).to_contain_text("m/s")


def test_an_oscillator_that_is_turned_away_from_the_machine_has_no_units(filled):
    slider = filled.page.locator('input[data-turn="damping"]')
    slider.focus()
    slider.press("ArrowRight")
    filled.page.mouse.move(*filled.spot(0.5, 0.5))
    expect(filled.page.locator("#reading")).not_to_contain_text("m/s")
    expect(filled.page).not_to_have_url(re.compile("machine="))


def test_what_is_wrong_is_said_at_its_field_and_a_machine_above_the_threshold_is_never_quiet(filled):
    filled.forgiven += ("422",)
    backlash = filled.page.locator("#machine-backlash")
    backlash.fill("0")
    expect(backlash).to_have_attribute("aria-invalid", "true")
    expect(filled.page.locator("#machine-hint-backlash")).to_contain_text("greater than 0")
    backlash.fill("120")
    filled.page.locator("#machine-speed").fill("3000")
    said = filled.page.locator("#machine-said")
    expect(said).to_contain_text("the machine is never quiet")
    expect(said).not_to_have_class(re.compile("wrong"))
    filled.page.locator("#machine-mesh_stiffness").fill("1")
    expect(said).to_contain_text("the machine is never quiet")
    expect(said).not_to_have_class(re.compile("wrong"))


def test_the_form_has_no_barriers(filled):
    filled.page.evaluate(AXE.read_text())
    found = filled.page.evaluate("axe.run().then(({ violations }) => violations)")
    assert [each["id"] for each in found] == []


QUICK = {"speed": "955 rpm", "inertia": "0.01 kg m^2", "drag_torque": "9.55 N m", "base_radius": "100 mm",
         "backlash": "60 mm", "transmission_error": "10 mm"}  # fmt: skip


@pytest.fixture
def quick(explorer):
    """The form of a machine, with reports that take seconds: of few cells, speeds and departures."""

    def smaller(route):
        few = {"cells": 30, "speeds": 3, "departures": 64, "machines": 64}
        route.continue_(post_data=route.request.post_data_json | few)

    explorer.page.route("**/v1/reports", smaller)
    explorer.ask("?damping=0.7&eccentricity=0.1&half_backlash=0.6&grid=0,1,0,7&cells=100,100&k=211").state("Complete")
    expect(explorer.page.locator("#report-ask")).to_be_disabled()
    fill(explorer, QUICK)
    expect(explorer.page.locator("#machine-said")).to_contain_text("Γ =")
    return explorer


def test_a_report_is_asked_for_followed_and_opened(quick):
    page = quick.page
    page.locator("#report-rate").fill("3 / hour")
    page.locator("#report-size").fill("50 N m s")
    page.locator("#report-numbers").fill("backlash = 50 to 70 mm")
    page.locator("#report-ask").click()
    link = page.locator("#report-done a")
    expect(link).to_have_text("Open the report", timeout=120_000)
    expect(page.locator("#report-said")).to_contain_text("the machine can run quietly")
    expect(page.locator("#report-cancel")).to_be_hidden()
    with quick.context.expect_page() as opened:
        link.click()
    report = opened.value
    complaints = []
    report.on("console", lambda message: complaints.append(message.text))
    report.reload()
    expect(report.get_by_role("heading", name="does it rattle?")).to_be_visible()
    for heading in ("How often", "Which tolerance", "What is not modelled"):
        expect(report.get_by_role("heading", name=heading)).to_be_visible()
    assert report.locator("svg").count() == 3
    assert complaints == [], "what the page holds is allowed where it is served"


def test_what_is_wrong_with_a_report_is_said_and_a_machine_that_is_refused_has_none(quick):
    quick.forgiven += ("422",)
    page = quick.page
    page.locator("#report-rate").fill("3 / hour")
    page.locator("#report-ask").click()
    expect(page.locator("#report-said")).to_contain_text("give both, or neither")
    expect(page.locator("#report-size")).to_have_attribute("aria-invalid", "true")
    page.locator("#report-numbers").fill("backlash")
    page.locator("#report-ask").click()
    expect(page.locator("#report-said")).to_contain_text("backlash = 120 +- 20 um")
    page.locator("#machine-speed").fill("0")
    expect(page.locator("#report-ask")).to_be_disabled()


def test_a_report_is_cancelled(explorer):
    explorer.ask("?damping=0.7&eccentricity=0.1&half_backlash=0.6&grid=0,1,0,7&cells=100,100&k=211").state("Complete")
    fill(explorer, QUICK | {"backlash": "61 mm"})
    explorer.page.locator("#report-numbers").fill("backlash = 50 to 70 mm; restitution = 0.8 to 1")
    explorer.page.locator("#machine-restitution").fill("0.9")
    explorer.page.locator("#report-ask").click()
    explorer.page.locator("#report-cancel").click()
    expect(explorer.page.locator("#report-said")).to_contain_text("The report was cancelled", timeout=30_000)
    expect(explorer.page.locator("#report-cancel")).to_be_hidden()


def test_a_service_without_reports_offers_none(explorer):
    def without(route):
        answer = route.fetch()
        route.fulfill(json={name: kind for name, kind in answer.json().items() if name != "report"})

    explorer.page.route("**/explorer/kinds.json", without)
    explorer.ask("?damping=0.7&eccentricity=0.1&half_backlash=0.6&grid=0,1,0,7&cells=100,100&k=211").state("Complete")
    explorer.page.locator("#machine summary").click()
    expect(explorer.page.locator("#machine-speed")).to_be_visible()
    expect(explorer.page.locator("#report-ask")).to_be_hidden()
