"""Sets of boxes that P maps into themselves: who is inside rattles for ever inside, by proof.

A union Q of boxes is grown from boxes that trajectories have visited: every box that may hold an image of Q joins,
until none is new. Where that ends, P(Q) lies in Q. A box whose image touches many boxes is mapped in parts, since the
hull of an image grows with the part: like its root at the graze. Where Q leaks, nothing is proven.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.jit import kernel_as_written
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_proof.enclosures.flight import Box, halves_of_part
from rattle_proof.enclosures.impact import LOST, image
from rattle_proof.enclosures.interval import Interval, middle, point
from rattle_proof.enclosures.lattice import UNPROVEN, Lattice, box_at, empty_lattice, span_of
from rattle_proof.enclosures.machine import Machine

# Columns of the lattices tried.
_LATTICES = 1024, 2048, 4096, 8192
# How often a part of a box is halved at most, and how many boxes its image may touch without.
_DEPTH, _FEW = 12, 9
# By how many boxes a set is made wider, and how often one beside it is halved at most, to show that it comes to it.
_WIDTHS, _SHALLOW, _ROUNDS = (1, 2, 4, 8, 16), 6, 64
# Beside what was visited, by how much of its range of speeds the lattice is higher at either end.
_ROOM = 0.5
# Boxes of a set, at most: a minute's work.
_MOST_BOXES = 2**20
_SEED_IMPACTS = 400
# Departures of the plane of which some rattle on, and after how many impacts they are seeds.
_DRAWN, _SETTLING, _LONG = 20_000, (30, 100), 400
# Boxes between two pauses: some 32,768 images.
_MARKED_AT_A_TIME = 2048


class Search(NamedTuple):
    """What sets are sought for.

    ``oscillator`` is one of the machine's: where roots are sought first. Nothing rests on it. ``slowest`` is a speed
    that all boxes lie above, ``most`` and ``fewest`` how many columns a lattice may have. ``pause`` is called several
    times a second; an exception raised there ends the search.
    """

    machine: Machine
    oscillator: Oscillator
    slowest: float
    most: int
    pause: Pause = never_stopped
    fewest: int = 0


@kernel_as_written
def _all_held(lattice, span):
    """Whether all boxes of a span carry an end."""
    for i in range(span.bottom, span.top + 1):
        for j in range(span.left, span.right + 1):
            if lattice.ends[i, j % lattice.ends.shape[1]] == UNPROVEN:
                return False
    return span.bottom <= span.top


@kernel_as_written
def _come_inside(machine, oscillator, lattice, rows, columns, inside):
    """Which boxes have all their images in boxes that carry an end."""
    waiting = np.empty((_DEPTH + 1, 5))
    for k in range(rows.size):
        whole = box_at(lattice, rows[k], columns[k])
        waiting[0] = whole.t.low, whole.t.high, whole.w.low, whole.w.high, 0.0
        left, inside[k] = 1, True
        while left > 0:
            left -= 1
            part = waiting[left, 0], waiting[left, 1], waiting[left, 2], waiting[left, 3], waiting[left, 4]
            box = Box(Interval(part[0], part[1]), Interval(part[2], part[3]))
            mapped = image(machine, oscillator, Box(point(middle(box.t)), point(middle(box.w))), box)
            if mapped.state != LOST and _all_held(lattice, span_of(lattice, mapped.all)):
                continue
            if part[4] >= _SHALLOW:
                inside[k] = False
                break
            waiting[left], waiting[left + 1] = halves_of_part(part)
            left += 2


@kernel_as_written
def _mark_images(machine, oscillator, lattice, rows, columns, marked):
    """Mark all boxes that images of some boxes may touch; false where one is lost or leaves the lattice."""
    waiting = np.empty((_DEPTH + 1, 5))
    for k in range(rows.size):
        whole = box_at(lattice, rows[k], columns[k])
        waiting[0] = whole.t.low, whole.t.high, whole.w.low, whole.w.high, 0.0
        left = 1
        while left > 0:
            left -= 1
            part = waiting[left, 0], waiting[left, 1], waiting[left, 2], waiting[left, 3], waiting[left, 4]
            box = Box(Interval(part[0], part[1]), Interval(part[2], part[3]))
            mapped = image(machine, oscillator, Box(point(middle(box.t)), point(middle(box.w))), box)
            span = span_of(lattice, mapped.all)
            held = mapped.state != LOST and span.bottom <= span.top
            few = (span.top - span.bottom + 1) * (span.right - span.left + 1) <= _FEW
            if not (held and few) and part[4] < _DEPTH:
                waiting[left], waiting[left + 1] = halves_of_part(part)
                left += 2
                continue
            if not held:
                return False
            for i in range(span.bottom, span.top + 1):
                for j in range(span.left, span.right + 1):
                    marked[i, j % marked.shape[1]] = True
    return True


def _visited(search: Search, lattice: Lattice, t: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Boxes that trajectories visit."""
    rows, columns = lattice.ends.shape
    held = np.zeros((rows, columns), np.bool_)
    for _ in range(_SEED_IMPACTS):
        search.pause()
        i, j = np.floor(v / lattice.height).astype(np.int64) - lattice.first, np.floor(t * columns).astype(np.int64)
        inside = (i >= 0) & (i < rows)
        held[i[inside], j[inside] % columns] = True
        landed = next_impacts(search.oscillator, t, v)
        kept = np.isfinite(landed.t)
        t, v = landed.t[kept], landed.v[kept]
    return held


