"""Periodic orbits as a table, and back: the dimension ``orbit``, like ``attractor`` in basins."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy import float64, int8, int32

from rattle_kernels import FoundOrbit, PeriodicOrbit
from worker.stores.layout import PERIODS, SPEED, Columns
from worker.stores.table import Column, Table

_POINT, _PAIR, _MATRICES = {"point": 0}, {"multiplier": 2}, {"point": 0, "row": 2, "column": 2}
ORBITS = Table("orbit", (
    Column("name", str, "P(m, n+, n-)", "orbit.name"),
    Column("forcing_periods", int32, "m of P(m, n+, n-)", "orbit.forcing_periods"),
    Column("upper_contacts", int32, "n+ of P(m, n+, n-): contacts with +beta", "orbit.upper_contacts"),
    Column("lower_contacts", int32, "n- of P(m, n+, n-): contacts with -beta", "orbit.lower_contacts"),
    Column("attracts", int8, "1 where both multipliers lie inside the unit circle, else 0", "orbit.attracts"),
    Column("multiplier_real", float64, "eigenvalues of DP^p, real part", "orbit.multipliers.real", {}, _PAIR),
    Column("multiplier_imaginary", float64, "eigenvalues of DP^p, imaginary part", "orbit.multipliers.imag", {}, _PAIR),
    Column("lyapunov_exponent", float64, "largest Lyapunov exponent per forcing period", "orbit.lyapunov_exponent"),
    Column("residual", float64, "|P^p(x) - x|, speeds relative to a fall through the backlash", "orbit.residual"),
    Column("grazing_distance", float64, "least |v - v*(t)| of its departures"),
    Column("orbit_time", float64, "phases of its departures, NaN-padded", "orbit.t", PERIODS, _POINT),
    Column("orbit_velocity", float64, "speeds of its departures, NaN-padded", "orbit.v", SPEED, _POINT),
    Column("grazing_margin", float64, "v - v*(t): above 0 where the flight meets -beta", "", SPEED, _POINT),
    Column("lower_speed", float64, "speed at -beta, NaN where it is not met", "", SPEED, _POINT),
    Column("jacobian", float64, "DP^p at each departure, NaN-padded", "orbit.jacobians", dims=_MATRICES),
), length="upper_contacts")  # fmt: skip


def orbits_of(columns: Mapping[str, Any]) -> list[FoundOrbit]:
    """Orbits from the columns of a part or a store, or from an xarray dataset."""
    return [
        FoundOrbit(
            PeriodicOrbit(
                row.orbit_time, row.orbit_velocity, row.forcing_periods, row.upper_contacts, row.lower_contacts,
                row.jacobian, row.residual,
            ),
            row.grazing_margin, row.lower_speed,
        )
        for row in ORBITS.rows(columns)
    ]  # fmt: skip


def summarise_orbits(columns: Columns) -> list[dict[str, Any]]:
    """Orbits as JSON."""
    return [
        {
            "name": row.name,
            "forcing_periods": row.forcing_periods,
            "upper_contacts": row.upper_contacts,
            "lower_contacts": row.lower_contacts,
            "attracts": bool(row.attracts),
            "multipliers": np.stack([row.multiplier_real, row.multiplier_imaginary], axis=-1).tolist(),
            "residual": row.residual,
            "grazing_distance": row.grazing_distance,
            "departures": _departures(row),
        }
        for row in ORBITS.rows(columns)
    ]


def _departures(row: Any) -> list[dict[str, float]]:
    each = row.orbit_time, row.orbit_velocity, row.grazing_margin, row.lower_speed
    names = "time", "velocity", "grazing_margin", "lower_speed"
    return [dict(zip(names, values, strict=True)) for values in np.stack(each, axis=-1).tolist()]
