"""Colours can be told apart, also by readers with any of the common forms of colour blindness."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from rattle_kernels import Attractor, AttractorKind
from rattle_kernels.attractors.attractor import UNDECIDED_ATTRACTOR
from worker.pictures import colours
from worker.pictures.colours import Palette

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
