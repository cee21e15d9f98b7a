"""Pre-images of the grazing curve (Sec. 6.1): departures whose (n+1)th flight touches -beta.

The pre-image of order n is ``P^-n`` of the grazing curve v*(t): flights are followed backwards in time from a graze, by
the same root-finders. Each is a closed curve round the cylinder (t, v), because v* is one and P is continuous and
one-to-one. It has corners where one graze follows another, and at their images. There it is cut into smooth pieces.

Of a loose gear there are three such curves (`FirstCurve`). Where a flight touches a wall from between the walls, it is
known there: at rest on the wall, at a phase at which a(t) presses away from it. Followed back to the last departure
from +beta, these phases give the curve of all departures that touch that wall before their next one. It need not be a
function of the phase, may have contacts with -beta on its way, and has gaps where P jumps.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.flights import BACKWARDS, LOWER, UPPER
from rattle_kernels.impact_map.grazing_velocity import grazing_velocity
from rattle_kernels.impact_map.rest_velocity import check_release, rest_velocity
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
    goes_on,
    split_at_corners,
)
from rattle_kernels.model.arcs import arcs_of
from rattle_kernels.model.domain import check_invertible
from rattle_kernels.model.flight import range_at_rest
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outside_domain import OutsideDomain
from rattle_kernels.numerics.pausing import Pause, never_stopped

_FIRST_POINTS = 65
STRETCHES = 8
"""Number of stretches of the grazing curve, as in `preimages_of_stretch`."""
_MOST_POINTS = 1_000_000


# Of an arc, kept from its ends.
_INSIDE = 1e-9


class TooManyPoints(ValueError):
    """A curve needs more points than allowed. The message says what to ask for instead."""


class FirstCurve(StrEnum):
    """Departures of which pre-images are drawn."""

    LOWER = "lower"
    """They touch -beta, from above, before the next departure: the grazing curve."""
    UPPER = "upper"
    """They touch +beta, from below, before the next departure; of a loose gear alone."""
    REST = "rest"
    """Slower ones come to rest on +beta, all others do not; of a loose gear alone."""


def check_first(oscillator: Oscillator, first: FirstCurve) -> Oscillator:
    """Return an oscillator as `check_invertible` does, or raise if it has no such curve.

    Parameters
    ----------
    oscillator : Oscillator
        As a user gave it.
    first : FirstCurve

    Returns
    -------
    Oscillator

    Raises
    ------
    OutsideDomain
        Naming the parameter, the bound and its value.
    """
    if first == FirstCurve.LOWER:
        return check_invertible(oscillator)
    checked = check_release(oscillator)
    if first == FirstCurve.REST and checked.restitution == 1.0:
        message = "restitution must be below 1: where impacts are elastic nothing comes to rest"
        raise OutsideDomain("restitution", checked.restitution, "energy", 1.0, message)
    return checked


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
    weakest, strongest = range_at_rest(oscillator)
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
    first: FirstCurve = FirstCurve.LOWER,
) -> tuple[tuple[Piece, ...], ...]:
    """The grazing curve and its pre-images, as smooth pieces.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model, also beyond the bound of Eq. (8).
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
    first : FirstCurve
        Curve of order 0. Beyond the bound of Eq. (8) P and its inverse go from bounce to bounce.

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
    Beyond Eq. (8) applications of more than 64 contacts with -beta are left out.
    """
    task = _task(oscillator, order, resolution, velocity_limits, most_points, pause, first)
    orders = []
    for curve in _images(task):
        pieces = split_at_corners(curve.t[-1], curve.v[-1], curve.corner, curve.joined)
        if not task.backwards.oscillator.is_loose:
            pieces = _closed(pieces, curve)
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
    first: FirstCurve
    speeds: Callable[[np.ndarray], np.ndarray]


def _task(
    oscillator: Oscillator,
    order: int,
    resolution: CurveResolution,
    velocity_limits: tuple[float, float] | None,
    most_points: int,
    pause: Pause,
    first: FirstCurve,
) -> _Task:
    checked, resolution, first = check_first(oscillator, first), check_resolution(resolution), FirstCurve(first)
    if order < 0:
        raise ValueError(f"order must be at least 0 (the grazing curve itself), not {order}")
    lowest, highest = (0.0, math.inf) if velocity_limits is None else velocity_limits
    if not 0.0 <= lowest < highest:
        raise ValueError(f"velocity_limits must be 0 <= lowest < highest, not {velocity_limits}")
    scale = largest_grazing_speed(checked)
    speeds, touched = _first_speeds(checked, first), UPPER if first == FirstCurve.UPPER else LOWER
    backwards = CurveMap(checked, BACKWARDS, 1, 0.0, scale, speeds, pause, touched)
    return _Task(backwards, order, resolution, (lowest, highest), most_points, first, speeds)


def _first_speeds(oscillator: Oscillator, first: FirstCurve) -> Callable[[np.ndarray], np.ndarray]:
    """Speeds of the first curve at some phases; 0 where a loose gear touches a wall."""
    if first == FirstCurve.REST:
        return lambda phase: rest_velocity(oscillator, phase)
    return np.zeros_like if oscillator.is_loose else lambda phase: grazing_velocity(oscillator, phase)


def _spans(oscillator: Oscillator, first: FirstCurve) -> list[tuple[float, float]]:
    """Phases over which the first curve is drawn; of a loose gear the arcs on which a(t) has the sign that it needs."""
    arcs = arcs_of(oscillator)
    if arcs is None:
        return [(0.0, 1.0)]
    size = np.diff(arcs.begin, append=arcs.begin[0] + 1.0)
    own = arcs.sign == (LOWER if first == FirstCurve.UPPER else UPPER)
    spans = np.column_stack([arcs.begin + _INSIDE * size, arcs.begin + (1.0 - _INSIDE) * size])
    return [(begin, end) for begin, end in spans[own].tolist()]


def _first_points(task: _Task, stretch: int | None) -> CurvePoints:
    """The first curve before it is refined, or a stretch of it; of a loose gear perhaps the touches it leads to."""
    spans, chords = _spans(task.backwards.oscillator, task.first), _FIRST_POINTS - 1
    start, stop = (0, STRETCHES) if stretch is None else (stretch, stretch + 1)
    chosen = np.arange(start, stop + 1) * (chords * len(spans) // STRETCHES)
    parts = []
    for number, span in enumerate(spans):
        begin, end = np.clip(chosen[[0, -1]] - number * chords, 0, chords)
        if end > begin:
            parts.append(np.linspace(*span, _FIRST_POINTS)[begin : end + 1])
    phase = np.concatenate(parts) if parts else np.empty(0)
    points = first_points(phase, task.speeds(phase))
    points.joined[np.cumsum([part.size for part in parts], dtype=int) - 1] = False
    return points


def _images(task: _Task, stretch: int | None = None) -> Iterator[CurvePoints]:
    """The first curve, or a stretch of it, then its pre-images, as many as the bound on points allows."""
    oscillator = task.backwards.oscillator
    beyond = max(task.velocity_limits[1], speed_of_no_return(oscillator))
    first = _first_points(task, stretch)
    touches = oscillator.is_loose and task.first != FirstCurve.REST
    curve: CurvePoints | None = first
    if first.corner.size:
        begin = next_image if touches else refine
        curve = begin(task.backwards, first, task.resolution, task.most_points)
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
    first: FirstCurve = FirstCurve.LOWER,
) -> tuple[tuple[Piece, ...], ...]:
    """Pre-images of one of `STRETCHES` stretches of the grazing curve: a part of the work of `grazing_preimages`.

    Parameters
    ----------
    oscillator, order, resolution, velocity_limits, most_points, pause, first
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
    task = _task(oscillator, order, resolution, velocity_limits, most_points, pause, first)
    return tuple(
        clip_velocity(split_at_corners(curve.t[-1], curve.v[-1], curve.corner, curve.joined), *task.velocity_limits)
        for curve in _images(task, stretch)
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
        if joined and pieces and goes_on(joined[-1], pieces[0]):
            joined[-1:] = [_chained(joined[-1], pieces[0])]
            pieces = pieces[1:]
        joined += pieces
    if len(joined) > 1 and goes_on(joined[-1], joined[0]):
        joined = [_chained(joined[-1], joined[0]), *joined[1:-1]]
    return tuple(from_first_period(piece) for piece in joined)


def _chained(piece: Piece, following: Piece) -> Piece:
    turn = np.rint(piece.t[-1] - following.t[0])
    return Piece(np.append(piece.t, following.t[1:] + turn), np.append(piece.v, following.v[1:]))
