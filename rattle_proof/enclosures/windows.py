"""Windows: small fine lattices around the departures of attracting orbits, on which what ends in the orbit grows.

A disc is an ellipse that P^p contracts, and may be far smaller than what ends in the orbit around it: the grazing curve
ends it, and a box of the common lattice may not fit into it. So each departure of an orbit has windows, the finest of
boxes of which 32 lie side by side in the disc, each other of boxes four times as long and high. Boxes are followed one
after the other, from the orbit outwards, until all of one lies in the disc, or in boxes of a window that were proven
before. Each carries its number in this order, so no proof rests on itself.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_proof.enclosures.flight import Box
from rattle_proof.enclosures.interval import Interval, width
from rattle_proof.enclosures.lattice import UNPROVEN, find_end_within
from rattle_proof.enclosures.machine import Machine
from rattle_proof.enclosures.moving_set import WIDEST, advance, set_out, strip_of
from rattle_proof.enclosures.orbit_disc import OrbitDisc, disc_rows, lies_in_disc

ACROSS = 128
"""Boxes of a window, each way."""
IMPACTS = 12
"""How many impacts a box is followed at most."""
_IN_A_DISC, _COARSER = 32, 4
# How often boxes are followed in a window at most, and what part of them must be proven anew for once more.
_SWEEPS, _WORTHWHILE = 4, 0.01
# Of boxes whose centres are not found to end in the orbit nothing is tried: periods until then.
_SETTLING, _NEAR = 96, 4.0
# Boxes between two pauses: some 32,768 images; or two million impacts of numbers.
_FOLLOWED_AT_A_TIME, _IMPACTS_AT_A_TIME = 2048, 2**21


class Windows(NamedTuple):
    """Windows n with boxes ``[left + j, left + j + 1]/columns`` by ``[first + i, first + i + 1] height``.

    ``places``, shape (windows, 4), has height, first, columns and left of each; heights and columns are powers of two.
    ``ends[n, i, j]``, uint16, is as that of a lattice, and ``order[n, i, j]``, uint32, says when a box was proven.
    """

    places: np.ndarray
    ends: np.ndarray
    order: np.ndarray


def empty_windows(places: np.ndarray) -> Windows:
    """Windows whose boxes are not proven.

    Parameters
    ----------
    places : ndarray, shape (windows, 4)

    Returns
    -------
    Windows
    """
    shape = len(places), ACROSS, ACROSS
    return Windows(places, np.zeros(shape, np.uint16), np.zeros(shape, np.uint32))


NO_WINDOWS = empty_windows(np.empty((0, 4)))
"""No windows at all."""


@inlined_as_written
def end_in_windows(windows, strip):
    """The end of all departures of a strip, as far as one of the windows knows it."""
    for n in range(windows.places.shape[0]):
        height, first = windows.places[n, 0], int(windows.places[n, 1])
        if not (strip.v.low >= first * height and strip.v.high < (first + windows.ends.shape[1]) * height):
            continue
        columns, left = int(windows.places[n, 2]), int(windows.places[n, 3])
        end = find_end_within(height, first, columns, left, windows.ends[n], strip).end
        if end != UNPROVEN:
            return end
    return UNPROVEN


@kernel_as_written
def _follow(machine, oscillator, disc, windows, boxes, count):
    """Follow boxes, and mark those that come to a disc or to marked ones, with numbers from `count` on: the next."""
    for k in range(boxes.shape[0]):
        n, i, j = boxes[k, 0], boxes[k, 1], boxes[k, 2]
        if windows.ends[n, i, j] != UNPROVEN:
            continue
        place = windows.places[n]
        times = Interval((place[3] + j) / place[2], (place[3] + j + 1.0) / place[2])
        moving = set_out(Box(times, Interval((place[1] + i) * place[0], (place[1] + i + 1.0) * place[0])), False)
        for impact in range(IMPACTS + 1):
            end = int(disc[0]) if lies_in_disc(disc, moving) else end_in_windows(windows, strip_of(moving))
            if end != UNPROVEN:
                windows.ends[n, i, j], windows.order[n, i, j] = end, count
                count += 1
                break
            if impact == IMPACTS:
                break
            proven, moving = advance(machine, oscillator, moving)
            if not (proven and width(moving.all.t) < WIDEST):
                break
    return count


def _with(windows: Windows, places: np.ndarray) -> Windows:
    new = empty_windows(places)
    return Windows(*(np.concatenate(both) for both in zip(windows, new, strict=True)))


def _end_in(
    oscillator: Oscillator, disc: OrbitDisc, orbit: Attractor, t: np.ndarray, v: np.ndarray, pause: Pause
) -> np.ndarray:
    """Which departures end in an orbit, as far as numbers tell."""
    impacts, (near_t, near_v) = _SETTLING * disc.impacts, disc.half_sides
    size = max(1, _IMPACTS_AT_A_TIME // impacts)
    ends = np.zeros(len(t), np.bool_)
    for start in range(0, len(t), size):
        pause()
        run = slice(start, start + size)
        landed = next_impacts(oscillator, t[run], v[run], impacts)
        for time, speed in zip(orbit.time.tolist(), orbit.velocity.tolist(), strict=True):
            off = np.abs((landed.t - time + 0.5) % 1.0 - 0.5)
            ends[run] |= (off < _NEAR * near_t) & (np.abs(landed.v - speed) < _NEAR * near_v)
    return ends


def _promising(
    oscillator: Oscillator, disc: OrbitDisc, orbit: Attractor, windows: Windows, beginning: int, pause: Pause
) -> np.ndarray:
    """Boxes of the windows from `beginning` on whose centres end in an orbit, as far as numbers tell: inner ones first.

    Returns rows of window, row and column.
    """
    boxes = np.argwhere(windows.ends[beginning:] == UNPROVEN) + (beginning, 0, 0)
    window, row, column = boxes.T
    place = windows.places[window]
    low = place[:, 1] + row > 0.0
    t, v = (place[:, 3] + column + 0.5) / place[:, 2], (place[:, 1] + row + 0.5) * place[:, 0]
    boxes = boxes[low][_end_in(oscillator, disc, orbit, t[low] % 1.0, v[low], pause)]
    return boxes[np.argsort(np.abs(boxes[:, 1:] - 0.5 * (ACROSS - 1)).max(1, initial=0.0), kind="stable")]


def grown_windows(
    machine: Machine,
    oscillator: Oscillator,
    discs: Mapping[int, OrbitDisc],
    attractors: Sequence[Attractor],
    coarsest: int,
    pause: Pause = never_stopped,
) -> Windows:
    """Windows around all departures of the orbits that have discs, with what is proven of their boxes.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first, and which boxes are tried. Nothing rests on it.
    discs : mapping of int to OrbitDisc
        By the number of the motion.
    attractors : sequence of Attractor
        Where each stands is its number.
    coarsest : int
        No window has so few columns to the period.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Windows
    """
    windows, count = NO_WINDOWS, 1
    for motion, disc in discs.items():
        orbit, row = attractors[motion], disc_rows({motion: disc})[0]
        near_t, near_v = disc.half_sides
        columns = 2 ** math.ceil(math.log2(_IN_A_DISC / (2.0 * near_t)))
        height = 2.0 ** math.floor(math.log2(2.0 * near_v / _IN_A_DISC))
        while columns > coarsest:
            beginning = len(windows.places)
            corners = np.stack([orbit.velocity / height, orbit.time * columns], axis=1) - ACROSS // 2
            first, left = np.floor(corners).T
            places = [np.full(first.size, height), first, np.full(first.size, float(columns)), left]
            windows = _with(windows, np.stack(places, axis=1))
            boxes = _promising(oscillator, disc, orbit, windows, beginning, pause)
            for _ in range(_SWEEPS):
                before = count
                for start in range(0, len(boxes), _FOLLOWED_AT_A_TIME):
                    pause()
                    here = boxes[start : start + _FOLLOWED_AT_A_TIME]
                    count = _follow(machine, oscillator, row, windows, here, count)
                if count - before <= _WORTHWHILE * len(boxes):
                    break
            columns, height = columns // _COARSER, height * _COARSER
    return windows
