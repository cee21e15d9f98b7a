"""One flight in freeplay, Eq. (6), in a form in which nothing cancels.

A flight leaves a wall at phase t0 with signed velocity w (negative from +beta, positive from -beta). With x = delta
tau, h = 2 pi tau, phi1 = (1 - e^-x)/x, phi2 = (1 - phi1)/x and s0, c0 = sin, cos(2 pi t0), its displacement from that
wall is

    y(tau) = tau (w phi1 + tau A),
    A = delta (4 pi - 2 pi eps s0) phi2 - 2 eps c0 (sin(pi tau)/tau)^2 + eps s0 (h - sin h)/tau^2,

which equals Eqs. (18), (24), (30) but keeps full precision as delta, tau or w tend to zero. Everything holds for tau <
0 as well: the flight backwards in time. Other harmonics add the like with an angle of their own (`model.harmonics`).
"""

import math
from typing import NamedTuple

from rattle_kernels.model.harmonics import (
    TWO_PI,
    add_mean_acceleration,
    add_rest_acceleration,
    add_swing,
    add_velocity,
    cubic_rest,
    states_at,
)
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.phase import part_turn

FOUR_PI = 4.0 * math.pi

# Taylor coefficients of phi2(x) = sum (-x)^n / (n + 2)!; 21 terms reach 1e-17 on |x| <= 1.
_PHI2 = tuple((-1.0) ** n / math.factorial(n + 2) for n in range(21))
# phi2'(x) = sum n (-1)^n x^(n-1)/(n + 2)!; 20 terms reach 1e-17 on |x| <= 1.
_PHI2_SLOPE = tuple(n * (-1.0) ** n / math.factorial(n + 2) for n in range(1, 21))


class Flight(NamedTuple):
    """A flight as the root-finders see it: the oscillator's numbers, where it starts and how fast.

    ``sine`` and ``cosine`` are those of the starting phase; ``velocity`` is signed. ``harmonics`` are states there.
    """

    damping: float
    eccentricity: float
    sine: float
    cosine: float
    velocity: float
    harmonics: tuple


@inlined
def start_flight(oscillator, phase, velocity):
    """Flight that leaves a wall at `phase` with signed `velocity`."""
    angle = TWO_PI * part_turn(phase)
    harmonics = states_at(oscillator.harmonics, phase)
    return Flight(oscillator.damping, oscillator.eccentricity, math.sin(angle), math.cos(angle), velocity, harmonics)


@inlined
def second_phi(x):
    """phi2(x) = (e^-x - 1 + x)/x^2."""
    if abs(x) > 1.0:
        return (math.expm1(-x) + x) / (x * x)
    total = 0.0
    for n in range(20, -1, -1):
        total = total * x + _PHI2[n]
    return total


@inlined
def second_phi_slope(x):
    """phi2'(x) = (phi1 - 2 phi2)/x."""
    if abs(x) > 1.0:
        phi2 = second_phi(x)
        return (1.0 - x * phi2 - 2.0 * phi2) / x
    total = 0.0
    for n in range(19, -1, -1):
        total = total * x + _PHI2_SLOPE[n]
    return total


@inlined
def mean_acceleration(flight, tau):
    """A(tau): half the acceleration at the wall for tau -> 0, later the mean that carries the flight back."""
    gravity = flight.damping * (FOUR_PI - TWO_PI * flight.eccentricity * flight.sine)
    cubic = TWO_PI * TWO_PI * TWO_PI * tau * cubic_rest(tau)
    chord = math.sin(math.pi * part_turn(tau)) / tau  # its sign may be lost: only the square counts
    forcing = flight.sine * cubic - 2.0 * flight.cosine * chord * chord
    phi2 = second_phi(flight.damping * tau)
    first = gravity * phi2 + flight.eccentricity * forcing
    return add_mean_acceleration(flight.harmonics, first, (flight.damping, tau, phi2))


@inlined
def displacement_rate(flight, tau):
    """y(tau)/tau: the displacement with its trivial root at tau = 0 divided out."""
    x = flight.damping * tau
    return flight.velocity * (1.0 - x * second_phi(x)) + tau * mean_acceleration(flight, tau)


@inlined
def velocity_after(flight, tau, displacement):
    """Signed velocity y'(tau), given that y(tau) = `displacement`; needs no exponential."""
    half_angle = math.pi * part_turn(tau)
    sine_half, cosine_half = math.sin(half_angle), math.cos(half_angle)
    # s - s0 and c - c0 as products, so that they keep their digits for short flights.
    sine_change = 2.0 * sine_half * (flight.cosine * cosine_half - flight.sine * sine_half)
    cosine_change = -2.0 * sine_half * (flight.sine * cosine_half + flight.cosine * sine_half)
    forcing = flight.damping * cosine_change - TWO_PI * sine_change
    first = flight.velocity + flight.damping * (FOUR_PI * tau - displacement) + flight.eccentricity * forcing
    return add_velocity(flight.harmonics, first, (flight.damping, tau))


@inlined
def rest_acceleration(oscillator, phase):
    """Acceleration felt at rest in freeplay, Eq. (7): positive at every phase below the bound of Eq. (8)."""
    angle = TWO_PI * part_turn(phase)
    forcing = TWO_PI * math.cos(angle) + oscillator.damping * math.sin(angle)
    first = FOUR_PI * oscillator.damping - TWO_PI * oscillator.eccentricity * forcing
    return add_rest_acceleration(oscillator.harmonics, first, (oscillator.damping, phase))


@inlined
def acceleration_range(oscillator):
    """Smallest and largest acceleration felt at rest, over all phases; with harmonics, bounds on them."""
    mean = FOUR_PI * oscillator.damping
    swing = TWO_PI * oscillator.eccentricity * math.hypot(TWO_PI, oscillator.damping)
    swing = add_swing(oscillator.harmonics, swing, oscillator.damping)
    return mean - swing, mean + swing


class _Forced(NamedTuple):
    damping: float
    eccentricity: float
    harmonics: tuple[NamedTuple, ...]


@kernel
def _acceleration_range(damping, eccentricity, harmonics):
    return acceleration_range(_Forced(damping, eccentricity, harmonics))


def range_at_rest(oscillator):
    """`acceleration_range` for Python, where each process would compile an inlined function for itself.

    Harmonics stay a tuple, however many there are: over an array other products are fused, and last digits change.
    """
    return _acceleration_range(oscillator.damping, oscillator.eccentricity, oscillator.harmonics)


@inlined
def fall_speed(oscillator):
    """Speed of a fall from +beta to -beta under the mean acceleration: the scale of speeds."""
    return math.sqrt(4.0 * FOUR_PI * oscillator.damping * oscillator.half_backlash)
