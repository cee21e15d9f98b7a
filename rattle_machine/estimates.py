"""A number from a sample, with its standard error, and how both are written."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

_SMALL = 1e-3
_TIMES = ((31_557_600.0, "years"), (86_400.0, "days"), (3_600.0, "h"), (60.0, "min"), (1.0, "s"))


@dataclass(frozen=True)
class Estimate:
    """A number and its standard error, NaN where the sample does not tell it.

    Attributes
    ----------
    value, error : float
    """

    value: float
    error: float

    def times(self, factor: float) -> "Estimate":
        """The estimate in other units."""
        return Estimate(self.value * factor, self.error * factor)

    def inverse(self) -> "Estimate":
        """One over it, by the delta method: the relative error is the same. Infinite where it is 0."""
        if self.value == 0.0:
            return Estimate(math.inf, math.nan)
        return Estimate(1.0 / self.value, self.error / self.value**2)

    def __str__(self) -> str:
        """Two digits of the error, and as many of the value."""
        if not (math.isfinite(self.value) and math.isfinite(self.error) and self.error > 0.0):
            return f"{self.value:.4g}"
        places = 1 - math.floor(math.log10(self.error))
        if places < 0 or 0.0 < abs(self.value) < _SMALL:
            return f"{self.value:.4g} ± {self.error:.2g}"
        return f"{self.value:.{places}f} ± {self.error:.{places}f}"


def mean_of(sample: np.ndarray) -> Estimate:
    """Mean of independent numbers, with its standard error from their scatter.

    Parameters
    ----------
    sample : ndarray of float64, shape (n,)

    Returns
    -------
    Estimate
        NaN of none; the error is NaN of a single one.
    """
    if not sample.size:
        return Estimate(math.nan, math.nan)
    error = sample.std(ddof=1) / math.sqrt(sample.size) if sample.size > 1 else math.nan
    return Estimate(float(sample.mean()), float(error))


def in_words(time: float) -> str:
    """A time in s, in the largest unit of which it is more than one."""
    if not math.isfinite(time):
        return "never"
    size, name = next((each for each in _TIMES if time >= each[0]), _TIMES[-1])
    return f"{time / size:.3g} {name}"


def with_error(time: Estimate) -> str:
    """A time in s with its error, in the largest unit of which it is more than one."""
    if not math.isfinite(time.value):
        return "never"
    size, name = next((each for each in _TIMES if time.value >= each[0]), _TIMES[-1])
    return f"{time.times(1.0 / size)} {name}"


def for_json(value: Any) -> Any:
    """A value for JSON: a number that is not finite is None.

    Parameters
    ----------
    value : object
        Numbers and texts, in dicts, lists and tuples.

    Returns
    -------
    object
    """
    if isinstance(value, dict):
        return {str(name): for_json(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [for_json(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
