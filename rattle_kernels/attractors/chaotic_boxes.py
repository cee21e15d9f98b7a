"""The boxes by which a chaotic motion is recognised: those that its points and their images hit.

A million departures mark them. The ensemble that finds the motion has flown most often through just these, from one of
its points to the next, and has noted the boxes on the way (`chaotic_transient`).
"""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.lanes.arrival import boxes_passed
from rattle_kernels.lanes.batch import Rules
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.lanes.traps import NO_TRAPS
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel

IMAGES = 256
"""Departures that each point of a chaotic motion marks boxes with: itself and its next images."""

_SAME_PART = 0.1


@dataclass(frozen=True)
class _Passed:
    """Boxes noted before, None if they were not: no part of a cache's key."""

    boxes: np.ndarray | None = field(default=None, compare=False)


@kernel
def _highest(box, columns):
    """Highest number in some columns of ``box``: those of captured trajectories hold anything."""
    highest = np.int64(0)
    for leg in range(box.shape[0]):
        for column in columns:
            for number in box[leg, column]:
                highest = max(highest, number)
    return highest


@kernel
def _mark(box, columns, marked):
    """Mark what some columns of ``box`` (legs, columns, images) hold; return whether no image is missing."""
    whole = True
    for leg in range(box.shape[0]):
        for column in columns:
            for number in box[leg, column]:
                if number >= 0:
                    marked[number] = True
                else:
                    whole = False
    return whole


def _distinct(box: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, bool]:
    """Numbers of the boxes in some columns, ascending, and whether no image is missing."""
    marked = np.zeros(_highest(box, columns) + 1, np.bool_)
    whole = _mark(box, columns, marked)
    return np.flatnonzero(marked), whole


def fly_and_note(
    oscillator: Oscillator, rules: Rules, t: np.ndarray, v: np.ndarray, rows: np.ndarray, visits: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Apply P leg by leg, and note where legs begin and which boxes are passed.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    rules : Rules
        Of each leg.
    t, v : ndarray of float64, shape (n,)
        Departures. They become where those land that return: to the bit what `run_lanes` says, leg by leg.
    rows : ndarray of int64, shape (n,)
        Row of `visits` and of the boxes for each.
    visits : ndarray of float64, shape (legs, 2, rows)
        Becomes phase and speed at the beginning of each leg that is begun.

    Returns
    -------
    kept : ndarray of bool, shape (n,)
        Which departures are not captured.
    box : ndarray of int64, shape (legs, rows, IMAGES)
        Numbers of boxes, negative after a capture or a lock. Rows that are nobody's hold anything.
    """
    legs, _, width = visits.shape
    box, kept = np.empty(legs * width * IMAGES + 1, np.int64), np.zeros(t.size, np.bool_)
    boxes_passed(oscillator, lane_tables(oscillator), rules, NO_TRAPS, t, v, kept, rows, visits, box)
    return kept, box[:-1].reshape(legs, width, IMAGES)


def keep_boxes(oscillator: Oscillator, t: np.ndarray, v: np.ndarray, box: np.ndarray, lanes: np.ndarray) -> None:
    """Remember the boxes that a chaotic motion hits, as noted on the way from point to point.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : ndarray of float64, shape (points,)
        Points of the motion.
    box : ndarray of int64, shape (legs, rows, IMAGES)
        From `fly_and_note`.
    lanes : ndarray of int64
        The rows that belong to the points.
    """
    boxes, whole = _distinct(box, lanes)
    if whole:
        _boxes(oscillator, t.tobytes(), v.tobytes(), _Passed(boxes))


@lru_cache(maxsize=16)
def _boxes(oscillator: Oscillator, times: bytes, speeds: bytes, passed: _Passed) -> np.ndarray:
    if passed.boxes is not None:
        return passed.boxes
    t, v = np.frombuffer(times).copy(), np.frombuffer(speeds).copy()
    rows = np.arange(t.size)
    # Without shortcuts: low bounces mark their boxes, too.
    rules = Rules(IMAGES - 1.0, 0.0, -1.0)
    _, box = fly_and_note(oscillator, rules, t, v, rows, np.empty((1, 2, t.size)))
    return _distinct(box, rows)[0]


def marked_boxes(oscillator: Oscillator, times: bytes, speeds: bytes) -> np.ndarray:
    """Numbers of the boxes that the points of a chaotic motion and their images hit; found once per process.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    times, speeds : bytes
        The points, as `ndarray.tobytes` gives them.

    Returns
    -------
    ndarray of int64, ascending
    """
    return _boxes(oscillator, times, speeds, _Passed())


def hit_the_same_boxes(oscillator: Oscillator, one: Attractor, other: Attractor) -> bool:
    """Whether two chaotic motions are one: they share more than a tenth of the boxes of the smaller one.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    one, other : Attractor
        Chaotic motions.

    Returns
    -------
    bool
    """
    some, others = (marked_boxes(oscillator, each.time.tobytes(), each.velocity.tobytes()) for each in (one, other))
    return np.intersect1d(some, others).size > _SAME_PART * min(some.size, others.size)
