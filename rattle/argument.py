"""An argument of a verb, and groups of arguments that together make a field of a request."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel

from rattle_kernels.model.oscillator import PARAMETERS
from worker.jobs.swept_parameter import is_of_harmonic

Values = Mapping[str, Any]
"""Arguments by name: only those that were given."""


@dataclass(frozen=True)
class Argument:
    """An argument of a verb: its name, type, default (``...`` if it must be given), description and least value."""

    name: str
    kind: Any
    default: Any
    text: str = ""
    least: float | None = None


class Group(NamedTuple):
    """Arguments that together make one field of a request, and how they do; None leaves the field out."""

    arguments: tuple[Argument, ...]
    read: Callable[[Values], Any]


def plain(value: Any) -> Any:
    """Numbers of NumPy as Python's; arrays as lists."""
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def of_part(model: type[BaseModel], name: str) -> Argument:
    """A number, a choice or a switch that is a field of a part."""
    field = model.model_fields[name]
    return Argument(name, field.annotation, field.default, field.description or "")


def is_parameter(name: str) -> bool:
    """Whether an argument is a number of the oscillator that a study may vary."""
    return name in PARAMETERS or is_of_harmonic(name)


def is_swept(value: Any) -> bool:
    """Whether an argument holds the values of a swept parameter, not one value."""
    return isinstance(value, list | tuple | dict)
