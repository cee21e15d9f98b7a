"""A lattice over the plane of departures whose boxes carry the end in which all of them are proven to come.

Columns divide the period, rows the speeds from some multiple of their height on. Both are powers of two wide, so that
the box of a number is found without rounding.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.numerics.jit import inlined_as_written
from rattle_proof.enclosures.flight import Box
from rattle_proof.enclosures.interval import Interval, down, up

UNPROVEN = 0
"""What a box without a proof carries."""
# In time: of what is looked up.
_WIDEST, _FURTHEST = 0.9, 2.0**20


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


class Strip(NamedTuple):
    """Departures at times t and speeds v of two intervals, with ``v - slope t`` in `offset`."""

    t: Interval
    v: Interval
    slope: float
    offset: Interval


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


def refined(lattice: Lattice) -> Lattice:
    """The same lattice with every box cut into four."""
    return Lattice(lattice.height / 2, 2 * lattice.first, lattice.ends.repeat(2, 0).repeat(2, 1))


def common_ends(ends: np.ndarray, parts: int) -> np.ndarray:
    """What boxes carry in all of several lattices that stand above each other.

    Parameters
    ----------
    ends : ndarray of uint16, shape (parts * rows, columns)
    parts : int

    Returns
    -------
    ndarray of uint16, shape (rows, columns)
    """
    each = ends.reshape(parts, -1, ends.shape[1])
    return np.where((each == each[0]).all(axis=0), each[0], np.uint16(UNPROVEN))


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
    low, high, early, late = box.w.low / lattice.height, box.w.high / lattice.height, box.t.low, box.t.high
    # In this form NaN is outside, too.
    if not (low >= lattice.first and high < lattice.first + rows and late - early < _WIDEST and abs(early) < _FURTHEST):
        return Span(0, -1, 0, -1)
    bottom, top = math.floor(low) - lattice.first, math.floor(high) - lattice.first
    return Span(bottom, top, math.floor(early * columns), math.floor(late * columns))


class Found(NamedTuple):
    """The end of a strip. Where UNPROVEN, the first box found without a proof; its row is -1 if no proof can help."""

    end: int
    row: int
    column: int


@inlined_as_written
def _rows_of(height, first, columns, rows, strip, j):
    """The first and the last row that a strip touches in a column: none if the last comes first."""
    early, late = max(j / columns, strip.t.low), min((j + 1) / columns, strip.t.high)
    begin, last = strip.slope * early, strip.slope * late
    low = max(down(down(min(begin, last)) + strip.offset.low), strip.v.low)
    high = min(up(up(max(begin, last)) + strip.offset.high), strip.v.high)
    if high < low:
        return 0, -1
    low, high = low / height, high / height
    # In this form NaN is outside, too.
    if not (low >= first and high < first + rows):
        return -1, -1
    return math.floor(low) - first, math.floor(high) - first


@inlined_as_written
def find_end(lattice, strip):
    """The end of all departures of a strip, as far as the lattice knows it."""
    return find_end_within(lattice.height, lattice.first, lattice.ends.shape[1], 0, lattice.ends, strip)


@inlined_as_written
def find_end_within(height, first, columns, left, ends, strip):
    """The same, where `columns` divide the period, of which there are those from the number `left` on."""
    if not (strip.t.high - strip.t.low < _WIDEST and abs(strip.t.low) < _FURTHEST):
        return Found(UNPROVEN, -1, -1)
    end = UNPROVEN
    for j in range(math.floor(strip.t.low * columns), math.floor(strip.t.high * columns) + 1):
        column = (j - left) % columns
        bottom, top = _rows_of(height, first, columns, ends.shape[0], strip, j)
        if bottom < 0 or column >= ends.shape[1]:
            return Found(UNPROVEN, -1, -1)
        for i in range(bottom, top + 1):
            here = int(ends[i, column])
            if here == UNPROVEN:
                return Found(UNPROVEN, i, column)
            if end != UNPROVEN and here != end:
                return Found(UNPROVEN, -1, -1)
            end = here
    return Found(end, -1, -1)


@inlined_as_written
def end_of(lattice, strip):
    """The end of all departures of a strip, UNPROVEN where the lattice does not know it."""
    return find_end(lattice, strip).end
