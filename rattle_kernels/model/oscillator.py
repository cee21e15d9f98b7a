"""The backlash oscillator, Eqs. (1, 2), and its impacting limit (4, 5): parameters, and where P is defined."""

import math
from typing import NamedTuple


class Oscillator(NamedTuple):
    """Parameters of the gear pair; everything is nondimensional and time counts forcing periods.

    Parameters
    ----------
    damping : float
        delta > 0.
    eccentricity : float
        epsilon, amplitude of the order-one forcing, ``0 <= epsilon < epsilon_crit2`` (Eq. 8).
    half_backlash : float
        beta > 0.
    stiffness : float
        kappa; infinite for the impacting model.
    permanent_after : float
        A contact beyond +beta that lasts longer than this many forcing periods counts as permanent. Infinity stands
        for the exact rule (the ringing's envelope), 1.0 for the paper's rule, one gross rotation. The impacting model
        does not use it.

    Examples
    --------
    >>> Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6)._replace(stiffness=1e4).stiffness
    10000.0
    """

    damping: float = 0.6
    eccentricity: float = 0.1
    half_backlash: float = 0.6
    stiffness: float = math.inf
    permanent_after: float = math.inf


# The fields that a study may vary. `permanent_after` is a rule, not a property.
PARAMETERS = ("damping", "eccentricity", "half_backlash", "stiffness")


