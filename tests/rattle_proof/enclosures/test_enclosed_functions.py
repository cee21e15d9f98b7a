"""Enclosures of sine, cosine and decays: they hold the exact values (Arb); their constants are derived here anew."""

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, ctx

from rattle_proof.enclosures import enclosed_functions as functions
from rattle_proof.enclosures.enclosed_functions import HIGHEST_PHI, TWO_PI, decay, first_phi, phi, phi_drop, wave
from rattle_proof.enclosures.interval import Interval, point

_POINTS = 3000
_UNIT = Fraction(1, 2**53)
# By how much the reduced part of a turn may be rounded.
_REDUCED = Fraction(1, 2**54)


def _holds(a, exact):
    return bool(exact >= a.low) and bool(exact <= a.high)


def _intervals(random, least, most):
    """Intervals of all widths, and a number in each that is one of its ends as often as not."""
    low = random.uniform(least, most, _POINTS)
    high = np.minimum(low + 10.0 ** random.uniform(-18.0, 0.0, _POINTS) * (most - least), most)
    inside = np.choose(random.integers(0, 4, _POINTS), [low, high, low, random.uniform(low, high)])
    return zip(low, high, inside, strict=True)


def test_waves():
    ctx.prec = 128
    for low, high, inside in _intervals(np.random.default_rng(1), -3.0, 3.0):
        held, angle = wave(Interval(low, high)), 2 * arb(inside)
        assert _holds(held.cosine, angle.cos_pi())
        assert _holds(held.sine, angle.sin_pi())


@pytest.mark.parametrize("most", [1e-6, 0.5, 1.0, 40.0])
def test_decays(most):
    ctx.prec = 128
    for low, high, inside in _intervals(np.random.default_rng(2), 0.0, most):
        x = arb(inside)
        assert _holds(decay(Interval(low, high)), (-x).exp())
        first = (1 - (-x).exp()) / x if inside else arb(1)
        assert _holds(first_phi(Interval(low, high)), first)
        assert _holds(phi_drop(Interval(low, high)), (first - (-x).exp()) / x if inside else arb(0.5))


@pytest.mark.parametrize("k", [1, 2, 5, HIGHEST_PHI])
def test_phis(k):
    ctx.prec = 512
    for low, high, inside in _intervals(np.random.default_rng(3), 0.0, 1.0):
        # phi_k = (e^-x less its Taylor polynomial of degree k - 1) / (-x)^k
        x = -arb(inside)
        left = x.exp() - sum(x**n / arb(math.factorial(n)) for n in range(k))
        assert _holds(phi(k, Interval(low, high)), left / x**k if inside else 1 / arb(math.factorial(k)))


def test_two_pi():
    ctx.prec = 128
    assert _holds(TWO_PI, 2 * arb.pi())


def _horner_error(coefficients, exact, z):
    """Bound on the error of Horner's rule up to |z|: each step rounds a product and a sum, each coefficient once."""
    total, error = abs(Fraction(coefficients[-1])), abs(Fraction(coefficients[-1]) - exact[-1])
    for rounded, true in zip(reversed(coefficients[:-1]), reversed(exact[:-1]), strict=True):
        product = total * z
        error = error * z + product * _UNIT
        total = product * (1 + _UNIT) + abs(Fraction(rounded))
        error += total * _UNIT + abs(Fraction(rounded) - true)
        total *= 1 + _UNIT
    return error


def _least_power_of_two_above(x):
    return Fraction(2) ** math.ceil(math.log2(x))


def _errors_of_waves():
    quarter = Fraction("0.7853981633974484")  # a little more than pi/4
    z = quarter**2
    sine = [Fraction((-1) ** n, math.factorial(2 * n + 1)) for n in range(9)]
    cosine = [Fraction((-1) ** n, math.factorial(2 * n)) for n in range(10)]
    # The angle: 2 pi as a double, and the product; then its square. Slopes are at most 1, and z/2 <= 1/3 of it.
    angle = (
        quarter * (_UNIT + abs(Fraction(functions._TURN) - Fraction("6.28318530717958647692528676655900577")) / 6) * 2
    )
    angle += _REDUCED * Fraction("6.2831853071795865")
    by_sine = _horner_error(functions._SINE, sine, z * (1 + 3 * _UNIT)) + quarter * 3 * _UNIT
    by_cosine = _horner_error(functions._COSINE, cosine, z * (1 + 3 * _UNIT))
    left_out = quarter**19 / math.factorial(19), quarter**20 / math.factorial(20)
    return angle + by_sine + left_out[0] + _UNIT, angle + by_cosine + left_out[1] + z * 3 * _UNIT


def _error_of_exponential():
    exact = [Fraction((-1) ** n, math.factorial(n)) for n in range(17)]
    return _horner_error(functions._EXPONENTIAL, exact, Fraction(1, 2)) + Fraction(1, 2) ** 17 / math.factorial(17)


def _errors_of_phis():
    """Of phi_k, in parts of phi_k(0) = 1/k!."""
    errors = []
    for k in range(HIGHEST_PHI + 1):
        exact = [Fraction((-1) ** n, math.factorial(n + k)) for n in range(len(functions._PHI[k]))]
        left_out = Fraction(1, math.factorial(len(exact) + k))
        errors.append((_horner_error(functions._PHI[k], exact, Fraction(1)) + left_out) * math.factorial(k))
    return errors


def test_the_error_allowed_to_polynomials_is_the_least_power_of_two_that_is_proven():
    """So half of it would not be proven."""
    worst = max(*_errors_of_waves(), _error_of_exponential(), *_errors_of_phis())
    assert Fraction(functions._ERROR) == _least_power_of_two_above(worst)


def test_an_angle_is_reduced_up_to_a_rounding():
    """Doubles next to multiples of an eighth are the ones for which the nearest quarter is in doubt."""
    tried = {0.0, 1e-300, *np.random.default_rng(4).uniform(-3.0, 3.0, _POINTS).tolist()}
    for eighth in range(-24, 25):
        for beside in (-math.inf, math.inf):
            near = eighth / 8.0
            for _ in range(3):
                tried.add(near)
                near = math.nextafter(near, beside)
    rounded = 0
    for turns in tried:
        quarter, rest = functions._reduced(turns)
        off = abs(Fraction(turns) - Fraction(quarter, 4) - Fraction(rest)) % 1
        off = min(off, 1 - off)
        assert off <= _REDUCED and abs(rest) <= 0.125 and abs(quarter) <= 2
        rounded += off > 0
    # Of all these, the doubles just below 1/2 and 1/8.
    assert rounded == 2


def test_an_interval_of_more_than_a_turn_knows_nothing():
    assert wave(Interval(0.0, 1.5)).cosine == (-1.0, 1.0)
    assert math.isnan(phi(1, point(1.5)).low)
