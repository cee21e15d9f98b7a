"""The rate of the forcing, e'(t)/(2 pi): where it has a value, and the eccentricity at which it first does.

With one harmonic both are closed formulas, with several they are found by bisection.
"""

import math

import numpy as np

from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.trigonometric_minimum import TrigonometricPolynomial, least_value

_TWO_PI = 2.0 * math.pi
# Samples for a period of the highest order.
_MESH = 64
_HALVINGS = 60


def _falling_rate(oscillator: Oscillator) -> TrigonometricPolynomial:
    """The rate, with the opposite sign."""
    order, amplitude, phase = np.array(oscillator.all_harmonics).T
    angle = _TWO_PI * phase
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
    turn = math.asin(rate / oscillator.eccentricity) / _TWO_PI
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
