"""Bounds of the parameters: of the eccentricity (Eqs. 3, 8, 22) and of the stiffness (Eq. 35).

With one harmonic they are closed formulas. With several, a bound says that a trigonometric polynomial is positive at
every phase: the acceleration at rest in freeplay (Eq. 8), or the reaction of contact without ringing (Eq. 3). Its least
value is found to rounding (`numerics.trigonometric_minimum`).
"""

import math
from collections.abc import Callable

from rattle_kernels.model.arcs import largest_eccentricity_of_one, rest_acceleration_over_phases
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outside_domain import check_is_oscillator, demand_positive
from rattle_kernels.numerics.trigonometric_minimum import TrigonometricPolynomial, least_value

_TWO_PI = 2.0 * math.pi
_HALVINGS = 60


def quiet_depth_over_phases(oscillator: Oscillator) -> TrigonometricPolynomial:
    """Depth of contact without ringing times ``2 kappa``, the reaction (Eqs. 33-37), as a polynomial in the phase.

    Parameters
    ----------
    oscillator : Oscillator
        Its stiffness may be infinite: there the reaction is the acceleration at rest.

    Returns
    -------
    TrigonometricPolynomial
    """
    felt = rest_acceleration_over_phases(oscillator)
    if math.isinf(oscillator.stiffness):
        return felt
    square = 2.0 * oscillator.stiffness
    drag = oscillator.damping + 2.0 * oscillator.contact_damping * math.sqrt(square)
    rate = _TWO_PI * felt.order
    depth = (felt.cosine - 1j * felt.sine) * square / (square - rate * rate + 1j * rate * drag)
    return felt._replace(cosine=depth.real, sine=-depth.imag)


def _largest_eccentricity(oscillator: Oscillator, felt: Callable[[Oscillator], TrigonometricPolynomial]) -> float:
    """Eccentricity up to which a polynomial is positive at every phase, 0 where it is not even without any.

    Its least value is concave in the eccentricity, so it changes its sign once.
    """

    def is_positive(eccentricity: float) -> bool:
        return least_value(felt(oscillator._replace(eccentricity=eccentricity)))[0] > 0.0

    # The mean over phases of the polynomial times 1 + cos is positive where the polynomial is: |first harmonic| < 2
    # mean.
    one = felt(oscillator._replace(eccentricity=1.0))
    low, high = 0.0, 2.0 * one.mean / math.hypot(one.cosine[0], one.sine[0])
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_positive(middle) else (low, middle)
    return low


def eccentricity_bound_quiet(oscillator: Oscillator) -> float:
    """Bound epsilon_crit1 below which a quiet solution (permanent linear contact) exists, Eq. (3).

    Parameters
    ----------
    oscillator : Oscillator
        Its stiffness may be infinite: there the bound tends to that of Eq. (8).

    Returns
    -------
    float

    Raises
    ------
    OutsideDomain
        If damping or stiffness is not positive.
    """
    check_is_oscillator(oscillator)
    demand_positive(oscillator, "damping")
    damping, stiffness = oscillator.damping, oscillator.stiffness
    if math.isinf(stiffness):
        return eccentricity_bound_smooth_maxima(oscillator)
    demand_positive(oscillator, "stiffness")
    if oscillator.harmonics or oscillator.contact_damping > 0.0:
        return _largest_eccentricity(oscillator, quiet_depth_over_phases)
    stretch = math.hypot(stiffness - 2 * math.pi**2, math.pi * damping) / stiffness
    return 2 * damping * stretch / math.hypot(2 * math.pi, damping)


def eccentricity_bound_smooth_maxima(oscillator: Oscillator) -> float:
    """Bound epsilon_crit2 below which Phi has no smooth maxima in freeplay, Eq. (8).

    Below it the acceleration that an object at rest feels, ``4 pi delta - 4 pi^2 eps cos - 2 pi delta eps sin`` and the
    like of other harmonics, is positive at every phase. All root-finding of this package rests on that.

    Parameters
    ----------
    oscillator : Oscillator
        Either model; its eccentricity is not used.

    Returns
    -------
    float

    Raises
    ------
    OutsideDomain
        If the damping is not positive.
    """
    check_is_oscillator(oscillator)
    demand_positive(oscillator, "damping")
    if oscillator.harmonics:
        return _largest_eccentricity(oscillator, rest_acceleration_over_phases)
    return largest_eccentricity_of_one(oscillator.damping)


def eccentricity_bound_convexity(oscillator: Oscillator) -> float:
    """Bound epsilon_crit3 that is sufficient for the paper's convexity argument, Eq. (22).

    No kernel needs it: the brackets of ``impact_map.flights`` follow from Eq. (8) alone. It is given for comparison
    with the paper, whose forcing has one harmonic.

    Parameters
    ----------
    oscillator : Oscillator
        Either model; its eccentricity is not used.

    Returns
    -------
    float

    Raises
    ------
    OutsideDomain
        If the damping is not positive.
    """
    check_is_oscillator(oscillator)
    demand_positive(oscillator, "damping")
    return oscillator.damping / (math.pi + oscillator.damping / 2)


def stiffness_bound(oscillator: Oscillator) -> float:
    """Bound of the stiffness above which a contact rings, Eq. (35).

    Parameters
    ----------
    oscillator : Oscillator
        Only its dampings are used.

    Returns
    -------
    float

    Raises
    ------
    OutsideDomain
        If the damping is not positive.
    """
    check_is_oscillator(oscillator)
    demand_positive(oscillator, "damping")
    damping, part = oscillator.damping, oscillator.contact_damping
    # (delta + 2 zeta w)^2 < 4 w^2 with w^2 = 2 kappa.
    return damping * damping / (8.0 * (1.0 - part) ** 2) if part > 0.0 else damping * damping / 8.0
