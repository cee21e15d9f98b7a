"""The impacting map in whole numbers: the kernels say which wall a flight meets, Newton's method where, here.

Every quantity is a whole multiple of 2^-128 and every function a series of such: no processor, no mathematical library
and no width of a type changes a bit of the result. The flight is taken in its plainest form, ``4 pi tau + eps (cos -
cos0) + B (e^{-delta tau} - 1)``, of which the kernels' own shares nothing. It cancels where bounces are low: some eight
of 38 digits, which is why it takes more than the 19 of a long double.

Of the kernels it takes the wall and a first guess of the duration, no digit of which is left: Newton's steps square its
error twice.
"""

import itertools
from fractions import Fraction

from rattle_kernels.impact_map.apply import LOWER, UPPER, next_contact

_BITS = 128
_ONE = 1 << _BITS
_NEWTON_STEPS = 2


def _times(a, b):
    return a * b >> _BITS


def _over(a, b):
    return (a << _BITS) // b


def _inverse_tangent(n):
    """arctan(1/n), with a word to spare for what the divisions lose."""
    power, total, odd = (_ONE << 32) // n, 0, 1
    while power:
        total += power // odd if odd % 4 == 1 else -(power // odd)
        power //= n * n
        odd += 2
    return total


_TWO_PI = 8 * (4 * _inverse_tangent(5) - _inverse_tangent(239)) >> 32  # Machin's formula


def _cosine_and_sine(turns):
    """Of 2 pi times `turns`: series about the nearest quarter turn."""
    quarters = (4 * turns + _ONE // 2) >> _BITS
    angle = _times(_TWO_PI, turns - (quarters << _BITS) // 4)
    minus_square = -_times(angle, angle)
    cosine, sine, even, odd, n = 0, 0, _ONE, angle, 0
    while abs(even) > 1:
        cosine, sine, n = cosine + even, sine + odd, n + 2
        even = _times(even, minus_square) // (n * (n - 1))
        odd = _times(odd, minus_square) // (n * (n + 1))
    for _ in range(quarters % 4):
        cosine, sine = -sine, cosine
    return cosine, sine


def _exponential_less_one(x):
    total, term, n = 0, x, 1
    while abs(term) > 1:
        total, n = total + term, n + 1
        term = _times(term, x) // n
    return total


def _land(damping, eccentricity, phase, velocity, target, guess):
    """End of a flight from a wall: duration and velocity."""
    cosine, sine = _cosine_and_sine(phase)
    swing = _times(_TWO_PI, eccentricity)
    drag = _over(2 * _TWO_PI - _times(swing, sine) - velocity, damping)
    tau = guess
    for step in range(_NEWTON_STEPS + 1):
        cosine_then, sine_then = _cosine_and_sine(phase + tau)
        lost = _exponential_less_one(-_times(damping, tau))
        rate = 2 * _TWO_PI - _times(swing, sine_then) - _times(damping, _times(drag, lost + _ONE))
        if step == _NEWTON_STEPS:
            return tau, rate
        forced = _times(eccentricity, cosine_then - cosine)
        tau -= _over(2 * _times(_TWO_PI, tau) + forced + _times(drag, lost) - target, rate)


def departures(oscillator, t, v):
    """Departures that follow one upon another from +beta: phase, speed and the forcing periods since the start."""
    phase, speed, damping, eccentricity, two_beta = (
        int(Fraction(value) * _ONE)
        for value in (t, v, oscillator.damping, oscillator.eccentricity, 2 * oscillator.half_backlash)
    )
    elapsed = 0
    while True:
        wall, velocity = UPPER, -speed
        while True:
            contact = next_contact(oscillator, wall, phase / _ONE, velocity / _ONE, 1.0)
            target = 0 if contact.wall == wall else (two_beta if wall == LOWER else -two_beta)
            guess = int(contact.duration * _ONE)
            tau, arrival = _land(damping, eccentricity, phase, velocity, target, guess)
            phase, elapsed, velocity, wall = (phase + tau) % _ONE, elapsed + tau, -arrival, contact.wall
            if wall == UPPER:
                break
        speed = -velocity
        yield tuple(Fraction(value, _ONE) for value in (phase, speed, elapsed))


def run_extended(oscillator, t, v, impacts):
    """Departure after so many impacts, and the forcing periods that passed."""
    return next(itertools.islice(departures(oscillator, t, v), impacts - 1, None))
