"""Curves in the (t, v) plane: as a table of smooth pieces, the vertices of all one after another, and on axes."""

from collections.abc import Mapping, Sequence
from enum import IntEnum
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy import float64, int8, int64

from rattle_kernels import Piece
from rattle_kernels.manifolds.polyline import goes_on
from worker.stores.layout import PERIODS, SPEED, Columns, flags
from worker.stores.table import Column, Table

THIN = 0.8
"""Width of the curves in pictures."""
_VERTEX = "vertex"
_SIZE = {"sample_dimension": _VERTEX}


class PieceEnd(IntEnum):
    """Why a piece ends."""

    CORNER = 1
    """A flight grazes here, or a later one does. The next piece begins with another tangent."""
    VELOCITY = 2
    """The piece leaves the window of speeds."""
    LAST = 3
    """The curve is drawn no further; of a loose gear also where it breaks off, as P jumps or contacts are too many."""


PIECES = Table("piece", (
    Column("piece_size", int64, "vertices of a piece, which follow those of the one before", "t.size", _SIZE),
    Column("piece_end", int8, "why a piece ends", None, flags(PieceEnd), fill=0),
    Column("time", float64, "phases along the pieces, unwrapped: they run on beyond 1", "t", PERIODS, along=_VERTEX),
    Column("velocity", float64, "speeds along the pieces", "v", SPEED, along=_VERTEX),
))  # fmt: skip


def piece_columns(pieces: Sequence[Piece], velocity: tuple[float, float]) -> Columns:
    """Columns of the pieces of one curve, in order. The curve is drawn within a window of speeds."""
    ends = np.full(len(pieces), PieceEnd.CORNER, np.int8)
    ends[[bool(np.isin(piece.v[-1], velocity)) for piece in pieces]] = PieceEnd.VELOCITY
    breaks = np.array([not goes_on(*pair) for pair in pairwise(pieces)], np.bool_)
    ends[:-1][(ends[:-1] == PieceEnd.CORNER) & breaks] = PieceEnd.LAST
    ends[-1:] = np.where(ends[-1:] == PieceEnd.VELOCITY, PieceEnd.VELOCITY, PieceEnd.LAST)
    return PIECES.of(pieces) | {"piece_end": ends}


def pieces_of(columns: Mapping[str, Any]) -> list[Piece]:
    """Pieces from a store's columns or an xarray dataset."""
    return [Piece(row.time, row.velocity) for row in PIECES.rows(columns)]


def finish_plane(axes: Axes, title: str, velocity: tuple[float, float]) -> None:
    """Give axes of the (t, v) plane their title, window, labels and legend."""
    axes.set_title(title)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(velocity)
    axes.set_xlabel("time t of departure (forcing periods)")
    axes.set_ylabel("velocity v of departure")
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize="small")
