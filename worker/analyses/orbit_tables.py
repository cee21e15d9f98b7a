"""Periodic orbits, their branches, special points and curves: as tables, as objects, as models of results."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy import float64, int8, int32, int64
from pydantic import BaseModel, Field

from rattle_kernels import Branch, FoundOrbit, Oscillator, PeriodicOrbit, SpecialKind, SpecialPoint
from rattle_kernels.orbits.graze_kind import graze_kind, graze_response, small_attractor_follows
from rattle_kernels.orbits.orbit_beyond_graze import orbit_beyond_graze
from rattle_kernels.orbits.periodic_orbit import orbit_name
from worker.jobs.swept_parameter import Parameter
from worker.results.summary import FiniteOrNone
from worker.stores.layout import PERIODS, SPEED, Columns
from worker.stores.table import Column, Table

# Dimensions of the values of an orbit, of a branch's end, of a special point and of a curve's ends.
_POINT, _PAIR, _MATRICES = {"point": 0}, {"multiplier": 2}, {"point": 0, "row": 2, "column": 2}
_DEPARTURE, _END = {"branch_departure": 0}, {"branch_end": 2}
_SPECIAL_DEPARTURE, _SIDE = {"special_departure": 0}, {"curve_side": 2}
# Dimensions of the points of all branches, and of all curves, one after another.
_LINE, _CURVE = "branch_point", "curve_point"
_BRANCH_SIZE, _CURVE_SIZE = {"sample_dimension": _LINE}, {"sample_dimension": _CURVE}
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


class OrbitDeparture(BaseModel):
    """A departure of an orbit."""

    time: float
    velocity: float
    grazing_margin: float = Field(description="v - v*(t): above 0 where the flight meets -beta")
    lower_speed: FiniteOrNone = Field(description="Speed at -beta; null where it is not met")


class OrbitView(BaseModel):
    """A periodic orbit."""

    name: str = Field(description="Its itinerary", examples=["P(1,1,0)"])
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    attracts: bool
    multipliers: list[tuple[float, float]] = Field(description="Eigenvalues of DP^p: real and imaginary parts")
    residual: float
    grazing_distance: float
    departures: list[OrbitDeparture] = Field(description="From the slowest on, in order of time")
    branch: int | None = Field(None, description="Branch that it lies on; null where none was asked for")


def summarise_orbits(columns: Columns) -> list[OrbitView]:
    """Orbits of a store's columns."""
    return [
        OrbitView(
            name=row.name,
            forcing_periods=row.forcing_periods,
            upper_contacts=row.upper_contacts,
            lower_contacts=row.lower_contacts,
            attracts=bool(row.attracts),
            multipliers=np.stack([row.multiplier_real, row.multiplier_imaginary], axis=-1).tolist(),
            residual=row.residual,
            grazing_distance=row.grazing_distance,
            departures=_departures(row),
        )
        for row in ORBITS.rows(columns)
    ]


def _departures(row: Any) -> list[OrbitDeparture]:
    each = row.orbit_time, row.orbit_velocity, row.grazing_margin, row.lower_speed
    names = "time", "velocity", "grazing_margin", "lower_speed"
    return [OrbitDeparture(**dict(zip(names, values, strict=True))) for values in np.stack(each, axis=-1).tolist()]


def _why(branch: Branch) -> list[str]:
    return [end.reason.name.lower() for end in branch.ends]


def _messages(branch: Branch) -> list[str]:
    return [end.message for end in branch.ends]


def _values(branch: Branch) -> list[float]:
    return [end.value for end in branch.ends]


def branch_table(parameter: str) -> Table:
    """Table of the branches in one parameter."""
    return Table("branch", (
        Column(parameter, float64, "value of the parameter along the branches", "values", along=_LINE),
        Column("orbit_branch", int32, "branch that an orbit lies on; -1 where not known", None, along="orbit"),
        Column("branch_orbit", int32, "orbit that a branch began with", None),
        Column("branch_forcing_periods", int32, "m of its orbits P(m, n+, n-)"),
        Column("branch_upper_contacts", int32, "n+ of its orbits"),
        Column(
            "branch_size", int64, "points of a branch, which follow those of the one before", "values.size",
            _BRANCH_SIZE,
        ),
        Column("branch_end_reason", str, "why it ends at its first and at its last point, in a word", _why, dims=_END),
        Column("branch_end_message", str, "the same in a sentence, with the place", _messages, dims=_END),
        Column("branch_end_value", float64, "value of the parameter there", _values, dims=_END),
        Column("branch_time", float64, "phases of departures, NaN-padded", "t", PERIODS, _DEPARTURE, _LINE),
        Column("branch_velocity", float64, "speeds of departures, NaN-padded", "v", SPEED, _DEPARTURE, _LINE),
        Column("branch_grazing_margin", float64, "v - v*(t) of departures", "", SPEED, _DEPARTURE, _LINE),
        Column("branch_lower_speed", float64, "speed at -beta, NaN where it is not met", "", SPEED, _DEPARTURE, _LINE),
        Column("branch_trace", float64, "trace of DP^p", along=_LINE),
        Column("branch_area", float64, "determinant of DP^p, e^(-delta m)", along=_LINE),
        Column("branch_attracts", int8, "1 where it attracts, else 0", along=_LINE),
    ), prefix="branch_")  # fmt: skip


