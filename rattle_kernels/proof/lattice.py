"""A lattice over the plane of departures whose boxes carry the end in which all of them are proven to come.

Columns divide the period, rows the speeds from some multiple of their height on. Both are powers of two wide, so that
the box of a number is found without rounding.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.numerics.interval import Interval
from rattle_kernels.numerics.jit import inlined_as_written
from rattle_kernels.proof.flight import Box

UNPROVEN = 0
"""What a box without a proof carries."""


class Lattice(NamedTuple):
    """Boxes ``[j, j + 1]/columns`` by ``[first + i, first + i + 1] height``.

    ``ends[i, j]``, uint16, is UNPROVEN, or 1 + the number of a motion.
    """

    height: float
    first: int
    ends: np.ndarray


class Span(NamedTuple):
    """Boxes of a lattice: rows and columns, both ends included. Columns are not reduced; rows may lie outside."""

    bottom: int
    top: int
    left: int
    right: int


def empty_lattice(bottom: float, top: float, columns: int, height: float) -> Lattice:
    """Lattice of boxes that are not proven.

    Parameters
    ----------
    bottom, top : float
        Speeds that it holds.
    columns : int
        A power of two.
    height : float
        Of a row: a power of two.

    Returns
    -------
    Lattice
    """
    first = math.floor(bottom / height)
    return Lattice(height, first, np.zeros((max(math.ceil(top / height) - first, 1), columns), np.uint16))


@inlined_as_written
def box_at(lattice, i, j):
    """Departures of a box of the lattice."""
    columns = lattice.ends.shape[1]
    low = (lattice.first + i) * lattice.height
    return Box(Interval(j / columns, (j + 1) / columns), Interval(low, low + lattice.height))


@inlined_as_written
def span_of(lattice, box):
    """Boxes that a box of departures touches; none of the lattice, as top < bottom, if they cannot be told."""
    rows, columns = lattice.ends.shape
    bottom, top = math.floor(box.w.low / lattice.height), math.floor(box.w.high / lattice.height)
    left, right = math.floor(box.t.low * columns), math.floor(box.t.high * columns)
    if not (bottom >= lattice.first and top < lattice.first + rows and right - left < columns and abs(left) < 2.0**40):
        return Span(0, -1, 0, -1)
    return Span(int(bottom) - lattice.first, int(top) - lattice.first, int(left), int(right))


@inlined_as_written
def end_of_span(ends, span):
    """The end that all boxes of a span carry, UNPROVEN where they differ or where there are none."""
    columns = ends.shape[1]
    if span.top < span.bottom:
        return UNPROVEN
    end = int(ends[span.bottom, span.left % columns])
    if end == UNPROVEN:
        return UNPROVEN
    for i in range(span.bottom, span.top + 1):
        for j in range(span.left, span.right + 1):
            if ends[i, j % columns] != end:
                return UNPROVEN
    return end


@inlined_as_written
def end_of(lattice, box):
    """The end of all departures of a box, UNPROVEN where the lattice does not know it."""
    return end_of_span(lattice.ends, span_of(lattice, box))
