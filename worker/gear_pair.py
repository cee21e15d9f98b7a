"""A machine in its own units: a gear pair in SI, its oscillator, and what one unit of the model is in SI.

Two shafts turn at the mean speeds that their base radii allow. Both lose speed at the same rate, ``c1/I1 = c2/I2``::

    I1 theta1'' + c1 theta1' = T - R1 F        I2 theta2'' + c2 theta2' = R2 F

Their difference along the line of action, ``x = R1 theta1 - R2 theta2``, and the transmission error e, scaled as
``Phi = (x + e)/L``, follow Eq. (1). docs/theory/machine.md derives each line.
"""

import json
import math
import re
import sys
import tomllib
from collections.abc import Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, Self, TypeVar

from pydantic import BeforeValidator, Field, ValidationError, model_validator

from rattle_kernels import Harmonic, Oscillator, OutsideDomain, check_quiet
from rattle_kernels.model.arcs import rest_acceleration_over_phases
from rattle_kernels.numerics.trigonometric_minimum import least_value
from worker.errors import InvalidFields, InvalidJob
from worker.jobs.oscillator_request import MOST_HARMONICS
from worker.jobs.request import Real, Request, Whole, refusal

if TYPE_CHECKING:
    import pandas as pd
    import pint
    import xarray as xr

    Quantity = float | str
    """A number in SI units, or a number with its unit, as in ``"3000 rpm"``."""

_T = TypeVar("_T")
_TWO_PI = 2.0 * math.pi
_FOUR_PI = 4.0 * math.pi
_RPM = 60.0 / _TWO_PI
_HIGHEST_ORDER = 1000
_ROUNDING = 4.0 * sys.float_info.epsilon
# Numbers of the model, and of its units in SI: beyond these their squares and products are none.
_LEAST, _GREATEST = 1e-100, 1e100
MACHINE = "machine"
"""Field of a request, and attribute of a result as JSON, that says of which machine it is."""
IN_SI = {
    "time": ("time_s", "s"),
    "velocity": ("speed_m_s", "m/s"),
    "grazing_velocity": ("grazing_speed_m_s", "m/s"),
    "orbit_time": ("orbit_time_s", "s"),
    "orbit_velocity": ("orbit_speed_m_s", "m/s"),
    "displacement": ("displacement_m", "m"),
    "contact_time": ("contact_time_s", "s"),
    "contact_speed": ("contact_speed_m_s", "m/s"),
    "largest_impact_speed": ("largest_impact_speed_m_s", "m/s"),
    "impact_power": ("impact_power_w", "W"),
    "impact_power_error": ("impact_power_error_w", "W"),
    "expected_largest_impact_speed": ("expected_largest_impact_speed_m_s", "m/s"),
    "expected_largest_impact_speed_error": ("expected_largest_impact_speed_error_m_s", "m/s"),
    "expected_impact_power": ("expected_impact_power_w", "W"),
    "expected_impact_power_error": ("expected_impact_power_error_w", "W"),
}
"""Variables of results, what they are called in SI, and their units.

Those that may be large are read lazily, and are left out.
"""
# No arithmetic: a text that comes over HTTP must not be a computation.
_UNIT = r"[A-Za-z\u00b5\u03bc\u00b0]+(?:(?:\^|\*\*)-?[1-9])?"
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?"
_UNITS = rf"(?:1?\s*/\s*)?{_UNIT}(?:[ */\u00b7]+{_UNIT})*"
_QUANTITY = re.compile(rf"\s*(?P<number>{_NUMBER})\s*(?P<unit>{_UNITS})?\s*")
# For pint, Nm counts yarn.
_NEWTON_METRE = re.compile(r"\b([mk]?)Nm\b")
_EXAMPLES = {
    "rad/s": "3000 rpm",
    "kg m^2": "0.02 kg m^2",
    "N m": "0.5 N m",
    "m": "50 um",
    "N/m": "1e8 N/m",
    "turn": "90 deg",
    "N m s": "0.05 N m s",
    "1/s": "3 / hour",
}
_ANGULAR, _RATE = ("rad/s", "turn"), "1/s"
_NO_PINT = "units need pint: pip install 'gear-rattle[units]', or give a number in SI units"


