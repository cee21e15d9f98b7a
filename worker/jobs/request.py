"""Base of all requests: strict numbers, no unknown fields, and errors that name the field at fault."""

import difflib
from collections.abc import Callable, Iterable, Sequence
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from rattle_kernels import OutsideDomain
from worker.errors import FieldPath, InvalidFields, InvalidJob


def as_real(value: Any) -> float:
    """A number as a float of Python's own: -0.0 and 0.0 are one, and so are the requests that they stand in."""
    return float(value) + 0.0


def _as_integer(value: Any) -> Any:
    """The integer that a float is; what is none stays as it is, and is refused."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


# Strict: the JSON value true is not a number. An integer is accepted where a real number is expected.
Real = Annotated[float, Field(strict=True, allow_inf_nan=False), AfterValidator(as_real)]
INTEGRAL = BeforeValidator(_as_integer)
"""In JSON and in its schemas 4.0 is the integer 4. It comes after the bounds, or the schema lacks them."""
Whole = Annotated[int, Field(strict=True), INTEGRAL]
Count = Annotated[int, Field(strict=True, ge=1), INTEGRAL]

UNION_TAGS = {"impacting", "piecewise_linear"}
"""Parts of pydantic's locations that name the model of the oscillator; they are not fields."""


_FIELDS: set[str] = set()


class Request(BaseModel):
    """A request, or a part of one. An unknown field is an error, so that a misspelt option is not ignored."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    def settled_to(self, names: Iterable[str] | None = None) -> Self:
        """The same value, of which its canonical form has some fields, by default all. The others have their defaults.

        Parameters
        ----------
        names : iterable of str, optional

        Returns
        -------
        Request
        """
        named = type(self).model_fields if names is None else names
        settled: Any = type(self).model_construct(**{name: getattr(self, name) for name in named})
        return settled

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Note the fields of each request: what is misspelt may have been meant to be one of them."""
        _FIELDS.update(name.rstrip("_") for name in cls.model_fields)


def in_schema(**keywords: Any) -> Any:
    """Keywords of JSON Schema for what a request's own check demands: its message tells more than pydantic's.

    Parameters
    ----------
    **keywords : object

    Returns
    -------
    pydantic.fields.FieldInfo
        Part of an annotation.
    """
    return Field(json_schema_extra=keywords)


def accepting(value_type: type, convert: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Convert the worker's own value to the part of a request that describes it, and leave JSON as it is.

    Parameters
    ----------
    value_type : type
        Type of the worker's value.
    convert : callable
        Makes the part of the request.

    Returns
    -------
    callable
        For `pydantic.BeforeValidator`.
    """
    return lambda given: convert(given) if isinstance(given, value_type) else given


def fault_of(item: Any) -> tuple[FieldPath, str]:
    """Field at fault, and what is wrong with it.

    Parameters
    ----------
    item : dict
        One of `pydantic.ValidationError.errors()`.

    Returns
    -------
    place : tuple of str and int
    message : str
    """
    error = item.get("ctx", {}).get("error")
    if item["type"] in ("extra_forbidden", "unexpected_keyword_argument"):  # the second is a dataclass's
        *inside, name = item["loc"]  # a name of the client's, which may be that of a tag
        return (*_without_tags(inside), name), f"Extra inputs are not permitted{_hint(str(name))}"
    place = _without_tags(item["loc"])
    if isinstance(error, InvalidJob):
        place += error.place
    return place, item["msg"].removeprefix("Value error, ")


def _without_tags(location: Sequence[str | int]) -> FieldPath:
    return tuple(part for part in location if part not in UNION_TAGS)


def _hint(name: str) -> str:
    """The field that may have been meant; none for one that is a field elsewhere."""
    near = [] if name in _FIELDS else difflib.get_close_matches(name, sorted(_FIELDS), 1, 0.7)
    return f"; did you mean {near[0]}?" if near else ""


def refusal(error: ValidationError) -> ValueError:
    """The error to raise for a validation error of pydantic.

    Parameters
    ----------
    error : ValidationError

    Returns
    -------
    OutsideDomain, InvalidJob or InvalidFields
        The error that the job itself raised, or what is wrong field by field.
    """
    items = error.errors()
    for item in items:
        own = item.get("ctx", {}).get("error")
        if isinstance(own, OutsideDomain):
            return own
    if len(items) == 1 and isinstance(items[0].get("ctx", {}).get("error"), InvalidJob):
        place, message = fault_of(items[0])
        return InvalidJob(message, place)
    return InvalidFields([fault_of(item) for item in items])
