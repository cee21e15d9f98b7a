"""Arcs: the times between neighbouring zeros of the acceleration at rest a(t), on each of which it keeps its sign.

Below the bound of Eq. (8) a(t) is positive and there is none. Beyond it inertia torque exceeds drag torque in a part of
every period. In freeplay ``(y' e^(delta t))' = a e^(delta t)``, so y' e^(delta t) is monotone on an arc and a flight
turns there at most once: at a minimum where a > 0, at a maximum where a < 0. A gear that lies on a wall is pressed to
it until the arc ends.
"""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import wrap
from rattle_kernels.numerics.trigonometric_minimum import TrigonometricPolynomial, changes_of_sign, least_value

if TYPE_CHECKING:
    from rattle_kernels.model.oscillator import Oscillator

_TWO_PI = 2.0 * math.pi
_FOUR_PI = 4.0 * math.pi


class Arcs(NamedTuple):
    """All arcs of an oscillator.

    Parameters
    ----------
    begin : ndarray of float64, shape (n,)
        Phases in [0, 1), ascending, where a(t) changes its sign. Each arc ends where the next one begins.
    sign : ndarray of float64, shape (n,)
        Sign of a(t) on each, in turn +1.0 and -1.0.
    error, error_rate : ndarray of float64, shape (n,)
        e and e' where each begins.
    change : float
        Bound on ``|a'(t)|``.
    strongest : float
        Bound on ``|a(t)|``.
    """

    begin: np.ndarray
    sign: np.ndarray
    error: np.ndarray
    error_rate: np.ndarray
    change: float
    strongest: float


def rest_acceleration_over_phases(oscillator: "Oscillator") -> TrigonometricPolynomial:
    """Acceleration felt at rest in freeplay, Eq. (7), as a polynomial in the phase.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.

    Returns
    -------
    TrigonometricPolynomial
    """
    order, amplitude, phase = np.array(oscillator.all_harmonics).T
    rate = _TWO_PI * order
    response = amplitude * np.exp(1j * _TWO_PI * phase) * (-rate * rate + 1j * rate * oscillator.damping)
    return TrigonometricPolynomial(_FOUR_PI * oscillator.damping, order, response.real, -response.imag)


def _error_over_phases(oscillator: "Oscillator") -> TrigonometricPolynomial:
    order, amplitude, phase = np.array(oscillator.all_harmonics).T
    angle = _TWO_PI * phase
    return TrigonometricPolynomial(0.0, order, amplitude * np.cos(angle), -amplitude * np.sin(angle))


def largest_eccentricity_of_one(damping: float) -> float:
    """The bound of Eq. (8) of a forcing with one harmonic, epsilon_crit2."""
    return 2 * damping / math.hypot(2 * math.pi, damping)


@lru_cache(maxsize=256)
def arcs_of(oscillator: "Oscillator") -> Arcs | None:
    """Arcs of an oscillator, None where a(t) is positive at every phase (Eq. 8).

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.

    Returns
    -------
    Arcs or None
        One arc, positive, where a(t) has zeros but does not change its sign.
    """
    felt = rest_acceleration_over_phases(oscillator)
    if not oscillator.harmonics:
        if oscillator.eccentricity < largest_eccentricity_of_one(oscillator.damping):
            return None
    elif felt.size < 2.0 * felt.mean or least_value(felt)[0] > 0.0:
        return None
    begin = changes_of_sign(felt)
    if not begin.size:
        begin = np.array([least_value(felt)[1]])
    middle = begin + 0.5 * np.diff(begin, append=begin[0] + 1.0)
    sign = np.sign(felt.at(middle))
    error = _error_over_phases(oscillator)
    ends = begin, sign, error.at(begin), error.slope.at(begin)
    for each in ends:
        each.setflags(write=False)
    return Arcs(*ends, felt.slope.size, felt.size)


@inlined
def next_end(arcs, phase):
    """Number of the first end of an arc after a phase in [0, 1). Ends are numbered from that at ``begin[0]`` on."""
    m = 0
    while m < arcs.begin.size and arcs.begin[m] <= phase:
        m += 1
    return m


@inlined
def ends_passed(arcs, phase, duration):
    """Number of ends of arcs between a phase (any value) and some time later, or earlier: that is negative."""
    after = phase + duration
    before, later = math.floor(phase), math.floor(after)
    passed = next_end(arcs, after - later) - next_end(arcs, phase - before)
    return int(later - before) * arcs.begin.size + passed


@inlined
def time_of_end(arcs, m):
    """Time of an end, counted as the phase after which it came."""
    return arcs.begin[m % arcs.begin.size] + m // arcs.begin.size


@inlined
def sign_before(arcs, m):
    """Sign of a(t) on the arc that has the end of this number."""
    return arcs.sign[(m - 1) % arcs.begin.size]


@inlined
def is_pressed(arcs, wall, phase):
    """Whether a gear that lies on a wall (+1.0 or -1.0) at a phase in [0, 1) stays there."""
    return sign_before(arcs, next_end(arcs, phase)) == wall


@inlined
def time_to_end(arcs, phase):
    """Time from a phase in [0, 1) to the end of its arc."""
    return time_of_end(arcs, next_end(arcs, phase)) - phase


@inlined
def time_to_release(arcs, phase):
    """Time from a phase in [0, 1) until a pressed gear leaves, at the end of its arc; infinite if a keeps its sign."""
    return time_to_end(arcs, phase) if arcs.begin.size > 1 else math.inf


@inlined
def phase_of_release(arcs, phase):
    """Phase in [0, 1) of the end of the arc at a phase in [0, 1)."""
    return wrap(arcs.begin[next_end(arcs, phase) % arcs.begin.size])
