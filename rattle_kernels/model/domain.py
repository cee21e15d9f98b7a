"""Where the impact map is defined: checks that name the parameter, the bound and what would be right."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from rattle_kernels.model.arcs import rest_acceleration_over_phases
from rattle_kernels.model.bounds import (
    eccentricity_bound_quiet,
    eccentricity_bound_smooth_maxima,
    quiet_depth_over_phases,
    stiffness_bound,
)
from rattle_kernels.model.harmonics import Harmonic
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outside_domain import OutsideDomain, check_is_oscillator, demand_positive
from rattle_kernels.numerics.trigonometric_minimum import TrigonometricPolynomial, least_value

_STIFFNESS_BOUND = "damping^2/8", "damping^2/(8 (1 - contact_damping)^2)"


def check_oscillator(oscillator: Oscillator) -> Oscillator:
    """Return the oscillator with plain float fields, or raise if its motion cannot be followed.

    Parameters
    ----------
    oscillator : Oscillator
        As a user gave it; fields may be integers, harmonics any sequences of three numbers. Both models are followed
        beyond the bound of Eq. (8), too.

    Returns
    -------
    Oscillator
        All fields of type float (an integer field would compile every kernel a second time), harmonics by order.

    Raises
    ------
    OutsideDomain
        Naming the parameter, the bound and its value.
    """
    check_is_oscillator(oscillator)
    numbers: list[Any] = [float(value) for value in oscillator[:-1]]
    checked = Oscillator(*numbers)._replace(harmonics=_checked_harmonics(oscillator.harmonics))
    demand_positive(checked, "damping", "half_backlash")
    if not checked.permanent_after > 0.0:
        message = f"permanent_after must be positive, not {checked.permanent_after}"
        raise OutsideDomain("permanent_after", checked.permanent_after, "positivity", 0.0, message)
    _check_contacts(checked)
    if not (math.isfinite(checked.eccentricity) and checked.eccentricity >= 0.0):
        message = f"eccentricity must be at least 0 and finite, not {checked.eccentricity}"
        raise OutsideDomain("eccentricity", checked.eccentricity, "positivity", 0.0, message)
    _check_size(checked)
    _check_stiffness(checked)
    return checked


def check_domain(oscillator: Oscillator) -> Oscillator:
    """Return the oscillator as `check_oscillator` does, or raise if it lies beyond the bound of Eq. (8).

    Parameters
    ----------
    oscillator : Oscillator
        As a user gave it. Either model.

    Returns
    -------
    Oscillator

    Raises
    ------
    OutsideDomain
        Naming the parameter, the bound and its value.
    """
    checked = check_oscillator(oscillator)
    _check_eccentricity(checked)
    return checked


def _checked_harmonics(harmonics: tuple[Harmonic, ...]) -> tuple[Harmonic, ...]:
    try:
        checked = tuple(sorted(Harmonic(*(float(value) for value in harmonic)) for harmonic in harmonics))
    except TypeError as error:
        raise ValueError(f"harmonics are a sequence of (order, amplitude, phase), not {harmonics!r}") from error
    orders = [harmonic.order for harmonic in checked]
    for order, amplitude, phase in checked:
        if not (order >= 2.0 and order == math.floor(order) and math.isfinite(order)):
            message = f"orders of harmonics are whole numbers from 2 on, not {order:g}; the first is the eccentricity"
            raise OutsideDomain("harmonics", order, "order", 2.0, message)
        if orders.count(order) > 1:
            raise OutsideDomain("harmonics", order, "order", 1.0, f"order {order:g} is there twice: add the two up")
        if not (math.isfinite(amplitude) and amplitude >= 0.0):
            message = f"amplitude of order {order:g} must be at least 0 and finite, not {amplitude}"
            raise OutsideDomain("harmonics", amplitude, "positivity", 0.0, message)
        if not math.isfinite(phase):
            raise OutsideDomain("harmonics", phase, "finite", 0.0, f"phase of order {order:g} must be finite")
    return checked


def _check_contacts(checked: Oscillator) -> None:
    """Refuse losses of energy that the oscillator's model does not have, or that are none."""
    impacting = math.isinf(checked.stiffness)
    restitution, part = checked.restitution, checked.contact_damping
    if not 0.0 < restitution <= 1.0:
        message = f"restitution must be above 0 and at most 1, not {restitution:g}"
        raise OutsideDomain("restitution", restitution, "energy", 1.0, message)
    if not impacting and restitution != 1.0:
        message = f"restitution belongs to the impacting model; with a stiffness of {checked.stiffness:g} give "
        raise OutsideDomain("restitution", restitution, "impacting model", 1.0, message + "contact_damping")
    if not 0.0 <= part < 1.0:
        message = f"contact_damping must be at least 0 and below 1, not {part:g}: beyond it contacts do not ring"
        raise OutsideDomain("contact_damping", part, "ringing", 1.0, message)
    if impacting and part != 0.0:
        message = "contact_damping belongs to the piecewise linear model; give restitution, or a stiffness"
        raise OutsideDomain("contact_damping", part, "piecewise linear model", 0.0, message)


def _check_eccentricity(checked: Oscillator) -> None:
    if checked.harmonics:
        _demand_positive(rest_acceleration_over_phases, "Eq. 8", "the acceleration at rest", checked)
        return
    limit = eccentricity_bound_smooth_maxima(checked)
    if not checked.eccentricity < limit:
        message = (
            f"eccentricity must be below epsilon_crit2 = {limit:.6g} at damping {checked.damping:g} (Eq. 8), "
            f"not {checked.eccentricity:g}: beyond it inertia torque exceeds drag torque, which is not "
            "followed here"
        )
        raise OutsideDomain("eccentricity", checked.eccentricity, "epsilon_crit2", limit, message)


