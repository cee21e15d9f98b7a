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


def damping_bound_quiet(oscillator: Oscillator) -> float:
    """Damping above which a quiet solution exists at a stiffness and an eccentricity, Eq. (3) solved for it.

    Parameters
    ----------
    oscillator : Oscillator
        Its stiffness may be infinite; its damping is not used.

    Returns
    -------
    float
        Infinite where the largest damping of a float has none.

    Raises
    ------
    OutsideDomain
        If the stiffness is not positive.
    ValueError
        With several harmonics or damping in contact, where Eq. (3) is no formula.

    Examples
    --------
    >>> bound = damping_bound_quiet(Oscillator(eccentricity=0.15, stiffness=100.0))
    >>> round(eccentricity_bound_quiet(Oscillator(bound, stiffness=100.0)), 12)
    0.15
    """
    _demand_one_harmonic(oscillator)
    demand_positive(oscillator, "stiffness")
    eccentricity = oscillator.eccentricity
    if not eccentricity > 0.0:
        return 0.0
    # a x^2 + b x - c = 0 with x = damping^2 has one positive root. Each form of it is used where nothing cancels.
    reduced, rate = 1.0 - 2.0 * math.pi**2 / oscillator.stiffness, _TWO_PI / oscillator.stiffness
    a, c = rate * rate, _TWO_PI * eccentricity * (_TWO_PI * eccentricity)
    b = 4.0 * reduced * reduced - eccentricity * eccentricity
    root = math.sqrt(b * b + 4.0 * a * c)
    if b > 0.0:
        return math.sqrt(2.0 * c / (b + root))
    return math.sqrt((root - b) / (2.0 * a)) if a > 0.0 else math.inf


def stiffness_gap_quiet(oscillator: Oscillator) -> tuple[float, float] | None:
    """Stiffnesses between which there is no quiet solution at a damping and an eccentricity, Eq. (3) solved for them.

    There contact resonates. Soft contact does not follow, stiff contact hardly bends.

    Parameters
    ----------
    oscillator : Oscillator
        Its stiffness is not used.

    Returns
    -------
    (float, float) or None
        None where every stiffness has one. The second is infinite from epsilon_crit2 on (Eq. 8).

    Raises
    ------
    OutsideDomain
        If the damping is not positive.
    ValueError
        With several harmonics or damping in contact, where Eq. (3) is no formula.

    Examples
    --------
    >>> low, high = stiffness_gap_quiet(Oscillator(eccentricity=0.15))
    >>> [round(eccentricity_bound_quiet(Oscillator(stiffness=edge)), 12) for edge in (low, high)]
    [0.15, 0.15]
    """
    _demand_one_harmonic(oscillator)
    demand_positive(oscillator, "damping")
    # (1 - part) x^2 - 4 x + 4 + turn^2 = 0 with x = stiffness/pi^2, divided by turn so that no square overflows.
    turn = oscillator.damping / math.pi
    ratio, half = oscillator.eccentricity / turn, 0.5 * oscillator.eccentricity
    part = ratio * ratio + half * half
    discriminant = 4.0 * part / turn / turn - (1.0 - part)
    if not discriminant > 0.0:
        return None
    sum_of = 2.0 / turn + math.sqrt(discriminant)
    low = (4.0 / turn + turn) / sum_of
    return math.pi**2 * low, math.pi**2 * turn * sum_of / (1.0 - part) if part < 1.0 else math.inf


def _demand_one_harmonic(oscillator: Oscillator) -> None:
    check_is_oscillator(oscillator)
    if oscillator.harmonics or oscillator.contact_damping > 0.0:
        raise ValueError("with several harmonics or damping in contact Eq. (3) is no formula: search for the bound")


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
