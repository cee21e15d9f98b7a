"""Films of a slider, of a sweep and of the tooth, as a browser records them."""

import base64

import numpy as np
import pytest
from PIL import Image, ImageSequence
from playwright.sync_api import expect

from tests.browser.test_help import findings

pytestmark = pytest.mark.browser

SIZE = """async (film) => {
    const video = document.createElement("video");
    video.src = URL.createObjectURL(new Blob([Uint8Array.from(atob(film), (each) => each.charCodeAt(0))]));
    video.muted = true;
    await video.play();
    const seen = new Set(), canvas = new OffscreenCanvas(64, 48);
    const pen = canvas.getContext("2d", { willReadFrequently: true });
    while (!video.ended) {
        pen.drawImage(video, 0, 0, 64, 48);
        seen.add(pen.getImageData(0, 0, 64, 48).data.join());
        await new Promise((resolve) => setTimeout(resolve, 40));
    }
    return [video.videoWidth, video.videoHeight, seen.size];
}"""


CARD = """() => {
    const pen = document.createElement("canvas").getContext("2d");
    pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--card");
    pen.fillRect(0, 0, 1, 1);
    return Array.from(pen.getImageData(0, 0, 1, 1).data.slice(0, 3));
}"""


def filmed(explorer, of, **fields):
    """Size, and number of unlike frames, of a film."""
    download = explorer.film(of, **fields)
    film = download.path().read_bytes()
    assert film.startswith(bytes.fromhex("1a45dfa3")) and len(film) < 1_000_000
    assert download.suggested_filename == "gear-rattle.webm"
    # The page itself may load no film.
    player = explorer.context.new_page()
    seen = player.evaluate(SIZE, base64.b64encode(film).decode())
    player.close()
    return seen


def test_a_slider_and_the_tooth_are_filmed_and_the_page_stays_as_it_is(explorer):
    page = explorer.visit().pictured().page
    address, caption = page.url, page.locator("#shown").inner_text()
    wide, high, unlike = filmed(explorer, "damping", **{"from": "0.45", "to": "0.7", "count": "5"})
    assert 700 <= wide <= 960 and 400 <= high and unlike >= 3
    expect(page.locator(".film [role=status]")).to_have_text("The film is saved.")
    assert findings(page) == []
    assert (page.url, page.locator("#shown").inner_text()) == (address, caption)
    page.keyboard.press("Escape")
    page.mouse.click(*explorer.spot(0.9, 0.55))
    expect(page.locator("#histories .ends")).to_have_count(1)
    *_, taller, unlike = filmed(explorer, "the tooth", count="6")
    assert taller > high and unlike >= 4


def test_a_film_as_gif_has_the_frames_of_the_page_and_their_colours(explorer):
    page = explorer.visit().pictured().page
    page.mouse.click(*explorer.spot(0.9, 0.55))
    expect(page.locator("#histories .ends")).to_have_count(1)
    download = explorer.film("the tooth", as_="GIF", count="6")
    assert download.suggested_filename == "gear-rattle.gif"
    with Image.open(download.path()) as film:
        assert film.format == "GIF" and film.n_frames == 6
        # A GIF counts hundredths of a second.
        assert film.info["duration"] in (120, 130)
        frames = [np.asarray(frame.convert("RGB"), dtype=int) for frame in ImageSequence.Iterator(film)]
    unlike = {frame.tobytes() for frame in frames}
    assert len(unlike) == 6
    # The last corner is the same card in each frame; 256 colours hold it to a step or two of 255.
    card = page.evaluate(CARD)
    assert all(np.abs(frame[-1, -1] - card).max() <= 4 for frame in frames)


def test_a_film_can_be_stopped_and_says_what_is_wrong(explorer):
    page = explorer.visit().pictured().page
    page.locator("#away summary").click()
    page.get_by_role("button", name="Make the film").click()
    expect(page.locator(".film [role=status]")).to_contain_text("of 24")
    page.get_by_role("button", name="Stop").click()
    expect(page.locator(".film [role=status]")).to_have_text("Stopped.", timeout=20_000)
    page.locator(".film input[name='film.count']").fill("1")
    page.get_by_role("button", name="Make the film").click()
    expect(page.locator("#state")).to_contain_text("A film has 2 to 120 frames")


def test_a_sweep_is_filmed_basin_by_basin(explorer, service):
    grid = {"time": {"cells": 40}, "velocity": {"cells": 40}}
    vary = [{"parameter": "damping", "values": [0.5, 0.6, 0.7]}]
    job = service.wait(service.submit({"grid": grid, "iterations": 227, "vary": vary})["id"])
    explorer.visit(f"?job={job['id']}").pictured("40 × 40")
    *_, unlike = filmed(explorer, "the sweep")
    assert unlike >= 3
