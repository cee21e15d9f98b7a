"""Proven boxes grow by rounds: a box whose departures all come to boxes of one end carries that end, too.

Each box is followed once, for a few impacts, and the boxes touched on the way are kept as its *trail*. A round then looks
only at trails. A box is proven from boxes of earlier rounds, so no proof rests on itself.
"""

import numpy as np

from rattle_kernels.numerics.interval import width
from rattle_kernels.numerics.jit import kernel_as_written
from rattle_kernels.proof.following import WIDEST
from rattle_kernels.proof.lattice import UNPROVEN, Span, box_at, end_of_span, span_of
from rattle_kernels.proof.moving_set import advance, set_out
from rattle_kernels.proof.targets import proven_end

IMPACTS = 4
"""Length of a trail."""


@kernel_as_written
def follow_boxes(machine, oscillator, targets, first, ends, trails):
    """Follow the boxes of some rows of the lattice that are not proven.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.
    targets : Targets
        What is proven before the first round.
    first : int
        The first of the rows.
    ends : ndarray of uint16, shape (rows, columns)
        Filled with the ends of boxes that come to a target at once.
    trails : ndarray of int16, shape (rows, columns, IMPACTS, 4)
        Filled with the spans touched; where one is not known, its top lies below its bottom.
    """
    trails[:, :, :, 0], trails[:, :, :, 1] = 0, -1
    for i in range(ends.shape[0]):
        for j in range(ends.shape[1]):
            moving = set_out(box_at(targets.lattice, first + i, j), False)
            ends[i, j] = proven_end(targets, moving.all)
            for n in range(IMPACTS):
                if ends[i, j] != UNPROVEN:
                    break
                proven, moving = advance(machine, oscillator, moving)
                if not (proven and width(moving.all.t) < WIDEST):
                    break
                ends[i, j] = proven_end(targets, moving.all)
                span = span_of(targets.lattice, moving.all)
                trails[i, j, n, 0], trails[i, j, n, 1] = span.bottom, span.top
                trails[i, j, n, 2], trails[i, j, n, 3] = span.left, span.right


@kernel_as_written
def grow(ends, rounds, trails, this_round, found):
    """One round: write into `found` the ends of boxes that come to boxes proven before; how many.

    Parameters
    ----------
    ends, found : ndarray of uint16, shape (rows, columns)
        What is proven; what is proven after the round.
    rounds : ndarray of uint16, shape (rows, columns)
        In which round each box was proven; the new ones get `this_round`.
    trails : ndarray of int16, shape (rows, columns, IMPACTS, 4)
    this_round : int

    Returns
    -------
    int
    """
    new = 0
    for i in range(ends.shape[0]):
        for j in range(ends.shape[1]):
            found[i, j] = ends[i, j]
            for n in range(IMPACTS):
                if found[i, j] != UNPROVEN:
                    break
                trail = trails[i, j, n]
                end = end_of_span(ends, Span(int(trail[0]), int(trail[1]), int(trail[2]), int(trail[3])))
                if end != UNPROVEN:
                    found[i, j], rounds[i, j] = end, this_round
                    new += 1
    return new


def grow_all(ends: np.ndarray, rounds: np.ndarray, trails: np.ndarray) -> np.ndarray:
    """All rounds, until one proves nothing new.

    Parameters
    ----------
    ends : ndarray of uint16, shape (rows, columns)
        What is proven before the first round.
    rounds : ndarray of uint16, shape (rows, columns)
        Filled with the round in which each box was proven.
    trails : ndarray of int16, shape (rows, columns, IMPACTS, 4)

    Returns
    -------
    ndarray of uint16, shape (rows, columns)
    """
    this_round, found = 1, np.empty_like(ends)
    while grow(ends, rounds, trails, this_round, found):
        ends, found = found, np.empty_like(ends)
        this_round += 1
    return ends
