"""Intervals that surely hold the exact result: each operation rounds to nearest and then moves outwards.

Numba has no directed rounding. An operation +, -, *, / or square root of IEEE doubles differs from the exact result by
at most ``u |x|``, u = 2^-53, or by 2^-1075 if it underflows (x is the rounded result). `down` and `up` move x by
``4 u |x| + 2^-1000``. That sum and the move are rounded, too: together by less than ``2 u |x| + 2^-1050``. So the exact
result lies beyond neither. `docs/theory/proof.md` has the derivation.

An interval with an end that is no number proves nothing: every test is written so that NaN fails it.
"""

import math
from typing import NamedTuple

from rattle_kernels.numerics.jit import inlined_as_written

_OUTWARDS = 2.0**-51
_LEAST = 2.0**-1000


class Interval(NamedTuple):
    """All numbers from ``low`` to ``high``."""

    low: float
    high: float


@inlined_as_written
def down(x):
    """A number below what was rounded to x."""
    return x - (abs(x) * _OUTWARDS + _LEAST)


@inlined_as_written
def up(x):
    """A number above what was rounded to x."""
    return x + (abs(x) * _OUTWARDS + _LEAST)


@inlined_as_written
def point(x):
    """The interval of one number."""
    return Interval(x, x)


@inlined_as_written
def around(x, radius):
    """All numbers at most `radius` from x."""
    return Interval(down(x - radius), up(x + radius))


@inlined_as_written
def middle(a):
    """A number near the middle of an interval, within it where it is finite."""
    return min(max(0.5 * (a.low + a.high), a.low), a.high)


@inlined_as_written
def width(a):
    """Distance of the ends, rounded up."""
    return up(a.high - a.low)


@inlined_as_written
def reach(a):
    """The largest absolute value."""
    return max(abs(a.low), abs(a.high))


@inlined_as_written
def hull(a, b):
    """The least interval that holds both."""
    return Interval(min(a.low, b.low), max(a.high, b.high))


@inlined_as_written
def lies_within(a, b):
    """Whether all of `a` lies strictly between the ends of `b`."""
    return b.low < a.low and a.low <= a.high and a.high < b.high


@inlined_as_written
def add(a, b):
    """A + b."""
    return Interval(down(a.low + b.low), up(a.high + b.high))


@inlined_as_written
def subtract(a, b):
    """A - b."""
    return Interval(down(a.low - b.high), up(a.high - b.low))


@inlined_as_written
def negative(a):
    """-a."""
    return Interval(-a.high, -a.low)


@inlined_as_written
def multiply(a, b):
    """A b.

    0 times infinity is NaN. Where that comes first the result is NaN; else another of the products is 0, and 0 is held.
    """
    first, second, third, fourth = a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high
    return Interval(down(min(first, second, third, fourth)), up(max(first, second, third, fourth)))


@inlined_as_written
def scale(a, factor):
    """A number times an interval."""
    first, second = factor * a.low, factor * a.high
    return Interval(down(min(first, second)), up(max(first, second)))


@inlined_as_written
def square(a):
    """A a, never negative."""
    first, second = a.low * a.low, a.high * a.high
    most = up(max(first, second))
    if a.low <= 0.0 and a.high >= 0.0:
        return Interval(0.0, most)
    return Interval(max(down(min(first, second)), 0.0), most)


@inlined_as_written
def divide(a, b):
    """A / b; not numbers where b holds 0."""
    if not (b.low > 0.0 or b.high < 0.0):
        return Interval(math.nan, math.nan)
    first, second, third, fourth = a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high
    return Interval(down(min(first, second, third, fourth)), up(max(first, second, third, fourth)))


@inlined_as_written
def root(a):
    """Square root of what is not negative in a."""
    return Interval(max(down(math.sqrt(max(a.low, 0.0))), 0.0), up(math.sqrt(max(a.high, 0.0))))