def _closed(search: Search, lattice: Lattice, held: np.ndarray) -> np.ndarray | None:
    """The boxes with all that their images reach; None if they leave the lattice or are too many."""
    new = held
    while new.any():
        marked = np.zeros_like(held)
        rows, columns = np.nonzero(new)
        if np.count_nonzero(held) > _MOST_BOXES:
            return None
        for start in range(0, rows.size, _MARKED_AT_A_TIME):
            search.pause()
            run = slice(start, start + _MARKED_AT_A_TIME)
            if not _mark_images(search.machine, search.oscillator, lattice, rows[run], columns[run], marked):
                return None
        new = marked & ~held
        held = held | new
    return held


def closed_set(search: Search, t: np.ndarray, v: np.ndarray, end: int) -> Lattice | None:
    """Fewest boxes around trajectories that P maps into themselves, on the first lattice that has such.

    Parameters
    ----------
    search : Search
    t, v : ndarray
        Departures whose trajectories rattle on.
    end : int
        What the boxes are to carry.

    Returns
    -------
    Lattice or None
        None if no lattice tried is fine enough.
    """
    slowest, fastest = float(v.min()), float(v.max())
    room = _ROOM * (fastest - slowest)
    for columns in (each for each in _LATTICES if search.fewest <= each <= search.most):
        height = 2.0 ** math.floor(math.log2(fastest / columns))
        bottom = max(slowest - room, 0.5 * slowest, search.slowest + height)
        lattice = empty_lattice(bottom, fastest + room, columns, height)
        closed = _closed(search, lattice, _visited(search, lattice, t, v))
        if closed is not None:
            lattice.ends[closed] = end
            return lattice
    return None


def rattling_set(search: Search, t: np.ndarray, v: np.ndarray, end: int) -> Lattice | None:
    """The boxes of `closed_set` with as many about them as P maps into themselves, too: motions come to them sooner."""
    lattice = closed_set(search, t, v, end)
    if lattice is None:
        return None
    fewest = lattice.ends != UNPROVEN
    for width in _WIDTHS:
        wider = fewest
        for _ in range(width):
            wider = wider | _beside(wider)
        closed = _closed(search, lattice, wider)
        if closed is None:
            break
        lattice.ends[closed] = end
    _grow(search, lattice, end)
    return lattice


def _beside(held: np.ndarray) -> np.ndarray:
    """Boxes beside those of a set, and some of the set."""
    near = np.roll(held, 1, axis=1) | np.roll(held, -1, axis=1)
    near[1:] |= held[:-1]
    near[:-1] |= held[1:]
    return near


def _grow(search: Search, lattice: Lattice, end: int) -> None:
    """Take in boxes beside the set whose images lie in it, round after round: so P maps it into itself as before."""
    for _ in range(_ROUNDS):
        held = lattice.ends != UNPROVEN
        rows, columns = np.nonzero(_beside(held) & ~held)
        inside = np.empty(rows.size, np.bool_)
        for start in range(0, rows.size, _MARKED_AT_A_TIME):
            search.pause()
            run = slice(start, start + _MARKED_AT_A_TIME)
            _come_inside(search.machine, search.oscillator, lattice, rows[run], columns[run], inside[run])
        if not inside.any():
            return
        lattice.ends[rows[inside], columns[inside]] = end


def wandering(oscillator: Oscillator, fastest: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Departures whose trajectories rattle on for long, as far as numbers tell.

    Parameters
    ----------
    oscillator : Oscillator
    fastest : float
        Speed of the plane that they come from.

    Yields
    ------
    (ndarray, ndarray)
        Times and speeds, after more and more impacts: the later, the fewer are near the edge of a basin.
    """
    random = np.random.default_rng(0)
    t, v = random.random(_DRAWN), fastest * (1.0 - random.random(_DRAWN))
    on = next_impacts(oscillator, t, v, _LONG, shortcuts=True).outcome == Outcome.RETURNED
    for impacts in _SETTLING if on.any() else ():
        landed = next_impacts(oscillator, t[on], v[on], impacts)
        yield landed.t, landed.v
