"""Images of a curve under a power of P or of its inverse, as polylines (impacting model).

P and its inverse are continuous but not smooth. Where a flight grazes -beta, one side of the curve never meets -beta
and is mapped smoothly. The other side meets it with a speed that grows like the square root of the distance. So images
of a smooth curve are smooth arcs that meet at corners. Corners lie on the grazing curve (inverse of P) or on its image
(P), where the arc that meets -beta is tangent to it, and on the images of those corners.

The image of an arc is refined by mapping new points, never by interpolating the image:

1. A chord that is too long, or that makes too large an angle with its neighbour, is divided. The new point starts from
   the youngest ancestor of the chord that is so short (1e-7) that the curve there is straight to rounding, or else from
   the first curve. So accuracy does not depend on resolution, and images shrink errors across an invariant manifold.
2. If one of two neighbours meets -beta and the other does not, a corner lies between them. It is found by bisection,
   down to neighbouring numbers before the last mapping. It is taken from the side that does not meet -beta, where P is
   smooth. The other side of the bracket may still be the square root of rounding (1e-8) away, along the grazing curve.

P of a loose gear, from bounce to bounce, also jumps: where a flight grazes +beta from below. On one side it meets +beta
there, and leaves with hardly any speed. On the other side it passes, and what comes next is the image of that. So an
image of a curve has a gap there. Each application is labelled by its contacts with -beta and by the ends of arcs that
it passes: a graze of either wall changes one of the two. A change of label is bisected, as above. What it was shows in
the images of both sides. If they are far apart, P jumps. If not, and contacts with -beta have changed, it is a corner.
Else the contact has only passed the end of an arc, and P is smooth. Where ever lower bounces lead to or from the end of
an arc their number grows without bound, with a corner for each. Applications of more than 64 contacts with -beta are
left out: the curve has a gap there.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import next_impact, previous_impact
from rattle_kernels.impact_map.flights import LOWER
from rattle_kernels.impact_map.loose_map import contact_by_contact, departure_before_touch, previous_loose_impact
from rattle_kernels.manifolds.polyline import CurveResolution, chord_lengths, turning_angles
from rattle_kernels.model.arcs import ends_passed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import chosen_by_field, inlined, kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped

# A smooth curve is off a chord c by curvature c^2/8: by 1e-15 for this chord at curvature 1.
_STRAIGHT = 1e-7
# Halvings to reach neighbouring numbers: from 1 to 1e-16, once among ancestors and once before the last map.
_HALVINGS = 120
_ROUNDS = 64
# Impacts between two pauses, some hundredths of a second.
_IMPACTS_A_LEG = 1 << 14
_IMPACTS_OF_ONTO = 64
LARGEST_POWER = 62
"""An int64 has a bit for each application, set if it met -beta."""
# A label of a loose gear has all contacts with -beta above so many bits, and a hash of each application below.
_HASHED = 32
_MOST_CONTACTS = 64
# Label of what is left out.
_LOST = -1


class CurveMap(NamedTuple):
    """The map to draw images of: P (FORWARDS) or its inverse (BACKWARDS), applied `power` times at once.

    ``turns`` forcing periods are subtracted from the phase each time, so that it does not run away. ``onto`` gives the
    speed of the first curve at a phase, if known. It is None if the first curve is straight. ``pause`` is called
    several times a second while images are drawn; an exception raised there ends the work. Backwards, a point of a
    loose gear without any speed touches the wall ``touched``; its image is the departure before that.
    """

    oscillator: Oscillator
    direction: float
    power: int
    turns: float
    velocity_scale: float
    onto: Callable[[np.ndarray], np.ndarray] | None = None
    pause: Pause = never_stopped
    touched: float = LOWER


class CurvePoints(NamedTuple):
    """Points along an image, and where they came from.

    ``t``, ``v`` (shape (ancestors + 1, points)): the last row is the image, the row before it the points that map to
    it, and so on. ``corner``: smooth arcs meet here. ``joined``: whether a point is joined to the next. ``before`` and
    ``after``: bits of the applications of the last mapping that met -beta, or labels of a loose gear's, just before and
    just after the point.
    """

    t: np.ndarray
    v: np.ndarray
    corner: np.ndarray
    joined: np.ndarray
    before: np.ndarray
    after: np.ndarray

    def at(self, index: np.ndarray | slice) -> "CurvePoints":
        """Select points by index or mask, with their ancestors."""
        return CurvePoints(*(field[..., index] for field in self))


class UndecidedFlight(ArithmeticError):
    """A root-finder gave up on a point of a curve. This is not expected."""


@inlined
def _loose_application(oscillator, direction, touched, phase, speed):
    if direction > 0.0:
        return contact_by_contact(oscillator, phase, speed, _MOST_CONTACTS).impact
    if speed == 0.0:
        return departure_before_touch(oscillator, touched, phase, _MOST_CONTACTS)
    return previous_loose_impact(oscillator, phase, speed, _MOST_CONTACTS)


@chosen_by_field("arcs", _loose_application)
def _application(oscillator, direction, touched, phase, speed):
    return next_impact(oscillator, phase, speed) if direction > 0.0 else previous_impact(oscillator, phase, speed)


@inlined
def _loose_label(oscillator, label, phase, impact):
    if label == _LOST or math.isnan(impact.duration):
        return _LOST
    passed = ends_passed(oscillator.arcs, phase, impact.duration)
    mixed = (label * 0x9E3779B1 + 0x85EBCA6B * passed + impact.lower_impacts + 1) & 0xFFFFFFFF
    return ((label >> _HASHED) + impact.lower_impacts) << _HASHED | mixed


@chosen_by_field("arcs", _loose_label)
def _label(oscillator, label, phase, impact):
    return 2 * label + impact.lower_impacts


@kernel
def _follow(oscillator, direction, power, turns, touched, base, t, v, case, first, last):
    for i in range(first, last):
        for row in range(base[i] + 1, t.shape[0]):
            phase, speed, label = t[row - 1, i], v[row - 1, i], 0
            for _ in range(power):
                impact = _application(oscillator, direction, touched, phase, speed)
                label = _label(oscillator, label, phase, impact)
                phase += impact.duration
                speed = impact.v
            t[row, i], v[row, i], case[i] = phase - turns, speed, label


def _legs(curve_map: CurveMap, size: int, impacts: int) -> Iterator[slice]:
    """Parts of `size` points, each of which takes so many impacts, with a pause before each part."""
    points = max(1, _IMPACTS_A_LEG // impacts)
    for first in range(0, size, points):
        curve_map.pause()
        yield slice(first, min(first + points, size))


def _map_from(curve_map: CurveMap, base: np.ndarray, t: np.ndarray, v: np.ndarray) -> CurvePoints:
    """Fill the rows above each point's base, in place."""
    direction, power, turns, touched = curve_map.direction, curve_map.power, curve_map.turns, curve_map.touched
    oscillator = curve_map.oscillator
    case = np.zeros(t.shape[1], np.int64)
    for leg in _legs(curve_map, case.size, power * t.shape[0]):
        _follow(oscillator, direction, power, turns, touched, base, t, v, case, leg.start, leg.stop)
    if not (oscillator.is_loose or np.isfinite(v[-1]).all()):
        raise UndecidedFlight(f"an image of (t, v) = ({t[0, 0]}, {v[0, 0]}) or near it was not found")
    return CurvePoints(t, v, np.zeros(case.size, np.bool_), np.ones(case.size, np.bool_), case, case.copy())


