"""Stable and unstable manifolds of saddles of the impacting model, one-dimensional (Sec. 6.2, Figs. 15-17).

A branch starts along the eigenvector, with a fundamental domain: the chord from a point close to the saddle to its
image under ``F = P^-p`` (stable manifold) or ``F = P^p`` (unstable); twice the power where the multiplier is negative,
so that F keeps to one side of the saddle. The images of that chord under F, F^2, ... follow each other without gaps and
are the branch. Each is refined by `curve_images`: a new point starts from ancestors that are straight to rounding.

Man1D (Krauskopf & Osinga), which the paper used, adds points at the end of the branch one by one, each the image of a
point found on the polyline already there, by interpolation. Here only the choice of points follows it, a bound on
chords and one on angles (which is not asked where one image continues another). Mapping ancestors instead of
interpolating costs some five applications of F for each point, of a quarter of a microsecond or two; it leaves rounding
as the only error, which F makes smaller across the manifold, and it finds the corners where they are. (A polyline of
chord h and angle alpha is off by h alpha/8; at a graze the root of that would show.)
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.manifolds.curve_images import (
    BACKWARDS,
    FORWARDS,
    LARGEST_POWER,
    CurveMap,
    CurvePoints,
    drop_fast,
    first_points,
    forget_ancestors,
    map_points,
    next_image,
)
from rattle_kernels.manifolds.grazing_preimages import speed_of_no_return
from rattle_kernels.manifolds.manifold_branch import (
    DEFAULT_LIMITS,
    ManifoldBranch,
    ManifoldEnd,
    ManifoldLimits,
    check_limits,
)
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
from rattle_kernels.manifolds.saddle import check_saddle, directions, orbit_name
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator, check_impacting
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit

# How far from the saddle the fundamental domain ends: the manifold leaves its tangent by 5e-15 times the curvature
# there. Saddles next to a graze have a large one, and a large multiplier too, so the other end will not do.
_START = 1e-7
# Branches shrunk to this length have ended.
_SETTLED = 1e-8
_MOST_IMAGES = 2000


def _appended(branch: CurvePoints, image: CurvePoints) -> CurvePoints:
    """The branch with its next image, which begins where it ends unless fast parts were left out."""
    image = image._replace(t=image.t[-1:], v=image.v[-1:])
    if branch.t[0, -1] == image.t[0, 0] and branch.v[0, -1] == image.v[0, 0]:
        branch.joined[-1] = image.joined[0]
        image = image.at(slice(1, None))
    return CurvePoints(*(np.concatenate(pair, axis=-1) for pair in zip(branch, image, strict=True)))


def _length_within(image: CurvePoints, limits: ManifoldLimits, velocity_scale: float) -> float:
    """Length of an image between the velocity limits, to about a chord at each crossing."""
    t, v = image.t[-1], image.v[-1]
    within = image.joined[:-1] & (v[:-1] >= limits.lowest_velocity) & (v[:-1] <= limits.highest_velocity)
    return float(chord_lengths(t, v, velocity_scale)[within].sum())


def _next_that_fits(
    curve_map: CurveMap, image: CurvePoints, resolution: CurveResolution, most_points: int
) -> tuple[CurvePoints | None, bool]:
    """The next image, or that of the first half, quarter, ... which keeps the bound on points; whether it is whole."""
    following = next_image(curve_map, image, resolution, most_points)
    whole = following is not None
    while following is None and image.corner.size > 2:
        half = image.at(slice(0, image.corner.size // 2 + 1))
        image = half._replace(joined=half.joined & (np.arange(half.corner.size) < half.corner.size - 1))
        following = next_image(curve_map, image, resolution, most_points)
    return following, whole


class _Growth(NamedTuple):
    """A branch so far, the image that it is to be continued by, its length, and why it ends (None: it goes on)."""

    branch: CurvePoints
    image: CurvePoints
    length: float
    end: ManifoldEnd | None


def _grow(curve_map: CurveMap, growth: _Growth, limits: ManifoldLimits, resolution: CurveResolution) -> _Growth:
    """The branch, longer by one image."""
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
    """The chord from a point close to the saddle to its image under F, and the one from the saddle to it."""
    near = saddle + first_step
    image = map_points(curve_map, first_points(*near[:, None]))
    domain = first_points(image.t[:, 0], image.v[:, 0])
    return _Growth(_appended(first_points(*np.column_stack([saddle, near])), domain), domain, 0.0, None)


def _branch(
    curve_map: CurveMap,
    saddle: np.ndarray,
    first_step: np.ndarray,
    limits: ManifoldLimits,
    resolution: CurveResolution,
    pause: Pause,
) -> tuple[tuple[Piece, ...], ManifoldEnd]:
    """Pieces of one branch, which begins with a step away from a point of a saddle, and why there are no more."""
    growth = _begin(curve_map, saddle, first_step)
    for _ in range(_MOST_IMAGES):
        pause()
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
    checked, orbit = check_impacting(oscillator), check_saddle(orbit)
    limits, resolution = check_limits(limits), check_resolution(resolution)
    scale = largest_grazing_speed(checked)
    flips = bool(min(orbit.multipliers.real) < 0.0)
    power = orbit.upper_contacts * (2 if flips else 1)
    if power > LARGEST_POWER:
        raise ValueError(
            f"P^{power} maps {orbit_name(orbit)} along its manifold: at most P^{LARGEST_POWER} is computed"
        )
    turns = sense * orbit.forcing_periods * (2 if flips else 1)
    curve_map = CurveMap(checked, sense, power, turns, scale)
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
            pieces, end = _branch(curve_map, saddle, side * first_step, limits, resolution, pause)
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
    """Stable manifold of a saddle: the departures that P takes to it, grown by the inverse of P.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    saddle : PeriodicOrbit
        As `find_saddle` gives it.
    limits : ManifoldLimits
        How far each branch is grown.
    resolution : CurveResolution
        Speeds count in units of the largest v*.
    only : (int, int), optional
        Point and side of the one branch to grow; all by default.
    pause : callable
        Called before every image of a branch. To stop the work, raise an exception there.

    Returns
    -------
    tuple of ManifoldBranch
        Two for each point of the orbit.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map, or its stiffness is finite.
    NotASaddle
        Where the orbit is another.
    ValueError
        Where another argument is not valid.

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
    """Unstable manifold of a saddle: the departures that the inverse of P takes to it, grown by P.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    saddle : PeriodicOrbit
        As `find_saddle` gives it.
    limits : ManifoldLimits
        How far each branch is grown.
    resolution : CurveResolution
        Speeds count in units of the largest v*.
    only : (int, int), optional
        Point and side of the one branch to grow; all by default.
    pause : callable
        Called before every image of a branch. To stop the work, raise an exception there.

    Returns
    -------
    tuple of ManifoldBranch
        Two for each point of the orbit.

    Raises
    ------
    OutsideDomain, NotASaddle, ValueError
        As `stable_manifold` does.
    """
    return _manifold(oscillator, saddle, FORWARDS, limits, resolution, only, pause)