@cache
def _registry() -> "pint.UnitRegistry[Any]":
    try:
        import pint
    except ImportError as error:
        raise InvalidJob(_NO_PINT) from error
    return pint.UnitRegistry()


def number_and_unit(text: str) -> tuple[float, str | None]:
    """Number of a text, and the unit behind it, as written: ``(35.0, "um")`` of ``"35 um"``.

    Raises
    ------
    InvalidJob
        If it is no number with a unit.
    """
    parts = _QUANTITY.fullmatch(text)
    if not parts:
        raise InvalidJob(f"{text!r} is no number with a unit")
    return float(parts["number"]), parts["unit"]


def in_si(value: Any, unit: str) -> Any:
    """A physical quantity as a number in SI units.

    Parameters
    ----------
    value : float or str
        A number, which is in SI units already, or a number with a unit, as in ``"35 um"``.
    unit : str
        The unit in which it is wanted, as in ``"m"``.

    Returns
    -------
    float
        What is no text is returned as it is.

    Raises
    ------
    InvalidJob
        If the text is no quantity, has a unit of another dimension, or pint is not installed.

    Examples
    --------
    >>> from worker.gear_pair import in_si
    >>> in_si("35 um", "m"), in_si(0.02, "kg m^2")
    (3.5e-05, 0.02)
    """
    if not isinstance(value, str):
        return value
    right = f'write it as in "{_EXAMPLES[unit]}"'
    try:
        number, written = number_and_unit(value)
    except InvalidJob as error:
        raise InvalidJob(f"{error}: {right}") from None
    if not written:
        raise InvalidJob(f"{value!r} has no unit: {right}, or give a number, which is in {unit}")
    registry = _registry()
    import pint

    written = _NEWTON_METRE.sub(r"\1N m", written)
    try:
        quantity = number * registry.parse_units(f"1{written}" if written[0] == "/" else written)
        # As written: 57.1 mm are 0.0571 m, where the product of two floats is 0.057100000000000005.
        converted = float(f"{quantity.to(unit).magnitude:.15g}")
    except pint.UndefinedUnitError as error:
        raise InvalidJob(f"{value!r}: {error}: {right}") from None
    except pint.DimensionalityError:
        raise InvalidJob(f"{value!r} cannot be in {unit}: {right}") from None
    except pint.OffsetUnitCalculusError:
        raise InvalidJob(f"{value!r} is a temperature: {right}") from None
    # For pint a radian is the number 1, so 50 Hz would be 50 rad/s, and 50 rpm 5.2 a second.
    angular = "radian" in f"{quantity.to_root_units().units}"
    if unit in _ANGULAR and not angular:
        raise InvalidJob(f"{value!r} does not say which angle is meant: {right}")
    if unit == _RATE and angular:
        raise InvalidJob(f"{value!r} is a speed of rotation, not how often something happens: {right}")
    return converted


def _read_as(unit: str) -> BeforeValidator:
    def read(value: Any) -> Any:
        try:
            return in_si(value, unit)
        except InvalidJob as error:  # of a field, as any other wrong value
            raise ValueError(str(error)) from None

    return BeforeValidator(read, json_schema_input_type=float | str)


AngularSpeed = Annotated[Real, _read_as("rad/s")]
Inertia = Annotated[Real, _read_as("kg m^2")]
Torque = Annotated[Real, _read_as("N m")]
Length = Annotated[Real, _read_as("m")]
Stiffness = Annotated[Real, _read_as("N/m")]
Turns = Annotated[Real, _read_as("turn")]


class ErrorOrder(Request):
    """One order of the transmission error: ``amplitude cos(2 pi (order t + phase))``, t in forcing periods."""

    amplitude: Length = Field(ge=0, description="along the line of action, m")
    phase: Turns = Field(0.0, description="in periods of this order")


