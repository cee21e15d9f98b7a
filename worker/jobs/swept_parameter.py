"""A parameter of the oscillator that a sweep steps through, and the values it takes."""

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import StrEnum
from functools import cached_property
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, ValidationError, WithJsonSchema, model_validator

from rattle_kernels import Oscillator
from rattle_kernels.model.oscillator import PARAMETERS
from worker.errors import FieldPath, InvalidJob
from worker.jobs.budget import spend
from worker.jobs.oscillator_request import with_swept_stiffness
from worker.jobs.request import INTEGRAL, Real, Request, as_real, in_schema, refusal

MOST_SWEPT = 2
MOST_LISTED = 10_000
"""A range of more values stays a rule in records and answers: its values would be most of them."""
_PIECE = 4096
_MISSING: Any = object()
_MODELS = "piecewise linear", "impacting"
_OF_HARMONICS = re.compile("(amplitude|phase)_[1-9][0-9]*")
_ORDERS = "amplitude_n and phase_n of the harmonic of order n"
_OF_MODELS = {"stiffness": False, "contact_damping": False, "restitution": True}
"""Parameters that only one model has, and whether that is the impacting one."""


def is_of_harmonic(name: str) -> bool:
    """Whether a name is that of amplitude or phase of a harmonic."""
    return _OF_HARMONICS.fullmatch(name) is not None


def is_phase(name: str) -> bool:
    """Whether a name is that of the phase of a harmonic, of which whole numbers change nothing."""
    return is_of_harmonic(name) and name.startswith("phase_")


def is_parameter(name: str) -> bool:
    """Whether a name is that of a number of the oscillator that a study may vary."""
    return name in PARAMETERS or is_of_harmonic(name)


def known_parameter(name: str) -> str:
    """The name of a parameter that some oscillator has.

    Raises
    ------
    ValueError
        If none has it.
    """
    if not is_parameter(name):
        raise ValueError(f"{name} is no parameter; these are: {', '.join(PARAMETERS)}, and {_ORDERS}")
    return name


Parameter = Annotated[
    str,
    AfterValidator(known_parameter),
    WithJsonSchema({"type": "string", "pattern": f"^({'|'.join(PARAMETERS)}|{_OF_HARMONICS.pattern})$"}),
]
"""Name of a number of the oscillator that a study may vary."""


class Spacing(StrEnum):
    """How values lie between a start and a stop.

    Examples
    --------
    >>> [spacing.value for spacing in Spacing]
    ['linear', 'geometric']
    """

    LINEAR = "linear"
    GEOMETRIC = "geometric"


def _in_pieces(values: Any) -> Iterator[Any]:
    """Slices of values, none of which takes long."""
    for begin in range(0, len(values), _PIECE):
        spend()
        yield values[begin : begin + _PIECE]


def as_array(values: Sequence[float]) -> np.ndarray:
    """Values, one or more, as an array. No other thread waits for long while it is made.

    Parameters
    ----------
    values : sequence of float

    Returns
    -------
    ndarray
    """
    return np.concatenate([np.array(piece) for piece in _in_pieces(values)])


def spaced(start: float, stop: float, count: int, spacing: Spacing) -> tuple[float, ...]:
    """Values from a start to a stop, both included.

    Parameters
    ----------
    start, stop : float
    count : int
        Two or more.
    spacing : Spacing

    Returns
    -------
    tuple of float
        Rounded to 15 digits: 0.6 and 0.6000000000000001 are two different oscillators.
    """
    space = np.geomspace if spacing == Spacing.GEOMETRIC else np.linspace
    inner = space(start, stop, count)[1:-1]
    between = (as_real(f"{value:.15g}") for piece in _in_pieces(inner) for value in piece.tolist())
    return tuple(itertools.chain([start], between, [stop]))


def values_as_json(values: Sequence[float]) -> Iterator[str]:
    """The text of `json.dumps` for a list of finite floats, in pieces.

    Parameters
    ----------
    values : sequence of float

    Yields
    ------
    str
    """
    before = "["
    for piece in _in_pieces(values):
        yield before + ", ".join(map(float.__repr__, piece))
        before = ", "
    yield "]"