def first_points(t: np.ndarray, v: np.ndarray) -> CurvePoints:
    """A curve without ancestors.

    Parameters
    ----------
    t, v : ndarray of float64, shape (points,)

    Returns
    -------
    CurvePoints
    """
    joined = np.arange(t.size) < t.size - 1
    none = np.zeros(t.size, np.int64)
    return CurvePoints(t[None].copy(), v[None].copy(), np.zeros(t.size, np.bool_), joined, none, none.copy())


def _midpoints(curve_map: CurveMap, low: CurvePoints, high: CurvePoints) -> CurvePoints:
    """Points of the image between others, mapped from the youngest ancestors with a straight curve between them."""
    t, v = 0.5 * (low.t + high.t), 0.5 * (low.v + high.v)
    chords = np.hypot(high.t - low.t, (high.v - low.v) / curve_map.velocity_scale)[:-1]
    rows = np.arange(chords.shape[0])[:, None]
    base = np.where(chords < _STRAIGHT, rows, 0).max(axis=0, initial=0)
    if curve_map.onto is not None:
        first = np.flatnonzero(base == 0)
        for leg in _legs(curve_map, first.size, _IMPACTS_OF_ONTO):
            v[0, first[leg]] = curve_map.onto(t[0, first[leg]])
    return _map_from(curve_map, base, t, v)


