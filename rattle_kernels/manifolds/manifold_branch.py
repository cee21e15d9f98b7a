"""A branch of a manifold: its pieces, why it ends, and how far it may grow."""

import math
from enum import StrEnum
from typing import NamedTuple

from rattle_kernels.manifolds.polyline import (
    Piece,
)


class ManifoldEnd(StrEnum):
    """Why a branch stopped growing."""

    ARCLENGTH = "it is as long as asked for"
    POINTS = "it would take more points than allowed"
    FAST = "all the rest is faster than asked for and than the speed of no return"
    SETTLED = "its images shrink to points: it ends in an attracting orbit"
    IMAGES = "its images grow no more: it is captured by ever lower bounces, or its multiplier is next to 1"


class ManifoldBranch(NamedTuple):
    """One of the two halves into which a point of a saddle divides its manifold.

    ``point`` is the index of the point in the orbit. ``side`` is +1 if the branch leaves it towards later phases, else
    -1. ``pieces`` are its smooth arcs, in order from the saddle. ``arclength`` is their total length in the plane (t,
    v/velocity_scale). ``end`` states why there are no more.
    """

    point: int
    side: int
    pieces: tuple[Piece, ...]
    arclength: float
    end: ManifoldEnd


class ManifoldLimits(NamedTuple):
    """How far a manifold may grow.

    Parameters
    ----------
    arclength : float
        Length of each branch in the plane (t, v/velocity_scale), within the velocity limits.
    lowest_velocity, highest_velocity : float
        Lowest and highest speed to keep.
    points : int
        Largest number of points of a branch, and of the image that extends it.
    """

    arclength: float = 20.0
    lowest_velocity: float = 0.0
    highest_velocity: float = math.inf
    points: int = 1_000_000


DEFAULT_LIMITS = ManifoldLimits()


def check_limits(limits: ManifoldLimits) -> ManifoldLimits:
    """Return the limits if they are valid.

    Raises
    ------
    ValueError
        If a limit is not valid. The message names it, its value and what is valid.
    """
    if not (math.isfinite(limits.arclength) and limits.arclength > 0.0):
        raise ValueError(f"arclength must be positive and finite, not {limits.arclength}")
    if not 0.0 <= limits.lowest_velocity < limits.highest_velocity:
        raise ValueError(
            f"velocities must be 0 <= lowest_velocity < highest_velocity, not {limits.lowest_velocity} and "
            f"{limits.highest_velocity}"
        )
    if limits.points < 100:
        raise ValueError(f"points must be at least 100, not {limits.points}")
    return limits