class BranchEndView(BaseModel):
    """Why a branch ends."""

    reason: Literal[
        "start", "bound", "closed", "grazing", "upper_grazing", "release", "held", "renamed", "contact_loss", "halved",
        "domain", "points", "stalled",
    ]  # fmt: skip
    message: str
    value: float = Field(description="Value of the parameter there")


class BranchView(BaseModel):
    """A branch of orbits."""

    orbit: int = Field(description="Orbit that it began with: index into `orbits`")
    points: int
    lowest: float = Field(description="Least value of the parameter on it")
    highest: float
    ends: tuple[BranchEndView, BranchEndView]


def summarise_branches(columns: Columns, parameter: str) -> list[BranchView]:
    """Branches of a store's columns."""
    return [
        BranchView(
            orbit=row.orbit,
            points=row.size,
            lowest=float(getattr(row, parameter).min()),
            highest=float(getattr(row, parameter).max()),
            ends=[
                BranchEndView(reason=str(reason), message=str(message), value=float(value))
                for reason, message, value in zip(row.end_reason, row.end_message, row.end_value, strict=True)
            ],
        )
        for row in branch_table(parameter).rows(columns)
    ]


_KINDS = tuple(SpecialKind)


def flags_of_words(kinds: Sequence[str]) -> dict[str, Any]:
    """CF attributes of an array of codes, which count from 1."""
    return {
        "flag_values": list(range(1, len(kinds) + 1)),
        "flag_meanings": " ".join(kind.replace(" ", "_") for kind in kinds),
    }


def _turn(point: SpecialPoint) -> np.ndarray:
    """N of a graze, NaN for other points; and with finite stiffness, where branches pass a graze smoothly."""
    impacts = np.isinf(point.oscillator.stiffness)
    graze = graze_kind(point) if impacts and point.kind == SpecialKind.GRAZING else None
    return np.full((2, 2), np.nan) if graze is None else graze.monodromy


def _beyond(point: SpecialPoint) -> tuple[str, float]:
    """The orbit that hits beside a graze, and the value at which it was found; no name where none was."""
    if np.isnan(_turn(point)).any():
        return "", np.nan
    found = orbit_beyond_graze(point)
    return ("", np.nan) if found is None else (found[1].name, found[0].value_of(point.parameter))


_CODES = flags_of_words(_KINDS)
SPECIALS = Table("special", (
    Column("special_kind", int8, "what happens there", lambda point: _KINDS.index(point.kind) + 1, _CODES, fill=0),
    Column("special_branch", int32, "first branch that has it", None),
    Column("special_value", float64, "value of the parameter"),
    Column("special_error", float64, "last change of that value by Newton's method"),
    Column("special_residual", float64, "what is left of the equations that define it"),
    Column("special_forcing_periods", int32, "m of the orbit P(m, n+, n-) there"),
    Column("special_upper_contacts", int32, "n+ of that orbit"),
    Column("special_lower_contacts", int32, "n- of that orbit; a graze is not counted"),
    Column("special_time", float64, "phases of its departures, NaN-padded", "t", PERIODS, _SPECIAL_DEPARTURE),
    Column("special_velocity", float64, "speeds of its departures, NaN-padded", "v", SPEED, _SPECIAL_DEPARTURE),
    Column(
        "special_multiplier_real", float64, "eigenvalues of DP^p, real part", "multipliers.real", dims=_PAIR,
        fill=np.nan,
    ),
    Column(
        "special_multiplier_imaginary", float64, "eigenvalues of DP^p, imaginary part", "multipliers.imag", dims=_PAIR,
        fill=np.nan,
    ),
    Column(
        "special_turn", float64, "N of a graze: derivative of a turn in (position, velocity) at its touch", _turn,
        dims={"row": 2, "column": 2}, fill=np.nan,
    ),
    Column("special_beyond", str, "orbit beside a graze with one impact more", lambda point: _beyond(point)[0]),
    Column(
        "special_beyond_value", float64, "value of the parameter at which that was found",
        lambda point: _beyond(point)[1], fill=np.nan,
    ),
), prefix="special_", length="special_upper_contacts")  # fmt: skip
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


def folding(columns: Columns) -> np.ndarray:
    """Which special points are grazes in whose fold the orbit vanishes, shape (specials,)."""
    return np.array([graze_response(turn) < 0.0 for turn in columns["special_turn"]], bool)


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


class SpecialDeparture(BaseModel):
    """A departure of the orbit at a special point."""

    time: float
    velocity: float


