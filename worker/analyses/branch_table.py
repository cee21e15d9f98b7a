"""Branches of periodic orbits as a table: the points of all branches one after another."""

from typing import Any

from numpy import float64, int8, int32, int64

from rattle_kernels import Branch
from worker.stores.layout import PERIODS, SPEED, Columns
from worker.stores.table import Column, Table

_POINT, _DEPARTURE, _END = "branch_point", {"branch_departure": 0}, {"branch_end": 2}
_SIZE = {"sample_dimension": _POINT}


def _why(branch: Branch) -> list[str]:
    return [end.reason.name.lower() for end in branch.ends]


def _messages(branch: Branch) -> list[str]:
    return [end.message for end in branch.ends]


def _values(branch: Branch) -> list[float]:
    return [end.value for end in branch.ends]


def branch_table(parameter: str) -> Table:
    """Table of the branches in one parameter."""
    return Table("branch", (
        Column(parameter, float64, "value of the parameter along the branches", "values", along=_POINT),
        Column("orbit_branch", int32, "branch that an orbit lies on; -1 where not known", None, along="orbit"),
        Column("branch_orbit", int32, "orbit that a branch began with", None),
        Column("branch_forcing_periods", int32, "m of its orbits P(m, n+, n-)"),
        Column("branch_upper_contacts", int32, "n+ of its orbits"),
        Column("branch_size", int64, "points of a branch, which follow those of the one before", "values.size", _SIZE),
        Column("branch_end_reason", str, "why it ends at its first and at its last point, in a word", _why, dims=_END),
        Column("branch_end_message", str, "the same in a sentence, with the place", _messages, dims=_END),
        Column("branch_end_value", float64, "value of the parameter there", _values, dims=_END),
        Column("branch_time", float64, "phases of departures, NaN-padded", "t", PERIODS, _DEPARTURE, _POINT),
        Column("branch_velocity", float64, "speeds of departures, NaN-padded", "v", SPEED, _DEPARTURE, _POINT),
        Column("branch_grazing_margin", float64, "v - v*(t) of departures", "", SPEED, _DEPARTURE, _POINT),
        Column("branch_lower_speed", float64, "speed at -beta, NaN where it is not met", "", SPEED, _DEPARTURE, _POINT),
        Column("branch_trace", float64, "trace of DP^p", along=_POINT),
        Column("branch_area", float64, "determinant of DP^p, e^(-delta m)", along=_POINT),
        Column("branch_attracts", int8, "1 where it attracts, else 0", along=_POINT),
    ), prefix="branch_")  # fmt: skip


def summarise_branches(columns: Columns, parameter: str) -> list[dict[str, Any]]:
    """Branches as JSON."""
    return [
        {
            "orbit": row.orbit,
            "points": row.size,
            "lowest": float(getattr(row, parameter).min()),
            "highest": float(getattr(row, parameter).max()),
            "ends": [
                {"reason": str(reason), "message": str(message), "value": float(value)}
                for reason, message, value in zip(row.end_reason, row.end_message, row.end_value, strict=True)
            ],
        }
        for row in branch_table(parameter).rows(columns)
    ]