class OutsideDomain(ValueError):
    """A parameter lies where the impact map is not defined.

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


def eccentricity_bound_quiet(oscillator: Oscillator) -> float:
    """Bound epsilon_crit1 below which a quiet solution (permanent linear contact) exists, Eq. (3).

    Parameters
    ----------
    oscillator : Oscillator
        Its stiffness may be infinite: there the bound tends to that of Eq. (8).

    Returns
    -------
    float
    """
    damping, stiffness = oscillator.damping, oscillator.stiffness
    if math.isinf(stiffness):
        return eccentricity_bound_smooth_maxima(oscillator)
    stretch = math.hypot(stiffness - 2 * math.pi**2, math.pi * damping) / stiffness
    return 2 * damping * stretch / math.hypot(2 * math.pi, damping)


def eccentricity_bound_smooth_maxima(oscillator: Oscillator) -> float:
    """Bound epsilon_crit2 below which Phi has no smooth maxima in freeplay, Eq. (8).

    Below it the acceleration that an object at rest feels, ``4 pi delta - 4 pi^2 eps cos - 2 pi delta eps sin``, is
    positive at every phase. All root-finding of this package rests on that.

    Parameters
    ----------
    oscillator : Oscillator
        Either model; its eccentricity is not used.

    Returns
    -------
    float
    """
    return 2 * oscillator.damping / math.hypot(2 * math.pi, oscillator.damping)


def eccentricity_bound_convexity(oscillator: Oscillator) -> float:
    """Bound epsilon_crit3 that is sufficient for the paper's convexity argument, Eq. (22).

    No kernel needs it: the brackets of `impact_map.flights` are proven from Eq. (8) alone. It is given for comparison
    with the paper.

    Parameters
    ----------
    oscillator : Oscillator
        Either model; its eccentricity is not used.

    Returns
    -------
    float
    """
    return oscillator.damping / (math.pi + oscillator.damping / 2)


def stiffness_bound(oscillator: Oscillator) -> float:
    """Bound of the stiffness above which a contact rings, Eq. (35).

    Parameters
    ----------
    oscillator : Oscillator
        Only its damping is used.

    Returns
    -------
    float
    """
    return oscillator.damping * oscillator.damping / 8.0


def check_domain(oscillator: Oscillator) -> Oscillator:
    """Return the oscillator with plain float fields, or raise if P is not defined for it.

    Parameters
    ----------
    oscillator : Oscillator
        As a user gave it; fields may be integers. Either model.

    Returns
    -------
    Oscillator
        All fields of type float (an integer field would compile every kernel a second time).

    Raises
    ------
    OutsideDomain
        Naming the parameter, the bound and its value.
    """
    checked = Oscillator(*(float(value) for value in oscillator))
    for name in ("damping", "half_backlash"):
        value = getattr(checked, name)
        if not (math.isfinite(value) and value > 0.0):
            raise OutsideDomain(name, value, "positivity", 0.0, f"{name} must be positive and finite, not {value}")
    if not checked.permanent_after > 0.0:
        message = f"permanent_after must be positive, not {checked.permanent_after}"
        raise OutsideDomain("permanent_after", checked.permanent_after, "positivity", 0.0, message)
    _check_eccentricity(checked)
    _check_stiffness(checked)
    return checked


def _check_eccentricity(checked: Oscillator) -> None:
    if not checked.eccentricity >= 0.0:
        message = f"eccentricity must be at least 0, not {checked.eccentricity}"
        raise OutsideDomain("eccentricity", checked.eccentricity, "positivity", 0.0, message)
    limit = eccentricity_bound_smooth_maxima(checked)
    if not checked.eccentricity < limit:
        message = (
            f"eccentricity must be below epsilon_crit2 = {limit:.6g} at damping {checked.damping:g} (Eq. 8), "
            f"not {checked.eccentricity:g}: beyond it freeplay has smooth maxima and the impact map is not defined"
        )
        raise OutsideDomain("eccentricity", checked.eccentricity, "epsilon_crit2", limit, message)


def _check_stiffness(checked: Oscillator) -> None:
    """Refuse a contact that does not ring: Eq. (35) needs ``2 kappa > delta^2/4``.

    Nothing more is needed. At a turning point beyond -beta the acceleration is that at rest plus the spring's, which is
    positive below epsilon_crit2 alone (Eqs. 8, 31). The condition ``kappa > pi^2 + delta^2/4``, under which
    epsilon_crit1 < epsilon_crit2, only decides which of the two bounds a quiet solution meets first.
    """
    limit = stiffness_bound(checked)
    if checked.stiffness != math.inf and not checked.stiffness > limit:
        message = (
            f"stiffness must be above damping^2/8 = {limit:.6g}, not {checked.stiffness:g}: contacts ring only above "
            "it (Eq. 35); infinite stiffness is the impacting model"
        )
        raise OutsideDomain("stiffness", checked.stiffness, "ringing", limit, message)


def check_impacting(oscillator: Oscillator) -> Oscillator:
    """Return the oscillator as `check_domain` does, or raise if its stiffness is finite.

    Parameters
    ----------
    oscillator : Oscillator
        As a user gave it.

    Returns
    -------
    Oscillator
        Of the impacting model.

    Raises
    ------
    OutsideDomain
        Naming the parameter, the bound and its value.
    """
    checked = check_domain(oscillator)
    if not math.isinf(checked.stiffness):
        message = (
            f"stiffness must be infinite, not {checked.stiffness:g}: here only the impacting model is computed, "
            "which has none"
        )
        raise OutsideDomain("stiffness", checked.stiffness, "impacting model", math.inf, message)
    return checked


def check_quiet(oscillator: Oscillator) -> Oscillator:
    """Return the oscillator as `check_domain` does, or raise if it has no quiet solution (Eq. 3).

    Parameters
    ----------
    oscillator : Oscillator
        As a user gave it. The impacting model's bound is that of Eq. (8).

    Returns
    -------
    Oscillator

    Raises
    ------
    OutsideDomain
        Naming the parameter, the bound and its value.
    """
    checked = check_domain(oscillator)
    limit = eccentricity_bound_quiet(checked)
    if not checked.eccentricity < limit:
        message = (
            f"eccentricity must be below epsilon_crit1 = {limit:.6g} at damping {checked.damping:g} and stiffness "
            f"{checked.stiffness:g} (Eq. 3), not {checked.eccentricity:g}: beyond it there is no quiet solution"
        )
        raise OutsideDomain("eccentricity", checked.eccentricity, "epsilon_crit1", limit, message)
    return checked