def _check_size(checked: Oscillator) -> None:
    """Refuse a forcing whose acceleration overflows."""
    with np.errstate(over="ignore", invalid="ignore"):
        bend = rest_acceleration_over_phases(checked).bend
    if not math.isfinite(bend):
        parameter = "harmonics" if checked.harmonics else "eccentricity"
        message = "too large for the acceleration at rest (Eq. 8) to be computed: lower"
        message = f"harmonics are {message} their amplitudes" if checked.harmonics else f"eccentricity is {message} it"
        raise OutsideDomain(parameter, bend, "Eq. 8", 0.0, message)


def _demand_positive(
    over_phases: Callable[[Oscillator], TrigonometricPolynomial], equation: str, what: str, checked: Oscillator
) -> None:
    """Refuse harmonics with which a polynomial is not positive at every phase."""
    with np.errstate(over="ignore", invalid="ignore"):
        felt = over_phases(checked)
        least, phase = least_value(felt)
    if not math.isfinite(least):
        message = f"harmonics are too large for {what} ({equation}) to be computed: lower their amplitudes"
        raise OutsideDomain("harmonics", least, equation, 0.0, message)
    if not least > 0.0:
        # What they take from the mean grows as they do.
        part = felt.mean / (felt.mean - least)
        message = (
            f"{what} must be positive at every phase ({equation}): its mean is {felt.mean:.6g}, and with these "
            f"harmonics and eccentricity {checked.eccentricity:g} it falls to {least:.6g} at t = {phase:.4f}; lower "
            f"their amplitudes: all of them times less than {part:.6g} are within the bound"
        )
        raise OutsideDomain("harmonics", least, equation, 0.0, message)


def _check_stiffness(checked: Oscillator) -> None:
    """Refuse a contact that does not ring: Eq. (35) needs ``2 kappa > delta^2/4``.

    Damping in contact adds to this delta. Nothing more is needed. At a turning point beyond -beta the acceleration is
    that at rest plus the spring's, which is positive below epsilon_crit2 alone (Eqs. 8, 31). The condition ``kappa >
    pi^2 + delta^2/4``, under which epsilon_crit1 < epsilon_crit2, only decides which of the two bounds a quiet solution
    meets first.
    """
    limit = stiffness_bound(checked)
    if checked.stiffness != math.inf and not checked.stiffness > limit:
        message = (
            f"stiffness must be above {_STIFFNESS_BOUND[checked.contact_damping > 0.0]} = {limit:.6g}, not "
            f"{checked.stiffness:g}: contacts ring only above it (Eq. 35); infinite stiffness is the impacting model"
        )
        raise OutsideDomain("stiffness", checked.stiffness, "ringing", limit, message)


def closed_edges(parameter: str) -> tuple[float, float]:
    """Least and largest value that a parameter may have, where the domain ends with that value itself.

    Parameters
    ----------
    parameter : str
        One of `Oscillator.parameters`.

    Returns
    -------
    (float, float)
        Infinite on a side where there is none: the domain is open there, as at damping 0, or ends elsewhere (Eq. 8).
    """
    if parameter == "restitution":
        return -math.inf, 1.0
    if parameter in ("eccentricity", "contact_damping") or parameter.startswith("amplitude_"):
        return 0.0, math.inf
    return -math.inf, math.inf


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
    return _demand_impacts(check_domain(oscillator), "here only the impacting model is computed")


def check_invertible(oscillator: Oscillator) -> Oscillator:
    """Return the oscillator as `check_oscillator` does, or raise if its stiffness is finite: P has no inverse here.

    Parameters
    ----------
    oscillator : Oscillator
        As a user gave it.

    Returns
    -------
    Oscillator
        Of the impacting model, perhaps beyond the bound of Eq. (8).

    Raises
    ------
    OutsideDomain
        Naming the parameter, the bound and its value.
    """
    reason = "the inverse of P is needed, and a contact of finite stiffness is followed forwards only"
    return _demand_impacts(check_oscillator(oscillator), reason)


def _demand_impacts(checked: Oscillator, reason: str) -> Oscillator:
    if not math.isinf(checked.stiffness):
        message = f"stiffness must be infinite, which is the impacting model, not {checked.stiffness:g}: {reason}"
        raise OutsideDomain("stiffness", checked.stiffness, "impacting model", math.inf, message)
    return checked


def check_quiet(oscillator: Oscillator) -> Oscillator:
    """Return the oscillator as `check_oscillator` does, or raise if it has no quiet solution (Eq. 3).

    Parameters
    ----------
    oscillator : Oscillator
        As a user gave it. The impacting model's bound is that of Eq. (8). Of a soft contact that of Eq. (3) may be the
        higher one.

    Returns
    -------
    Oscillator

    Raises
    ------
    OutsideDomain
        Naming the parameter, the bound and its value.
    """
    checked = check_oscillator(oscillator)
    if math.isinf(checked.stiffness):
        return check_domain(checked)
    if checked.harmonics:
        _demand_positive(quiet_depth_over_phases, "Eq. 3", "the reaction in permanent contact", checked)
        return checked
    limit = eccentricity_bound_quiet(checked)
    if not checked.eccentricity < limit:
        message = (
            f"eccentricity must be below epsilon_crit1 = {limit:.6g} at damping {checked.damping:g} and stiffness "
            f"{checked.stiffness:g} (Eq. 3), not {checked.eccentricity:g}: beyond it there is no quiet solution"
        )
        raise OutsideDomain("eccentricity", checked.eccentricity, "epsilon_crit1", limit, message)
    return checked
