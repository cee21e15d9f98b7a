"""Henon's map with his parameters, by numbers and by intervals of NumPy; and a set that it maps into itself.

Coordinates are ``x = 4 t - 2`` and ``y = (v - 2)/4``: so the attractor has times within a period and speeds above 0.
"""

import numpy as np

from rattle_proof.chaos.leaf_search import Numbers
from rattle_proof.enclosures.lattice import Lattice

_A, _B = 1.4, 0.3


class Intervals:
    """Arrays of intervals: each operation rounds to nearest, and then moves to the next numbers outwards."""

    __array_ufunc__ = None  # arrays leave it to this class

    def __init__(self, low, high):
        self.low, self.high = low, high

    def __add__(self, other):
        other = intervals(other)
        return _outwards(self.low + other.low, self.high + other.high)

    def __neg__(self):
        return Intervals(-self.high, -self.low)

    def __sub__(self, other):
        return self + -intervals(other)

    def __rsub__(self, other):
        return intervals(other) + -self

    def __mul__(self, other):
        other = intervals(other)
        products = [one * two for one in (self.low, self.high) for two in (other.low, other.high)]
        return _outwards(np.minimum.reduce(products), np.maximum.reduce(products))

    __radd__, __rmul__ = __add__, __mul__

    def square(self):
        most = np.maximum(self.low**2, self.high**2)
        least = np.where((self.low < 0.0) & (self.high > 0.0), 0.0, np.minimum(self.low**2, self.high**2))
        return _outwards(least, most)

    @property
    def middle(self):
        return 0.5 * (self.low + self.high)


def _outwards(low, high):
    return Intervals(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))


def intervals(x):
    return x if isinstance(x, Intervals) else Intervals(np.asarray(x, float), np.asarray(x, float))


# 1.4 and 0.3 are no doubles.
_OF_A, _OF_B = _outwards(np.float64(_A), np.float64(_A)), _outwards(np.float64(_B), np.float64(_B))


def image(t, v):
    """Henon's map, of numbers or of intervals."""
    if isinstance(t, Intervals):
        x, y = 4.0 * t - 2.0, 0.25 * v - 0.5
        return 0.25 * (3.0 - _OF_A * x.square() + y), 4.0 * (_OF_B * x) + 2.0
    x, y = 4.0 * t - 2.0, 0.25 * v - 0.5
    return 0.25 * (3.0 - _A * x * x + y), 4.0 * _B * x + 2.0


def _slopes(t, v):
    """Along which dt/dv four iterates shrink most."""
    product = np.broadcast_to(np.eye(2), (*t.shape, 2, 2))
    for _ in range(4):
        step = np.zeros((*t.shape, 2, 2))
        step[..., 0, 0], step[..., 0, 1], step[..., 1, 0] = -2.0 * _A * (4.0 * t - 2.0), 1.0 / 16.0, 16.0 * _B
        product = step @ product
        t, v = image(t, v)
    squares = np.swapaxes(product, -1, -2) @ product
    return -np.tan(0.5 * np.arctan2(2.0 * squares[..., 0, 1], squares[..., 0, 0] - squares[..., 1, 1]))


NUMBERS = Numbers(image, _slopes)


def follow(pieces, half_width, impacts):
    """Enclose images of pieces of leaves, as `rattle_proof.chaos.crossings.Following` says."""
    below, above, low, high = pieces.T
    hulls = np.empty((len(pieces), impacts, 4))
    # Heights are powers of two, so nothing is rounded in 1/height.
    slope = (intervals(above) - below) * (1.0 / (high - low))
    v = 0.5 * (low + high)
    exact = slope * (v - low) + below
    t = exact.middle
    d_t, d_v = Intervals(0.0 * t - half_width, 0.0 * t + half_width), Intervals(low - v, high - v)
    (tt, tv), (vt, vv) = (intervals(1.0 + 0.0 * t), slope), (intervals(0.0 * t), intervals(1.0 + 0.0 * t))
    rest_t, rest_v = exact - t, intervals(0.0 * t)
    times = Intervals(np.minimum(below, above) - 2.0 * half_width, np.maximum(below, above) + 2.0 * half_width)
    for n in range(impacts):
        whole = Intervals(np.minimum(times.low, t), np.maximum(times.high, t))
        by_t = -2.0 * _OF_A * (4.0 * whole - 2.0)
        by_v, back = intervals(1.0 / 16.0 + 0.0 * t), 16.0 * _OF_B + 0.0 * t
        to_t, to_v = image(intervals(t), intervals(v))
        t, v = to_t.middle, to_v.middle
        rest_t, rest_v = by_t * rest_t + by_v * rest_v + (to_t - t), back * rest_t + (to_v - v)
        (tt, tv), (vt, vv) = (by_t * tt + by_v * vt, by_t * tv + by_v * vv), (back * tt, back * tv)
        times, speeds = tt * d_t + tv * d_v + rest_t + t, vt * d_t + vv * d_v + rest_v + v
        hulls[:, n] = np.stack([times.low, times.high, speeds.low, speeds.high], axis=1)
    return hulls


def closed_boxes(columns, parts=4):
    """Boxes around the attractor that the map takes into themselves."""
    height = 4.0 / columns
    held = np.zeros((columns, columns), np.bool_)
    t, v = np.full(2000, 0.5) + np.linspace(-0.02, 0.02, 2000), np.full(2000, 2.0)
    for n in range(300):
        t, v = image(t, v)
        if n > 30:
            held[np.floor(v / height).astype(int), np.floor(t * columns).astype(int)] = True
    new = held
    while new.any():
        rows, places = np.nonzero(new)
        marked = np.zeros_like(held)
        for i in range(parts):
            for j in range(parts):
                times = Intervals((places + j / parts) / columns, (places + (j + 1) / parts) / columns)
                to_t, to_v = image(times, Intervals((rows + i / parts) * height, (rows + (i + 1) / parts) * height))
                bottom, top = (np.floor(end / height).astype(int) for end in (to_v.low, to_v.high))
                left, right = (np.floor(end * columns).astype(int) for end in (to_t.low, to_t.high))
                for up in range((top - bottom).max() + 1):
                    for along in range((right - left).max() + 1):
                        marked[np.minimum(bottom + up, top), np.minimum(left + along, right)] = True
        new = marked & ~held
        held |= new
    return Lattice(height, 0, held.astype(np.uint16))
