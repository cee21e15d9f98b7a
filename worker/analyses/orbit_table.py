"""Periodic orbits as a table, and back: the dimension ``orbit``, like ``attractor`` in basins."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from rattle_kernels import FoundOrbit, PeriodicOrbit
from worker.stores.layout import PERIODS, SPEED, Columns
from worker.stores.table import Column, Table

_POINT, _PAIR = {"point": 0}, {"multiplier": 2}
ORBITS = Table(
    "orbit",
    (
        Column("name", str, "orbit.name", "P(m, n+, n-)"),
        Column("forcing_periods", np.int32, "orbit.forcing_periods", "m of P(m, n+, n-)"),
        Column("upper_contacts", np.int32, "orbit.upper_contacts", "n+ of P(m, n+, n-): contacts with +beta"),
        Column("lower_contacts", np.int32, "orbit.lower_contacts", "n- of P(m, n+, n-): contacts with -beta"),
        Column("attracts", np.int8, "orbit.attracts", "1 where both multipliers lie inside the unit circle, else 0"),
        Column(
            "multiplier_real", np.float64, lambda each: each.orbit.multipliers.real,
            "eigenvalues of DP^p, real part", dims=_PAIR,
        ),
        Column(
            "multiplier_imaginary", np.float64, lambda each: each.orbit.multipliers.imag,
            "eigenvalues of DP^p, imaginary part", dims=_PAIR,
        ),
        Column(
            "lyapunov_exponent", np.float64, "orbit.lyapunov_exponent", "largest Lyapunov exponent per forcing period"
        ),
        Column(
            "residual", np.float64, "orbit.residual", "|P^p(x) - x|, speeds relative to a fall through the backlash"
        ),
        Column("grazing_distance", np.float64, "grazing_distance", "least |v - v*(t)| of its departures"),
        Column("orbit_time", np.float64, "orbit.t", "phases of its departures, NaN-padded", PERIODS, _POINT),
        Column("orbit_velocity", np.float64, "orbit.v", "speeds of its departures, NaN-padded", SPEED, _POINT),
        Column(
            "grazing_margin", np.float64, "grazing_margin", "v - v*(t): above 0 where the flight meets -beta", SPEED,
            _POINT,
        ),
        Column("lower_speed", np.float64, "lower_speed", "speed at -beta, NaN where it is not met", SPEED, _POINT),
        Column(
            "jacobian", np.float64, "orbit.jacobians", "DP^p at each departure, NaN-padded",
            dims={"point": 0, "row": 2, "column": 2},
        ),
    ),
    length="upper_contacts",
)  # fmt: skip


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
