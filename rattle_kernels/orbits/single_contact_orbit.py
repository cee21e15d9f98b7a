"""P(m, 1, 0) in closed form: one impact on +beta every m forcing periods, none on -beta (the family behind Eq. 41).

A flight leaves +beta with speed v and returns after a time m. The forcing terms are then the same again, so its
velocity is -v + 4 pi delta m. An impact makes v of it, hence ``v = 4 pi delta m r/(1 + r)`` for all forcing and beta.
With x = delta m, y(m) = 0 then says for the rate of the forcing e(t) at the departure

    e'(t0)/(2 pi) = x coth(x/2) - 2 + x (1 - r)/(1 + r) = x^2/6 - x^4/360 + ... + x (1 - r)/(1 + r).

Under one harmonic the left side is -eps sin(2 pi t0). So the two orbits of each m are born together, at t0 = 3/4 and
where eps is the right side, whose series Eq. (41) gives for elastic impacts. Then they move apart. Under several
harmonics there may be more pairs; their phases are found by bisection. With S = (1 - e^{-x})/delta the trace of DP is

    1 + r^2 e^{-x} + r (1 + r) e''(t0) S/v,

and its determinant r^2 e^{-x}. Below epsilon_crit2 the acceleration at rest is positive, and the trace exceeds -r (1 +
e^{-x}) and with it -1 - r^2 e^{-x}: none of them ever doubles its period. Of two that are born together one attracts,
with e''(t0) < 0, and the other is a saddle. They exist while they stay clear of -beta, at ``v <= v*(t0)``. Beyond that
the flight would meet -beta.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.grazing_velocity import grazing_velocity
from rattle_kernels.model.domain import check_impacting
from rattle_kernels.model.flight import FOUR_PI, TWO_PI, second_phi, second_phi_slope
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outside_domain import check_is_oscillator
from rattle_kernels.numerics.trigonometric_minimum import TrigonometricPolynomial, least_value

# Samples for a period of the highest order.
_MESH = 64
_HALVINGS = 60


def _falling_rate(oscillator: Oscillator) -> TrigonometricPolynomial:
    """The rate, with the opposite sign."""
    order, amplitude, phase = np.array(oscillator.all_harmonics).T
    angle = TWO_PI * phase
    return TrigonometricPolynomial(0.0, order, order * amplitude * np.sin(angle), order * amplitude * np.cos(angle))


def phases_at_rate(oscillator: Oscillator, rate: float) -> tuple[float, ...]:
    """Phases at which the rate of the forcing has a value.

    Parameters
    ----------
    oscillator : Oscillator
        Either model, checked by the caller.
    rate : float
        Above 0.

    Returns
    -------
    tuple of float
        Under one harmonic the phase at which the rate falls, then the other; under several all phases, ascending. A
        pair of them that is closer than a 64th of a period of the highest order may be missed.
    """
    if oscillator.harmonics:
        return _by_bisection(_falling_rate(oscillator), rate)
    if not oscillator.eccentricity > rate:
        return ()
    turn = math.asin(rate / oscillator.eccentricity) / TWO_PI
    return 1.0 - turn, 0.5 + turn


def _by_bisection(falling: TrigonometricPolynomial, rate: float) -> tuple[float, ...]:
    samples = _MESH * int(falling.order.max())
    low = np.arange(samples) / samples
    high = np.append(low[1:], 1.0)
    crossed = (falling.at(low) < -rate) != (falling.at(high) < -rate)
    low, high = low[crossed], high[crossed]
    begins = falling.at(low) < -rate
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        as_before = (falling.at(middle) < -rate) == begins
        low, high = np.where(as_before, middle, low), np.where(as_before, high, middle)
    return tuple(map(float, low))


def eccentricity_at_rate(oscillator: Oscillator, rate: float) -> float:
    """Eccentricity at which the rate of the forcing first has a value at some phase, as it grows from 0.

    Parameters
    ----------
    oscillator : Oscillator
        Either model; only its harmonics are used.
    rate : float
        Above 0.

    Returns
    -------
    float
        At any larger eccentricity the rate has that value, too. 0 if it has it without any eccentricity; it may then
        lose it for some eccentricities.
    """
    if not oscillator.harmonics:
        return rate

    def stays_below(eccentricity: float) -> bool:
        return least_value(_falling_rate(oscillator._replace(eccentricity=eccentricity)))[0] > -rate

    if not stays_below(0.0):
        return 0.0
    # The largest rate is convex in the eccentricity, so it passes the value once. It is at least half the eccentricity:
    # that is the mean of the rate times 1 - sin(2 pi t).
    low, high = 0.0, 2.0 * rate
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stays_below(middle) else (low, middle)
    return low


class SingleContactOrbit(NamedTuple):
    """One of the orbits P(m, 1, 0).

    ``t``, ``v`` are the departure. ``trace`` is the trace of DP, whose determinant is r^2 e^{-delta m}.
    ``grazing_margin`` is v - v*(t), negative while the orbit exists.
    """

    forcing_periods: int
    t: float
    v: float
    trace: float
    grazing_margin: float

    @property
    def exists(self) -> bool:
        """Whether the flight stays clear of -beta."""
        return self.grazing_margin <= 0.0


def eccentricity_bound_single_contact(oscillator: Oscillator, forcing_periods: int = 1) -> float:
    """Eccentricity at which the first orbits P(m, 1, 0) are born: the exact form of Eq. (41).

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model; its eccentricity is not used.
    forcing_periods : int
        m > 0.

    Returns
    -------
    float
        ``x coth(x/2) - 2 + x (1 - r)/(1 + r)`` with x = delta m, accurate to rounding even where it is tiny. With
        harmonics there is no formula, and it is found by bisection; 0 if they make such orbits without eccentricity.

    Raises
    ------
    OutsideDomain
        If the oscillator's other parameters lie outside the domain of the map, or its stiffness is finite.
    ValueError
        If ``forcing_periods`` is not valid.
    """
    check_is_oscillator(oscillator)
    checked = check_impacting(oscillator._replace(eccentricity=0.0))
    return eccentricity_at_rate(checked, _rate_at_departure(checked, _checked_periods(forcing_periods)))


def _checked_periods(forcing_periods: int) -> int:
    if not (forcing_periods >= 1 and forcing_periods == math.floor(forcing_periods)):
        raise ValueError(f"forcing_periods must be a whole number from 1 on, not {forcing_periods}")
    return int(forcing_periods)


def _rate_at_departure(oscillator: Oscillator, forcing_periods: int) -> float:
    """Rate of the forcing, e'(t)/(2 pi), at which an orbit P(m, 1, 0) departs."""
    restitution = oscillator.restitution
    x = oscillator.damping * forcing_periods
    # x coth(x/2) - 2 = x (2 phi2 - phi1)/phi1, and phi1 - 2 phi2 = x phi2': nothing cancels.
    elastic = -x * x * float(second_phi_slope(x)) / (1.0 - x * float(second_phi(x)))
    return elastic + x * (1.0 - restitution) / (1.0 + restitution)


