"""Where leaves are sought: along the direction that the next few impacts shrink most. Nothing rests on it."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.jacobian import next_impact_with_jacobian
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel
from rattle_proof.chaos.leaves import Leaves
from rattle_proof.enclosures.lattice import Lattice

# Impacts that shrink a leaf, and after how many its image is to be small, in parts of the set's width in time.
_SHRINKING, _LATER, _SMALL = 4, 2, 0.1
# Leaves of a family that is looked at, rows at which one begins, and rows at which a window may end.
_MANY, _BEGINNINGS, _EDGES = 240, 6, 24
_STEEPEST = 2.0
# Half the width of a leaf, and how far leaves are apart at least.
_HALF_WIDTH, _APART = 2.0**-36, 2.0**-32
# Fewer leaves prove nothing.
_FEW = 4


class Numbers(NamedTuple):
    """A map by numbers: where departures come to, and along which ``dt/dv`` it shrinks them most."""

    images: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
    slopes: Callable[[np.ndarray, np.ndarray], np.ndarray]


@kernel
def _slopes(oscillator, t, v, scale, slopes):
    for k in range(t.size):
        tt, tv, vt, vv = 1.0, 0.0, 0.0, 1.0
        x, y = t[k], v[k]
        for _ in range(_SHRINKING):
            landed, by = next_impact_with_jacobian(oscillator, x, y)
            tt, tv, vt, vv = (
                by.tt * tt + by.tv * vt,
                by.tt * tv + by.tv * vv,
                by.vt * tt + by.vv * vt,
                by.vt * tv + by.vv * vv,
            )
            x, y = landed.t, landed.v
        # In units in which the set is as long as it is high.
        tv, vt = scale * tv, vt / scale
        one, both, other = tt * tt + vt * vt, tt * tv + vt * vv, tv * tv + vv * vv
        angle = 0.5 * np.arctan2(2.0 * both, one - other)
        slopes[k] = -np.tan(angle) / scale


def numbers_of(oscillator: Oscillator, scale: float) -> Numbers:
    """P by numbers.

    Parameters
    ----------
    oscillator : Oscillator
    scale : float
        Speed that is as much as a period.

    Returns
    -------
    Numbers
    """

    def images(t: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        landed = next_impacts(oscillator, t, v)
        return landed.t, landed.v

    def slopes(t: np.ndarray, v: np.ndarray) -> np.ndarray:
        found = np.empty(t.size)
        _slopes(oscillator, t, v, scale, found)
        return found

    return Numbers(images, slopes)


class _Family(NamedTuple):
    """Curves t = T(v) along the slopes, arrays of shape (leaves, nodes): times, and where those in the set come to.

    ``later``, shape (2, leaves, nodes), are times and speeds after a few impacts, not numbers outside of the set.
    """

    times: np.ndarray
    held: np.ndarray
    later: np.ndarray


def _family(lattice: Lattice, numbers: Numbers, begin: int, starts: np.ndarray, bottom: int, top: int) -> _Family:
    """Curves that begin at a node at some times, over the nodes from `bottom` to `top`."""
    speeds = (lattice.first + np.arange(bottom, top + 1)) * lattice.height
    times = np.empty((starts.size, speeds.size))
    begin -= bottom
    times[:, begin] = starts
    for way in (1, -1):
        for j in range(begin, speeds.size - 1 if way > 0 else 0, way):
            half = 0.5 * way * lattice.height
            t, v = times[:, j], np.full(starts.size, speeds[j])
            middle = t + half * _bounded(numbers.slopes(t, v))
            times[:, j + way] = t + 2.0 * half * _bounded(numbers.slopes(middle, v + half))
    rows, columns = lattice.ends.shape
    held = np.zeros(times.shape, np.bool_)
    place = np.floor(times * columns).astype(np.int64) % columns
    # A node touches two rows.
    for row in (np.arange(bottom, top + 1), np.arange(bottom, top + 1) - 1):
        held |= (lattice.ends[row.clip(0, rows - 1), place] != 0) & ((row >= 0) & (row < rows))
    t, v = times[held], np.broadcast_to(speeds, times.shape)[held]
    for _ in range(_LATER):
        t, v = numbers.images(t, v)
    later = np.full((2, *times.shape), np.nan)
    later[0][held], later[1][held] = t, v
    return _Family(times, held, later)


def _bounded(slopes: np.ndarray) -> np.ndarray:
    return np.clip(np.nan_to_num(slopes), -_STEEPEST, _STEEPEST)


def _small(lattice: Lattice, family: _Family, nodes: slice = slice(None)) -> np.ndarray:
    """Which leaves end outside of the set at some nodes, and have small images."""
    ends = family.held[:, nodes][:, [0, -1]]
    small: np.ndarray = np.logical_and(family.held[:, nodes].any(axis=1), ~ends.any(axis=1))
    asked = np.flatnonzero(small)
    rows, columns = np.nonzero(lattice.ends)
    sizes = np.ptp(columns) / lattice.ends.shape[1], np.ptp(rows) * lattice.height
    for places, size in zip(family.later[:, asked, nodes], sizes, strict=True):
        small[asked] &= np.nanmax(places, axis=1) - np.nanmin(places, axis=1) < _SMALL * size
    return small


class _Window(NamedTuple):
    """Curves that begin at a node from one time to another, from a node below to one above; and how much they hold."""

    held: int
    begin: int
    early: float
    late: float
    bottom: int
    top: int


def _windows(lattice: Lattice, family: _Family, begin: int) -> Iterator[_Window]:
    """Windows that the set does not leave above or below."""
    rows = np.flatnonzero((lattice.ends != 0).any(axis=1))
    height, width = lattice.ends.shape
    edges = np.unique(np.linspace(rows[0] - 1, rows[-1] + 2, _EDGES).astype(int).clip(0, height))
    # In which gap of the set a leaf is: by how many of the row's boxes in the set lie before it.
    before = np.concatenate([np.zeros((height, 1), int), np.cumsum(lattice.ends != 0, axis=1)], axis=1)
    places = (family.times.clip(0.0, 1.0) * width).astype(int)
    for bottom in edges[edges < begin]:
        for top in edges[edges > begin]:
            touched = ((bottom, bottom), (bottom - 1, bottom), (top, top), (top - 1, top))
            gaps = [before[min(max(row, 0), height - 1), places[:, node]] for row, node in touched]
            small = _small(lattice, family, slice(bottom, top + 1))
            starts = np.flatnonzero(np.any(np.diff(gaps, axis=1, prepend=-1) != 0, axis=0))
            for start, stop in zip(starts, [*starts[1:], len(small)], strict=True):
                good = np.flatnonzero(small[start:stop]) + start
                if good.size > _FEW:
                    held = int(family.held[good, bottom : top + 1].sum())
                    ends = family.times[good[[0, -1]], begin]
                    yield _Window(held, int(begin), float(ends[0]), float(ends[1]), int(bottom), int(top))


def leaves_across(lattice: Lattice, numbers: Numbers, count: int) -> Iterator[Leaves]:
    """Leaves across a set, in windows that hold much of it, the most first.

    Parameters
    ----------
    lattice : Lattice
        Whose boxes with an end are the set.
    numbers : Numbers
    count : int
        How many leaves are tried in a window.

    Yields
    ------
    Leaves
    """
    rows, columns = np.nonzero(lattice.ends)
    starts = np.linspace(columns.min() / lattice.ends.shape[1], (columns.max() + 1) / lattice.ends.shape[1], _MANY)
    found: list[_Window] = []
    for begin in np.quantile(rows, (np.arange(_BEGINNINGS) + 0.5) / _BEGINNINGS).astype(int):
        found += _windows(lattice, _family(lattice, numbers, begin, starts, 0, lattice.ends.shape[0]), begin)
    for each in sorted(found, reverse=True):
        starts = np.linspace(each.early, each.late, count)
        family = _family(lattice, numbers, each.begin, starts, each.bottom, each.top)
        chosen: list[np.ndarray] = []
        for times in family.times[_small(lattice, family)]:
            if not chosen or (times - chosen[-1] > _APART).all():
                chosen.append(times)
        if len(chosen) > _FEW:
            yield Leaves(np.array(chosen), lattice.first + each.bottom, lattice.height, _HALF_WIDTH)
