"""Pictures and films of the explorer: ``python -m tests.browser.screenshots [ADDRESS]``; see `make screenshots`.

Those that documents show go to docs/pictures, too; all of them go to the folder screenshots.
"""

import contextlib
import io
import re
import shutil
import sys
import tempfile
from pathlib import Path

import httpx2 as httpx
from PIL import Image
from playwright.sync_api import expect

from tests.browser.chromium import Explorer, browser
from tests.running_service import running_service

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "screenshots"
SHOWN = {
    "motions": "explorer-motions", "sweep": "explorer-sweep", "charted": "explorer-chart",
    **{f"{what}-{number}": f"{what}-{number}" for what in ("slider", "tooth") for number in (1, 2, 3)},
}  # fmt: skip


def start(explorer):
    explorer.visit().pictured("Preview")


def refused(explorer):
    explorer.visit()
    explorer.fill(eccentricity=0.2, iterations=1500)
    expect(explorer.page.locator("#compute")).to_be_disabled()


def coming(explorer):
    explorer.visit()
    explorer.page.locator("#preset").select_option("fig12")
    explorer.compute()
    explorer.state(re.compile("Mapping|Finding|Labelling"))  # each may pass within a moment
    explorer.page.locator("#legend button").first.wait_for()


def finished(explorer):
    explorer.visit()
    explorer.page.locator("#preset").select_option("fig7bottom")
    explorer.compute()
    explorer.state("Complete")


def motions(explorer):
    finished(explorer)
    explorer.page.mouse.click(*explorer.spot(0.2, 0.53))
    expect(explorer.page.locator("#histories")).to_contain_text("A The motion")
    explorer.page.locator("#second").click()
    explorer.page.mouse.click(*explorer.spot(0.88, 0.5))
    expect(explorer.page.locator("#histories")).to_contain_text("B The motion")
    explorer.hover(0.6, 0.42)


def zoomed(explorer):
    finished(explorer)
    explorer.page.locator("#box").click()
    explorer.page.mouse.move(*explorer.spot(0.7, 0.5))
    explorer.page.mouse.down()
    explorer.page.mouse.move(*explorer.spot(0.95, 0.75), steps=3)
    explorer.page.mouse.up()
    expect(explorer.page).to_have_url(re.compile("window="))
    explorer.state("Complete")


def steps(explorer):
    zoomed(explorer)
    explorer.page.locator("#layer").select_option("step")


def highlighted(explorer):
    finished(explorer)
    explorer.page.get_by_role("button", name="P(1,1,0)").click()


def dark(explorer):
    explorer.page.emulate_media(color_scheme="dark")
    motions(explorer)
    explorer.page.locator("#display summary").click()
    explorer.page.locator("#palette").select_option("paper")
    explorer.page.keyboard.press("Escape")


def diagram(explorer):
    finished(explorer)
    explorer.page.locator("[data-diagram=damping]").click()
    expect(explorer.page.locator("#diagram-note")).to_contain_text("Click to look", timeout=100_000)


def compared(explorer):
    finished(explorer)
    explorer.page.locator("#keep").click()
    explorer.fill(damping=0.57)
    explorer.page.locator("#open-drawer").click()
    explorer.pictured("edited, not computed")
    explorer.page.wait_for_load_state("networkidle")


def sweep(explorer):
    explorer.visit()
    explorer.page.locator("#preset").select_option("fig9")
    explorer.compute()
    explorer.state("Complete", seconds=200)
    explorer.page.locator("#sliders input").fill("3")
    explorer.state("Complete")
    expect(explorer.page.locator("#shares .here")).to_have_count(1)


def cancelled(explorer):
    explorer.visit()
    explorer.fill(time__cells=1500, velocity__cells=1500, iterations=20011)
    explorer.compute()
    explorer.state("Mapping")
    explorer.page.locator("#cancel").click()
    explorer.state("Cancelled")


def sample(explorer):
    request = {"sample": {"points": 4000, "seed": 1}, "vary": [{"parameter": "damping", "values": [0.55, 0.6]}]}
    job = httpx.post(f"{explorer.url}/v1/sweeps", json=request).json()
    explorer.visit(f"?job={job['id']}").state("Complete")
    explorer.page.locator("#still").wait_for()


def charted(explorer):
    """A chart, and the basin of the machine that the pointer is on."""
    damping = {"parameter": "damping", "start": 0.55, "stop": 0.65}
    eccentricity = {"parameter": "eccentricity", "start": 0.085, "stop": 0.1}
    request = {"oscillator": {"half_backlash": 0.6}, "first": damping, "second": eccentricity, "lines": 2, "longest": 3}
    job = httpx.post(f"{explorer.url}/v1/charts", json=request).json()
    window = "damping,eccentricity,0.55,0.65,0.085,0.1"
    explorer.visit(f"?damping=0.6&eccentricity=0.1&parameters={window}&parameters_job={job['id']}").pictured()
    page = explorer.page
    expect(page.locator("#parameters [data-curve]").first).to_be_attached(timeout=150_000)
    frame = page.locator("#parameters .stage rect.axis").bounding_box()
    page.mouse.move(frame["x"] + 0.2 * frame["width"], frame["y"] + 0.2 * frame["height"])
    expect(page.locator("#shown")).to_contain_text(re.compile(r"δ = 0\.5[67]"))
    page.wait_for_load_state("networkidle")


