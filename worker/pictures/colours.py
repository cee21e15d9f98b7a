"""Colours of motions, the same in every picture (Sec. 4).

Permanent contact is dark blue, shorter itineraries are bluer, chaos is dark red, a chaotic transient greyer, and what
could not be decided is grey.
"""

import colorsys
import math
from enum import StrEnum

import numpy as np

from rattle_kernels import Attractor, AttractorKind

Colour = tuple[float, float, float]

PERMANENT_CONTACT: Colour = (0.0, 0.0, 0.5)
CHAOTIC: Colour = (0.5, 0.0, 0.0)
CHAOTIC_TRANSIENT: Colour = (0.62, 0.33, 0.33)
UNDECIDED: Colour = (0.46, 0.46, 0.46)
"""The grey that is farthest from all motions and from what is laid over cells, with and without colour blindness."""
MISSING: Colour = (0.85, 0.85, 0.85)
SPECKLE = (0.85, 1.05, 1.25, 1.45)
"""Brightness of chaotic cells, by their group modulo 4."""

_KINDS: dict[AttractorKind, Colour] = {
    AttractorKind.PERMANENT_CONTACT: PERMANENT_CONTACT,
    AttractorKind.CHAOTIC: CHAOTIC,
    AttractorKind.CHAOTIC_TRANSIENT: CHAOTIC_TRANSIENT,
    AttractorKind.UNDECIDED: UNDECIDED,
}
# Points on the scale from blue to red. The paper's text names P(1,1,0) pale blue, P(1,2,0) blue, P(2,2,1) yellow and
# P(3,3,2) orange. Other itineraries are placed by length, between green and red.
_NAMED: dict[str, Colour] = {
    "P(1,1,0)": (0.55, 0.85, 1.0),
    "P(1,2,0)": (0.1, 0.45, 1.0),
    "P(1,3,0)": (0.0, 0.75, 0.75),
    "P(2,2,1)": (1.0, 0.9, 0.1),
    "P(4,4,2)": (1.0, 0.78, 0.1),
    "P(3,3,2)": (1.0, 0.6, 0.1),
}
# Least and most contacts per turn, and their hues. Between lie the yellows and oranges of the named itineraries.
_HUES = ((2, 8, 0.45, 0.2), (9, 48, 0.03, -0.07))
_ODD_VALUE, _EVEN_VALUE = 0.6, 0.95
_LONG_ITINERARY = 24

# Okabe and Ito's colours: distinguishable with any of the common forms of colour blindness.
_SAFE_KINDS: dict[AttractorKind, Colour] = {
    AttractorKind.PERMANENT_CONTACT: (0.08, 0.12, 0.25),
    AttractorKind.CHAOTIC: (0.835, 0.369, 0.0),
    AttractorKind.CHAOTIC_TRANSIENT: (0.72, 0.53, 0.4),
    AttractorKind.UNDECIDED: UNDECIDED,
}
_SAFE_NAMED: dict[str, Colour] = {
    "P(1,1,0)": (0.337, 0.706, 0.914),
    "P(1,2,0)": (0.0, 0.447, 0.698),
    "P(1,3,0)": (0.0, 0.62, 0.451),
    "P(2,2,1)": (0.941, 0.894, 0.259),
    "P(4,4,2)": (0.8, 0.475, 0.655),
    "P(3,3,2)": (0.902, 0.624, 0.0),
}


class Palette(StrEnum):
    """Which colours motions have.

    Examples
    --------
    >>> [palette.value for palette in Palette]
    ['paper', 'colour_blind']
    """

    PAPER = "paper"
    """The colours that the paper's text names."""
    COLOUR_BLIND = "colour_blind"
    """Colours distinguishable with a colour vision deficiency."""


def _by_length(attractor: Attractor) -> Colour:
    """Hue by the logarithm of contacts per turn, from green for few to red for many; odd ones are darker."""
    contacts = attractor.upper_contacts + attractor.lower_contacts
    least, most, first, last = next((each for each in _HUES if contacts <= each[1]), _HUES[-1])
    part = math.log(min(max(contacts, least), most) / least) / math.log(most / least)
    hue = (first + (last - first) * part) % 1.0
    # Neighbours on the scale differ in length by one or two contacts. Of two that look alike, one is usually odd.
    return colorsys.hsv_to_rgb(hue, 0.85, _ODD_VALUE if attractor.upper_contacts % 2 else _EVEN_VALUE)


def _lighter(colour: Colour, part: float) -> Colour:
    return tuple(channel + (1.0 - channel) * part for channel in colour)  # type: ignore[return-value]


def _safe_by_length(attractor: Attractor) -> Colour:
    """Purples, darker for longer itineraries."""
    contacts = attractor.upper_contacts + attractor.lower_contacts
    return _lighter((0.35, 0.12, 0.45), 0.65 * (1.0 - min(contacts, _LONG_ITINERARY) / _LONG_ITINERARY))


def _colour_of(attractor: Attractor, palette: Palette) -> Colour:
    if palette == Palette.COLOUR_BLIND:
        known = _SAFE_KINDS.get(attractor.kind) or _SAFE_NAMED.get(attractor.name)
        return known or _safe_by_length(attractor)
    return _KINDS.get(attractor.kind) or _NAMED.get(attractor.name) or _by_length(attractor)


def colours_of(attractors: tuple[Attractor, ...], palette: Palette = Palette.PAPER) -> list[Colour]:
    """Colour of each attractor; those with the same name get ever lighter shades of one colour, in order.

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
    >>> basin = rattle.basin(cells=40, progress=False)
    >>> colours_of(basin.rattle.catalogue())
    [(0.0, 0.0, 0.5), (0.55, 0.85, 1.0), (0.5, 0.0, 0.0)]
    """
    seen: dict[str, int] = {}
    colours = []
    for attractor in attractors:
        colour = _colour_of(attractor, palette)
        twins = seen.get(attractor.name, 0)
        seen[attractor.name] = twins + 1
        colours.append(_lighter(colour, 1.0 - 0.7**twins))
    return colours


def paint_cells(
    solution: np.typing.ArrayLike, group: np.typing.ArrayLike, attractors: tuple[Attractor, ...],
    palette: Palette = Palette.PAPER,
) -> np.ndarray:  # fmt: skip
    """Colours of cells, with chaos speckled by Hsu's groups as in the paper.

    Parameters
    ----------
    solution, group : array_like of int, one shape
        Solution and group of each cell; a cell with a negative solution is missing.
    attractors : tuple of Attractor
        The catalogue that ``solution`` indexes.
    palette : Palette

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
    colours = np.array([*colours_of(attractors, palette), MISSING])
    image = colours[np.where(solution >= 0, solution, len(attractors))]
    chaotic = [i for i, attractor in enumerate(attractors) if attractor.is_chaotic]
    inside = np.isin(solution, chaotic)
    speckle = np.array(SPECKLE)[group[inside] % len(SPECKLE)]
    image[inside] = np.minimum(image[inside] * speckle[:, None], 1.0)
    return image
