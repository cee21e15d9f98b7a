"""Colours can be told apart, also by readers with any of the common forms of colour blindness."""

import json
import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb

from rattle_kernels import Attractor, AttractorKind
from rattle_kernels.attractors.attractor import UNDECIDED_ATTRACTOR
from worker.pictures import colours
from worker.pictures.colours import MISSING, POOLS, TEXTURES, Palette

# Machado, Oliveira and Fernandes (2009), severity 1, on linear red, green and blue.
VISION = {
    "all": np.eye(3),
    "no red": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "no green": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
    "no blue": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
}
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
MOTIONS = (
    (AttractorKind.PERMANENT_CONTACT, 0, 0, 0),
    (AttractorKind.CHAOTIC, 0, 0, 0),
    (AttractorKind.CHAOTIC_TRANSIENT, 0, 0, 0),
    *((AttractorKind.PERIODIC, *each) for each in ((1, 1, 0), (1, 2, 0), (1, 3, 0), (2, 2, 1), (4, 4, 2), (3, 3, 2))),
)
# As in the list of overlays, in documents and in the page.
MANIFOLDS = ("magenta", "lime", "darkorange", "cyan")
# A difference of 2.3 can just be seen beside each other; lines and scattered cells need several times that.
LEAST = 11.0


def lab(colour, vision):
    """CIE L*a*b* of a colour as seen."""
    channels = np.array(to_rgb(colour))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.array(vision) @ linear, 0.0, 1.0)
    part = TO_XYZ @ seen / TO_XYZ.sum(axis=1)
    f = np.where(part > 0.008856, np.cbrt(part), 7.787 * part + 16.0 / 116.0)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


def attractor(kind, *contacts):
    return Attractor(kind, *contacts, np.nan, np.nan, np.empty(0), np.empty(0))


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize("palette", Palette)
def test_what_is_undecided_looks_like_no_motion_and_no_line(palette, vision):
    (undecided,) = colours.colours_of((UNDECIDED_ATTRACTOR,), palette)
    motions = tuple(attractor(*each) for each in MOTIONS)
    others = dict(zip(MOTIONS, colours.colours_of(motions, palette), strict=True))
    others |= {"missing": colours.MISSING} | {line: line for line in MANIFOLDS}
    near = {
        name: distance
        for name, colour in others.items()
        if (distance := np.linalg.norm(lab(undecided, VISION[vision]) - lab(colour, VISION[vision]))) < LEAST
    }
    assert not near


def ciede2000(one, other):
    """Difference of two colours in L*a*b* (CIE 142-2001, as written down by Sharma, Wu and Dalal, 2005)."""
    (l1, a1, b1), (l2, a2, b2) = one, other
    mean_c = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2.0
    g = 0.5 * (1.0 - np.sqrt(mean_c**7 / (mean_c**7 + 25.0**7)))
    a1, a2 = (1.0 + g) * a1, (1.0 + g) * a2
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360.0, np.degrees(np.arctan2(b2, a2)) % 360.0
    dh = 0.0 if c1 * c2 == 0.0 else (h2 - h1 + 180.0) % 360.0 - 180.0
    big_h = 2.0 * np.sqrt(c1 * c2) * np.sin(np.radians(dh / 2.0))
    mean_l, mean_c = (l1 + l2) / 2.0, (c1 + c2) / 2.0
    mean_h = h1 + h2 if c1 * c2 == 0.0 else (h1 + dh / 2.0) % 360.0
    t = (
        1.0 - 0.17 * np.cos(np.radians(mean_h - 30.0)) + 0.24 * np.cos(np.radians(2.0 * mean_h))
        + 0.32 * np.cos(np.radians(3.0 * mean_h + 6.0)) - 0.2 * np.cos(np.radians(4.0 * mean_h - 63.0))
    )  # fmt: skip
    turn = np.radians(60.0 * np.exp(-(((mean_h - 275.0) / 25.0) ** 2)))
    lightness = (l2 - l1) / (1.0 + 0.015 * (mean_l - 50.0) ** 2 / np.sqrt(20.0 + (mean_l - 50.0) ** 2))
    chroma, hue = (c2 - c1) / (1.0 + 0.045 * mean_c), big_h / (1.0 + 0.015 * mean_c * t)
    rotation = -np.sin(turn) * 2.0 * np.sqrt(mean_c**7 / (mean_c**7 + 25.0**7))
    return float(np.sqrt(lightness**2 + chroma**2 + hue**2 + rotation * chroma * hue))


# Pairs 1, 7, 17 and 25 of the table of Sharma, Wu and Dalal.
@pytest.mark.parametrize(
    ("one", "other", "difference"),
    [
        ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
        ((50.0, 0.0, 0.0), (50.0, -1.0, 2.0), 2.3669),
        ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
        ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ],
)
def test_the_difference_is_the_published_one(one, other, difference):
    assert ciede2000(one, other) == pytest.approx(difference, abs=5e-5)


