"""The yardstick: P as Sec. 2 of the paper describes it, in plain scalar code.

Newton's method on Eqs. (18), (24), (30) (with the errata) from the paper's guesses, the grazing curve interpolated
linearly from a table that is made beforehand, `math.sin`, `math.cos`, `math.exp` as they come. Compiled like everything
else, so that what is compared is the method.
"""

import math

import numba
import numpy as np

_STEPS = 50
_TOLERANCE = 1e-13


@numba.njit(nogil=True)
def solve_flight(lead, delta, eps, t0, offset, guess):
    """End of a flight: Newton on lead (e^(-delta tau) - 1)/delta + eps (cos 2 pi t - c0) + 4 pi tau + offset = 0."""
    t = guess
    cosine = math.cos(2.0 * math.pi * t0)
    for _ in range(_STEPS):
        decay = math.exp(-delta * (t - t0))
        f = lead * (decay - 1.0) / delta + eps * (math.cos(2.0 * math.pi * t) - cosine) + 4.0 * math.pi * (t - t0)
        slope = -lead * decay - 2.0 * math.pi * eps * math.sin(2.0 * math.pi * t) + 4.0 * math.pi
        step = (f + offset) / slope
        t -= step
        if abs(step) < _TOLERANCE:
            break
    return t


@numba.njit(nogil=True)
def speed_of_flight(lead, delta, eps, t0, t):
    """Signed velocity at time t of a flight."""
    return -lead * math.exp(-delta * (t - t0)) - 2.0 * math.pi * eps * math.sin(2.0 * math.pi * t) + 4.0 * math.pi


@numba.njit(nogil=True)
def interpolate(grazing, t0):
    """Grazing curve at a phase, linearly between the entries of its table."""
    place = t0 * (grazing.size - 1)
    i = int(place)
    return grazing[i] + (place - i) * (grazing[i + 1] - grazing[i])


@numba.njit(nogil=True)
def _impact(delta, eps, beta, grazing, t0, v0):
    lead = 4.0 * math.pi + v0 - 2.0 * math.pi * eps * math.sin(2.0 * math.pi * t0)
    if v0 < interpolate(grazing, t0):
        acceleration = 4.0 * math.pi * delta - 4.0 * math.pi**2 * eps * math.cos(2.0 * math.pi * t0)
        t1 = solve_flight(lead, delta, eps, t0, 0.0, t0 + 2.5 * v0 / acceleration)
        return t1, speed_of_flight(lead, delta, eps, t0, t1)
    t_hat = solve_flight(lead, delta, eps, t0, 2.0 * beta, t0 + 2.0 * beta / v0)
    u = -speed_of_flight(lead, delta, eps, t0, t_hat)
    lead = 4.0 * math.pi - u - 2.0 * math.pi * eps * math.sin(2.0 * math.pi * t_hat)
    t1 = solve_flight(lead, delta, eps, t_hat, -2.0 * beta, 2.0 * t_hat - t0)
    return t1, speed_of_flight(lead, delta, eps, t_hat, t1)


@numba.njit(nogil=True)
def apply_plainly(delta, eps, beta, grazing, t, v, applications):
    """Apply P to every point in place."""
    for i in range(t.size):
        for _ in range(applications):
            t1, v1 = _impact(delta, eps, beta, grazing, t[i], v[i])
            t[i], v[i] = t1 - math.floor(t1), abs(v1)


def plain_grazing_table(grazing_velocity, oscillator):
    """Grazing curve on 4096 intervals."""
    return grazing_velocity(oscillator, np.linspace(0.0, 1.0, 4097))
