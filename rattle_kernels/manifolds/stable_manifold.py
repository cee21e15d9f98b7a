"""One-dimensional stable and unstable manifolds of saddles of the impacting model (Sec. 6.2, Figs. 15-17).

A branch starts along the eigenvector with a fundamental domain: the chord from a point close to the saddle to its image
under ``F = P^-p`` (stable manifold) or ``F = P^p`` (unstable). If the multiplier is negative the power is doubled, so
that F keeps to one side of the saddle. The images of that chord under F, F^2, ... follow each other without gaps and
form the branch. `curve_images` refines each: a new point starts from a chord of ancestors that is straight to rounding.

Man1D (Krauskopf & Osinga), which the paper used, adds points at the end of the branch one by one. Each is the image of
a point interpolated on the polyline so far. Here only the choice of points follows Man1D: a bound on chords and one on
angles (not applied where one image continues another). Mapping ancestors instead costs about five applications of F per
point, of 0.25 to 0.5 microseconds each. Rounding is then the only error, which F shrinks across the manifold, and
corners are found where they are. (A polyline of chord h and angle alpha is off by h alpha/8; at a graze the square root
of that would show.)
"""

import math
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.flights import BACKWARDS, FORWARDS
from rattle_kernels.manifolds.curve_images import (
    LARGEST_POWER,
    CurveMap,
    CurvePoints,
    drop_fast,
    first_points,
    forget_ancestors,
    map_curve_points,
    next_image,
)
from rattle_kernels.manifolds.grazing_preimages import speed_of_no_return
from rattle_kernels.manifolds.polyline import (
    DEFAULT_RESOLUTION,
    CurveResolution,
    Piece,
    arclength,
    check_resolution,
    chord_lengths,
    clip_velocity,
    cut_at_arclength,
    split_at_corners,
)
from rattle_kernels.manifolds.saddle import check_saddle, directions
from rattle_kernels.model.domain import check_invertible
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit


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


# Distance from the saddle to the far end of the fundamental domain: the manifold is 5e-15 times its curvature off its
# tangent there. Next to a graze the curvature is large, and the multiplier too, so fixing the near end will not do.
_START = 1e-7
# A branch whose image has shrunk to this length has ended.
_SETTLED = 1e-8
_MOST_IMAGES = 2000


def _appended(branch: CurvePoints, image: CurvePoints) -> CurvePoints:
    """Append the next image to the branch. It begins where the branch ends unless fast parts were dropped."""
    image = image._replace(t=image.t[-1:], v=image.v[-1:])
    if branch.t[0, -1] == image.t[0, 0] and branch.v[0, -1] == image.v[0, 0]:
        branch.joined[-1] = image.joined[0]
        image = image.at(slice(1, None))
    return CurvePoints(*(np.concatenate(pair, axis=-1) for pair in zip(branch, image, strict=True)))


def _length_within(image: CurvePoints, limits: ManifoldLimits, velocity_scale: float) -> float:
    """Length of an image between the velocity limits, accurate to about a chord at each crossing."""
    t, v = image.t[-1], image.v[-1]
    within = image.joined[:-1] & (v[:-1] >= limits.lowest_velocity) & (v[:-1] <= limits.highest_velocity)
    return float(chord_lengths(t, v, velocity_scale)[within].sum())