def _orders(value: Any) -> Any:
    """An amplitude is that of the first order; of several each is an amplitude, or a table of amplitude and phase."""
    if not isinstance(value, Mapping):
        return {1: {"amplitude": value}}
    return {
        order: each if isinstance(each, Mapping | ErrorOrder) else {"amplitude": each} for order, each in value.items()
    }


def _as_order(value: Any) -> Any:
    """TOML and JSON write keys as text."""
    return int(value) if isinstance(value, str) and value.isascii() and value.isdecimal() else value


Order = Annotated[int, Field(strict=True, ge=1, le=_HIGHEST_ORDER), BeforeValidator(_as_order)]


def beside_in_si(result: "xr.Dataset", units: "Mapping[str, float | xr.Variable]") -> "xr.Dataset":
    """A result with SI units beside the numbers of the model.

    Parameters
    ----------
    result : xarray.Dataset
    units : mapping
        One unit of the model, by the unit in SI. It may differ along a dimension of the result.

    Returns
    -------
    xarray.Dataset
    """
    import xarray as xr

    added = {}
    for name, (own, unit) in IN_SI.items():
        if name in result.variables:
            variable = result.variables[name]
            attributes = {"units": unit, "long_name": variable.attrs.get("long_name", name)}
            scaled = units[unit] * xr.Variable(variable.dims, variable.values)
            added[own] = (scaled.dims, scaled.values, attributes)
    coordinates = {own: value for own, value in added.items() if own in ("time_s", "speed_m_s")}
    others = {own: value for own, value in added.items() if own not in coordinates}
    return result.assign_coords(coordinates).assign(others)


def with_columns_in_si(table: "pd.DataFrame", units: "Mapping[str, float | pd.Series]") -> "pd.DataFrame":
    """A table with columns in SI units, after those of the model.

    Parameters
    ----------
    table : pandas.DataFrame
    units : mapping
        One unit of the model, by the unit in SI. It may differ from row to row.

    Returns
    -------
    pandas.DataFrame
    """
    known = {name: IN_SI[name] for name in table.columns if name in IN_SI}
    return table.assign(**{own: table[name] * units[unit] for name, (own, unit) in known.items()})


def factors_of(units: "Mapping[str, _T]") -> "dict[str, tuple[str, _T]]":
    """Unit of each variable of a result that has one, and what one unit of the model is in it, by its name."""
    return {name: (unit, units[unit]) for name, (_, unit) in IN_SI.items()}


class Scales(NamedTuple):
    """One unit of the model in SI units.

    Attributes
    ----------
    time : float
        A forcing period, s.
    length : float
        One unit of Phi, of the half backlash and of the eccentricity, along the line of action, m.
    speed : float
        One unit of velocity, along the line of action, m/s.
    mass : float
        Of the pair, seen along the line of action, kg.
    energy : float
        One unit of ``v^2/2``, J.
    power : float
        One unit of impact power, the sum of ``v^2/2`` over a forcing period, W.
    impulse : float
        Torque pulse on the driven shaft that changes the velocity by one unit, N m s.
    """

    time: float
    length: float
    speed: float
    mass: float
    energy: float
    power: float
    impulse: float


