"""The yardstick of the piecewise linear model: P as Sec. 3 of the paper lists it, in plain scalar code.

Flights as in `plain_newton`. Stays in contact by Eq. (33) with its errata: turning points from Eq. (40), the first
minimum beyond the wall within one gross rotation, the maximum before it, bisection until the slopes at both ends are
negative, then the secant method.
"""

import math

import numba

from benchmarks.plain_newton import interpolate, solve_flight, speed_of_flight

_STEPS = 60
_TOLERANCE = 1e-13


@numba.njit(nogil=True)
def _depth(stay, t):
    a, b, t0, delta, q, mean, p, shift = stay
    decay = math.exp(-0.5 * delta * (t - t0))
    ring_cos, ring_sin = math.cos(q * (t - t0)), math.sin(q * (t - t0))
    angle = 2.0 * math.pi * t + shift
    depth = decay * (a * ring_cos + b * ring_sin) + mean + p * math.cos(angle)
    ringing = decay * ((b * q - 0.5 * delta * a) * ring_cos - (a * q + 0.5 * delta * b) * ring_sin)
    return depth, ringing - 2.0 * math.pi * p * math.sin(angle)


@numba.njit(nogil=True)
def _enter(delta, eps, kappa, side, t0, u):
    """Constants of Eq. (33) for x(t0) = 0, x'(t0) = u beyond the wall of `side`."""
    q = math.sqrt(2.0 * kappa - 0.25 * delta * delta)
    root = math.sqrt((kappa - 2.0 * math.pi**2) ** 2 + (math.pi * delta) ** 2)
    p = -math.pi * eps * math.sqrt(4.0 * math.pi**2 + delta * delta) / root * side
    shift = math.atan2(-delta * kappa, 2.0 * math.pi * (kappa - 2.0 * math.pi**2) - math.pi * delta * delta)
    mean = 2.0 * math.pi * delta / kappa * side
    angle = 2.0 * math.pi * t0 + shift
    a = -mean - p * math.cos(angle)
    b = (u + 2.0 * math.pi * p * math.sin(angle) + 0.5 * delta * a) / q
    return a, b, t0, delta, q, mean, p, shift


@numba.njit(nogil=True)
def _leave(stay):
    """Time and slope of the first crossing within one gross rotation, NaN where there is none."""
    a, b, t0, _, q, _, _, _ = stay
    phase = math.atan2(-b, a)  # the ringing is cos(q (t - t0) + phase): minima where that is an odd multiple of pi
    m = math.ceil(phase / math.pi)
    m += 1 - m % 2
    while True:
        low = t0 + (m * math.pi - phase) / q
        if low > t0 + 1.0 + math.pi / q:
            return math.nan, math.nan
        if low > t0 and _depth(stay, low)[0] < 0.0:
            break
        m += 2
    high = max(low - math.pi / q, t0)
    while _depth(stay, high)[1] >= 0.0 or _depth(stay, low)[1] >= 0.0:
        middle = 0.5 * (high + low)
        if _depth(stay, middle)[0] > 0.0:
            high = middle
        else:
            low = middle
        if low - high < _TOLERANCE:
            break
    x_high, x_low = _depth(stay, high)[0], _depth(stay, low)[0]
    for _ in range(_STEPS):
        if x_low == x_high:
            break
        new = low - x_low * (low - high) / (x_low - x_high)
        high, x_high, low = low, x_low, new
        x_low = _depth(stay, low)[0]
        if abs(low - high) < _TOLERANCE:
            break
    return low, _depth(stay, low)[1]


@numba.njit(nogil=True)
def _departure(delta, eps, beta, kappa, grazing, t0, v0):
    lead = 4.0 * math.pi + v0 - 2.0 * math.pi * eps * math.sin(2.0 * math.pi * t0)
    if v0 < interpolate(grazing, t0):
        acceleration = 4.0 * math.pi * delta - 4.0 * math.pi**2 * eps * math.cos(2.0 * math.pi * t0)
        t1 = solve_flight(lead, delta, eps, t0, 0.0, t0 + 2.5 * v0 / acceleration)
        u = speed_of_flight(lead, delta, eps, t0, t1)
    else:
        t_hat = solve_flight(lead, delta, eps, t0, 2.0 * beta, t0 + 2.0 * beta / v0)
        u = -speed_of_flight(lead, delta, eps, t0, t_hat)
        t_exit, slope = _leave(_enter(delta, eps, kappa, -1.0, t_hat, u))
        lead = 4.0 * math.pi + slope - 2.0 * math.pi * eps * math.sin(2.0 * math.pi * t_exit)
        t1 = solve_flight(lead, delta, eps, t_exit, -2.0 * beta, t_exit + (t_hat - t0))
        u = speed_of_flight(lead, delta, eps, t_exit, t1)
    t_exit, slope = _leave(_enter(delta, eps, kappa, 1.0, t1, abs(u)))
    return t_exit, -slope


@numba.njit(nogil=True)
def apply_recipe(delta, eps, beta, kappa, grazing, t, v, applications):
    """Apply P to every point in place; how many applications there were before contact became permanent."""
    done = 0
    for i in range(t.size):
        for _ in range(applications):
            t1, v1 = _departure(delta, eps, beta, kappa, grazing, t[i], v[i])
            done += 1
            if not v1 > 0.0:
                t[i], v[i] = math.nan, math.nan
                break
            t[i], v[i] = t1 - math.floor(t1), v1
    return done
