"""Seeds of a catalogue of attractors: one landing point from every box of a coarse lattice."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rattle_kernels.attractors.classify import coarser_boxes, landing_boxes
from rattle_kernels.model.oscillator import Oscillator

# Every seed is followed for some thousand impacts. This many take a quarter of a second.
_MOST_SEEDS = 4096


@dataclass(frozen=True)
class Seeds:
    """Landing points, no two in one box; arrays of one length."""

    box: np.ndarray
    time: np.ndarray
    velocity: np.ndarray


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