class GearPair(Request):
    """A gear pair in physical units. A number is in SI; a text has its unit.

    Parameters
    ----------
    speed : float or str
        Mean speed of the driven shaft, rad/s, as in ``"3000 rpm"``.
    inertia : float or str
        I2, of the driven shaft, kg m2.
    inertia_ratio : float
        rho: I2 over the driving shaft's inertia I1, both seen from the driven shaft: ``(R1/R2)^2 I2/I1``. 1 is a pair
        of equal gears, 0 a loose gear on a heavy shaft.
    drag_torque : float or str
        On the driven shaft at this speed, N m.
    base_radius : float or str
        R2, of the driven gear, m.
    backlash : float or str
        All of it, along the line of action, m.
    mesh_stiffness : float or str, optional
        Along the line of action, N/m. Without it contacts are impacts.
    transmission_error : float, str or mapping
        Amplitude of its first order along the line of action, m. Or orders: ``{1: "5 um", 2: {"amplitude": "1 um",
        "phase": 0.25}}``, phases in periods of the order.
    contact_damping : float, optional
        zeta, damping ratio of the contact; 0 by default.
    restitution : float, optional
        r, in place of the damping ratio: ``r = exp(-pi zeta/sqrt(1 - zeta^2))``.
    drag_law : {"constant", "proportional"}
        How the drag torque changes with speed in `at_speed`.
    turns : int
        Turns of the driven gear in a forcing period, after which the transmission error repeats.

    Raises
    ------
    InvalidJob
        If a number is missing, not positive, or in a unit of another dimension. It is a ValueError.

    Examples
    --------
    >>> import rattle
    >>> pair = rattle.GearPair(speed=300.0, inertia=0.02, drag_torque=0.4, base_radius=0.06, backlash=60e-6,
    ...                        transmission_error=5e-6)
    >>> round(pair.oscillator.damping, 6), round(pair.oscillator.half_backlash, 6)
    (0.001396, 0.0005)
    >>> round(pair.gamma, 3)
    0.188
    """

    speed: AngularSpeed = Field(gt=0, description="of the driven shaft, rad/s")
    inertia: Inertia = Field(gt=0, description="of the driven shaft, kg m2")
    inertia_ratio: Real = Field(1.0, ge=0, description="(R1/R2)^2 I2/I1; 0 for a heavy driving shaft")
    drag_torque: Torque = Field(gt=0, description="on the driven shaft at this speed, N m")
    base_radius: Length = Field(gt=0, description="of the driven gear, m")
    backlash: Length = Field(gt=0, description="all of it, along the line of action, m")
    mesh_stiffness: Stiffness | None = Field(None, gt=0, description="N/m; contacts are impacts without it")
    transmission_error: Annotated[dict[Order, ErrorOrder], BeforeValidator(_orders)] = Field(
        max_length=MOST_HARMONICS, description="amplitude of the first order, m, or orders"
    )
    contact_damping: Real | None = Field(None, ge=0, lt=1, description="zeta, damping ratio of the contact")
    restitution: Real | None = Field(None, gt=0, le=1, description="r, in place of the damping ratio")
    drag_law: Literal["constant", "proportional"] = Field("constant", description="of the drag torque over speed")
    turns: Whole = Field(1, ge=1, description="of the driven gear in a forcing period")

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            speed: "Quantity",
            inertia: "Quantity",
            drag_torque: "Quantity",
            base_radius: "Quantity",
            backlash: "Quantity",
            transmission_error: "Quantity | Mapping[int, Quantity | Mapping[str, Quantity]]",
            inertia_ratio: float = 1.0,
            mesh_stiffness: "Quantity | None" = None,
            contact_damping: float | None = None,
            restitution: float | None = None,
            drag_law: Literal["constant", "proportional"] = "constant",
            turns: int = 1,
        ) -> None: ...

    else:

        def __init__(self, /, **given: Any) -> None:
            try:
                super().__init__(**given)
            except ValidationError as error:
                raise refusal(error) from None

    @model_validator(mode="after")
    def _one_loss(self) -> Self:
        if self.contact_damping is not None and self.restitution is not None:
            raise InvalidJob("give contact_damping or restitution, not both: one follows from the other")
        return self

    @model_validator(mode="after")
    def _representable(self) -> Self:
        try:
            model = self.oscillator
            error = [model.eccentricity, *(each.amplitude for each in model.harmonics)]
            numbers = {
                "damping": model.damping, "half_backlash": model.half_backlash,
                "stiffness": 1.0 if self.mesh_stiffness is None else model.stiffness,
                "the transmission error": max(error) or 1.0,
                **{f"one unit of {name}": value for name, value in self.scales._asdict().items()},
            }  # fmt: skip
        except (OverflowError, ZeroDivisionError):
            numbers = {"damping": math.inf}
        for name, value in numbers.items():
            if not _LEAST < value < _GREATEST:
                raise InvalidJob(f"no such machine: {name} would be {value:.3g}; look at the units of its numbers")
        return self

    @classmethod
    def of(cls, given: Any) -> "GearPair":
        """Machine that an argument describes: itself, or that of a TOML file.

        Raises
        ------
        InvalidJob
            If it is none.
        """
        pair = cls.read(given) if isinstance(given, str | Path) else given
        if not isinstance(pair, GearPair):
            raise InvalidJob(f"machine is a rattle.GearPair, or the path of a TOML file, not {pair!r}", ("machine",))
        return pair

    @classmethod
    def read(cls, path: str | Path) -> "GearPair":
        """Read a machine from a TOML file, whose keys are the parameters.

        Parameters
        ----------
        path : str or path

        Returns
        -------
        GearPair

        Raises
        ------
        InvalidJob
            If the file cannot be read, is no TOML, or says something else than a machine.
        """
        try:
            with Path(path).open("rb") as file:
                return cls(**tomllib.load(file))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise InvalidJob(f"{path}: {reason}") from error
        except InvalidFields as error:
            raise InvalidFields([((str(path), *place), message) for place, message in error.faults]) from None
        except InvalidJob as error:
            raise InvalidJob(f"{path}: {error}", error.place) from None

    @cached_property
    def scales(self) -> Scales:
        """One unit of the model in SI units."""
        time = _TWO_PI * self.turns / self.speed
        length = 0.5 * self.turns * self.base_radius * (1.0 + self.inertia_ratio)
        speed = (1.0 + self.inertia_ratio) * self.base_radius * self.speed / _FOUR_PI
        mass = self.inertia / (self.base_radius**2 * (1.0 + self.inertia_ratio))
        energy = mass * speed**2
        impulse = speed * self.inertia / self.base_radius
        return Scales(time, length, speed, mass, energy, energy / time, impulse)

    @cached_property
    def oscillator(self) -> Oscillator:
        """Its parameters in the model. They may lie beyond Eq. (8): what computes with them says so."""
        first = self.transmission_error.get(1)
        shift = first.phase if first else 0.0
        harmonics = tuple(
            Harmonic(float(order), each.amplitude / self.scales.length, (each.phase - order * shift) % 1.0)
            for order, each in sorted(self.transmission_error.items())
            if order > 1
        )
        stiff = self.mesh_stiffness
        return Oscillator(
            damping=_TWO_PI * self.turns * self.drag_torque / (self.inertia * self.speed**2),
            eccentricity=first.amplitude / self.scales.length if first else 0.0,
            half_backlash=0.5 * self.backlash / self.scales.length,
            stiffness=math.inf if stiff is None else 0.5 * stiff * self.scales.time**2 / self.scales.mass,
            restitution=self._restitution if stiff is None else 1.0,
            contact_damping=0.0 if stiff is None else self._contact_damping,
            harmonics=harmonics,
        )

    @property
    def _restitution(self) -> float:
        zeta = self.contact_damping
        if zeta is None:
            return 1.0 if self.restitution is None else self.restitution
        return math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2))

    @property
    def _contact_damping(self) -> float:
        if self.restitution is None:
            return self.contact_damping or 0.0
        loss = -math.log(self.restitution)
        return loss / math.hypot(math.pi, loss)

    @cached_property
    def gamma(self) -> float:
        """Inertia torque over drag torque. Below 1 Eq. (8) holds; from 1 on impacts part the teeth in every turn."""
        felt = rest_acceleration_over_phases(self.oscillator)
        return 1.0 - least_value(felt)[0] / felt.mean

    def drag_torque_at(self, speed: "Quantity") -> float:
        """Drag torque at another speed, by the drag law, N m.

        Parameters
        ----------
        speed : float or str

        Returns
        -------
        float
        """
        value = float(in_si(speed, "rad/s"))
        return self.drag_torque * (value / self.speed if self.drag_law == "proportional" else 1.0)

    def at_speed(self, speed: "Quantity") -> "GearPair":
        """The machine at another speed: its drag torque follows the drag law, everything else stays.

        Parameters
        ----------
        speed : float or str

        Returns
        -------
        GearPair

        Raises
        ------
        InvalidJob
            If the speed is no positive angular speed.
        """
        try:
            value = in_si(speed, "rad/s")
        except InvalidJob as error:
            raise InvalidJob(f"speed: {error}", ("speed",)) from None
        torque = self.drag_torque_at(value) if isinstance(value, int | float) else self.drag_torque
        return GearPair(**self.model_dump() | {"speed": value, "drag_torque": torque})

    @cached_property
    def can_be_quiet(self) -> bool:
        """Whether teeth can stay together: with impacts where Gamma is below 1, with a mesh stiffness by Eq. (3)."""
        if self.mesh_stiffness is None:
            return self.gamma < 1.0
        try:
            check_quiet(self.oscillator)
        except OutsideDomain:
            return False
        return True

    def check_pulses(self) -> None:
        """Refuse the machine if pulses that hit it are not followed: it is never quiet, or Gamma is 1 or more.

        Raises
        ------
        InvalidJob
            With the speed at which Gamma reaches 1.
        """
        said = f"Gamma is {self.gamma:.3g} at {self.speed * _RPM:.6g} rpm"
        if not self.can_be_quiet:
            slower = f"; below {self._threshold} it can be" if self.gamma >= 1.0 else ""
            raise InvalidJob(
                f"{said}, and no motion keeps its teeth together. So it is never quiet{slower}", ("machine",)
            )
        if self.gamma >= 1.0:
            message = f"{said}: inertia torque reaches drag torque. Pulses are followed below {self._threshold} alone"
            raise InvalidJob(message, ("machine",))

    @property
    def _threshold(self) -> str:
        return f"{self.threshold_speed * _RPM:.6g} rpm"

    @property
    def threshold_speed(self) -> float:
        """Speed at which Gamma reaches 1, rad/s: above it inertia torque exceeds drag torque for a part of each turn.

        Infinite if it never does, as without a transmission error.

        Gamma of order n is ``n pi eps sqrt(n^2 + (delta/2 pi)^2)/delta`` and grows with speed, as delta shrinks.
        """
        low = high = self.speed
        from scipy.optimize import brentq

        try:
            while self.at_speed(high).gamma < 1.0:
                low, high = high, 2.0 * high
            while self.at_speed(low).gamma >= 1.0:
                low, high = 0.5 * low, low
        except InvalidJob:  # beyond any speed
            return math.inf if self.gamma < 1.0 else 0.0
        return float(brentq(lambda speed: self.at_speed(speed).gamma - 1.0, low, high, rtol=_ROUNDING))

    def with_units(self, result: "xr.Dataset") -> "xr.Dataset":
        """A result of this machine with SI units beside the numbers of the model.

        Parameters
        ----------
        result : xarray.Dataset
            Of its oscillator.

        Returns
        -------
        xarray.Dataset
            It has ``time_s`` and ``speed_m_s`` beside ``time`` and ``velocity``, the like of what else it holds, and
            the machine as JSON among its attributes.
        """
        return beside_in_si(result, self.units).assign_attrs({MACHINE: str(self)})

    def with_columns(self, table: "pd.DataFrame") -> "pd.DataFrame":
        """A table of a result of this machine with columns in SI units, after those of the model.

        Parameters
        ----------
        table : pandas.DataFrame

        Returns
        -------
        pandas.DataFrame
        """
        return with_columns_in_si(table, self.units)

    @property
    def factors(self) -> dict[str, tuple[str, float]]:
        """Unit of each variable of a result that has one, and what one unit of the model is in it."""
        return factors_of(self.units)

    @property
    def units(self) -> dict[str, float]:
        """One unit of the model, by the unit in SI."""
        scales = self.scales
        return {"s": scales.time, "m": scales.length, "m/s": scales.speed, "W": scales.power}

    @property
    def as_request(self) -> dict[str, Any]:
        """The machine as requests have it: its numbers in SI."""
        return self.model_dump(mode="json", exclude_none=True)

    def __str__(self) -> str:
        """The numbers in SI, as JSON."""
        return json.dumps(self.as_request)