# Values, or start, stop and count; what is spaced geometrically lies above 0.
_NUMBERS = {"start": {"type": "number"}, "stop": {"type": "number"}, "count": {"type": "integer"}}
_ABOVE_ZERO = {"exclusiveMinimum": 0}
_LISTED_OR_SPACED: dict[str, Any] = {
    "description": "Values of one swept parameter: all of them, or how many from a start to a stop, both included.",
    "if": {"properties": {"values": {"type": "array"}}, "required": ["values"]},
    "then": {"properties": {name: {"type": "null"} for name in _NUMBERS} | {"spacing": False}},
    "else": {
        "properties": _NUMBERS,
        "required": list(_NUMBERS),
        "if": {"properties": {"spacing": {"const": Spacing.GEOMETRIC.value}}, "required": ["spacing"]},
        "then": {"properties": {"start": _ABOVE_ZERO, "stop": _ABOVE_ZERO}},
    },
}


class SweptParameter(Request):
    """A parameter of the oscillator and its values, in the order in which basins follow one another.

    Parameters
    ----------
    parameter : str
        One of `Oscillator.parameters`.
    values : iterable of float
        Ascending or descending. In their place ``start``, ``stop``, ``count`` and ``spacing`` may be given by name.

    Examples
    --------
    >>> SweptParameter.spaced("stiffness", 1e2, 1e4, 3, Spacing.GEOMETRIC)
    SweptParameter(parameter='stiffness', values=(100.0, 1000.0, 10000.0))
    """

    model_config = ConfigDict(
        title="VaryRequest",
        alias_generator=lambda name: name.rstrip("_"),
        serialize_by_alias=True,
        json_schema_extra=_LISTED_OR_SPACED,
    )

    parameter: Parameter
    values_: Annotated[tuple[Real, ...], Field(fail_fast=True), in_schema(minItems=1)] | None = Field(
        None, description="Ascending or descending"
    )
    start: Real | None = None
    stop: Real | None = None
    count: Annotated[int, Field(strict=True, ge=2), INTEGRAL] | None = None
    spacing: Spacing = Spacing.LINEAR

    # pydantic makes one of JSON in this way, too: what is not given is said to be missing.
    def __init__(self, parameter: str = _MISSING, values: Iterable[float] | None = _MISSING, **rule: Any) -> None:
        listed = values.tolist() if isinstance(values, np.ndarray) else values
        given = {"parameter": parameter, "values": listed}
        super().__init__(**{name: value for name, value in given.items() if value is not _MISSING}, **rule)

    @classmethod
    def spaced(cls, parameter: str, start: float, stop: float, count: int, spacing: Spacing) -> "SweptParameter":
        """Two values or more from start to stop, both included.

        Parameters
        ----------
        parameter : str
        start, stop : float
        count : int
        spacing : Spacing

        Returns
        -------
        SweptParameter

        Raises
        ------
        InvalidJob
            If values cannot be spaced in this way.
        """
        try:
            rule = cls(parameter, start=start, stop=stop, count=count, spacing=spacing)
        except ValidationError as error:
            raise refusal(error) from error
        return cls.listed(parameter, rule.values)

    @classmethod
    def listed(cls, parameter: str, values: tuple[float, ...]) -> "SweptParameter":
        """Values that are checked already."""
        return cls.model_construct(parameter=parameter, values_=values)

    __str__ = Request.__repr__

    def __repr_args__(self) -> Iterator[tuple[str, Any]]:
        yield from (("parameter", self.parameter), ("values", self.values))

    @model_validator(mode="after")
    def _listed_or_spaced(self) -> Self:
        ends, named = (self.start, self.stop, self.count), self.model_fields_set
        listed = self.values_ is not None and ends == (None, None, None) and "spacing" not in named
        if not listed and (self.values_ is not None or None in ends):
            raise InvalidJob(f"give {self.parameter} either values, or start, stop and count")
        if self.spacing == Spacing.GEOMETRIC and not ((self.start or 0.0) > 0.0 and (self.stop or 0.0) > 0.0):
            message = f"{self.parameter} can only be spaced geometrically from and to values above 0"
            raise InvalidJob(message, ("spacing",))
        return self

    @property
    def is_rule(self) -> bool:
        """Whether the values are given by start, stop and count."""
        return self.values_ is None

    @cached_property
    def values(self) -> tuple[float, ...]:
        """All values."""
        if self.values_ is not None:
            return self.values_
        assert self.start is not None and self.stop is not None and self.count is not None
        return spaced(self.start, self.stop, self.count, self.spacing)

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.values_) if self.values_ is not None else self.count or 0

    @property
    def name(self) -> str:
        """Name of the axis: that of the parameter."""
        return self.parameter

    @property
    def columns(self) -> Mapping[str, tuple[float, ...]]:
        """Values of each parameter that changes along the axis: of this one."""
        return {self.parameter: self.values}

    def at(self, index: int) -> dict[str, float]:
        """Values of the parameters at a place on the axis."""
        return {self.parameter: self.values[index]}

    def least(self, parameter: str) -> float | None:
        """Least value above 0 that a parameter takes, or 1 if there is none; None if it is another than this one.

        Values of 0 and below are refused elsewhere.
        """
        if parameter != self.parameter:
            return None
        ends = [end for end in (self.start, self.stop) if end is not None]
        return min((value for value in self.values_ or ends if value > 0.0), default=1.0)

    def settled(self) -> "SweptParameter":
        """The same values in canonical form: listed, or as a rule where that would be long."""
        if not self.is_rule or self.size <= MOST_LISTED:
            return self.listed(self.parameter, self.values)
        rule = "parameter", "start", "stop", "count"
        return self.settled_to(rule if self.spacing == Spacing.LINEAR else (*rule, "spacing"))


