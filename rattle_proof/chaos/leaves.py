"""Curves across a set that P maps into itself, and on which side of them all of a box lies.

A *leaf* runs from one side of the set to the other, close to a stable manifold: so its images shrink. It is the graph
of a polyline t = T(v) with a node at each row of the lattice, and as wide as ``2 half_width`` in time. Leaves do not
meet, and are numbered by time. The part of the plane between the first and the last, from the lowest node to the
highest, is the *window*. The set leaves it by these two leaves alone: `places_of` shows that.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_proof.enclosures.interval import down, up
from rattle_proof.enclosures.lattice import Lattice

OUTSIDE, INSIDE, LEFT, RIGHT, BESIDE_FIRST, BESIDE_LAST = range(6)
"""Where a box of the set lies: nowhere known, in the window, before its first leaf or behind its last; or beside these,
so that a part of it may lie in the window, too."""


class Leaves(NamedTuple):
    """Leaves by time: ``times``, shape (leaves, nodes), at the speeds ``(first + j) height``, j counting the nodes."""

    times: np.ndarray
    first: int
    height: float
    half_width: float


class NotSeparated(Exception):
    """The leaves do not cut the set in two, each of them."""


@inlined_as_written
def sides_of(leaves, early, late, low, high):
    """How many leaves a box is behind for certain, and how many at most; it lies at speeds of the window in part."""
    nodes = leaves.times.shape[1]
    bottom = min(max(int(np.floor(low / leaves.height)) - leaves.first, 0), nodes - 1)
    top = min(max(int(np.ceil(high / leaves.height)) - leaves.first, 0), nodes - 1)
    surely, ahead = 0, leaves.times.shape[0]
    while surely < ahead:
        i = (surely + ahead) // 2
        if up(leaves.times[i, bottom : top + 1].max() + leaves.half_width) < early:
            surely = i + 1
        else:
            ahead = i
    most, ahead = surely, leaves.times.shape[0]
    while most < ahead:
        i = (most + ahead) // 2
        if down(leaves.times[i, bottom : top + 1].min() - leaves.half_width) <= late:
            most = i + 1
        else:
            ahead = i
    return surely, most


@kernel_as_written
def _sides(leaves, lattice, rows, columns, surely, most):
    width = 1.0 / lattice.ends.shape[1]
    for k in range(rows.size):
        low = (lattice.first + rows[k]) * lattice.height
        surely[k], most[k] = sides_of(leaves, columns[k] * width, (columns[k] + 1) * width, low, low + lattice.height)


def places_of(leaves: Leaves, lattice: Lattice) -> np.ndarray:
    """Where each box of a set lies.

    Parameters
    ----------
    leaves : Leaves
        Over rows of the lattice.
    lattice : Lattice
        Whose boxes with an end are the set.

    Returns
    -------
    ndarray of uint8, shape (rows, columns)

    Raises
    ------
    NotSeparated
        If leaves meet; if the set may leave the window otherwise than by the first and the last leaf; or if it leads
        outside of the window from the one to the other; or does not lead through the window at all.
    """
    apart = up(2.0 * leaves.half_width)
    if not (leaves.height == lattice.height and (np.diff(leaves.times, axis=0) > up(2.0 * apart)).all()):
        raise NotSeparated("leaves meet")
    if not (leaves.times.min() > apart and leaves.times.max() < 1.0 - apart):
        raise NotSeparated("a leaf leaves the period")
    rows, columns = np.nonzero(lattice.ends)
    surely, most = np.empty(rows.size, np.int64), np.empty(rows.size, np.int64)
    _sides(leaves, lattice, rows, columns, surely, most)
    count, nodes = leaves.times.shape
    # Rows of the window, by nodes: closed boxes of the rows beside it touch its edges.
    node = lattice.first + rows - leaves.first
    within = (node >= -1) & (node <= nodes - 1)
    beside_first, beside_last = within & (surely == 0) & (most > 0), within & (most == count) & (surely < count)
    at_edge = within & ((node <= 0) | (node >= nodes - 2)) & (most > 0) & (surely < count)
    if at_edge.any():
        raise NotSeparated("the set leaves the window above or below")
    inside = within & (surely > 0) & (most < count)
    outer = np.flatnonzero(~inside)
    pieces = _pieces(rows[outer], columns[outer], lattice.ends.shape[1])
    left, right = (np.isin(pieces, pieces[beside[outer]]) for beside in (beside_first, beside_last))
    if (left & right).any() or not (left.any() and right.any()):
        raise NotSeparated("the set leads round the window, or ends in it")
    whole = _pieces(rows, columns, lattice.ends.shape[1])
    if not set(whole[outer[left]]) & set(whole[outer[right]]):
        raise NotSeparated("the set does not lead through the window")
    places = np.where(inside, INSIDE, OUTSIDE).astype(np.uint8)
    places[outer[left]], places[outer[right]] = LEFT, RIGHT
    places[beside_first], places[beside_last] = BESIDE_FIRST, BESIDE_LAST
    result = np.zeros(lattice.ends.shape, np.uint8)
    result[rows, columns] = places
    return result


def _pieces(rows: np.ndarray, columns: np.ndarray, period: int) -> np.ndarray:
    """The connected piece of each box: boxes that share a corner are connected, and the last column meets the first."""
    keys = rows * period + columns
    order = np.argsort(keys)
    ordered = keys[order]
    pairs = []
    for up_, along in ((0, 1), (1, -1), (1, 0), (1, 1)):
        others = (rows + up_) * period + (columns + along) % period
        found = np.minimum(np.searchsorted(ordered, others), max(len(ordered) - 1, 0))
        there = np.flatnonzero(ordered[found] == others)
        pairs.append((there, order[found[there]]))
    one, other = (np.concatenate(each) for each in zip(*pairs, strict=True))
    graph = coo_array((np.ones(len(one), np.bool_), (one, other)), shape=(len(keys), len(keys)))
    pieces: np.ndarray = connected_components(graph, directed=False)[1]
    return pieces
