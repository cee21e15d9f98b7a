"""How fast the explorer answers its user: ``python -m benchmarks.explorer``, on a quiet machine.

Measured in Chromium, from the user's action to the frame that shows its effect. The targets are for two cores with
browser and service on them, and nothing else.
"""

import tempfile
import time
from functools import partial

from playwright.sync_api import expect

from tests.browser.chromium import Explorer, browser
from tests.running_service import running_service

TARGETS = {
    "first picture after opening": "1000 ms",
    "first picture after a zoom": "150 ms",
    "first picture after a slider's step": "150 ms",
    "previews while a slider moves": "10 /s",
    "frame while panning with manifolds, 95 %": "33 ms",
    "motion after a click": "100 ms",
    "first picture after a move over a chart": "100 ms",
}
# Of the last picture that came, in milliseconds since the page was opened.
SHOWN = """() => performance.getEntriesByType("resource").filter(({name}) => name.endsWith("/v1/previews"))
  .map(({responseEnd}) => responseEnd)"""
MACHINE = "?damping=0.6&eccentricity=0.1&half_backlash=0.6&grid=0,1,0,7"
CHART = {
    "first": {"parameter": "damping", "start": 0.75, "stop": 0.78},
    "second": {"parameter": "eccentricity", "start": 0.094, "stop": 0.0995},
    "longest": 1, "lines": 2, "cells": 12, "pixels": 6, "departures": 16,
}  # fmt: skip
FRAMES = """() => { window.frames_ = []; let last = performance.now();
  const next = (now) => { window.frames_.push(now - last); last = now; 
    window.sampling && requestAnimationFrame(next); };
  window.sampling = true; requestAnimationFrame(next); }"""

# Milliseconds from the release of the button to the frame after the one that first has the motion.
CLICKED = """() => { window.shown_ = null; document.addEventListener("pointerup", (event) => {
  new MutationObserver((_, observer) => { observer.disconnect();
    requestAnimationFrame(() => requestAnimationFrame((now) => { window.shown_ = now - event.timeStamp; }));
  }).observe(document.querySelector("#histories"), { childList: true });
}, { capture: true, once: true }); }"""


def settle(page):
    """Wait until nothing is asked for any more, and the last frame is drawn."""
    page.wait_for_load_state("networkidle")
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def after(page, act, response):
    """Milliseconds from an action to the frame after an answer."""
    begin = time.perf_counter()
    with page.expect_response(response):
        act()
    page.evaluate("() => new Promise((done) => requestAnimationFrame(done))")
    return 1000 * (time.perf_counter() - begin)


def opening(explorer):
    """Milliseconds from the navigation to the first preview."""
    explorer.visit().pictured("Preview")
    settle(explorer.page)
    return explorer.page.evaluate(SHOWN)[0]


def zooming(explorer):
    """Median of five zooms."""
    explorer.page.mouse.move(*explorer.spot(0.6, 0.5))
    times = []
    for _ in range(5):
        times.append(after(explorer.page, lambda: explorer.page.mouse.wheel(0, -100), "**/v1/previews"))
        settle(explorer.page)
    return sorted(times)[2]


def sliding(explorer):
    """A single step, and the rate while the slider moves for two seconds."""
    page = explorer.page
    slider = page.locator("[data-turn=damping]")
    box = slider.bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.5 * box["width"], y)
    page.mouse.down()
    step = after(page, lambda: page.mouse.move(box["x"] + 0.52 * box["width"], y), "**/v1/previews")
    settle(page)
    before = len(page.evaluate(SHOWN))
    begin = time.perf_counter()
    for i in range(100):
        page.mouse.move(box["x"] + (0.52 + 0.001 * i) * box["width"], y)
        page.wait_for_timeout(20)
    seconds = time.perf_counter() - begin
    rate = (len(page.evaluate(SHOWN)) - before) / seconds
    page.mouse.up()
    return step, rate


def panning(explorer):
    """The 95th percentile of frames while the plane is dragged, with manifolds over it."""
    page = explorer.page
    explorer.ask(f"{MACHINE}&cells=500,500&k=1499").state("Complete", seconds=200)
    page.get_by_label("Stable manifolds").check()
    expect(page.locator("#overlays")).to_contain_text("manifold of", timeout=200_000)
    page.locator("#anew").uncheck()
    page.mouse.move(*explorer.spot(0.8, 0.5))
    page.mouse.down()
    page.evaluate(FRAMES)
    for i in range(120):
        page.mouse.move(*explorer.spot(0.8 - 0.005 * i, 0.5))
    page.mouse.up()
    frames = sorted(page.evaluate("() => { window.sampling = false; return window.frames_; }"))
    return frames[int(0.95 * (len(frames) - 1))]


def clicking(explorer):
    """Median of five clicks, in the page's own time: Playwright takes a tenth of a second to click and to look."""
    times = []
    for i in range(5):
        explorer.page.evaluate(CLICKED)
        explorer.page.mouse.click(*explorer.spot(0.2 + 0.15 * i, 0.6))
        explorer.page.wait_for_function("() => window.shown_ !== null")
        times.append(explorer.page.evaluate("() => window.shown_"))
        settle(explorer.page)
    return sorted(times)[2]


def hovering(explorer, chart):
    """Median of five moves over a chart, each to a machine that was not seen before."""
    page = explorer.page
    explorer.visit(f"{MACHINE}&parameters=damping,eccentricity,0.75,0.78,0.094,0.0995&parameters_job={chart}")
    expect(page.locator("#parameters [data-curve]").first).to_be_attached(timeout=30_000)
    settle(page)
    frame = page.locator("#parameters .stage rect.axis").bounding_box()
    times = []
    for i in range(5):
        x, y = frame["x"] + (0.2 + 0.12 * i) * frame["width"], frame["y"] + 0.5 * frame["height"]
        times.append(after(page, partial(page.mouse.move, x, y), "**/v1/previews"))
        settle(page)
    return sorted(times)[2]


def measure(service):
    """All of them, by name."""
    chart, url = service.wait(service.submit(CHART, "charts")["id"])["id"], service.url
    with browser() as started:
        opening(Explorer(started, url))  # the service loads its kernels
        explorer = Explorer(started, url)
        found = {"first picture after opening": f"{opening(explorer):.0f} ms"}
        found["first picture after a zoom"] = f"{zooming(explorer):.0f} ms"
        step, rate = sliding(explorer)
        found["first picture after a slider's step"] = f"{step:.0f} ms"
        found["previews while a slider moves"] = f"{rate:.1f} /s"
        found["frame while panning with manifolds, 95 %"] = f"{panning(explorer):.0f} ms"
        found["motion after a click"] = f"{clicking(explorer):.0f} ms"
        found["first picture after a move over a chart"] = f"{hovering(explorer, chart):.0f} ms"
    return found


def main():
    """Measure a service that runs for it alone."""
    with tempfile.TemporaryDirectory() as folder, running_service(folder) as service:
        for name, value in measure(service).items():
            print(f"{name:45} {value:>10}   target {TARGETS[name]}")


if __name__ == "__main__":
    main()
