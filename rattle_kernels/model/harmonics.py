"""Harmonics of the forcing beside the first: e(t) = eps cos(2 pi t) + sum of eps_n cos(2 pi (n t + phi_n)).

A measured transmission error has several orders, a pair of eccentric gears of ratio p : q has two, and torque ripple is
one more. In freeplay every harmonic adds its own terms to the formulas of `model.flight`, where its angle n h stands
for h. The functions here add them to what the first harmonic gives. With none these functions give back what they are
given, so the paper's model keeps its machine code and its bytes.

Kernels are compiled for none, one and two harmonics, and once for all larger numbers: more than two are an array of
records there. A tuple of each length would be a type of its own, and of 32 too long for the compiler.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from rattle_kernels.numerics.jit import inlined, mapped_over_tuple, record_type, summed_over_tuple
from rattle_kernels.numerics.phase import part_turn

TWO_PI = 2.0 * math.pi

# (h - sin h)/h^3 = sum (-h^2)^n / (2n + 3)!; 9 terms reach 1e-17 on |h| <= 1.
_CUBIC_REST = tuple((-1.0) ** n / math.factorial(2 * n + 3) for n in range(9))


class Harmonic(NamedTuple):
    """One harmonic of the forcing, ``amplitude cos(2 pi (order t + phase))``.

    Parameters
    ----------
    order : float
        A whole number, 2 or more: the first is the eccentricity.
    amplitude : float
        Not negative, as the eccentricity.
    phase : float
        Forcing periods of this harmonic, so 0.5 is half a turn of its own angle.

    Examples
    --------
    >>> Harmonic(order=2, amplitude=0.01, phase=0.25).order
    2
    """

    order: float
    amplitude: float
    phase: float = 0.0


MOST_IN_A_TUPLE = 2
"""Numbers of harmonics up to here have kernels of their own; more are an array of records there."""


@lru_cache(maxsize=256)
def records_of(harmonics: tuple[Harmonic, ...]) -> Any:
    """Harmonics as an array of records, which is not to be changed."""
    records = np.array(list(harmonics), record_type(Harmonic))
    records.flags.writeable = False
    return records


class HarmonicState(NamedTuple):
    """A harmonic at the beginning of a flight: order, amplitude, sine and cosine of its angle there."""

    order: float
    amplitude: float
    sine: float
    cosine: float


@inlined
def _state_at(harmonic, phase):
    # Each is reduced by itself: a phase and the same a period later give the same bits.
    angle = TWO_PI * part_turn(harmonic.order * part_turn(phase) + part_turn(harmonic.phase))
    return HarmonicState(harmonic.order, harmonic.amplitude, math.sin(angle), math.cos(angle))


states_at = mapped_over_tuple(_state_at, HarmonicState)
"""States of harmonics at a phase: ``states_at(harmonics, phase)``."""


@inlined
def cubic_rest(tau):
    """Compute (h - sin h)/h^3 for h = 2 pi tau."""
    h = TWO_PI * tau
    if abs(h) > 1.0:
        return (h - math.sin(TWO_PI * part_turn(tau))) / (h * h * h)
    total = 0.0
    for n in range(8, -1, -1):
        total = total * (h * h) + _CUBIC_REST[n]
    return total


@summed_over_tuple
def add_mean_acceleration(terms, total, place):
    """Add the harmonics of A(tau) to the first; `place` is (delta, tau, phi2)."""
    damping, tau, phi2 = place
    for state in terms:
        rate = TWO_PI * state.order
        cubic = rate * rate * rate * tau * cubic_rest(state.order * tau)
        chord = math.sin(math.pi * part_turn(state.order * tau)) / tau
        forcing = state.sine * (cubic - rate * damping * phi2) - 2.0 * state.cosine * chord * chord
        total += state.amplitude * forcing
    return total


@summed_over_tuple
def add_velocity(terms, total, place):
    """Add the harmonics of y'(tau) to the first; `place` is (delta, tau)."""
    damping, tau = place
    for state in terms:
        half_angle = math.pi * part_turn(state.order * tau)
        sine_half, cosine_half = math.sin(half_angle), math.cos(half_angle)
        sine_change = 2.0 * sine_half * (state.cosine * cosine_half - state.sine * sine_half)
        cosine_change = -2.0 * sine_half * (state.sine * cosine_half + state.cosine * sine_half)
        total += state.amplitude * (damping * cosine_change - TWO_PI * state.order * sine_change)
    return total


@summed_over_tuple
def add_rest_acceleration(terms, total, place):
    """Add the harmonics of the acceleration at rest to the first; `place` is (delta, phase)."""
    damping, phase = place
    for harmonic in terms:
        state, rate = _state_at(harmonic, phase), TWO_PI * harmonic.order
        total -= rate * harmonic.amplitude * (rate * state.cosine + damping * state.sine)
    return total


@summed_over_tuple
def add_swing(terms, total, place):
    """Add the largest accelerations of the harmonics; `place` is delta. Phases are not looked at: this is a bound."""
    for harmonic in terms:
        rate = TWO_PI * harmonic.order
        total += rate * harmonic.amplitude * math.hypot(rate, place)
    return total
