"""Special points of branches, and their curves in two parameters, as tables."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle_kernels import Oscillator, SpecialKind, SpecialPoint
from worker.stores.layout import PERIODS, SPEED, Columns
from worker.stores.table import Column, Table

_KINDS = tuple(SpecialKind)
_DEPARTURE, _PAIR, _POINT = {"special_departure": 0}, {"multiplier": 2}, "curve_point"
SPECIALS = Table(
    "special",
    (
        Column(
            "special_kind", np.int8, lambda point: _KINDS.index(point.kind) + 1, "what happens there",
            {
                "flag_values": list(range(1, len(_KINDS) + 1)),
                "flag_meanings": " ".join(kind.replace(" ", "_") for kind in _KINDS),
            },
            fill=0,
        ),
        Column("special_branch", np.int32, None, "first branch that has it"),
        Column("special_value", np.float64, "value", "value of the parameter"),
        Column("special_error", np.float64, "error", "last change of that value by Newton's method"),
        Column("special_residual", np.float64, "residual", "what is left of the equations that define it"),
        Column("special_forcing_periods", np.int32, "forcing_periods", "m of the orbit P(m, n+, n-) there"),
        Column("special_upper_contacts", np.int32, "upper_contacts", "n+ of that orbit"),
        Column("special_lower_contacts", np.int32, "lower_contacts", "n- of that orbit; a graze is not counted"),
        Column("special_time", np.float64, "t", "phases of its departures, NaN-padded", PERIODS, _DEPARTURE),
        Column("special_velocity", np.float64, "v", "speeds of its departures, NaN-padded", SPEED, _DEPARTURE),
        Column(
            "special_multiplier_real", np.float64, "multipliers.real", "eigenvalues of DP^p, real part", dims=_PAIR,
            fill=np.nan,
        ),
        Column(
            "special_multiplier_imaginary", np.float64, "multipliers.imag", "eigenvalues of DP^p, imaginary part",
            dims=_PAIR, fill=np.nan,
        ),
    ),
    prefix="special_",
    length="special_upper_contacts",
)  # fmt: skip
CURVES = Table(
    "curve",
    (
        Column("curve_special", np.int32, None, "special point that a curve began with"),
        Column(
            "curve_size", np.int64, "t.size", "points of a curve, which follow those of the one before",
            {"sample_dimension": "curve_point"},
        ),
        Column("curve_end", str, "ends", "why it ends at its first and at its last point", dims={"curve_side": 2}),
        Column(
            "curve_first", np.float64, lambda curve: curve.values[:, 0], "value of the first parameter", along=_POINT
        ),
        Column(
            "curve_second", np.float64, lambda curve: curve.values[:, 1], "value of the second parameter",
            along=_POINT,
        ),
        Column("curve_time", np.float64, "t", "phase of the first departure", PERIODS, along=_POINT),
        Column("curve_velocity", np.float64, "v", "its speed, 0 for contact loss", SPEED, along=_POINT),
        Column("curve_residual", np.float64, "residual", "what is left of the equations", along=_POINT),
    ),
    prefix="curve_",
)  # fmt: skip
# Branches that meet in a special point agree on its value to 1e-12.
_SAME = 1e-9
# Tolerance of speeds. Next to a fold they are known only to the square root of 1e-12.
_NEAR = 1e-5


def specials_of(columns: Columns, oscillator: Oscillator, parameter: str) -> list[SpecialPoint]:
    """Points of such columns."""
    return [
        SpecialPoint(
            _KINDS[row.kind - 1], parameter, row.value, oscillator._replace(**{parameter: row.value}),
            row.forcing_periods, row.upper_contacts, row.lower_contacts, row.time, row.velocity,
            row.multiplier_real + 1j * row.multiplier_imaginary, row.residual, row.error,
        )
        for row in SPECIALS.rows(columns)
    ]  # fmt: skip


def distinct(points: Sequence[tuple[SpecialPoint, int]]) -> tuple[list[SpecialPoint], list[int]]:
    """Points without repetitions, each with the first branch that has it."""
    kept: list[tuple[SpecialPoint, int]] = []
    for point, branch in points:
        if not any(_same(point, other) for other, _ in kept):
            kept.append((point, branch))
    return [point for point, _ in kept], [branch for _, branch in kept]


def _same(one: SpecialPoint, other: SpecialPoint) -> bool:
    shapes = [(point.kind, point.forcing_periods, point.upper_contacts) for point in (one, other)]
    apart = abs(one.value - other.value) / max(1.0, abs(one.value))
    return shapes[0] == shapes[1] and apart < _SAME and abs(one.v.min() - other.v.min()) < _NEAR


def summarise_specials(columns: Columns, parameter: str) -> list[dict[str, Any]]:
    """Special points as JSON."""
    return [
        {
            "kind": _KINDS[row.kind - 1].value,
            "parameter": parameter,
            "value": row.value,
            "error": row.error,
            "residual": row.residual,
            "orbit": f"P({row.forcing_periods},{row.upper_contacts},{row.lower_contacts})",
            "branch": row.branch,
            "multipliers": np.stack([row.multiplier_real, row.multiplier_imaginary], axis=-1).tolist(),
            "departures": [
                {"time": t, "velocity": v} for t, v in zip(row.time.tolist(), row.velocity.tolist(), strict=True)
            ],
        }
        for row in SPECIALS.rows(columns)
    ]


def summarise_curves(columns: Columns, parameters: tuple[str, str]) -> list[dict[str, Any]]:
    """Curves as JSON: how far they reach and why they end. Their points are in the store."""
    return [
        {
            "special_point": row.special,
            "parameters": list(parameters),
            "points": row.size,
            "first": [float(row.first.min()), float(row.first.max())],
            "second": [float(row.second.min()), float(row.second.max())],
            "ends": [str(end) for end in row.end],
        }
        for row in CURVES.rows(columns)
    ]
