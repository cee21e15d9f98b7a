"""Colours of motions, the same in the page and in every picture.

Each palette has colours of its own for what happens often: permanent contact, chaos, and a few motions by name. Other
motions of a basin take the colours of a pool in order, short itineraries first. All colours of a palette differ by at
least 15 of CIEDE2000: those of `Palette.COLOUR_BLIND` with each of the three colour vision deficiencies as well, by
Machado, Oliveira and Fernandes (2009). Where the pool runs out, its colours come again with a texture.
"""

import re
from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels import Attractor, AttractorKind
from worker.errors import InvalidJob

Colour = tuple[float, float, float]


def _rgb(text: str) -> Colour:
    red, green, blue = bytes.fromhex(text)
    return red / 255.0, green / 255.0, blue / 255.0


PERMANENT_CONTACT: Colour = _rgb("141f40")
CHAOTIC: Colour = _rgb("d55e00")
CHAOTIC_TRANSIENT: Colour = _rgb("bf9580")
UNDECIDED: Colour = (0.46, 0.46, 0.46)
"""The grey that is farthest from all motions and from what is laid over cells, with and without colour blindness."""
MISSING: Colour = (0.85, 0.85, 0.85)
SPECKLE = (0.85, 1.05, 1.25, 1.45)
"""Brightness of chaotic cells, by their group modulo 4; that of most chaotic cells of a picture counts as 1."""
TEXTURES = 3
"""Ways to mark cells of a colour that is used again: stripes up, stripes down, dots."""


class Palette(StrEnum):
    """Which colours motions have.

    Examples
    --------
    >>> [palette.value for palette in Palette]
    ['paper', 'colour_blind']
    """

    PAPER = "paper"
    """The colours that the paper's text names (Sec. 4)."""
    COLOUR_BLIND = "colour_blind"
    """Colours distinguishable with a colour vision deficiency: those of the page, and of pictures by default."""


USUAL = Palette.COLOUR_BLIND

_KINDS: dict[Palette, dict[AttractorKind, Colour]] = {
    Palette.PAPER: {
        AttractorKind.PERMANENT_CONTACT: (0.0, 0.0, 0.5),
        AttractorKind.CHAOTIC: (0.5, 0.0, 0.0),
        AttractorKind.CHAOTIC_TRANSIENT: (0.62, 0.33, 0.33),
        AttractorKind.UNDECIDED: UNDECIDED,
    },
    Palette.COLOUR_BLIND: {
        AttractorKind.PERMANENT_CONTACT: PERMANENT_CONTACT,
        AttractorKind.CHAOTIC: CHAOTIC,
        AttractorKind.CHAOTIC_TRANSIENT: CHAOTIC_TRANSIENT,
        AttractorKind.UNDECIDED: UNDECIDED,
    },
}
NAMED: dict[Palette, dict[str, Colour]] = {
    # The paper's text names P(1,1,0) pale blue, P(1,2,0) blue, P(2,2,1) yellow and P(3,3,2) orange.
    Palette.PAPER: {
        "P(1,1,0)": (0.55, 0.85, 1.0),
        "P(1,2,0)": (0.1, 0.45, 1.0),
        "P(1,3,0)": (0.0, 0.75, 0.75),
        "P(2,2,1)": (1.0, 0.9, 0.1),
        "P(3,3,2)": (1.0, 0.6, 0.1),
    },
    # Of Okabe and Ito's colours those that are far enough from each other.
    Palette.COLOUR_BLIND: {
        "P(1,1,0)": _rgb("56b4e9"),
        "P(1,2,0)": _rgb("0072b2"),
        "P(2,2,1)": _rgb("f0e442"),
    },
}
"""Colours of motions that have one by name."""
POOLS: dict[Palette, tuple[Colour, ...]] = {
    Palette.PAPER: tuple(
        _rgb(text)
        for text in (
            "009900", "ff80cc", "33ffe6", "8066b3", "664d33", "99cc00", "ff0066", "331a00", "b3ffb3", "ff8080",
            "006680", "cc4dff", "999933", "b39980", "33b380", "66334d",
        )
    ),
    Palette.COLOUR_BLIND: tuple(_rgb(text) for text in ("bfffbf", "2a00bf", "802a00", "2a0000", "554040")),
}  # fmt: skip
"""Colours of motions that have none by name, in the order in which they are taken."""


