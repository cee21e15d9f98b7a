"""The error of a parameter beyond the domain, and the checks that need no bound."""

import math
from typing import Any

from rattle_kernels.model.oscillator import Oscillator


class OutsideDomain(ValueError):
    """A parameter lies where what is asked for is not computed.

    Attributes
    ----------
    parameter : str
        The field of `Oscillator` at fault.
    bound : str
        Name of the bound that it violates.
    limit : float
        Value of that bound.
    value : float
        Value of the parameter.

    Examples
    --------
    >>> from rattle_kernels import check_domain
    >>> try:
    ...     check_domain(Oscillator(eccentricity=0.3))
    ... except OutsideDomain as error:
    ...     print(error.parameter, error.bound, round(error.limit, 3))
    eccentricity epsilon_crit2 0.19
    """

    def __init__(self, parameter: str, value: float, bound: str, limit: float, message: str) -> None:
        super().__init__(message)
        self.parameter = parameter
        self.value = value
        self.bound = bound
        self.limit = limit

    def __reduce__(self) -> tuple[type, tuple[str, float, str, float, str]]:
        # Raised in workers too: it must survive pickling with all its arguments.
        return type(self), (self.parameter, self.value, self.bound, self.limit, str(self))


def check_is_oscillator(oscillator: Any) -> None:
    """Raise if a value is no oscillator.

    Parameters
    ----------
    oscillator : Any

    Raises
    ------
    TypeError
    """
    if not isinstance(oscillator, Oscillator):
        raise TypeError(f"oscillator must be an Oscillator, such as Oscillator(damping=0.6), not {oscillator!r}")


def demand_positive(oscillator: Oscillator, *parameters: str) -> None:
    """Raise if a parameter is not positive and finite.

    Parameters
    ----------
    oscillator : Oscillator
    *parameters : str
        Fields to check.

    Raises
    ------
    OutsideDomain
    """
    for name in parameters:
        value = getattr(oscillator, name)
        if not (math.isfinite(value) and value > 0.0):
            raise OutsideDomain(name, value, "positivity", 0.0, f"{name} must be positive and finite, not {value}")
