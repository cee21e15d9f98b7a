"""Pre-images of the grazing curve (Sec. 6.1): departures whose (n+1)th flight touches -beta.

The pre-image of order n is ``P^-n`` of the grazing curve v*(t): flights are followed backwards in time from a graze, by
the same root-finders. Each is a closed curve round the cylinder (t, v), because v* is one and P is continuous and
one-to-one. It has corners where one graze follows another, and at their images. There it is cut into smooth pieces.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import INVERSE_OF_IMPACTS
from rattle_kernels.impact_map.flights import BACKWARDS
from rattle_kernels.impact_map.grazing_velocity import grazing_velocity
from rattle_kernels.manifolds.curve_images import (
    CurveMap,
    CurvePoints,
    drop_fast,
    first_points,
    next_image,
    refine,
)
from rattle_kernels.manifolds.polyline import (
    DEFAULT_RESOLUTION,
    CurveResolution,
    Piece,
    check_resolution,
    clip_velocity,
    from_first_period,
    split_at_corners,
)
from rattle_kernels.model.domain import check_impacting
from rattle_kernels.model.flight import acceleration_range
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped

_FIRST_POINTS = 65
STRETCHES = 8
"""Number of stretches of the grazing curve, as in `preimages_of_stretch`."""
_MOST_POINTS = 1_000_000
# Phases of the same point, wrapped to [0, 1) from the ends of two pieces, differ by less.
_SAME_PHASE = 1e-12


class TooManyPoints(ValueError):
    """A curve needs more points than allowed. The message says what to ask for instead."""


def speed_of_no_return(oscillator: Oscillator) -> float:
    """Speed above which the inverse of P makes every departure faster, so that none returns to lower speeds.

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
    way to -beta. So for ``v^2 > (A/delta)^2 + 4 beta a_max`` it is always faster than A/delta, and damping adds more
    energy than the forcing can remove, ``delta Phi'^2 > A |Phi'|``. The constant part of the acceleration adds none
    over the way there and back.
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
    return (from_first_period(_chained(last, first)), *inner)


def grazing_preimages(
    oscillator: Oscillator,
    order: int,
    resolution: CurveResolution = DEFAULT_RESOLUTION,
    velocity_limits: tuple[float, float] | None = None,
    most_points: int = _MOST_POINTS,
    pause: Pause = never_stopped,
) -> tuple[tuple[Piece, ...], ...]:
    """The grazing curve and its pre-images, as smooth pieces.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    order : int
        Highest order, not negative; 0 is the grazing curve itself.
    resolution : CurveResolution
        Speeds are in units of the largest v*.
    velocity_limits : (float, float), optional
        Lowest and highest speed to keep. All speeds by default.
    most_points : int
        Largest number of points per order.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    tuple of tuple of Piece
        Pieces of each order, 0 to ``order``. Phases are unwrapped along each piece and start in [0, 1);
        ``polyline.split_at_wrap`` makes them ready for drawing.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map, or its stiffness is finite.
    TooManyPoints
        If a pre-image needs more points than ``most_points``.
    ValueError
        If another argument is not valid.

    Notes
    -----
    Order n is ``P^-n {(t, v*(t))}``: the flight touches -beta after n more impacts with +beta. Sec. 6.1, Fig. 14.
    """
    task = _task(oscillator, order, resolution, velocity_limits, most_points, pause)
    orders = []
    for curve in _images(task, np.linspace(0.0, 1.0, _FIRST_POINTS)):
        pieces = _closed(split_at_corners(curve.t[-1], curve.v[-1], curve.corner, curve.joined), curve)
        orders.append(clip_velocity(pieces, *task.velocity_limits))
    if len(orders) <= order:
        raise TooManyPoints(
            f"pre-image {len(orders)} of the grazing curve needs more than {most_points} points: ask for a lower "
            "order, a coarser resolution or a lower velocity limit"
        )
    return tuple(orders)


class _Task(NamedTuple):
    """A checked request for pre-images."""

    backwards: CurveMap
    order: int
    resolution: CurveResolution
    velocity_limits: tuple[float, float]
    most_points: int


