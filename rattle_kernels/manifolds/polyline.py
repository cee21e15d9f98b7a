"""Pieces of curves on the cylinder (t, v) as polylines: resolution, length and cuts.

Lengths and angles are those of the plane (t, v/velocity_scale). Along a piece the phase is unwrapped: it runs on beyond
[0, 1) instead of jumping.
"""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

# Phases of the same point, wrapped to [0, 1) from the ends of two pieces, differ by less.
_SAME_PHASE = 1e-12


class Piece(NamedTuple):
    """A smooth arc: phases (unwrapped) and speeds of its points in order, arrays of shape (points,)."""

    t: np.ndarray
    v: np.ndarray


class CurveResolution(NamedTuple):
    """Resolution of a polyline.

    Parameters
    ----------
    chord : float
        Longest distance between neighbouring points.
    angle : float
        Largest angle, in radians, by which the polyline turns at a point.
    finest : float
        Chords shorter than this are not divided to make an angle smaller.
    """

    chord: float = 0.01
    angle: float = 0.2
    finest: float = 1e-4


DEFAULT_RESOLUTION = CurveResolution()


def check_resolution(resolution: CurveResolution) -> CurveResolution:
    """Return the resolution with plain float fields if it is valid.

    Raises
    ------
    ValueError
        If a field is not valid. The message names it, its value and what is valid.
    """
    checked = CurveResolution(*(float(value) for value in resolution))
    for name, value in checked._asdict().items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be positive and finite, not {value}")
    if checked.finest > checked.chord:
        raise ValueError(f"finest must be at most chord = {checked.chord}, not {checked.finest}")
    return checked


def chord_lengths(t: np.ndarray, v: np.ndarray, velocity_scale: float) -> np.ndarray:
    """Distance of each point from the next, shape (points - 1,)."""
    return np.hypot(np.diff(t), np.diff(v) / velocity_scale)


def turning_angles(t: np.ndarray, v: np.ndarray, velocity_scale: float) -> np.ndarray:
    """Angle between the chords that meet at each inner point, in [0, pi], shape (points - 2,)."""
    dt, dv = np.diff(t), np.diff(v) / velocity_scale
    cross, dot = dt[:-1] * dv[1:] - dv[:-1] * dt[1:], dt[:-1] * dt[1:] + dv[:-1] * dv[1:]
    return np.abs(np.arctan2(cross, dot))


def from_first_period(piece: Piece) -> Piece:
    """The piece, shifted so that its first phase lies in [0, 1)."""
    return Piece(piece.t - math.floor(piece.t[0]), piece.v)


def goes_on(piece: Piece, following: Piece) -> bool:
    """Whether a piece ends exactly where another begins."""
    apart = following.t[0] - piece.t[-1]
    return bool(following.v[0] == piece.v[-1] and abs(apart - np.rint(apart)) < _SAME_PHASE)


def arclength(pieces: Iterable[Piece], velocity_scale: float) -> float:
    """Total length of pieces.

    Parameters
    ----------
    pieces : iterable of Piece
        Parts of one curve, or of several.
    velocity_scale : float
        Speed that counts as much as one forcing period.

    Returns
    -------
    float
        In forcing periods.
    """
    return float(sum(chord_lengths(piece.t, piece.v, velocity_scale).sum() for piece in pieces))


def cut_at_arclength(pieces: Iterable[Piece], length: float, velocity_scale: float) -> tuple[Piece, ...]:
    """First pieces of a curve, cut at a given length along it."""
    kept, left = [], length
    for piece in pieces:
        along = np.concatenate([[0.0], np.cumsum(chord_lengths(piece.t, piece.v, velocity_scale))])
        if along[-1] > left:
            points = int(np.searchsorted(along, left))
            end = Piece(*(np.interp([left], along, values) for values in piece))
            kept.append(Piece(*(np.append(values[:points], last) for values, last in zip(piece, end, strict=True))))
            break
        kept.append(piece)
        left -= along[-1]
    return tuple(piece for piece in kept if piece.t.size > 1)


def _with_crossings(piece: Piece, axis: int, level: float) -> Piece:
    """Insert a point wherever the piece crosses a level of t (axis 0) or of v (axis 1)."""
    above = piece[axis] - level
    at = np.flatnonzero(above[:-1] * above[1:] < 0.0)
    part = above[at] / (above[at] - above[at + 1])
    new = [values[at] + part * (values[at + 1] - values[at]) for values in piece]
    new[axis] = np.full(at.size, level)
    return Piece(*(np.insert(values, at + 1, points) for values, points in zip(piece, new, strict=True)))


def _runs(piece: Piece, chord_of: np.ndarray) -> list[tuple[int, Piece]]:
    """Runs of chords with the same label: the label, and the piece with the points at both ends."""
    changes = np.flatnonzero(np.diff(chord_of)) + 1
    bounds = [0, *changes.tolist(), chord_of.size]
    pairs = zip(bounds[:-1], bounds[1:], strict=True)
    return [(int(chord_of[a]), Piece(piece.t[a : b + 1], piece.v[a : b + 1])) for a, b in pairs if b > a]


def clip_velocity(pieces: Iterable[Piece], lowest: float, highest: float) -> tuple[Piece, ...]:
    """Parts of pieces with speeds between two bounds, cut where they cross a bound.

    Parameters
    ----------
    pieces : iterable of Piece
    lowest, highest : float
        Speeds, ``lowest < highest``.

    Returns
    -------
    tuple of Piece
        The first phase of each lies in [0, 1).
    """
    inside = []
    for piece in pieces:
        fine = _with_crossings(_with_crossings(piece, 1, lowest), 1, highest)
        middle = 0.5 * (fine.v[:-1] + fine.v[1:])
        within = ((middle >= lowest) & (middle <= highest)).astype(int)
        inside += [from_first_period(part) for label, part in _runs(fine, within) if label]
    return tuple(inside)


def split_at_wrap(pieces: Iterable[Piece]) -> tuple[Piece, ...]:
    """Pieces for drawing: cut where the phase passes a whole period, and shifted to [0, 1].

    Parameters
    ----------
    pieces : iterable of Piece

    Returns
    -------
    tuple of Piece
        Phases in [0, 1], both ends included.
    """
    wrapped = []
    for piece in pieces:
        fine = piece
        for turn in range(math.floor(piece.t.min()) + 1, math.ceil(piece.t.max())):
            fine = _with_crossings(fine, 0, float(turn))
        turns = np.floor(0.5 * (fine.t[:-1] + fine.t[1:])).astype(int)
        wrapped += [Piece(part.t - turn, part.v) for turn, part in _runs(fine, turns)]
    return tuple(wrapped)


def split_at_corners(t: np.ndarray, v: np.ndarray, corner: np.ndarray, joined: np.ndarray) -> tuple[Piece, ...]:
    """Smooth arcs of a curve with corners at some points and gaps after others.

    Parameters
    ----------
    t, v : ndarray of float64, shape (points,)
    corner : ndarray of bool, shape (points,)
        Where two arcs meet. The point belongs to both.
    joined : ndarray of bool, shape (points,)
        Whether a point is joined to the next.

    Returns
    -------
    tuple of Piece
    """
    if not t.size:
        return ()
    starts: Sequence[int] = np.flatnonzero(corner | ~np.roll(joined, 1)).tolist()
    pieces = []
    for start, following in zip(starts, [*starts[1:], t.size], strict=True):
        stop = min(following + 1, t.size) if joined[following - 1] else following
        pieces.append(from_first_period(Piece(t[start:stop], v[start:stop])))
    return tuple(piece for piece in pieces if piece.t.size > 1)
