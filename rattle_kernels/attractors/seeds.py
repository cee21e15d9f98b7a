"""Seeds of a catalogue of attractors: one landing point from every box of a coarse lattice."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator

# Every seed is followed for some thousand impacts. This many take a quarter of a second.
_MOST_SEEDS = 4096
_LATTICE = 512


@dataclass(frozen=True)
class Seeds:
    """Landing points, no two in one box; arrays of one length."""

    box: np.ndarray
    time: np.ndarray
    velocity: np.ndarray


def landing_boxes(oscillator: Oscillator, t: np.typing.ArrayLike, v: np.typing.ArrayLike) -> np.ndarray:
    """Box of each landing point in a coarse lattice: 512 boxes to a period and to the largest grazing speed.

    One landing point from every box suffices to seed a catalogue, however many cells there are.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : array_like, shape (n,)
        Landing points; NaN for a cell that has none.

    Returns
    -------
    ndarray of int64, shape (n,)
        Box numbers, -1 for NaN.
    """
    scale = largest_grazing_speed(check_oscillator(oscillator))
    times, speeds = np.asarray(t, np.float64), np.asarray(v, np.float64)
    known = np.isfinite(times) & np.isfinite(speeds)
    columns = np.minimum((np.where(known, times, 0.0) * _LATTICE).astype(np.int64), _LATTICE - 1)
    rows = (np.where(known, speeds, 0.0) / scale * _LATTICE).astype(np.int64)
    return np.where(known, rows * _LATTICE + columns, -1)


def coarser_boxes(boxes: np.ndarray) -> np.ndarray:
    """Boxes of the next coarser lattice, with half as many each way, that contain given boxes.

    Parameters
    ----------
    boxes : ndarray of int64, shape (n,)
        Numbers from `landing_boxes` or from this function; not negative.

    Returns
    -------
    ndarray of int64, shape (n,)
    """
    rows, columns = np.divmod(boxes, _LATTICE)
    return rows // 2 * _LATTICE + columns // 2


def choose_seeds(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> Seeds:
    """The first landing point in every box; NaN are skipped."""
    boxes = landing_boxes(oscillator, t.ravel(), v.ravel())
    numbers, first = np.unique(boxes, return_index=True)
    first = first[numbers >= 0]
    return Seeds(numbers[numbers >= 0], t.ravel()[first], v.ravel()[first])


def gather_seeds(parts: Sequence[Seeds], most: int = _MOST_SEEDS) -> Seeds:
    """The first seed of each box. Boxes are coarsened until at most a few thousand seeds remain, or as many as asked.

    Parts are in the order of tiles, so the first seed does not depend on when its tile was computed. Attractors that
    the thinned seeds miss show up when landing points are named, as unassigned points.
    """
    boxes = np.concatenate([part.box for part in parts])
    numbers, first = np.unique(boxes, return_index=True)
    while first.size > most:
        boxes = coarser_boxes(boxes)
        numbers, first = np.unique(boxes, return_index=True)
    times = np.concatenate([part.time for part in parts])
    velocities = np.concatenate([part.velocity for part in parts])
    return Seeds(numbers, times[first], velocities[first])
