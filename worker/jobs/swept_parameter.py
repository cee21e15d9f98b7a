"""A parameter of the oscillator that a sweep steps through, and the values it takes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from rattle_kernels import Oscillator
from worker.errors import InvalidJob

MOST_SWEPT = 2


class Spacing(StrEnum):
    """How values lie between a start and a stop."""

    LINEAR = "linear"
    GEOMETRIC = "geometric"


@dataclass(frozen=True)
class SweptParameter:
    """A field of `Oscillator` and its values, in the order in which basins follow one another."""

    parameter: str
    values: tuple[float, ...]

    @classmethod
    def spaced(cls, parameter: str, start: float, stop: float, count: int, spacing: Spacing) -> "SweptParameter":
        """Two values or more from start to stop, both included.

        Raises
        ------
        InvalidJob
            Where values cannot be spaced so.
        """
        if spacing == Spacing.GEOMETRIC and not (start > 0.0 and stop > 0.0):
            raise InvalidJob(f"{parameter} can only be spaced geometrically from and to values above 0")
        if count < 2:
            raise InvalidJob(f"{parameter} takes at least two values from start to stop, not {count}")
        space = np.geomspace if spacing == Spacing.GEOMETRIC else np.linspace
        # Decimals where decimals are meant: 0.6, not 0.6000000000000001, which is another oscillator.
        between = [float(f"{value:.15g}") for value in space(start, stop, count)[1:-1]]
        return cls(parameter, (float(start), *between, float(stop)))


def check_swept(vary: Sequence[SweptParameter], oscillator: Oscillator) -> tuple[SweptParameter, ...]:
    """Return swept parameters with plain float values, or say what is wrong with them.

    Parameters
    ----------
    vary : sequence of SweptParameter
    oscillator : Oscillator
        What is swept about.

    Raises
    ------
    InvalidJob
        With the place of what is at fault.
    """
    if len(vary) > MOST_SWEPT:
        raise InvalidJob(f"at most {MOST_SWEPT} parameters can be swept, not {len(vary)}", ("vary",))
    names = [swept.parameter for swept in vary]
    for axis, name in enumerate(names):
        place = ("vary", axis, "parameter")
        if name not in Oscillator._fields:
            raise InvalidJob(f"{name} cannot be swept; these can: {', '.join(Oscillator._fields)}", place)
        if name in names[:axis]:
            raise InvalidJob(f"{name} is swept twice", place)
        if name == "stiffness" and math.isinf(oscillator.stiffness):
            raise InvalidJob("stiffness cannot be swept in the impacting model, where it is infinite", place)
    return tuple(SweptParameter(swept.parameter, _checked_values(axis, swept)) for axis, swept in enumerate(vary))


def _checked_values(axis: int, swept: SweptParameter) -> tuple[float, ...]:
    values = tuple(float(value) for value in swept.values)
    if not values:
        raise InvalidJob(f"{swept.parameter} needs at least one value", ("vary", axis, "values"))
    for index, value in enumerate(values):
        if not math.isfinite(value):
            message = f"values of {swept.parameter} must be finite; number {index} is {value}"
            raise InvalidJob(message, ("vary", axis, "values", index))
    steps = np.diff(values)
    # Neighbours are compared with one another, and births and deaths are told by the interval between them.
    astray = np.flatnonzero(steps * (steps[0] if steps.size else 1.0) <= 0.0)
    if astray.size:
        index = int(astray[0]) + 1
        message = f"values of {swept.parameter} must ascend or descend; number {index} is {values[index]:g}"
        raise InvalidJob(f"{message} after {values[index - 1]:g}", ("vary", axis, "values", index))
    return values
