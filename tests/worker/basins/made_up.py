"""Motions of a made-up basin, and a look at its picture."""

import numpy as np

from rattle_kernels import Attractor, AttractorKind


def motion(kind, contacts=(0, 0, 0), t=(), v=()):
    return Attractor(kind, *contacts, np.nan, np.nan, np.array(t, np.float64), np.array(v, np.float64))


QUIET = motion(AttractorKind.PERMANENT_CONTACT)
RATTLE = motion(AttractorKind.PERIODIC, (1, 1, 0), [0.5], [3.5])
CHAOS = motion(AttractorKind.CHAOTIC, t=[0.2], v=[1.0])


def near(pixels, colour, tolerance=0.03):
    """Share of the pixels that have a colour."""
    return (np.abs(pixels - np.array(colour)).max(axis=-1) < tolerance).mean()
