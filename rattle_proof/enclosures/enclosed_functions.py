"""Enclosures of the functions of which flights are made: sine and cosine of turns, and the decay of a speed.

At a number they are Taylor polynomials in doubles, whose errors are bounded in `docs/theory/proof.md`; over an interval
their slopes are. Nothing is asked of a library's sine.
"""

import math
from typing import NamedTuple

from rattle_kernels.numerics.jit import inlined_as_written
from rattle_proof.enclosures.interval import (
    Interval,
    add,
    around,
    divide,
    down,
    middle,
    point,
    scale,
    square,
    subtract,
    up,
)

TWO_PI = Interval(6.283185307179586, 6.283185307179588)
_TURN = 6.283185307179586
# Bound on the absolute error of the polynomials below: truncation, coefficients, Horner's rule and the reduced angle.
_ERROR = 2.0**-49
_SINE = tuple((-1.0) ** n / math.factorial(2 * n + 1) for n in range(9))
_COSINE = tuple((-1.0) ** n / math.factorial(2 * n) for n in range(10))
_EXPONENTIAL = tuple((-1.0) ** n / math.factorial(n) for n in range(17))
HIGHEST_PHI = 16
"""Highest order of `phi`."""
_PHI_TERMS = 18
_PHI = tuple(tuple((-1.0) ** n / math.factorial(n + k) for n in range(_PHI_TERMS)) for k in range(HIGHEST_PHI + 1))
_LONGEST_HALVINGS = 40


class Wave(NamedTuple):
    """Cosine and sine of an angle."""

    cosine: Interval
    sine: Interval


@inlined_as_written
def _reduced(turns):
    """The nearest quarter turn, -2 to 2, and what is left: at most an eighth, and rounded by at most 2^-54.

    Both differences are exact, but for the doubles just below 1/2 and 1/8: there the sum with 1/2 is rounded up to a
    whole number.
    """
    part = turns - math.floor(turns + 0.5)
    quarter = math.floor(4.0 * part + 0.5)
    return quarter, part - 0.25 * quarter


@inlined_as_written
def _waves_of_number(turns):
    """Cosine and sine of 2 pi `turns`, each up to `_ERROR`."""
    quarter, rest = _reduced(turns)
    x = _TURN * rest
    z = x * x
    sine, cosine = _SINE[8], _COSINE[9]
    for n in range(7, -1, -1):
        sine = sine * z + _SINE[n]
    for n in range(8, -1, -1):
        cosine = cosine * z + _COSINE[n]
    sine *= x
    if quarter == 0.0:
        return cosine, sine
    if quarter == 1.0:
        return -sine, cosine
    if quarter == -1.0:
        return sine, -cosine
    return -cosine, -sine


@inlined_as_written
def _nearby(value, slope, angle):
    """Values of a cosine or sine within `angle` of where it and its slope are these.

    Where an end is not cut off at -1 or 1, spread and pull are together below 3. So the three sums are rounded by less
    than 2^-50, and the `_ERROR` that the spread has for itself is more.
    """
    bend = up(0.5 * up(angle * angle))
    spread = up(up(abs(slope) + _ERROR) * angle) + _ERROR
    # cos d is between 1 - d^2/2 and 1: it pulls the value towards 0.
    pull = up(up(abs(value) + _ERROR) * bend)
    low = value - spread - (pull if value > -_ERROR else 0.0)
    high = value + spread + (pull if value < _ERROR else 0.0)
    return Interval(max(down(low - _ERROR), -1.0), min(up(high + _ERROR), 1.0))


@inlined_as_written
def wave(turns):
    """Cosine and sine of 2 pi times all numbers of an interval."""
    centre = middle(turns)
    angle = up(TWO_PI.high * up(max(turns.high - centre, centre - turns.low)))
    if not angle < 4.0:
        return Wave(Interval(-1.0, 1.0), Interval(-1.0, 1.0))
    cosine, sine = _waves_of_number(centre)
    return Wave(_nearby(cosine, sine, angle), _nearby(sine, cosine, angle))


@inlined_as_written
def _decay_of_number(x):
    """Enclosure of e^-x for a number x >= 0: a polynomial up to 1/2, squared as often as x was halved."""
    halvings = 0
    rest = x
    while rest > 0.5 and halvings < _LONGEST_HALVINGS:
        rest *= 0.5
        halvings += 1
    if not 0.0 <= rest <= 0.5:
        return Interval(0.0, 1.0)
    total = _EXPONENTIAL[16]
    for n in range(15, -1, -1):
        total = total * rest + _EXPONENTIAL[n]
    decay = around(total, _ERROR)
    for _ in range(halvings):
        decay = square(decay)
    return decay


@inlined_as_written
def decay(x):
    """e^-x over an interval of numbers that are not negative."""
    return Interval(_decay_of_number(x.high).low, min(_decay_of_number(x.low).high, 1.0))


@inlined_as_written
def _phi_of_number(k, x):
    """phi_k(x), 0 <= x <= 1, up to `_ERROR` of phi_k(0) = 1/k!."""
    total = _PHI[k][_PHI_TERMS - 1]
    for n in range(_PHI_TERMS - 2, -1, -1):
        total = total * x + _PHI[k][n]
    return total, _PHI[k][0] * _ERROR


@inlined_as_written
def phi(k, x):
    """phi_k(x) = sum (-x)^n/(n + k)! over an interval within [0, 1]; it falls with x."""
    if not (x.low >= 0.0 and x.high <= 1.0):
        return Interval(math.nan, math.nan)
    least, error = _phi_of_number(k, x.high)
    most, _ = _phi_of_number(k, x.low)
    return Interval(down(least - error), up(most + error))


@inlined_as_written
def first_phi(x):
    """phi_1(x) = (1 - e^-x)/x over an interval of numbers that are not negative."""
    if x.high <= 1.0:
        return phi(1, x)
    least = _first_phi_beyond(x.high)
    most = _first_phi_beyond(x.low) if x.low > 1.0 else phi(1, point(max(x.low, 0.0)))
    return Interval(max(least.low, 0.0), most.high)


@inlined_as_written
def phi_drop(x):
    """-phi_1'(x) = (phi_1 - e^-x)/x over an interval of numbers that are not negative.

    It is the integral of u e^-xu over 0 <= u <= 1, so it falls with x.
    """
    return Interval(max(_drop_at(x.high).low, 0.0), min(_drop_at(max(x.low, 0.0)).high, 0.5))


@inlined_as_written
def _drop_at(x):
    if x <= 1.0:
        return subtract(phi(1, point(x)), phi(2, point(x)))
    return divide(subtract(_first_phi_beyond(x), _decay_of_number(x)), point(x))


@inlined_as_written
def _first_phi_beyond(x):
    fallen = add(point(1.0), scale(_decay_of_number(x), -1.0))
    return Interval(down(fallen.low / x), up(fallen.high / x))
