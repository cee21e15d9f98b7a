"""A parameter of the oscillator that a sweep steps through, and the values it takes."""

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, WithJsonSchema

from rattle_kernels import Oscillator
from rattle_kernels.model.oscillator import PARAMETERS
from worker.errors import FieldPath, InvalidJob
from worker.jobs.budget import spend
from worker.jobs.first_refused import Axis
from worker.jobs.oscillator_request import with_swept_stiffness
from worker.jobs.request import INTEGRAL, Real, Request, accepting, told, without_sign_of_zero

MOST_SWEPT = 2
MOST_LISTED = 10_000
"""A range of more values stays a rule in records and answers: its values would be most of them."""
_PIECE = 4096
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


@dataclass(frozen=True)
class SweptParameter:
    """A parameter of the oscillator and its values, in the order in which basins follow one another.

    Parameters
    ----------
    parameter : str
        One of `Oscillator.parameters`.
    values : tuple of float
        Ascending or descending.

    Examples
    --------
    >>> SweptParameter.spaced("stiffness", 1e2, 1e4, 3, Spacing.GEOMETRIC)
    SweptParameter(parameter='stiffness', values=(100.0, 1000.0, 10000.0))
    """

    parameter: str
    values: tuple[float, ...]

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
        if spacing == Spacing.GEOMETRIC and not (start > 0.0 and stop > 0.0):
            raise InvalidJob(f"{parameter} can only be spaced geometrically from and to values above 0")
        if count < 2:
            raise InvalidJob(f"{parameter} takes at least two values from start to stop, not {count}")
        space = np.geomspace if spacing == Spacing.GEOMETRIC else np.linspace
        # Rounded to 15 digits: 0.6 and 0.6000000000000001 are two different oscillators.
        spaced = space(start, stop, count)
        between = (float(f"{value:.15g}") for piece in _in_pieces(spaced[1:-1]) for value in piece.tolist())
        return cls(parameter, tuple(itertools.chain([float(start)], between, [float(stop)])))


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
    "if": {"properties": {"values": {"type": "array"}}, "required": ["values"]},
    "then": {"properties": {name: {"type": "null"} for name in _NUMBERS} | {"spacing": False}},
    "else": {
        "properties": _NUMBERS,
        "required": list(_NUMBERS),
        "if": {"properties": {"spacing": {"const": Spacing.GEOMETRIC.value}}, "required": ["spacing"]},
        "then": {"properties": {"start": _ABOVE_ZERO, "stop": _ABOVE_ZERO}},
    },
}


class VaryRequest(Request):
    """Values of one swept parameter: all of them, or how many from a start to a stop, both included."""

    model_config = ConfigDict(json_schema_extra=_LISTED_OR_SPACED)

    parameter: Parameter
    values: Annotated[tuple[Real, ...], Field(fail_fast=True), told(minItems=1)] | None = Field(
        None, description="Ascending or descending"
    )
    start: Real | None = None
    stop: Real | None = None
    count: Annotated[int, Field(strict=True, ge=2), INTEGRAL] | None = None
    spacing: Spacing = Spacing.LINEAR

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.values) if self.values is not None else self.count or 0

    @property
    def least(self) -> float:
        """Least value above 0, or 1 if there is none; values of 0 and below are refused elsewhere."""
        ends = [end for end in (self.start, self.stop) if end is not None]
        return min((value for value in self.values or ends if value > 0.0), default=1.0)

    def to_swept(self, place: FieldPath) -> SweptParameter:
        """Swept parameter that this describes.

        Parameters
        ----------
        place : tuple of str and int
            Its location in the request.

        Returns
        -------
        SweptParameter

        Raises
        ------
        InvalidJob
            If neither or both descriptions are given, or they are contradictory.
        """
        spaced = self.start, self.stop, self.count
        if self.values is not None and spaced == (None, None, None) and "spacing" not in self.model_fields_set:
            return SweptParameter(self.parameter, self.values)
        if self.values is not None or self.start is None or self.stop is None or self.count is None:
            raise InvalidJob(f"give {self.parameter} either values, or start, stop and count", place)
        try:
            return SweptParameter.spaced(self.parameter, self.start, self.stop, self.count, self.spacing)
        except InvalidJob as error:
            raise InvalidJob(str(error), (*place, "spacing")) from error

    def settled(self, swept: SweptParameter) -> "VaryRequest":
        """The same values in canonical form: listed, or as a rule where that would be long.

        Parameters
        ----------
        swept : SweptParameter
            What this describes, checked.

        Returns
        -------
        VaryRequest
        """
        if self.values is not None or self.size <= MOST_LISTED:
            return vary_request(swept)
        assert self.start is not None and self.stop is not None
        rule: dict[str, Any] = {"start": float(self.start), "stop": float(self.stop), "count": self.count}
        if self.spacing != Spacing.LINEAR:
            rule["spacing"] = self.spacing
        return VaryRequest.model_construct(parameter=self.parameter, **rule)


