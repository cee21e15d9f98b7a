"""Phases: times in forcing periods, of which only the part of a period counts."""

import math

import numpy as np

from rattle_kernels.numerics.jit import inlined


@inlined
def wrap(phase):
    """Phase in [0, 1): the whole periods below it are taken off.

    A phase just below a whole number would round up to 1.0. It becomes 0.0, the same point of the circle. NaN stays
    NaN.
    """
    rest = phase - math.floor(phase)
    return 0.0 if rest == 1.0 else rest


@inlined
def part_turn(turns):
    """Turns less the nearest whole number: the reduction is exact, and the angle that is left is small."""
    return turns - math.floor(turns + 0.5)


def wrap_all(phases: np.ndarray) -> np.ndarray:
    """Phases in [0, 1), as `wrap` does it for one.

    Parameters
    ----------
    phases : ndarray of float64

    Returns
    -------
    ndarray of float64, that shape
    """
    rest = phases - np.floor(phases)
    return np.where(rest == 1.0, 0.0, rest)