def narrow(explorer):
    explorer.page.set_viewport_size({"width": 420, "height": 900})
    finished(explorer)


STATES = (
    start, refused, coming, finished, motions, zoomed, steps, highlighted, dark, diagram, compared, sweep, cancelled,
    sample, charted, narrow,
)  # fmt: skip


def slide(explorer):
    """Stills of the picture while a slider moves."""
    explorer.visit().pictured("Preview")
    slider = explorer.page.locator("[data-turn=damping]")
    for number, damping in enumerate((0.62, 0.59, 0.55), 1):
        # As a hand does: values come while it moves, and nothing is computed until it rests.
        slider.evaluate(
            "(input, value) => { input.value = value; input.dispatchEvent(new Event('input', {bubbles: true})); }",
            str(damping),
        )
        expect(explorer.page.locator("#shown")).to_contain_text(f"δ = {damping}", timeout=30_000)
        explorer.page.wait_for_timeout(300)
        yield f"slider-{number}", explorer.page.locator("#frame")


def move_tooth(explorer):
    """Stills of the tooth: as it departs, and as it strikes each side."""
    finished(explorer)
    explorer.page.mouse.click(*explorer.spot(0.2, 0.53))
    expect(explorer.page.locator("#histories")).to_contain_text("A The motion")
    explorer.page.locator("#play").click()
    chart = explorer.page.locator("#histories svg")
    strikes = [
        chart.locator(f"circle.first >> nth={number}").evaluate("dot => [dot.cx.baseVal.value, dot.cy.baseVal.value]")
        for number in range(12)
    ]
    lowest = max(y for _, y in strikes)
    lower = next(x for x, y in strikes if y == lowest)
    upper = next(x for x, y in strikes if y != lowest)
    for number, x in enumerate((62, lower + 1, upper + 1), 1):
        chart.click(position={"x": x, "y": 60})
        explorer.page.wait_for_timeout(300)
        yield f"tooth-{number}", explorer.page.locator("#history")


STILLS = (slide, move_tooth)


def film_slider(explorer):
    """A film of the basin while damping falls, as the page makes it."""
    finished(explorer)
    return "slider", "damping", {"from": "0.65", "to": "0.5", "count": "31"}


def film_tooth(explorer):
    """A film of the tooth over the time that the page shows."""
    finished(explorer)
    explorer.page.mouse.click(*explorer.spot(0.2, 0.53))
    expect(explorer.page.locator("#histories")).to_contain_text("A The motion")
    return "tooth", "the tooth", {"count": "48"}


FILMS = (film_slider, film_tooth)


def save_film(explorer, name, of, fields):
    """Have the page make a film, and write it where documents show it."""
    target = ROOT / "docs" / "pictures" / f"{name}.webm"
    explorer.film(of, **fields).save_as(target)
    print(target.relative_to(ROOT), target.stat().st_size // 1000, "kB")


def save(name, picture):
    """Write a picture in few colours: a third of the size, and nothing that an eye sees is lost."""
    target = FOLDER / f"{name}.png"
    Image.open(io.BytesIO(picture)).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(target, optimize=True)
    print(target.relative_to(ROOT), target.stat().st_size // 1000, "kB")


def shoot(url, names):
    """Take the pictures of the states of these names from a running service."""
    FOLDER.mkdir(exist_ok=True)
    with browser() as started:
        for state in STATES:
            if names and state.__name__ not in names:
                continue
            explorer = Explorer(started, url)
            state(explorer)
            explorer.page.wait_for_timeout(400)
            save(state.__name__, explorer.page.screenshot(full_page=True))
            print(explorer.complaints or "")
            explorer.context.close()
        for stills in STILLS:
            if names and stills.__name__ not in names:
                continue
            explorer = Explorer(started, url, viewport={"width": 1100, "height": 720})
            for name, part in stills(explorer):
                save(name, part.screenshot())
            explorer.context.close()
        for film in FILMS:
            if names and film.__name__ not in names:
                continue
            explorer = Explorer(started, url, viewport={"width": 1100, "height": 720})
            save_film(explorer, *film(explorer))
            explorer.context.close()


def main(arguments):
    """Shoot from the service at an address, or from one that runs for it alone."""
    with contextlib.ExitStack() as stack:
        if arguments and arguments[0].startswith("http"):
            url = arguments.pop(0)
        else:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            url = stack.enter_context(running_service(folder)).url
        shoot(url, arguments)
    for name, shown in SHOWN.items():
        if (FOLDER / f"{name}.png").exists():
            shutil.copy(FOLDER / f"{name}.png", ROOT / "docs" / "pictures" / f"{shown}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
