"""What lanes need of traps (`attractors.trapping_region`): which may be near, and whether a point is inside.

Each orbit has one trap, around its slowest point. A lattice over the plane gives the orbit's point that is probably the
nearest, and so the number of impacts after which the trajectory is checked. That is a hint only: a wrong one costs time
and nothing else.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import part_turn

DEGREE = 8
POWERS = tuple((n + k, k) for n in range(1, DEGREE + 1) for k in range(DEGREE) if 3 <= n + 2 * k <= DEGREE)
"""Powers (j, k) of z and its conjugate in V, j > k, in order of j - k."""
_TURNS = tuple(j - k for j, k in POWERS)
_RIGHT = tuple(k for _, k in POWERS)
TERMS = len(POWERS)
NOWHERE = -1


class LaneTraps(NamedTuple):
    """Traps of some orbits, numbered in order.

    The lattice: ``nearest`` (rows, columns) is the number of the orbit point that is probably near, NOWHERE for none;
    ``top`` is the speed that its rows reach. Every orbit point, orbit by orbit: its ``orbit``, ``place`` on it,
    ``time`` and ``speed``; ``stretch`` is the largest distance from it at which a point of the trap arrives, in units
    of |z|. Every orbit: its ``first`` point, ``period``, ``rate`` of ln V per turn, ``frame`` (4), which takes (dt, dv)
    to the parts of z, ``radius`` and ``level`` of the trap, ``floor`` of V/|z|^2, ``real`` and ``imaginary`` parts of c
    (TERMS).
    """

    nearest: np.ndarray
    top: float
    orbit: np.ndarray
    place: np.ndarray
    time: np.ndarray
    speed: np.ndarray
    stretch: np.ndarray
    first: np.ndarray
    period: np.ndarray
    rate: np.ndarray
    frame: np.ndarray
    radius: np.ndarray
    level: np.ndarray
    floor: np.ndarray
    real: np.ndarray
    imaginary: np.ndarray


def _no_traps() -> LaneTraps:
    whole, real, terms = np.empty(0, np.int64), np.empty(0), np.empty((0, TERMS))
    return LaneTraps(
        np.full((1, 1), NOWHERE, np.int32), 0.0, whole, whole, real, real, real, whole, whole, real,
        np.empty((0, 4)), real, real, real, terms, terms,
    )  # fmt: skip


NO_TRAPS = _no_traps()


@inlined
def nearest_point(nearest, top, phase, speed):
    """Number of the orbit point that is probably near, NOWHERE for none."""
    if not speed < top:
        return NOWHERE
    rows, columns = nearest.shape
    row, column = int(speed / top * rows), int(phase * columns)
    return int(nearest[min(row, rows - 1), min(column, columns - 1)])


@inlined
def potential(real, imaginary, x, y):
    """V at z = x + iy."""
    square = x * x + y * y
    total, cosine, sine, n = square, 1.0, 0.0, 0
    for m in range(TERMS):
        while n < _TURNS[m]:  # the next power of z
            cosine, sine, n = cosine * x - sine * y, cosine * y + sine * x, n + 1
        total += square ** _RIGHT[m] * (real[m] * cosine - imaginary[m] * sine)
    return total


@inlined
def potential_in(traps, orbit, phase, speed):
    """V of a point inside the trap of an orbit, NaN outside."""
    point = traps.first[orbit]
    dt, dv = part_turn(phase - traps.time[point]), speed - traps.speed[point]
    frame = traps.frame[orbit]
    x, y = frame[0] * dt + frame[1] * dv, frame[2] * dt + frame[3] * dv
    if not math.hypot(x, y) <= traps.radius[orbit]:
        return math.nan
    value = potential(traps.real[orbit], traps.imaginary[orbit], x, y)
    return value if value < traps.level[orbit] else math.nan
