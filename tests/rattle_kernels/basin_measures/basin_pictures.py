"""Basins whose measures are known: half planes, discs, noise, Cantor's middle thirds."""

import numpy as np


def centres(cells, columns=None):
    """Row and column coordinates of cell centres in a unit square."""
    return np.meshgrid((np.arange(cells) + 0.5) / cells, (np.arange(columns or cells) + 0.5) / cells, indexing="ij")


def half_plane(cells, slope):
    """Cells below a line of some slope through the middle."""
    v, t = centres(cells)
    return (v - 0.5 < slope * (t - 0.5)).astype(np.int64)


def disc(cells, radius):
    v, t = centres(cells)
    return (np.hypot(v - 0.5, t - 0.5) < radius).astype(np.int64)


def noise(shape, motions, seed=0):
    return np.random.default_rng(seed).integers(0, motions, shape)


def cantor(levels):
    """Levels of the middle thirds: the gap of level i is i, what is left in the end is `levels`; 3^levels cells."""
    row = np.full(3**levels, levels)
    for level in reversed(range(levels)):
        length = 3 ** (levels - level)
        for start in range(0, row.size, length):
            row[start + length // 3 : start + 2 * length // 3] = level
    for level in range(levels):  # a gap within a gap is none
        length = 3 ** (levels - level)
        for start in range(0, row.size, length):
            middle = slice(start + length // 3, start + 2 * length // 3)
            row[middle] = np.minimum(row[middle], level)
    return row
