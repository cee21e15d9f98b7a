"""Branches of periodic orbits as a table: the points of all branches one after another."""

from typing import Any

import numpy as np

from worker.stores.layout import PERIODS, SPEED, Columns
from worker.stores.table import Column, Table

_POINT, _DEPARTURE, _END = "branch_point", {"branch_departure": 0}, {"branch_end": 2}


def branch_table(parameter: str) -> Table:
    """Table of the branches in one parameter."""
    return Table(
        "branch",
        (
            Column(parameter, np.float64, "values", "value of the parameter along the branches", along=_POINT),
            Column(
                "orbit_branch", np.int32, None, "branch that an orbit lies on; -1 where not known", along="orbit"
            ),
            Column("branch_orbit", np.int32, None, "orbit that a branch began with"),
            Column("branch_forcing_periods", np.int32, "forcing_periods", "m of its orbits P(m, n+, n-)"),
            Column("branch_upper_contacts", np.int32, "upper_contacts", "n+ of its orbits"),
            Column(
                "branch_size", np.int64, "values.size", "points of a branch, which follow those of the one before",
                {"sample_dimension": "branch_point"},
            ),
            Column(
                "branch_end_reason", str, lambda branch: [end.reason.name.lower() for end in branch.ends],
                "why it ends at its first and at its last point, in a word", dims=_END,
            ),
            Column(
                "branch_end_message", str, lambda branch: [end.message for end in branch.ends],
                "the same in a sentence, with the place", dims=_END,
            ),
            Column(
                "branch_end_value", np.float64, lambda branch: [end.value for end in branch.ends],
                "value of the parameter there", dims=_END,
            ),
            Column("branch_time", np.float64, "t", "phases of departures, NaN-padded", PERIODS, _DEPARTURE, _POINT),
            Column("branch_velocity", np.float64, "v", "speeds of departures, NaN-padded", SPEED, _DEPARTURE, _POINT),
            Column(
                "branch_grazing_margin", np.float64, "grazing_margin", "v - v*(t) of departures", SPEED, _DEPARTURE,
                _POINT,
            ),
            Column(
                "branch_lower_speed", np.float64, "lower_speed", "speed at -beta, NaN where it is not met", SPEED,
                _DEPARTURE, _POINT,
            ),
            Column("branch_trace", np.float64, "trace", "trace of DP^p", along=_POINT),
            Column("branch_area", np.float64, "area", "determinant of DP^p, e^(-delta m)", along=_POINT),
            Column("branch_attracts", np.int8, "attracts", "1 where it attracts, else 0", along=_POINT),
        ),
        prefix="branch_",
    )  # fmt: skip


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