class GrazeView(BaseModel):
    """What a graze does to its orbit."""

    scenario: Literal["persists", "folds"]
    response: float = Field(description="N_12/det(I - N), whose sign says which")
    turn: list[list[float]] = Field(description="N, the derivative of a turn in (position, velocity) at the touch")
    small_attractor_follows: bool = Field(
        description="Whether something small attracts at once where the orbit attracts no more, as a rule chaos"
    )
    beyond: str = Field(description="Orbit with one impact more that was found beside the graze; empty if none was")
    beyond_value: FiniteOrNone = Field(description="Value of the parameter at which that was found")
    says: str = Field(description="In a sentence or two")


def _graze_of(row: Any, name: str) -> GrazeView | None:
    if np.isnan(row.turn).any():
        return None
    response, follows = graze_response(row.turn), small_attractor_follows(row.turn)
    if response < 0.0:
        says = f"{name} meets an orbit that hits -beta, and both vanish."
    elif follows:
        says = f"{name} goes on with one impact more, as a saddle; a small attractor takes its place at once."
    else:
        says = f"{name} goes on with one impact more, as a saddle."
    return GrazeView(
        scenario="persists" if response > 0.0 else "folds", response=response, turn=row.turn.tolist(),
        small_attractor_follows=follows, beyond=str(row.beyond), beyond_value=row.beyond_value, says=says,
    )  # fmt: skip


class SpecialPointView(BaseModel):
    """A special point of branches."""

    kind: Literal["saddle-node", "period doubling", "grazing", "contact loss", "upper grazing", "release"]
    parameter: Parameter
    value: float
    error: float = Field(description="Last change of the value by Newton's method")
    residual: float
    orbit: str = Field(description="Itinerary of the orbit there; a contact that only grazes is not counted")
    branch: int = Field(description="First branch that has it: index into `branches`")
    multipliers: list[tuple[FiniteOrNone, FiniteOrNone]]
    departures: list[SpecialDeparture] = Field(description="The first one grazes, or loses contact, or comes to rest")
    graze: GrazeView | None = Field(description="Of a graze of -beta in the impacting model; null for others")


def summarise_specials(columns: Columns, parameter: Parameter) -> list[SpecialPointView]:
    """Special points of a store's columns."""
    return [_special_view(row, parameter) for row in SPECIALS.rows(columns)]


def _special_view(row: Any, parameter: Parameter) -> SpecialPointView:
    rests = not (row.multiplier_real.any() or row.multiplier_imaginary.any())
    name = orbit_name(row.forcing_periods, row.upper_contacts, row.lower_contacts, rests=rests)
    departures = zip(row.time.tolist(), row.velocity.tolist(), strict=True)
    return SpecialPointView(
        kind=_KINDS[row.kind - 1].value, parameter=parameter, value=row.value, error=row.error, residual=row.residual,
        orbit=name, branch=row.branch,
        multipliers=np.stack([row.multiplier_real, row.multiplier_imaginary], axis=-1).tolist(),
        departures=[SpecialDeparture(time=t, velocity=v) for t, v in departures], graze=_graze_of(row, name),
    )  # fmt: skip


CURVES = Table("curve", (
    Column("curve_special", int32, "special point that a curve began with", None),
    Column("curve_size", int64, "points of a curve, which follow those of the one before", "t.size", _CURVE_SIZE),
    Column("curve_end", str, "why it ends at its first and at its last point", "ends", dims=_SIDE),
    Column("curve_first", float64, "value of the first parameter", lambda curve: curve.values[:, 0], along=_CURVE),
    Column("curve_second", float64, "value of the second parameter", lambda curve: curve.values[:, 1], along=_CURVE),
    Column("curve_time", float64, "phase of the first departure", "t", PERIODS, along=_CURVE),
    Column("curve_velocity", float64, "its speed, 0 for contact loss", "v", SPEED, along=_CURVE),
    Column("curve_residual", float64, "what is left of the equations", along=_CURVE),
), prefix="curve_")  # fmt: skip


class CurveView(BaseModel):
    """A curve of special points in two parameters."""

    special_point: int = Field(description="Which it began with: index into `special_points`")
    parameters: tuple[Parameter, Parameter]
    points: int
    first: tuple[float, float] = Field(description="Least and greatest value of the first parameter")
    second: tuple[float, float]
    ends: tuple[str, str] = Field(description="Why it ends, in words")


def summarise_curves(columns: Columns, parameters: tuple[Parameter, Parameter]) -> list[CurveView]:
    """Curves of a store's columns: how far they reach and why they end. Their points are in the store."""
    return [
        CurveView(
            special_point=row.special,
            parameters=parameters,
            points=row.size,
            first=(float(row.first.min()), float(row.first.max())),
            second=(float(row.second.min()), float(row.second.max())),
            ends=tuple(map(str, row.end)),
        )
        for row in CURVES.rows(columns)
    ]