def _next_that_fits(
    curve_map: CurveMap, image: CurvePoints, resolution: CurveResolution, most_points: int
) -> tuple[CurvePoints | None, bool]:
    """The next image, or that of the first half, quarter, ... within the bound on points; whether it is whole."""
    following = next_image(curve_map, image, resolution, most_points)
    whole = following is not None
    while following is None and image.corner.size > 2:
        half = image.at(slice(0, image.corner.size // 2 + 1))
        image = half._replace(joined=half.joined & (np.arange(half.corner.size) < half.corner.size - 1))
        following = next_image(curve_map, image, resolution, most_points)
    return following, whole


class _Growth(NamedTuple):
    """The branch so far, the image to map next, the length, and why the branch ends (None if it goes on)."""

    branch: CurvePoints
    image: CurvePoints
    length: float
    end: ManifoldEnd | None


def _grow(curve_map: CurveMap, growth: _Growth, limits: ManifoldLimits, resolution: CurveResolution) -> _Growth:
    """Extend the branch by one image."""
    scale = curve_map.velocity_scale
    image, whole = _next_that_fits(curve_map, growth.image, resolution, limits.points)
    if image is None:
        return growth._replace(end=ManifoldEnd.POINTS)
    if curve_map.direction == BACKWARDS:
        image = drop_fast(image, max(limits.highest_velocity, speed_of_no_return(curve_map.oscillator)))
    if not image.corner.size:
        return growth._replace(end=ManifoldEnd.FAST)
    branch = _appended(growth.branch, image)
    length = growth.length + _length_within(image, limits, scale)
    end = None
    if length >= limits.arclength:
        end = ManifoldEnd.ARCLENGTH
    elif not whole or branch.corner.size > limits.points:
        end = ManifoldEnd.POINTS
    elif chord_lengths(image.t[-1], image.v[-1], scale)[image.joined[:-1]].sum() < _SETTLED:
        end = ManifoldEnd.SETTLED
    return _Growth(branch, forget_ancestors(image, scale), length, end)


def _begin(curve_map: CurveMap, saddle: np.ndarray, first_step: np.ndarray) -> _Growth:
    """Begin with the chord from the saddle to a point close to it, and the chord from there to its image under F."""
    near = saddle + first_step
    image = map_curve_points(curve_map, first_points(*near[:, None]))
    domain = first_points(image.t[:, 0], image.v[:, 0])
    return _Growth(_appended(first_points(*np.column_stack([saddle, near])), domain), domain, 0.0, None)


def _branch(
    curve_map: CurveMap,
    saddle: np.ndarray,
    first_step: np.ndarray,
    limits: ManifoldLimits,
    resolution: CurveResolution,
) -> tuple[tuple[Piece, ...], ManifoldEnd]:
    """Pieces of the branch that begins with a step away from a point of a saddle, and why it ends."""
    growth = _begin(curve_map, saddle, first_step)
    for _ in range(_MOST_IMAGES):
        growth = _grow(curve_map, growth, limits, resolution)
        if growth.end is not None:
            break
    branch = growth.branch
    pieces = split_at_corners(branch.t[0], branch.v[0], branch.corner, branch.joined)
    kept = clip_velocity(pieces, limits.lowest_velocity, limits.highest_velocity)
    return cut_at_arclength(kept, limits.arclength, curve_map.velocity_scale), growth.end or ManifoldEnd.IMAGES


def _manifold(
    oscillator: Oscillator,
    orbit: PeriodicOrbit,
    sense: float,
    limits: ManifoldLimits,
    resolution: CurveResolution,
    only: tuple[int, int] | None,
    pause: Pause,
) -> tuple[ManifoldBranch, ...]:
    checked, orbit = check_invertible(oscillator), check_saddle(orbit)
    limits, resolution = check_limits(limits), check_resolution(resolution)
    scale = largest_grazing_speed(checked)
    flips = bool(min(orbit.multipliers.real) < 0.0)
    power = orbit.upper_contacts * (2 if flips else 1)
    if power > LARGEST_POWER:
        raise ValueError(f"P^{power} maps {orbit.name} along its manifold: at most P^{LARGEST_POWER} is computed")
    turns = sense * orbit.forcing_periods * (2 if flips else 1)
    curve_map = CurveMap(checked, sense, power, turns, scale, pause=pause)
    branches = []
    for point in range(orbit.upper_contacts):
        local = directions(orbit, point, scale)
        stretch = local.unstable_multiplier if sense == FORWARDS else 1.0 / local.stable_multiplier
        direction = local.unstable if sense == FORWARDS else local.stable
        first_step = direction * _START / (stretch * stretch if flips else stretch)
        for side in (1, -1):
            if only not in (None, (point, side)):
                continue
            saddle = np.array([orbit.t[point], orbit.v[point]])
            pieces, end = _branch(curve_map, saddle, side * first_step, limits, resolution)
            branches.append(ManifoldBranch(point, side, pieces, arclength(pieces, scale), end))
    return tuple(branches)


def stable_manifold(
    oscillator: Oscillator,
    saddle: PeriodicOrbit,
    limits: ManifoldLimits = DEFAULT_LIMITS,
    resolution: CurveResolution = DEFAULT_RESOLUTION,
    only: tuple[int, int] | None = None,
    pause: Pause = never_stopped,
) -> tuple[ManifoldBranch, ...]:
    """Stable manifold of a saddle: the departures that tend to it under P. It is grown by the inverse of P.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    saddle : PeriodicOrbit
        From `find_saddle`.
    limits : ManifoldLimits
        How far each branch may grow.
    resolution : CurveResolution
        Speeds are in units of the largest v*.
    only : (int, int), optional
        Point and side of a single branch to grow. All branches by default.
    pause : callable
        Called before every image of a branch. To stop the work, raise an exception there.

    Returns
    -------
    tuple of ManifoldBranch
        Two for each point of the orbit.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map, or its stiffness is finite.
    NotASaddle
        If the orbit is not a saddle.
    ValueError
        If another argument is not valid.

    References
    ----------
    Sec. 6.2, Figs. 15-17. Krauskopf, Osinga: Growing 1D and quasi-2D unstable manifolds of maps. J. Comput. Phys. 146,
    404 (1998). England, Krauskopf, Osinga: Computing one-dimensional stable manifolds and stable sets of planar maps
    without the inverse. SIAM J. Appl. Dyn. Syst. 3, 161 (2004).
    """
    return _manifold(oscillator, saddle, BACKWARDS, limits, resolution, only, pause)


def unstable_manifold(
    oscillator: Oscillator,
    saddle: PeriodicOrbit,
    limits: ManifoldLimits = DEFAULT_LIMITS,
    resolution: CurveResolution = DEFAULT_RESOLUTION,
    only: tuple[int, int] | None = None,
    pause: Pause = never_stopped,
) -> tuple[ManifoldBranch, ...]:
    """Unstable manifold of a saddle: the departures that tend to it under the inverse of P. It is grown by P.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    saddle : PeriodicOrbit
        From `find_saddle`.
    limits : ManifoldLimits
        How far each branch may grow.
    resolution : CurveResolution
        Speeds are in units of the largest v*.
    only : (int, int), optional
        Point and side of a single branch to grow. All branches by default.
    pause : callable
        Called before every image of a branch. To stop the work, raise an exception there.

    Returns
    -------
    tuple of ManifoldBranch
        Two for each point of the orbit.

    Raises
    ------
    OutsideDomain, NotASaddle, ValueError
        As for `stable_manifold`.
    """
    return _manifold(oscillator, saddle, FORWARDS, limits, resolution, only, pause)
