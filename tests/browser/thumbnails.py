"""Small pictures of the explorer's examples: ``python -m tests.browser.thumbnails``; see `make screenshots`."""

import json
from pathlib import Path

import numpy as np
from PIL import Image

from worker.jobs.preview_request import PreviewRequest, preview_basin
from worker.pictures.colours import Palette, colours_of

EXPLORER = Path(__file__).parents[2] / "service" / "explorer"
CELLS = 96


def draw(request):
    """Picture of the first basin of a request, from the highest speed down."""
    oscillator = request["oscillator"] | {
        each["parameter"]: 0.4 * each["start"] + 0.6 * each["stop"] for each in request.get("vary", ())
    }
    axes = {axis: request["grid"][axis] | {"cells": CELLS} for axis in ("time", "velocity")}
    preview = preview_basin(PreviewRequest(oscillator=oscillator, grid=axes))
    palette = np.round(255 * np.array(colours_of(preview.attractors, Palette.COLOUR_BLIND))).astype(np.uint8)
    picture = Image.fromarray(preview.solution[::-1].astype(np.uint8), mode="P")
    picture.putpalette(palette.tobytes())
    return picture


def main():
    """Draw all examples."""
    folder = EXPLORER / "thumbnails"
    folder.mkdir(exist_ok=True)
    for preset in json.loads((EXPLORER / "presets.json").read_text()):
        target = folder / f"{preset['name']}.png"
        draw(preset["request"]).save(target, optimize=True)
        print(target.name, target.stat().st_size)


if __name__ == "__main__":
    main()