def without_stiffness(request: Any) -> Any:
    """The same request, except that the oscillator may lack a stiffness if ``vary`` or ``design`` changes it.

    Parameters
    ----------
    request : object
        Request as sent.

    Returns
    -------
    object
    """
    if not isinstance(request, dict) or "oscillator" not in request:
        return request
    vary, design = request.get("vary"), request.get("design")
    asked = vary if isinstance(vary, list | tuple) else [vary]
    names = [each.get("parameter") if isinstance(each, dict) else getattr(each, "parameter", None) for each in asked]
    columns = design.get("parameters") if isinstance(design, dict) else getattr(design, "parameters", None)
    if "stiffness" not in [*names, *(columns if isinstance(columns, dict) else ())]:
        return request
    return request | {"oscillator": with_swept_stiffness(request["oscillator"])}


def check_swept(vary: Sequence[SweptParameter], oscillator: Oscillator) -> None:
    """Refuse swept parameters that the oscillator does not have, and values that do not follow one another.

    Parameters
    ----------
    vary : sequence of SweptParameter
    oscillator : Oscillator
        Whose parameters they are, unchecked.

    Raises
    ------
    InvalidJob
        With the location of the fault.
    """
    names = [swept.parameter for swept in vary]
    for axis, name in enumerate(names):
        place = ("vary", axis, "parameter")
        if name in names[:axis]:
            raise InvalidJob(f"{name} is swept twice", place)
        check_parameter(name, oscillator, place)
    for axis, swept in enumerate(vary):
        check_values(swept.parameter, swept.values, ("vary", axis, "values"))


def check_parameter(name: str, oscillator: Oscillator, place: FieldPath) -> None:
    """Refuse a parameter that the oscillator does not have.

    Parameters
    ----------
    name : str
    oscillator : Oscillator
    place : tuple of str and int
        Where in the request it stands.

    Raises
    ------
    InvalidJob
    """
    if name not in oscillator.parameters:
        raise InvalidJob(f"{name} cannot be swept; these can: {', '.join(oscillator.parameters)}", place)
    impacting = math.isinf(oscillator.stiffness)
    if name == "stiffness" and impacting:
        raise InvalidJob("stiffness cannot be swept in the impacting model, where it is infinite", place)
    if _OF_MODELS.get(name, impacting) != impacting:
        raise InvalidJob(f"{name} cannot be swept in the {_MODELS[impacting]} model, which has none", place)


def check_values(name: str, values: Sequence[float], place: FieldPath) -> None:
    """Refuse values of an axis that do not follow one another.

    Parameters
    ----------
    name : str
    values : sequence of float
    place : tuple of str and int
        Where in the request they stand.

    Raises
    ------
    InvalidJob
    """
    if not values:
        raise InvalidJob(f"{name} needs at least one value", place)
    numbers = as_array(values)
    for index in np.flatnonzero(~np.isfinite(numbers))[:1].tolist():
        raise InvalidJob(f"values of {name} must be finite; number {index} is {values[index]}", (*place, index))
    with np.errstate(over="ignore"):  # the step between two huge numbers is infinite, of the right sign
        steps = np.sign(np.diff(numbers))
    # Neighbours are compared with one another: births and deaths are reported for the interval between them.
    astray = np.flatnonzero(steps * (steps[0] if steps.size else 1.0) <= 0.0)
    if astray.size:
        index = int(astray[0]) + 1
        message = f"values of {name} must ascend or descend; number {index} is {values[index]:g}"
        raise InvalidJob(f"{message} after {values[index - 1]:g}", (*place, index))