def vary_request(swept: SweptParameter) -> VaryRequest:
    """Swept parameter as requests describe it, unchecked.

    Parameters
    ----------
    swept : SweptParameter

    Returns
    -------
    VaryRequest
    """
    fields: dict[str, Any] = {"parameter": swept.parameter, "values": tuple(map(without_sign_of_zero, swept.values))}
    return VaryRequest.model_construct(**fields)


Vary = Annotated[VaryRequest, BeforeValidator(accepting(SweptParameter, vary_request))]
"""From Python also a `SweptParameter`."""


def without_stiffness(request: Any) -> Any:
    """The same request, except that the oscillator may lack a stiffness if ``vary`` sweeps it.

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
    vary = request.get("vary")
    asked = vary if isinstance(vary, list | tuple) else [vary]
    names = [each.get("parameter") if isinstance(each, dict) else getattr(each, "parameter", None) for each in asked]
    if "stiffness" not in names:
        return request
    return request | {"oscillator": with_swept_stiffness(request["oscillator"])}


def axes_of(vary: Iterable[SweptParameter], convex: Iterable[str] | None) -> list[Axis]:
    """Axes of swept parameters for `first_refused`.

    Parameters
    ----------
    vary : iterable of SweptParameter
    convex : iterable of str, optional
        Parameters in which the check is convex, beside half backlash, eccentricity and amplitudes; by default all.

    Returns
    -------
    list of Axis
    """
    return [Axis(len(swept.values), _is_convex(swept.parameter, convex)) for swept in vary]


def _is_convex(parameter: str, convex: Iterable[str] | None) -> bool:
    if is_of_harmonic(parameter):
        return not is_phase(parameter)
    return convex is None or parameter in ("eccentricity", "half_backlash", *convex)


def check_swept(vary: Sequence[SweptParameter], oscillator: Oscillator) -> tuple[SweptParameter, ...]:
    """Return swept parameters with plain float values, or raise an error that says what is wrong.

    Parameters
    ----------
    vary : sequence of SweptParameter
    oscillator : Oscillator
        Whose parameters they are, unchecked.

    Returns
    -------
    tuple of SweptParameter

    Raises
    ------
    InvalidJob
        With the location of the fault.
    """
    names = [swept.parameter for swept in vary]
    for axis, name in enumerate(names):
        place = ("vary", axis, "parameter")
        if name not in oscillator.parameters:
            raise InvalidJob(f"{name} cannot be swept; these can: {', '.join(oscillator.parameters)}", place)
        if name in names[:axis]:
            raise InvalidJob(f"{name} is swept twice", place)
        impacting = math.isinf(oscillator.stiffness)
        if name == "stiffness" and impacting:
            raise InvalidJob("stiffness cannot be swept in the impacting model, where it is infinite", place)
        if _OF_MODELS.get(name, impacting) != impacting:
            raise InvalidJob(f"{name} cannot be swept in the {_MODELS[impacting]} model, which has none", place)
    return tuple(SweptParameter(swept.parameter, _checked_values(axis, swept)) for axis, swept in enumerate(vary))


def _checked_values(axis: int, swept: SweptParameter) -> tuple[float, ...]:
    values = tuple(float(value) + 0.0 for piece in _in_pieces(swept.values) for value in piece)
    if not values:
        raise InvalidJob(f"{swept.parameter} needs at least one value", ("vary", axis, "values"))
    numbers = as_array(values)
    for index in np.flatnonzero(~np.isfinite(numbers))[:1].tolist():
        message = f"values of {swept.parameter} must be finite; number {index} is {values[index]}"
        raise InvalidJob(message, ("vary", axis, "values", index))
    with np.errstate(over="ignore"):  # the step between two huge numbers is infinite, of the right sign
        steps = np.sign(np.diff(numbers))
    # Neighbours are compared with one another: births and deaths are reported for the interval between them.
    astray = np.flatnonzero(steps * (steps[0] if steps.size else 1.0) <= 0.0)
    if astray.size:
        index = int(astray[0]) + 1
        message = f"values of {swept.parameter} must ascend or descend; number {index} is {values[index]:g}"
        raise InvalidJob(f"{message} after {values[index - 1]:g}", ("vary", axis, "values", index))
    return values
