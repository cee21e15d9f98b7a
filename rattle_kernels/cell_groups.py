"""Group, period and step of every cell, as Hsu (1980, 1987) defines them, from the image set alone.

A cell map sends each cell to one image, so following images from any cell ends on a cycle of cells (a group; its length
is the period) or in a reserved image. The *image set* R, the distinct images of all cells, is closed under the map and
holds every cycle. So `find_groups` runs Hsu's algorithm on R only, which for ``P^k`` with a large k is far smaller than
the grid, and `label_cells` then labels any cells by looking up their images: ``group(c) = group(image(c))``, and
``step(c) = step(image(c)) + 1`` unless c is on a cycle.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.jit import kernel

_UNSEEN = np.int32(-2_000_000_000)
_ON_PATH = np.int32(-2_000_000_001)


class CellGroups(NamedTuple):
    """Hsu's numbers on the image set, arrays of one length.

    ``cells`` (int64, ascending) are the cells of R; ``group`` (int32) is 1, 2, ... by each cycle's lowest cell number,
    0 the sink, -1 permanent contact, -2 undecided; ``period`` (int32) the length of the cycle, 0 where there is none;
    ``step`` (int32) the applications to reach the cycle, 0 on it, or to get into the reserved image.
    """

    cells: np.ndarray
    group: np.ndarray
    period: np.ndarray
    step: np.ndarray


@kernel
def _follow(position, group, period, step):
    """Hsu's pass over cells given by position: `position` is where the image lies, or a reserved negative image.

    Each start walks until it meets its own path (a new cycle), a cell already settled or a reserved image, then settles
    the path backwards. Every cell is walked once.
    """
    path = np.empty(position.size, np.int64)
    arrived = np.empty(position.size, np.int64)
    cycles = 0
    for start in range(position.size):
        length = 0
        here = start
        while here >= 0 and group[here] == _UNSEEN:
            group[here] = _ON_PATH
            arrived[here] = length
            path[length] = here
            length += 1
            here = position[here]
        if here < 0:
            end_group, end_period, end_step = here + 1, 0, 0
        elif group[here] == _ON_PATH:
            # A new cycle: its cells stand at the end of the path.
            cycles += 1
            end_group, end_period, end_step = cycles, length - arrived[here], 0
            for i in range(arrived[here], length):
                group[path[i]], period[path[i]], step[path[i]] = end_group, end_period, 0
            length = arrived[here]
        else:
            end_group, end_period, end_step = group[here], period[here], step[here]
        for i in range(length - 1, -1, -1):
            end_step += 1
            group[path[i]], period[path[i]], step[path[i]] = end_group, end_period, end_step
    return cycles


def _renumber(group: np.ndarray, step: np.ndarray, cycles: int) -> np.ndarray:
    """Number groups by their lowest cell: `group` runs over cells in ascending order, so first sight decides."""
    on_cycle = np.flatnonzero((group > 0) & (step == 0))
    found, first = np.unique(group[on_cycle], return_index=True)
    number = np.arange(cycles + 1, dtype=np.int32)
    number[found[np.argsort(first)]] = np.arange(1, found.size + 1, dtype=np.int32)
    return np.where(group > 0, number[np.maximum(group, 0)], group).astype(np.int32)


def find_groups(cells: np.ndarray, images: np.ndarray) -> CellGroups:
    """Run Hsu's algorithm on the image set.

    Parameters
    ----------
    cells : ndarray of int64, shape (n,)
        The distinct images of all cells that are cell numbers, ascending.
    images : ndarray of int64, shape (n,)
        Their own images: members of `cells`, or SINK, PERMANENT_CONTACT, UNDECIDED.

    Returns
    -------
    CellGroups

    Raises
    ------
    ValueError
        Where `cells` is not ascending or not closed under the map.

    References
    ----------
    Hsu and Guttalu (1980); Hsu, Cell-to-Cell Mapping (1987), Sec. 8.
    """
    cells, images = np.asarray(cells, np.int64), np.asarray(images, np.int64)
    if np.any(np.diff(cells) <= 0):
        raise ValueError("cells must be ascending without repetition")
    position = np.searchsorted(cells, images)
    inside = images >= 0
    if np.any(inside & (cells[np.minimum(position, cells.size - 1)] != images)):
        raise ValueError("the image set is not closed: some image is no member of it")
    position = np.where(inside, position, images)
    group = np.full(cells.size, _UNSEEN, np.int32)
    period, step = np.zeros(cells.size, np.int32), np.zeros(cells.size, np.int32)
    cycles = _follow(position, group, period, step)
    return CellGroups(cells, _renumber(group, step, cycles), period, step)


@kernel
def _label(lookup_start, bucket_bits, cells, groups, own_cells, image_cell, labels):
    group_of, period_of, step_of = groups
    group, period, step = labels
    for i in range(image_cell.size):
        image = image_cell[i]
        if image < 0:
            group[i], period[i], step[i] = image + 1, 0, 1
            continue
        bucket = image >> bucket_bits
        low, high = lookup_start[bucket], lookup_start[bucket + 1]
        while high - low > 1:
            middle = (low + high) >> 1
            if cells[middle] <= image:
                low = middle
            else:
                high = middle
        group[i], period[i], step[i] = group_of[low], period_of[low], step_of[low] + 1
        if step_of[low] == 0:
            step[i] = _step_beside_cycle(own_cells[i], lookup_start, bucket_bits, cells, step_of)


@kernel
def _step_beside_cycle(own, lookup_start, bucket_bits, cells, step_of):
    """Step of a cell whose image lies on a cycle: 0 where it is on the cycle itself, else 1."""
    bucket = own >> bucket_bits
    if bucket >= lookup_start.size - 1:
        return 1
    for at in range(lookup_start[bucket], lookup_start[bucket + 1]):
        if cells[at] == own:
            return 0 if step_of[at] == 0 else 1
    return 1


def _buckets(cells: np.ndarray) -> tuple[np.ndarray, int]:
    """Start of each run of cells that share their upper bits: a coarse index with about as many buckets as cells."""
    last = int(cells[-1]) if cells.size else 0
    bits = max(0, last.bit_length() - max(cells.size, 1).bit_length() - 1)
    edges = np.arange((last >> bits) + 2, dtype=np.int64) << bits
    return np.searchsorted(cells, edges), bits


def label_cells(
    groups: CellGroups, own_cells: np.ndarray, image_cell: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Group, period and step of any cells, by their images.

    Parameters
    ----------
    groups : CellGroups
        Of the whole map.
    own_cells, image_cell : ndarray of int64, one shape
        Cell numbers, and their images.

    Returns
    -------
    group, period, step : ndarray of int32, that shape
    """
    labels = tuple(np.empty(image_cell.size, np.int32) for _ in range(3))
    start, bits = _buckets(groups.cells)
    _label(start, bits, groups.cells, groups[1:], own_cells.ravel(), image_cell.ravel(), labels)
    group, period, step = (label.reshape(image_cell.shape) for label in labels)
    return group, period, step
