"""Periodic orbits as columns of a store, and back: the dimension ``orbit``, as ``attractor`` is that of basins."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rattle_kernels import FoundOrbit, PeriodicOrbit
from worker.stores.layout import MISSING, PERIODS, SPEED, Columns, Variable

_ORBIT, _POINTS, _PAIR = ("orbit",), ("orbit", "point"), ("orbit", "multiplier")
ORBITS = (
    Variable("name", _ORBIT, str, "", "P(m, n+, n-)"),
    Variable("forcing_periods", _ORBIT, np.int32, MISSING, "m of P(m, n+, n-)"),
    Variable("upper_contacts", _ORBIT, np.int32, MISSING, "n+ of P(m, n+, n-): contacts with +beta"),
    Variable("lower_contacts", _ORBIT, np.int32, MISSING, "n- of P(m, n+, n-): contacts with -beta"),
    Variable("attracts", _ORBIT, np.int8, MISSING, "1 where both multipliers lie inside the unit circle, else 0"),
    Variable("multiplier_real", _PAIR, np.float64, np.inf, "eigenvalues of DP^p, real part"),
    Variable("multiplier_imaginary", _PAIR, np.float64, np.inf, "eigenvalues of DP^p, imaginary part"),
    Variable("lyapunov_exponent", _ORBIT, np.float64, np.inf, "largest Lyapunov exponent per forcing period"),
    Variable("residual", _ORBIT, np.float64, np.inf, "|P^p(x) - x|, speeds relative to a fall through the backlash"),
    Variable("grazing_distance", _ORBIT, np.float64, np.inf, "least |v - v*(t)| of its departures"),
    Variable("orbit_time", _POINTS, np.float64, np.nan, "phases of its departures, NaN-padded", PERIODS),
    Variable("orbit_velocity", _POINTS, np.float64, np.nan, "speeds of its departures, NaN-padded", SPEED),
    Variable("grazing_margin", _POINTS, np.float64, np.nan, "v - v*(t): above 0 where the flight meets -beta", SPEED),
    Variable("lower_speed", _POINTS, np.float64, np.nan, "speed at -beta, NaN where it is not met", SPEED),
    Variable("jacobian", ("orbit", "point", "row", "column"), np.float64, np.nan, "DP^p at each departure, NaN-padded"),
)
"""What is stored of periodic orbits."""


def padded(rows: Sequence[np.ndarray], shape: tuple[int, ...] = ()) -> np.ndarray:
    """Rows of different lengths as one array, NaN where they end; `shape` is that of an element."""
    longest = max((len(row) for row in rows), default=0)
    array = np.full((len(rows), longest, *shape), np.nan)
    for number, row in enumerate(rows):
        array[number, : len(row)] = row
    return array


def orbit_columns(found: Sequence[FoundOrbit]) -> Columns:
    """Columns of some orbits."""
    orbits = [each.orbit for each in found]
    multipliers = np.array([orbit.multipliers for orbit in orbits], complex).reshape(-1, 2)
    return {
        "name": np.array([orbit.name for orbit in orbits], dtype=object),
        "forcing_periods": np.array([orbit.forcing_periods for orbit in orbits], np.int32),
        "upper_contacts": np.array([orbit.upper_contacts for orbit in orbits], np.int32),
        "lower_contacts": np.array([orbit.lower_contacts for orbit in orbits], np.int32),
        "attracts": np.array([orbit.attracts for orbit in orbits], np.int8),
        "multiplier_real": multipliers.real,
        "multiplier_imaginary": multipliers.imag,
        "lyapunov_exponent": np.array([orbit.lyapunov_exponent for orbit in orbits]),
        "residual": np.array([orbit.residual for orbit in orbits]),
        "grazing_distance": np.array([each.grazing_distance for each in found]),
        "orbit_time": padded([orbit.t for orbit in orbits]),
        "orbit_velocity": padded([orbit.v for orbit in orbits]),
        "grazing_margin": padded([each.grazing_margin for each in found]),
        "lower_speed": padded([each.lower_speed for each in found]),
        "jacobian": padded([orbit.jacobians for orbit in orbits], (2, 2)),
    }


def orbits_of(columns: Mapping[str, Any]) -> list[FoundOrbit]:
    """Orbits of such columns: of a part, of a store, or the values of an xarray dataset."""
    found = []
    for i, period in enumerate(np.asarray(columns["upper_contacts"]).tolist()):
        t, v, margin, lower_speed, jacobians = (
            np.asarray(columns[name])[i, :period]
            for name in ("orbit_time", "orbit_velocity", "grazing_margin", "lower_speed", "jacobian")
        )
        forcing, lower = (int(np.asarray(columns[name])[i]) for name in ("forcing_periods", "lower_contacts"))
        residual = float(np.asarray(columns["residual"])[i])
        orbit = PeriodicOrbit(t, v, forcing, period, lower, jacobians, residual)
        found.append(FoundOrbit(orbit, margin, lower_speed))
    return found


def tell_orbits(columns: Columns) -> list[dict[str, Any]]:
    """Orbits as JSON."""
    pairs = np.stack([columns["multiplier_real"], columns["multiplier_imaginary"]], axis=-1)
    return [
        {
            "name": found.orbit.name,
            "forcing_periods": found.orbit.forcing_periods,
            "upper_contacts": found.orbit.upper_contacts,
            "lower_contacts": found.orbit.lower_contacts,
            "attracts": bool(attracts),
            "multipliers": pair.tolist(),
            "residual": found.orbit.residual,
            "grazing_distance": float(distance),
            "departures": [
                {"time": t, "velocity": v, "grazing_margin": margin, "lower_speed": speed}
                for t, v, margin, speed in zip(
                    *(each.tolist() for each in (found.orbit.t, found.orbit.v, *found[1:])), strict=True
                )
            ],
        }
        for found, attracts, pair, distance in zip(
            orbits_of(columns), columns["attracts"], pairs, columns["grazing_distance"], strict=True
        )
    ]