def _insert(points: CurvePoints, at: np.ndarray, new: CurvePoints) -> CurvePoints:
    """Insert new points after those at the indices `at`."""
    return CurvePoints(*(np.insert(old, at + 1, more, axis=-1) for old, more in zip(points, new, strict=True)))


def _choose(first: np.ndarray, one: CurvePoints, other: CurvePoints) -> CurvePoints:
    return CurvePoints(*(np.where(first, a, b) for a, b in zip(one, other, strict=True)))


def _bisect(curve_map: CurveMap, low: CurvePoints, high: CurvePoints) -> tuple[CurvePoints, CurvePoints]:
    """Neighbours between which the label changes, for each of some pairs of points whose labels differ."""
    for _ in range(_HALVINGS):
        middle = _midpoints(curve_map, low, high)
        ends = [(middle.t[-2] == end.t[-2]) & (middle.v[-2] == end.v[-2]) for end in (low, high)]
        stays_low = middle.before == low.after
        low, high = _choose(stays_low, middle, low), _choose(stays_low, high, middle)
        if (ends[0] | ends[1]).all():
            break
    return low, high


def _corners(curve_map: CurveMap, low: CurvePoints, high: CurvePoints) -> CurvePoints:
    """What lies between neighbours: a corner, or of a loose gear perhaps a point where only the label changes."""
    # The first application that differs misses -beta where its bit is 0. Earlier applications have higher bits.
    corner = _choose(low.after < high.before, low, high)
    unlike = low.after ^ high.before
    if curve_map.oscillator.is_loose:
        unlike >>= _HASHED
    return corner._replace(
        corner=unlike != 0, joined=np.ones(unlike.size, np.bool_), before=low.after, after=high.before
    )


def _with_corners(
    curve_map: CurveMap, points: CurvePoints, resolution: CurveResolution, most_points: int
) -> CurvePoints:
    """Insert every corner that the labels of neighbouring points reveal, and both ends of every gap."""
    while points.corner.size <= most_points:
        flips = np.flatnonzero(points.joined[:-1] & (points.after[:-1] != points.before[1:]))
        if not flips.size:
            break
        curve_map.pause()
        low, high = _bisect(curve_map, points.at(flips), points.at(flips + 1))
        between = _corners(curve_map, low, high)
        if not curve_map.oscillator.is_loose:
            points = _insert(points, flips, between)
            continue
        apart = np.hypot(high.t[-1] - low.t[-1], (high.v[-1] - low.v[-1]) / curve_map.velocity_scale)
        gap = ~(apart <= resolution.finest)
        none = np.zeros(gap.size, np.bool_)
        points = _insert(points, flips, _choose(gap, low._replace(corner=none, joined=none, before=low.after), between))
        ends = high._replace(corner=none, joined=~none, after=high.before).at(gap)
        points = _insert(points, (flips + 1 + np.arange(flips.size))[gap], ends)
    return _without_lost(points)


