"""Pre-images of the grazing curve (Sec. 6.1): departures whose (n+1)th flight touches -beta.

The pre-image of order n is ``P^-n`` of the grazing curve v*(t): flights followed backwards in time from a graze, by the
same root-finders. Each is a closed curve round the cylinder (t, v), as v* is and P is continuous and one to one. It has
corners where a graze is followed by another one, and their images: there it is cut into smooth pieces.
"""

import math

import numpy as np

from rattle_kernels.curve_images import (
    BACKWARDS,
    CurveMap,
    CurvePoints,
    drop_fast,
    first_points,
    next_image,
    refine,
)
from rattle_kernels.flight import acceleration_range
from rattle_kernels.grazing_curve import grazing_velocity
from rattle_kernels.lane_tables import lane_tables
from rattle_kernels.oscillator import Oscillator, check_impacting
from rattle_kernels.polyline import (
    DEFAULT_RESOLUTION,
    CurveResolution,
    Piece,
    check_resolution,
    clip_velocity,
    from_first_period,
    split_at_corners,
)

_FIRST_POINTS = 65
_MOST_POINTS = 1_000_000


class TooManyPoints(ValueError):
    """A curve needs more points than are allowed; what to ask for instead."""


def speed_of_no_return(oscillator: Oscillator) -> float:
    """Speed above which the inverse of P makes every departure faster, so that nothing comes back from there.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model, checked by the caller.

    Returns
    -------
    float

    Notes
    -----
    At rest the acceleration is ``4 pi delta`` plus a forcing of amplitude ``A = 2 pi eps sqrt(4 pi^2 + delta^2)``, at
    most ``a_max = 4 pi delta + A`` (Eq. 7). Backwards in time a flight loses at most ``2 a_max 2 beta`` of v^2 on its
    way to -beta, so for ``v^2 > (A/delta)^2 + 4 beta a_max`` it is always faster than A/delta. Then damping gives more
    energy than the forcing can take, ``delta Phi'^2 > A |Phi'|``, and over the way there and back the constant part of
    the acceleration gives none.
    """
    weakest, strongest = acceleration_range(oscillator)
    forcing = 0.5 * (strongest - weakest) / oscillator.damping
    return math.sqrt(forcing * forcing + 4.0 * oscillator.half_backlash * strongest)


def _closed(pieces: tuple[Piece, ...], points: CurvePoints) -> tuple[Piece, ...]:
    """Join the last piece to the first across the phase at which the grazing curve was cut open."""
    cut_open = points.corner[0] or points.corner[-1] or not (points.joined[0] and points.joined[-2])
    if cut_open or len(pieces) < 2:
        return pieces
    *inner, last = pieces[1:]
    first = pieces[0]
    turn = np.rint(last.t[-1] - first.t[0])
    whole = Piece(np.append(last.t, first.t[1:] + turn), np.append(last.v, first.v[1:]))
    return (from_first_period(whole), *inner)


def grazing_preimages(
    oscillator: Oscillator,
    order: int,
    resolution: CurveResolution = DEFAULT_RESOLUTION,
    velocity_limits: tuple[float, float] | None = None,
    most_points: int = _MOST_POINTS,
) -> tuple[tuple[Piece, ...], ...]:
    """Grazing curve and its pre-images, as smooth pieces.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    order : int
        Highest order, not negative; 0 is the grazing curve itself.
    resolution : CurveResolution
        Speeds count in units of the largest v*.
    velocity_limits : (float, float), optional
        Lowest and highest speed to keep; all by default.
    most_points : int
        Largest number of points of one order.

    Returns
    -------
    tuple of tuple of Piece
        Pieces of each order, 0 to `order`. Phases are unwrapped along each piece and start in [0, 1);
        `polyline.split_at_wrap` makes them ready for drawing.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map, or its stiffness is finite.
    TooManyPoints
        Where a pre-image needs more points than `most_points`.
    ValueError
        Where another argument is not valid.

    Notes
    -----
    Order n is ``P^-n {(t, v*(t))}``: the touch comes n impacts with +beta later. Sec. 6.1, Fig. 14.
    """
    checked, resolution = check_impacting(oscillator), check_resolution(resolution)
    if order < 0:
        raise ValueError(f"order must be at least 0 (the grazing curve itself), not {order}")
    lowest, highest = (0.0, math.inf) if velocity_limits is None else velocity_limits
    if not 0.0 <= lowest < highest:
        raise ValueError(f"velocity_limits must be 0 <= lowest < highest, not {velocity_limits}")
    beyond = max(highest, speed_of_no_return(checked))
    scale = lane_tables(checked).speed_scale
    backwards = CurveMap(checked, BACKWARDS, 1, 0.0, scale, lambda phase: grazing_velocity(checked, phase))
    phase = np.linspace(0.0, 1.0, _FIRST_POINTS)
    curve = refine(backwards, first_points(phase, grazing_velocity(checked, phase)), resolution, most_points)
    orders: list[tuple[Piece, ...]] = []
    while curve is not None:
        pieces = _closed(split_at_corners(curve.t[-1], curve.v[-1], curve.corner, curve.joined), curve)
        orders.append(clip_velocity(pieces, lowest, highest))
        if len(orders) > order:
            return tuple(orders)
        curve = next_image(backwards, drop_fast(curve, beyond), resolution, most_points)
    raise TooManyPoints(
        f"pre-image {len(orders)} of the grazing curve needs more than {most_points} points: ask for a lower order, a "
        "coarser resolution or a lower velocity limit"
    )
