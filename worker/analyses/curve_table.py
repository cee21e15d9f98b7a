"""Curves in the (t, v) plane as columns: smooth pieces one after another, as contiguous ragged arrays."""

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Any

import numpy as np

from rattle_kernels import Piece
from worker.analyses.branch_table import slices
from worker.stores.layout import MISSING, PERIODS, SPEED, Columns, Variable, flags


class PieceEnd(IntEnum):
    """Why a piece ends."""

    CORNER = 1
    """Here a flight grazes, or one after it: another piece begins with another tangent."""
    VELOCITY = 2
    """It leaves the window of speeds."""
    LAST = 3
    """The curve is drawn no further."""


_PIECE, _VERTEX = ("piece",), ("vertex",)
PIECES = (
    Variable(
        "piece_size", _PIECE, np.int64, MISSING, "vertices of a piece, which follow those of the one before",
        {"sample_dimension": "vertex"},
    ),
    Variable("piece_end", _PIECE, np.int8, 0, "why a piece ends", flags(PieceEnd)),
    Variable("time", _VERTEX, np.float64, np.inf, "phases along the pieces, unwrapped: they run on beyond 1", PERIODS),
    Variable("velocity", _VERTEX, np.float64, np.inf, "speeds along the pieces", SPEED),
)  # fmt: skip


def piece_columns(pieces: Sequence[Piece], velocity: tuple[float, float]) -> Columns:
    """Columns of the pieces of one curve, in order, that is drawn within a window of speeds."""
    ends = np.full(len(pieces), PieceEnd.CORNER, np.int8)
    ends[[bool(np.isin(piece.v[-1], velocity)) for piece in pieces]] = PieceEnd.VELOCITY
    ends[-1:] = np.where(ends[-1:] == PieceEnd.VELOCITY, PieceEnd.VELOCITY, PieceEnd.LAST)
    empty = [np.empty(0)]
    return {
        "piece_size": np.array([piece.t.size for piece in pieces], np.int64),
        "piece_end": ends,
        "time": np.concatenate([piece.t for piece in pieces] or empty),
        "velocity": np.concatenate([piece.v for piece in pieces] or empty),
    }


def join_pieces(parts: Sequence[Columns]) -> Columns:
    """Columns of several curves, one after another."""
    return {
        variable.name: np.concatenate([part[variable.name] for part in parts] or [np.empty(0, variable.dtype)])
        for variable in PIECES
    }


def pieces_of(columns: Mapping[str, Any]) -> list[Piece]:
    """Pieces of such columns: of a store, or of an xarray dataset."""
    t, v = (np.asarray(columns[name]) for name in ("time", "velocity"))
    return [Piece(t[vertices], v[vertices]) for vertices in slices(np.asarray(columns["piece_size"]))]