def _without_lost(points: CurvePoints) -> CurvePoints:
    there = np.isfinite(points.v[-1])
    return points if there.all() else points._replace(joined=points.joined & np.append(there[1:], False)).at(there)


def _too_coarse(points: CurvePoints, resolution: CurveResolution, velocity_scale: float) -> np.ndarray:
    """Indices of points whose chord to the next is too long, or turns too far and can still be divided."""
    t, v, joined = points.t[-1], points.v[-1], points.joined[:-1]
    chords = chord_lengths(t, v, velocity_scale)
    sharp = turning_angles(t, v, velocity_scale) > resolution.angle
    sharp &= joined[:-1] & joined[1:] & ~points.corner[1:-1]
    bent = np.zeros(chords.size, np.bool_)
    bent[:-1] |= sharp
    bent[1:] |= sharp
    return np.flatnonzero(joined & ((chords > resolution.chord) | (bent & (chords > resolution.finest))))


def refine(
    curve_map: CurveMap, points: CurvePoints, resolution: CurveResolution, most_points: int
) -> CurvePoints | None:
    """Divide chords until the polyline has the required resolution.

    Parameters
    ----------
    curve_map : CurveMap
    points : CurvePoints
        At least two points.
    resolution : CurveResolution
    most_points : int

    Returns
    -------
    CurvePoints or None
        None if more than `most_points` would be needed.
    """
    points = _with_corners(curve_map, points, resolution, most_points)
    for _ in range(_ROUNDS):
        if points.corner.size > most_points:
            return None
        curve_map.pause()
        coarse = _too_coarse(points, resolution, curve_map.velocity_scale)
        if not coarse.size:
            break
        curve_map.pause()
        middle = _midpoints(curve_map, points.at(coarse), points.at(coarse + 1))
        points = _with_corners(curve_map, _insert(points, coarse, middle), resolution, most_points)
    return points


def map_curve_points(curve_map: CurveMap, points: CurvePoints) -> CurvePoints:
    """Images of the points, none added.

    Parameters
    ----------
    curve_map : CurveMap
    points : CurvePoints

    Returns
    -------
    CurvePoints
        With one more ancestor.
    """
    t, v = (np.concatenate([rows, rows[-1:]]) for rows in (points.t, points.v))
    base = np.full(points.corner.size, points.t.shape[0] - 1)
    return _map_from(curve_map, base, t, v)._replace(corner=points.corner, joined=points.joined)


def next_image(
    curve_map: CurveMap, points: CurvePoints, resolution: CurveResolution, most_points: int
) -> CurvePoints | None:
    """Image of a curve, refined.

    Parameters
    ----------
    curve_map : CurveMap
    points : CurvePoints
        The curve, from `first_points` or this function.
    resolution : CurveResolution
    most_points : int

    Returns
    -------
    CurvePoints or None
        With one more ancestor. None if it takes more than `most_points`.
    """
    return refine(curve_map, map_curve_points(curve_map, points), resolution, most_points)


def forget_ancestors(points: CurvePoints, velocity_scale: float) -> CurvePoints:
    """Drop ancestors from which no new point will start, because all chords of a younger one are straight."""
    chords = np.hypot(np.diff(points.t), np.diff(points.v) / velocity_scale)[:-1]
    short = np.flatnonzero((chords < _STRAIGHT)[:, points.joined[:-1]].all(axis=1))
    oldest = int(short[-1]) if short.size else 0
    return points._replace(t=points.t[oldest:], v=points.v[oldest:])


def drop_fast(points: CurvePoints, highest: float) -> CurvePoints:
    """Drop chords with both ends faster than a bound, and points that are then joined to no other."""
    fast = points.v[-1] > highest
    joined = points.joined & ~(fast & np.roll(fast, -1))
    keep = joined | np.roll(joined, 1)
    return points._replace(joined=joined).at(keep)