PERIODIC = [
    (1, 1, 0),
    (1, 2, 0),
    (1, 3, 0),
    (2, 2, 1),
    (4, 4, 2),
    (3, 3, 2),
    (2, 2, 2),
    (3, 3, 0),
    (1, 1, 1),
    (5, 5, 3),
]
SEEN = [*((Palette.COLOUR_BLIND, vision) for vision in VISION), (Palette.PAPER, "all")]


@pytest.mark.parametrize(("palette", "vision"), SEEN)
def test_all_colours_of_a_palette_can_be_told_apart(palette, vision):
    motions = [attractor(*each) for each in MOTIONS] + [UNDECIDED_ATTRACTOR]
    own = {to_hex(colour) for colour in colours.colours_of(tuple(motions), palette)}
    everything = sorted(own | {to_hex(colour) for colour in POOLS[palette]} | {to_hex(MISSING)})
    seen = {colour: lab(colour, VISION[vision]) for colour in everything}
    near = {pair: ciede2000(seen[pair[0]], seen[pair[1]]) for pair in combinations(everything, 2)}
    assert min(near.values()) >= 15.0, min(near, key=near.get)


@pytest.mark.parametrize("palette", Palette)
def test_no_two_motions_of_a_basin_have_one_colour_and_texture(palette):
    motions = tuple(attractor(AttractorKind.PERIODIC, *each) for each in PERIODIC * 2)
    paints = colours.paints_of(motions, palette)
    assert len(set(paints)) == len(motions)
    assert max(paint.texture for paint in paints) <= TEXTURES
    few = colours.paints_of(motions[6:10], palette)
    assert all(paint.texture == 0 for paint in few)


def test_the_papers_colours_go_by_name_to_the_cells():
    """Sec. 4: P(1,1,0) pale blue, P(1,2,0) blue, P(2,2,1) yellow, P(3,3,2) orange; quiet dark blue, chaos dark red."""
    wanted = {
        (1, 1, 0): (0.55, 0.85, 1.0),
        (1, 2, 0): (0.1, 0.45, 1.0),
        (2, 2, 1): (1.0, 0.9, 0.1),
        (3, 3, 2): (1.0, 0.6, 0.1),
    }
    motions = [attractor(AttractorKind.PERMANENT_CONTACT, 0, 0, 0), attractor(AttractorKind.CHAOTIC, 0, 0, 0)]
    motions += [attractor(AttractorKind.PERIODIC, *each) for each in wanted]
    solution = np.array([[5, 4, 3], [2, 1, 0], [-1, 4, 5]])
    image = colours.paint_cells(solution, np.zeros((3, 3), int), tuple(motions), Palette.PAPER)
    entries = [(0.0, 0.0, 0.5), (0.5, 0.0, 0.0), *wanted.values(), MISSING]
    np.testing.assert_array_equal(image, np.array(entries)[solution])


def test_most_chaotic_cells_have_the_colour_of_the_legend():
    chaos = (attractor(AttractorKind.CHAOTIC, 0, 0, 0),)
    for usual in range(1, 5):
        group = np.array([[usual] * 9 + [usual + 1] * 3 + [0]])
        image = colours.paint_cells(np.zeros_like(group), group, chaos)
        np.testing.assert_allclose(image[0, :9], [colours.CHAOTIC] * 9)
        np.testing.assert_allclose(image[0, 12], colours.CHAOTIC)
        assert (image[0, 9] != image[0, 0]).any()


def test_textures_mark_a_part_of_their_cells():
    motions = tuple(
        attractor(AttractorKind.PERIODIC, 7, n, 0) for n in range(2, 2 + 4 * len(POOLS[Palette.COLOUR_BLIND]))
    )
    first, *_ = paints = colours.paints_of(motions)
    again = [number for number, paint in enumerate(paints) if paint.colour == first.colour]
    assert [paints[number].texture for number in again] == [0, 1, 2, 3]
    shares = []
    for number in again:
        image = colours.paint_cells(np.full((20, 20), number), np.zeros((20, 20), int), motions)
        shares.append(float((image != np.array(first.colour)).any(axis=-1).mean()))
    assert shares == pytest.approx([0.0, 1 / 5, 1 / 5, 1 / 16])


def test_the_page_has_the_same_pool():
    page = Path(colours.__file__).parents[2] / "service/explorer/js/plane/pools.js"
    told = re.findall(r'"(\w+)": (\[[^\]]*\])', page.read_text())
    assert {name: json.loads(pool) for name, pool in told} == {
        palette.value: [to_hex(colour) for colour in pool] for palette, pool in POOLS.items()
    }
    own = dict(re.findall(r'"(\w+)": (\{[^}]*\})', page.read_text()))
    kinds = tuple(attractor(kind, 0, 0, 0) for kind in (AttractorKind.CHAOTIC, AttractorKind.PERMANENT_CONTACT))
    for palette in Palette:
        wanted = dict(zip([each.name for each in kinds], colours.colours_of(kinds, palette), strict=True))
        wanted |= colours.NAMED[palette]
        assert json.loads(own[palette]) == {name: to_hex(colour) for name, colour in wanted.items()}