class Paint(NamedTuple):
    """A colour, and the texture that it is used with: 0 for none."""

    colour: Colour
    texture: int = 0


def paints_of(
    attractors: tuple[Attractor, ...], palette: Palette = USUAL, own: Mapping[str, Colour | Paint] | None = None
) -> list[Paint]:
    """Colour and texture of each attractor of a basin or of a sweep: no two have the same.

    Beyond the pool's colours with all textures (20 motions without a colour of their own), they begin anew.

    Parameters
    ----------
    attractors : tuple of Attractor
    palette : Palette
    own : mapping of str to (red, green, blue) or Paint, optional
        Colours that some motions have instead, by their names. ``"P(2,2,1) (2)"`` is the second of this name.

    Returns
    -------
    list of Paint
    """
    paints: dict[int, Paint] = {}
    named = dict(NAMED[palette])
    others = []
    for number, attractor in enumerate(attractors):
        # The second motion of a name needs a colour of its own.
        colour = _KINDS[palette].get(attractor.kind) or named.pop(attractor.name, None)
        if colour is None:
            others.append((attractor.upper_contacts + attractor.lower_contacts, attractor.name, number))
        else:
            paints[number] = Paint(colour)
    pool = POOLS[palette]
    for place, (_, _, number) in enumerate(sorted(others)):
        paints[number] = Paint(pool[place % len(pool)], place // len(pool) % (TEXTURES + 1))
    seen: dict[str, int] = {}
    for number, attractor in enumerate(attractors):
        name = attractor.name
        seen[name] = seen.get(name, 0) + 1
        given = own and (own.get(f"{name} ({seen[name]})") or own.get(name))
        if given:
            paints[number] = given if isinstance(given, Paint) else Paint(given)
    return [paints[number] for number in range(len(attractors))]


def parse_paints(text: str) -> dict[str, Paint]:
    """Paints of motions by their names, from a text as ``P(2,2,2):bfffbf;P(3,3,0):802a00/1``; none from an empty text.

    Raises
    ------
    InvalidJob
        If a part is no name with a colour, and perhaps a texture from 0 to 3.

    Examples
    --------
    >>> parse_paints("P(2,2,2):ff0000/1")
    {'P(2,2,2)': Paint(colour=(1.0, 0.0, 0.0), texture=1)}
    """
    paints = {}
    for part in filter(None, text.split(";")):
        found = re.fullmatch(r"([^:;]{1,60}):([0-9a-f]{6})(?:/([0-3]))?", part)
        if found is None:
            raise InvalidJob(f"a motion's colour is written as P(2,2,2):bfffbf or P(2,2,2):bfffbf/1, not as {part!r}")
        name, colour, texture = found.groups()
        paints[name] = Paint(_rgb(colour), int(texture or 0))
    return paints


def _motion_of(name: str) -> Attractor:
    """A motion with a name alone, as far as its colour needs one; chaos where the name has no numbers."""
    numbers = tuple(map(int, re.findall(r"\d+", name)))
    kind = AttractorKind.PERIODIC if numbers else AttractorKind.CHAOTIC
    periods, upper, lower = numbers if len(numbers) == 3 else (0, sum(numbers), 0)
    return Attractor(kind, periods, upper, lower, np.nan, np.nan, np.empty(0), np.empty(0))


def paints_of_names(names: Iterable[str], palette: Palette = USUAL) -> dict[str, Paint]:
    """Colour and texture of motions by their names, as the page has them where it shows nothing else.

    Parameters
    ----------
    names : iterable of str
        With the numbers of P(m,n+,n-), or of impacts alone; a name without numbers is painted as chaos.
    palette : Palette

    Returns
    -------
    dict of str to Paint

    Examples
    --------
    >>> sorted(paints_of_names(["P(1,1,0)", "P(4,4,2)", "no period seen"]))
    ['P(1,1,0)', 'P(4,4,2)', 'no period seen']
    """
    each = sorted(set(names))
    return dict(zip(each, paints_of(tuple(map(_motion_of, each)), palette), strict=True))


def colours_of(attractors: tuple[Attractor, ...], palette: Palette = USUAL) -> list[Colour]:
    """Colour of each attractor.

    Parameters
    ----------
    attractors : tuple of Attractor
    palette : Palette

    Returns
    -------
    list of (red, green, blue)
        Each in [0, 1].

    Examples
    --------
    >>> import rattle
    >>> from rattle.pictures import Palette
    >>> basin = rattle.basin(cells=40, progress=False)
    >>> colours_of(basin.rattle.catalogue(), Palette.PAPER)
    [(0.0, 0.0, 0.5), (0.55, 0.85, 1.0), (0.5, 0.0, 0.0)]
    """
    return [paint.colour for paint in paints_of(attractors, palette)]


def _textured(shape: tuple[int, ...], texture: np.ndarray) -> np.ndarray:
    """Which cells the marks of their textures cover; the page has the same (``isMarked``)."""
    row, column = np.indices(shape) if len(shape) == 2 else (np.zeros(shape, int), np.arange(np.prod(shape)))
    up, down = (column - row) % 5 == 0, (column + row) % 5 == 0
    dots = (column % 4 == 0) & (row % 4 == 0)
    return np.choose(texture, [np.zeros(shape, bool), up, down, dots])


def ink_on(colour: Colour) -> Colour:
    """Black or white, whichever is seen better on a colour."""
    return (0.0, 0.0, 0.0) if np.dot(colour, (0.2126, 0.7152, 0.0722)) > 0.4 else (1.0, 1.0, 1.0)


def usual_speckle(
    solution: np.typing.ArrayLike, group: np.typing.ArrayLike, attractors: tuple[Attractor, ...]
) -> int:  # fmt: skip
    """Number of the brightness that most chaotic cells have; they are drawn in the colour of the legend.

    Parameters
    ----------
    solution, group : array_like of int, one shape
    attractors : tuple of Attractor

    Returns
    -------
    int
        Index into `SPECKLE`; 0 where no cell is chaotic.
    """
    chaotic = [i for i, attractor in enumerate(attractors) if attractor.is_chaotic]
    groups = np.asarray(group)[np.isin(solution, chaotic)]
    return int(np.bincount(groups[groups > 0] % len(SPECKLE), minlength=len(SPECKLE)).argmax())


def paint_cells(
    solution: np.typing.ArrayLike, group: np.typing.ArrayLike, attractors: tuple[Attractor, ...],
    palette: Palette = USUAL, usual: int | None = None, own: Mapping[str, Colour | Paint] | None = None,
) -> np.ndarray:  # fmt: skip
    """Colours of cells, with chaos speckled by Hsu's groups as in the paper, and textures where colours are used again.

    Parameters
    ----------
    solution, group : array_like of int, one shape
        Solution and group of each cell; a cell with a negative solution is missing.
    attractors : tuple of Attractor
        The catalogue that ``solution`` indexes.
    palette : Palette
    usual : int, optional
        From ``usual_speckle`` of the whole picture, where these cells are a part of it.
    own : mapping of str to (red, green, blue) or Paint, optional
        Colours that some motions have instead, by their names; none of these is speckled.

    Returns
    -------
    ndarray of float64, that shape and 3
        Red, green, blue in [0, 1].

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=40, progress=False)
    >>> paint_cells(basin.solution, basin.group, basin.rattle.catalogue()).shape
    (40, 40, 3)
    """
    solution, group = np.asarray(solution), np.asarray(group)
    paints = [*paints_of(attractors, palette, own), Paint(MISSING)]
    number = np.where((solution >= 0) & (solution < len(attractors)), solution, len(attractors))
    image = np.array([paint.colour for paint in paints])[number]
    chaotic = [i for i, each in enumerate(attractors) if each.is_chaotic and not (own and each.name in own)]
    inside = np.isin(solution, chaotic)
    if inside.any():
        one = SPECKLE[usual_speckle(solution, group, attractors) if usual is None else usual]
        speckle = np.where(group[inside] > 0, np.array(SPECKLE)[group[inside] % len(SPECKLE)] / one, 1.0)
        image[inside] = np.minimum(image[inside] * speckle[:, None], 1.0)
    texture = np.array([paint.texture for paint in paints])[number]
    if texture.any():
        marked = _textured(solution.shape, texture)
        image[marked] = np.array([ink_on(paint.colour) for paint in paints])[number][marked]
    return image