def _task(
    oscillator: Oscillator,
    order: int,
    resolution: CurveResolution,
    velocity_limits: tuple[float, float] | None,
    most_points: int,
    pause: Pause,
) -> _Task:
    checked, resolution = check_impacting(oscillator, INVERSE_OF_IMPACTS), check_resolution(resolution)
    if order < 0:
        raise ValueError(f"order must be at least 0 (the grazing curve itself), not {order}")
    lowest, highest = (0.0, math.inf) if velocity_limits is None else velocity_limits
    if not 0.0 <= lowest < highest:
        raise ValueError(f"velocity_limits must be 0 <= lowest < highest, not {velocity_limits}")
    scale = largest_grazing_speed(checked)
    backwards = CurveMap(checked, BACKWARDS, 1, 0.0, scale, lambda phase: grazing_velocity(checked, phase), pause)
    return _Task(backwards, order, resolution, (lowest, highest), most_points)


def _images(task: _Task, phase: np.ndarray) -> Iterator[CurvePoints]:
    """The grazing curve over some phases, then its pre-images, as many as the bound on points allows."""
    oscillator = task.backwards.oscillator
    beyond = max(task.velocity_limits[1], speed_of_no_return(oscillator))
    first = first_points(phase, grazing_velocity(oscillator, phase))
    curve = refine(task.backwards, first, task.resolution, task.most_points)
    for order in range(task.order + 1):
        if curve is None:
            return
        yield curve
        if order < task.order:
            slow = drop_fast(curve, beyond)
            curve = next_image(task.backwards, slow, task.resolution, task.most_points) if slow.corner.size else slow


def preimages_of_stretch(
    oscillator: Oscillator,
    order: int,
    stretch: int,
    resolution: CurveResolution = DEFAULT_RESOLUTION,
    velocity_limits: tuple[float, float] | None = None,
    most_points: int = _MOST_POINTS,
    pause: Pause = never_stopped,
) -> tuple[tuple[Piece, ...], ...]:
    """Pre-images of one of `STRETCHES` stretches of the grazing curve: a part of the work of `grazing_preimages`.

    Parameters
    ----------
    oscillator, order, resolution, velocity_limits, most_points, pause
        As for `grazing_preimages`. `most_points` applies to the stretch alone.
    stretch : int
        0 to ``STRETCHES - 1``.

    Returns
    -------
    tuple of tuple of Piece
        Pieces of each order, in order along the curve. Orders end before the first that needs too many points.

    Raises
    ------
    OutsideDomain, ValueError
        As for `grazing_preimages`.
    """
    task = _task(oscillator, order, resolution, velocity_limits, most_points, pause)
    chords = (_FIRST_POINTS - 1) // STRETCHES
    phase = np.linspace(0.0, 1.0, _FIRST_POINTS)[stretch * chords : (stretch + 1) * chords + 1]
    return tuple(
        clip_velocity(split_at_corners(curve.t[-1], curve.v[-1], curve.corner, curve.joined), *task.velocity_limits)
        for curve in _images(task, phase)
    )


def join_stretches(stretches: Sequence[Sequence[Piece]]) -> tuple[Piece, ...]:
    """Pieces of one order from those of its stretches, joined where one stretch continues another.

    Parameters
    ----------
    stretches : sequence of sequence of Piece
        In order along the curve. Missing stretches are empty.

    Returns
    -------
    tuple of Piece
        The first phase of each lies in [0, 1).
    """
    joined: list[Piece] = []
    for pieces in stretches:
        if joined and pieces and _goes_on(joined[-1], pieces[0]):
            joined[-1:] = [_chained(joined[-1], pieces[0])]
            pieces = pieces[1:]
        joined += pieces
    if len(joined) > 1 and _goes_on(joined[-1], joined[0]):
        joined = [_chained(joined[-1], joined[0]), *joined[1:-1]]
    return tuple(from_first_period(piece) for piece in joined)


def _goes_on(piece: Piece, following: Piece) -> bool:
    """Whether a piece ends exactly where another begins."""
    apart = following.t[0] - piece.t[-1]
    return bool(following.v[0] == piece.v[-1] and abs(apart - np.rint(apart)) < _SAME_PHASE)


def _chained(piece: Piece, following: Piece) -> Piece:
    turn = np.rint(piece.t[-1] - following.t[0])
    return Piece(np.append(piece.t, following.t[1:] + turn), np.append(piece.v, following.v[1:]))
