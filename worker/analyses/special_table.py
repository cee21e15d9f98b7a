"""Special points of branches, and their curves in two parameters, as columns."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle_kernels import Oscillator, SpecialCurve, SpecialKind, SpecialPoint
from worker.analyses.branch_table import slices
from worker.analyses.orbit_table import padded
from worker.stores.layout import MISSING, PERIODS, SPEED, Columns, Variable

_KINDS = tuple(SpecialKind)
_SPECIAL, _DEPARTURES, _PAIR = ("special",), ("special", "special_departure"), ("special", "multiplier")
_CURVE, _POINT = ("curve",), ("curve_point",)
SPECIALS = (
    Variable(
        "special_kind", _SPECIAL, np.int8, 0, "what happens there",
        {
            "flag_values": list(range(1, len(_KINDS) + 1)),
            "flag_meanings": " ".join(kind.replace(" ", "_") for kind in _KINDS),
        },
    ),
    Variable("special_branch", _SPECIAL, np.int32, MISSING, "first branch that has it"),
    Variable("special_value", _SPECIAL, np.float64, np.inf, "value of the parameter"),
    Variable("special_error", _SPECIAL, np.float64, np.inf, "last change of that value by Newton's method"),
    Variable("special_residual", _SPECIAL, np.float64, np.inf, "what is left of the equations that define it"),
    Variable("special_forcing_periods", _SPECIAL, np.int32, MISSING, "m of the orbit P(m, n+, n-) there"),
    Variable("special_upper_contacts", _SPECIAL, np.int32, MISSING, "n+ of that orbit"),
    Variable("special_lower_contacts", _SPECIAL, np.int32, MISSING, "n- of that orbit; a graze is not counted"),
    Variable("special_time", _DEPARTURES, np.float64, np.nan, "phases of its departures, NaN-padded", PERIODS),
    Variable("special_velocity", _DEPARTURES, np.float64, np.nan, "speeds of its departures, NaN-padded", SPEED),
    Variable("special_multiplier_real", _PAIR, np.float64, np.nan, "eigenvalues of DP^p, real part"),
    Variable("special_multiplier_imaginary", _PAIR, np.float64, np.nan, "eigenvalues of DP^p, imaginary part"),
)  # fmt: skip
CURVES = (
    Variable("curve_special", _CURVE, np.int32, MISSING, "special point that a curve began with"),
    Variable(
        "curve_size", _CURVE, np.int64, MISSING, "points of a curve, which follow those of the one before",
        {"sample_dimension": "curve_point"},
    ),
    Variable("curve_end", ("curve", "curve_side"), str, "", "why it ends at its first and at its last point"),
    Variable("curve_first", _POINT, np.float64, np.inf, "value of the first parameter"),
    Variable("curve_second", _POINT, np.float64, np.inf, "value of the second parameter"),
    Variable("curve_time", _POINT, np.float64, np.inf, "phase of the first departure", PERIODS),
    Variable("curve_velocity", _POINT, np.float64, np.inf, "its speed, 0 for contact loss", SPEED),
    Variable("curve_residual", _POINT, np.float64, np.inf, "what is left of the equations"),
)  # fmt: skip
# Branches that meet in a special point give its value to 1e-12.
_SAME = 1e-9
# Speeds of orbits that are one; next to a fold they are known to the root of that.
_NEAR = 1e-5


def special_columns(points: Sequence[SpecialPoint]) -> Columns:
    """Columns of some points."""
    multipliers = np.array([point.multipliers for point in points], complex).reshape(-1, 2)
    return {
        "special_kind": np.array([_KINDS.index(point.kind) + 1 for point in points], np.int8),
        "special_value": np.array([point.value for point in points], np.float64),
        "special_error": np.array([point.error for point in points], np.float64),
        "special_residual": np.array([point.residual for point in points], np.float64),
        "special_forcing_periods": np.array([point.forcing_periods for point in points], np.int32),
        "special_upper_contacts": np.array([point.upper_contacts for point in points], np.int32),
        "special_lower_contacts": np.array([point.lower_contacts for point in points], np.int32),
        "special_time": padded([point.t for point in points]),
        "special_velocity": padded([point.v for point in points]),
        "special_multiplier_real": multipliers.real,
        "special_multiplier_imaginary": multipliers.imag,
    }


def specials_of(columns: Columns, oscillator: Oscillator, parameter: str) -> list[SpecialPoint]:
    """Points of such columns."""
    points = []
    for i, code in enumerate(columns["special_kind"].tolist()):
        value, period = float(columns["special_value"][i]), int(columns["special_upper_contacts"][i])
        multipliers = columns["special_multiplier_real"][i] + 1j * columns["special_multiplier_imaginary"][i]
        points.append(
            SpecialPoint(
                _KINDS[code - 1], parameter, value, oscillator._replace(**{parameter: value}),
                int(columns["special_forcing_periods"][i]), period, int(columns["special_lower_contacts"][i]),
                columns["special_time"][i, :period], columns["special_velocity"][i, :period], multipliers,
                float(columns["special_residual"][i]), float(columns["special_error"][i]),
            )
        )  # fmt: skip
    return points


def distinct(points: Sequence[tuple[SpecialPoint, int]]) -> tuple[list[SpecialPoint], list[int]]:
    """Points that several branches have, each once, with the first branch that has it."""
    kept: list[tuple[SpecialPoint, int]] = []
    for point, branch in points:
        if not any(_is_one(point, other) for other, _ in kept):
            kept.append((point, branch))
    return [point for point, _ in kept], [branch for _, branch in kept]


def _is_one(one: SpecialPoint, other: SpecialPoint) -> bool:
    shapes = [(point.kind, point.forcing_periods, point.upper_contacts) for point in (one, other)]
    apart = abs(one.value - other.value) / max(1.0, abs(one.value))
    return shapes[0] == shapes[1] and apart < _SAME and abs(one.v.min() - other.v.min()) < _NEAR


def tell_specials(columns: Columns, parameter: str) -> list[dict[str, Any]]:
    """Special points as JSON."""
    names = ("forcing_periods", "upper_contacts", "lower_contacts")
    return [
        {
            "kind": _KINDS[int(columns["special_kind"][i]) - 1].value,
            "parameter": parameter,
            "value": float(columns["special_value"][i]),
            "error": float(columns["special_error"][i]),
            "residual": float(columns["special_residual"][i]),
            "orbit": f"P({','.join(str(int(columns[f'special_{name}'][i])) for name in names)})",
            "branch": int(columns["special_branch"][i]),
            "multipliers": np.stack(
                [columns["special_multiplier_real"][i], columns["special_multiplier_imaginary"][i]], axis=-1
            ).tolist(),
            "departures": [
                {"time": t, "velocity": v}
                for t, v in zip(
                    columns["special_time"][i].tolist(), columns["special_velocity"][i].tolist(), strict=True
                )
                if np.isfinite(t)
            ],
        }
        for i in range(columns["special_kind"].size)
    ]


def curve_columns(curve: SpecialCurve) -> Columns:
    """Columns of one curve."""
    return {
        "curve_size": np.array([curve.t.size], np.int64),
        "curve_end": np.array([curve.ends], object),
        "curve_first": curve.values[:, 0],
        "curve_second": curve.values[:, 1],
        "curve_time": curve.t,
        "curve_velocity": curve.v,
        "curve_residual": curve.residual,
    }


def join_curves(parts: Sequence[Columns]) -> Columns:
    """Columns of several curves, one after another."""
    joined = {}
    for variable in CURVES[1:]:
        empty = np.empty(
            (0, 2) if variable.name == "curve_end" else 0, object if variable.dtype is str else variable.dtype
        )
        joined[variable.name] = np.concatenate([part[variable.name] for part in parts]) if parts else empty
    return joined


def tell_curves(columns: Columns, parameters: tuple[str, str]) -> list[dict[str, Any]]:
    """Curves as JSON: how far they reach and why they end; their points are in the store."""
    told = []
    for number, points in enumerate(slices(columns["curve_size"])):
        first, second = columns["curve_first"][points], columns["curve_second"][points]
        told.append(
            {
                "special_point": int(columns["curve_special"][number]),
                "parameters": list(parameters),
                "points": int(first.size),
                "first": [float(first.min()), float(first.max())],
                "second": [float(second.min()), float(second.max())],
                "ends": [str(end) for end in columns["curve_end"][number]],
            }
        )
    return told
