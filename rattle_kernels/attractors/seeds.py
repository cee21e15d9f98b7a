"""Scouts: one landing point of every box of a coarse lattice, the seeds of a catalogue of attractors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rattle_kernels.attractors.classify import coarser_boxes, landing_boxes
from rattle_kernels.model.oscillator import Oscillator

# Every scout is followed for some thousand impacts: a quarter of a second for this many.
_MOST_SCOUTS = 4096


@dataclass(frozen=True)
class Scouts:
    """Landing points, no two in one box; arrays of one length."""

    box: np.ndarray
    time: np.ndarray
    velocity: np.ndarray


def choose_scouts(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> Scouts:
    """The first of some landing points in every box; NaN are passed over."""
    boxes = landing_boxes(oscillator, t.ravel(), v.ravel())
    numbers, first = np.unique(boxes, return_index=True)
    first = first[numbers >= 0]
    return Scouts(numbers[numbers >= 0], t.ravel()[first], v.ravel()[first])


def gather_scouts(parts: Sequence[Scouts]) -> Scouts:
    """The first scout of each box, of boxes so coarse that a few thousand scouts are left.

    Parts come in the order of tiles, so the first is the same whenever its tile was computed. What a thinned crowd of
    scouts misses, landing points that arrive nowhere report when they are named.
    """
    boxes = np.concatenate([part.box for part in parts])
    numbers, first = np.unique(boxes, return_index=True)
    while first.size > _MOST_SCOUTS:
        boxes = coarser_boxes(boxes)
        numbers, first = np.unique(boxes, return_index=True)
    times = np.concatenate([part.time for part in parts])
    velocities = np.concatenate([part.velocity for part in parts])
    return Scouts(numbers, times[first], velocities[first])
