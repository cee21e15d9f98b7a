"""Seeds: one landing point of every box of a coarse lattice, the seeds of a catalogue of attractors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rattle_kernels.attractors.classify import coarser_boxes, landing_boxes
from rattle_kernels.model.oscillator import Oscillator

# Every seed is followed for some thousand impacts: a quarter of a second for this many.
_MOST_SEEDS = 4096


@dataclass(frozen=True)
class Seeds:
    """Landing points, no two in one box; arrays of one length."""

    box: np.ndarray
    time: np.ndarray
    velocity: np.ndarray


def choose_seeds(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> Seeds:
    """The first of some landing points in every box; NaN are passed over."""
    boxes = landing_boxes(oscillator, t.ravel(), v.ravel())
    numbers, first = np.unique(boxes, return_index=True)
    first = first[numbers >= 0]
    return Seeds(numbers[numbers >= 0], t.ravel()[first], v.ravel()[first])


def gather_seeds(parts: Sequence[Seeds]) -> Seeds:
    """The first seed of each box, of boxes so coarse that a few thousand seeds are left.

    Parts come in the order of tiles, so the first is the same whenever its tile was computed. What a thinned crowd of
    seeds misses, landing points that arrive nowhere report when they are named.
    """
    boxes = np.concatenate([part.box for part in parts])
    numbers, first = np.unique(boxes, return_index=True)
    while first.size > _MOST_SEEDS:
        boxes = coarser_boxes(boxes)
        numbers, first = np.unique(boxes, return_index=True)
    times = np.concatenate([part.time for part in parts])
    velocities = np.concatenate([part.velocity for part in parts])
    return Seeds(numbers, times[first], velocities[first])
