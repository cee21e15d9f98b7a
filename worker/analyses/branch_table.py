"""Branches of periodic orbits as columns: points of all branches one after another, as contiguous ragged arrays."""

from typing import Any

import numpy as np

from rattle_kernels import Branch
from worker.stores.layout import MISSING, PERIODS, SPEED, Columns, Variable

_BRANCH, _ENDS = ("branch",), ("branch", "branch_end")
_POINT, _DEPARTURES = ("branch_point",), ("branch_point", "branch_departure")
BRANCHES = (
    Variable("orbit_branch", ("orbit",), np.int32, MISSING, "branch that an orbit lies on; -1 where not known"),
    Variable("branch_orbit", _BRANCH, np.int32, MISSING, "orbit that a branch began with"),
    Variable("branch_forcing_periods", _BRANCH, np.int32, MISSING, "m of its orbits P(m, n+, n-)"),
    Variable("branch_upper_contacts", _BRANCH, np.int32, MISSING, "n+ of its orbits"),
    Variable(
        "branch_size", _BRANCH, np.int64, MISSING, "points of a branch, which follow those of the one before",
        {"sample_dimension": "branch_point"},
    ),
    Variable("branch_end_reason", _ENDS, str, "", "why it ends at its first and at its last point, in a word"),
    Variable("branch_end_message", _ENDS, str, "", "the same in a sentence, with the place"),
    Variable("branch_end_value", _ENDS, np.float64, np.inf, "value of the parameter there"),
    Variable("branch_time", _DEPARTURES, np.float64, np.nan, "phases of departures, NaN-padded", PERIODS),
    Variable("branch_velocity", _DEPARTURES, np.float64, np.nan, "speeds of departures, NaN-padded", SPEED),
    Variable("branch_grazing_margin", _DEPARTURES, np.float64, np.nan, "v - v*(t) of departures", SPEED),
    Variable("branch_lower_speed", _DEPARTURES, np.float64, np.nan, "speed at -beta, NaN where it is not met", SPEED),
    Variable("branch_trace", _POINT, np.float64, np.inf, "trace of DP^p"),
    Variable("branch_area", _POINT, np.float64, np.inf, "determinant of DP^p, e^(-delta m)"),
    Variable("branch_attracts", _POINT, np.int8, MISSING, "1 where it attracts, else 0"),
)  # fmt: skip
"""Beside the parameter itself, along ``branch_point``."""
_PADDED = ("branch_time", "branch_velocity", "branch_grazing_margin", "branch_lower_speed")


def branch_variables(parameter: str) -> tuple[Variable, ...]:
    """The parameter along the branches."""
    return (Variable(parameter, _POINT, np.float64, np.inf, "value of the parameter along the branches"),)


def branch_columns(branch: Branch) -> Columns:
    """Columns of one branch."""
    return {
        branch.parameter: branch.values,
        "branch_forcing_periods": np.array([branch.forcing_periods], np.int32),
        "branch_upper_contacts": np.array([branch.upper_contacts], np.int32),
        "branch_size": np.array([branch.values.size], np.int64),
        "branch_end_reason": np.array([[end.reason.name.lower() for end in branch.ends]], object),
        "branch_end_message": np.array([[end.message for end in branch.ends]], object),
        "branch_end_value": np.array([[end.value for end in branch.ends]]),
        "branch_time": branch.t,
        "branch_velocity": branch.v,
        "branch_grazing_margin": branch.grazing_margin,
        "branch_lower_speed": branch.lower_speed,
        "branch_trace": branch.trace,
        "branch_area": branch.area,
        "branch_attracts": branch.attracts.astype(np.int8),
    }


def join_branches(parts: list[Columns], parameter: str) -> Columns:
    """Columns of several branches, one after another."""
    most = max((part["branch_time"].shape[1] for part in parts), default=0)
    joined: Columns = {}
    for variable in (*branch_variables(parameter), *BRANCHES[2:]):
        name = variable.name
        rows = [part[name] for part in parts]
        if name in _PADDED:
            rows = [np.pad(row, ((0, 0), (0, most - row.shape[1])), constant_values=np.nan) for row in rows]
            rows = rows or [np.empty((0, 0))]
        empty = np.empty((0, 2) if variable.dims == _ENDS else 0, object if variable.dtype is str else variable.dtype)
        joined[name] = np.concatenate(rows) if rows else empty
    return joined


def slices(sizes: np.ndarray) -> list[slice]:
    """Where the parts of a contiguous ragged array lie."""
    stops = np.cumsum(sizes).tolist()
    return [slice(stop - int(size), stop) for stop, size in zip(stops, sizes.tolist(), strict=True)]


def tell_branches(columns: Columns, parameter: str) -> list[dict[str, Any]]:
    """Branches as JSON."""
    told = []
    for number, points in enumerate(slices(columns["branch_size"])):
        values = columns[parameter][points]
        told.append(
            {
                "orbit": int(columns["branch_orbit"][number]),
                "points": int(values.size),
                "lowest": float(values.min()),
                "highest": float(values.max()),
                "ends": [
                    {"reason": str(reason), "message": str(message), "value": float(value)}
                    for reason, message, value in zip(
                        *(columns[f"branch_end_{name}"][number] for name in ("reason", "message", "value")), strict=True
                    )
                ],
            }
        )
    return told