def single_contact_orbits(oscillator: Oscillator, forcing_periods: int = 1) -> tuple[SingleContactOrbit, ...]:
    """All orbits P(m, 1, 0) of the impacting model: two under one harmonic, none below the bound of Eq. (41).

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    forcing_periods : int
        m > 0.

    Returns
    -------
    tuple of SingleContactOrbit
        Under one harmonic the attracting orbit first, then the saddle; under several by phase. ``exists`` says whether
        an orbit stays clear of -beta.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map, or its stiffness is finite.
    ValueError
        If ``forcing_periods`` is not valid.

    References
    ----------
    Sec. 5.2, Eq. (41), given there as a series without derivation (Halse et al., 2007; Mason et al., 2007).
    """
    checked, periods = check_impacting(oscillator), _checked_periods(forcing_periods)
    rate = _rate_at_departure(checked, periods)
    return tuple(_at_phase(checked, periods, t) for t in phases_at_rate(checked, rate))


def _at_phase(oscillator: Oscillator, forcing_periods: int, t: float) -> SingleContactOrbit:
    x, r = oscillator.damping * forcing_periods, oscillator.restitution
    v = FOUR_PI * x * r / (1.0 + r)
    stretch = -math.expm1(-x) / oscillator.damping
    order, amplitude, phase = np.array(oscillator.all_harmonics).T
    fall = float(((TWO_PI * order) ** 2 * amplitude * np.cos(TWO_PI * (order * t + phase))).sum())
    trace = 1.0 + r * r * math.exp(-x) - r * (1.0 + r) * fall * stretch / v
    return SingleContactOrbit(forcing_periods, t, v, trace, v - float(grazing_velocity(oscillator, t)))
