"""Special points of branches, and their curves in two parameters, as tables."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy import float64, int8, int32, int64

from rattle_kernels import Oscillator, SpecialKind, SpecialPoint
from rattle_kernels.orbits.periodic_orbit import orbit_name
from worker.stores.layout import PERIODS, SPEED, Columns
from worker.stores.table import Column, Table

_KINDS = tuple(SpecialKind)
_DEPARTURE, _PAIR, _POINT = {"special_departure": 0}, {"multiplier": 2}, "curve_point"
_SIZE, _SIDE = {"sample_dimension": _POINT}, {"curve_side": 2}
_CODES = {
    "flag_values": list(range(1, len(_KINDS) + 1)),
    "flag_meanings": " ".join(kind.replace(" ", "_") for kind in _KINDS),
}
SPECIALS = Table("special", (
    Column("special_kind", int8, "what happens there", lambda point: _KINDS.index(point.kind) + 1, _CODES, fill=0),
    Column("special_branch", int32, "first branch that has it", None),
    Column("special_value", float64, "value of the parameter"),
    Column("special_error", float64, "last change of that value by Newton's method"),
    Column("special_residual", float64, "what is left of the equations that define it"),
    Column("special_forcing_periods", int32, "m of the orbit P(m, n+, n-) there"),
    Column("special_upper_contacts", int32, "n+ of that orbit"),
    Column("special_lower_contacts", int32, "n- of that orbit; a graze is not counted"),
    Column("special_time", float64, "phases of its departures, NaN-padded", "t", PERIODS, _DEPARTURE),
    Column("special_velocity", float64, "speeds of its departures, NaN-padded", "v", SPEED, _DEPARTURE),
    Column(
        "special_multiplier_real", float64, "eigenvalues of DP^p, real part", "multipliers.real", dims=_PAIR,
        fill=np.nan,
    ),
    Column(
        "special_multiplier_imaginary", float64, "eigenvalues of DP^p, imaginary part", "multipliers.imag", dims=_PAIR,
        fill=np.nan,
    ),
), prefix="special_", length="special_upper_contacts")  # fmt: skip
CURVES = Table("curve", (
    Column("curve_special", int32, "special point that a curve began with", None),
    Column("curve_size", int64, "points of a curve, which follow those of the one before", "t.size", _SIZE),
    Column("curve_end", str, "why it ends at its first and at its last point", "ends", dims=_SIDE),
    Column("curve_first", float64, "value of the first parameter", lambda curve: curve.values[:, 0], along=_POINT),
    Column("curve_second", float64, "value of the second parameter", lambda curve: curve.values[:, 1], along=_POINT),
    Column("curve_time", float64, "phase of the first departure", "t", PERIODS, along=_POINT),
    Column("curve_velocity", float64, "its speed, 0 for contact loss", "v", SPEED, along=_POINT),
    Column("curve_residual", float64, "what is left of the equations", along=_POINT),
), prefix="curve_")  # fmt: skip
# Branches that meet in a special point agree on its value to 1e-12.
_SAME = 1e-9
# Tolerance of speeds. Next to a fold they are known only to the square root of 1e-12.
_NEAR = 1e-5


def specials_of(columns: Columns, oscillator: Oscillator, parameter: str) -> list[SpecialPoint]:
    """Special points from the columns of a part or a store."""
    return [
        SpecialPoint(
            _KINDS[row.kind - 1], parameter, row.value, oscillator.at(**{parameter: row.value}),
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
            "orbit": orbit_name(row.forcing_periods, row.upper_contacts, row.lower_contacts),
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
