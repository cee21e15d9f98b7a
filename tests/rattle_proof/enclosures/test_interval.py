"""Interval operations hold every exact result, in fractions, which round nothing."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rattle_proof.enclosures.interval import (
    Interval,
    add,
    around,
    divide,
    down,
    hull,
    lies_within,
    middle,
    multiply,
    negative,
    point,
    reach,
    root,
    scale,
    square,
    subtract,
    up,
    width,
)

# Neither overflows when multiplied or divided; tiny numbers and 0 are among them.
numbers = st.floats(-1e150, 1e150) | st.floats(-4.0, 4.0) | st.sampled_from([0.0, -0.0, 5e-324, -5e-324, 1.0, -1.0])


@st.composite
def intervals(draw):
    return Interval(*sorted((draw(numbers), draw(numbers))))


def _points(a):
    inside = 0.5 * (a.low / 2.0 + a.high / 2.0) * 2.0
    return [Fraction(a.low), Fraction(a.high), Fraction(min(max(inside, a.low), a.high))]


def _holds(a, exact):
    return a.low <= exact <= a.high


@settings(max_examples=400)
@given(intervals(), intervals())
def test_sums_differences_products_and_quotients(a, b):
    for x in _points(a):
        for y in _points(b):
            assert _holds(add(a, b), x + y)
            assert _holds(subtract(a, b), x - y)
            assert _holds(multiply(a, b), x * y)
            assert _holds(hull(a, b), x) and _holds(hull(a, b), y)
            if not b.low <= 0.0 <= b.high and min(abs(b.low), abs(b.high)) > 1e-150:
                assert _holds(divide(a, b), x / y)


@settings(max_examples=400)
@given(intervals(), numbers)
def test_functions_of_one_interval(a, factor):
    rooted, inside = root(a), middle(a)
    for x in _points(a):
        assert _holds(square(a), x * x)
        assert _holds(negative(a), -x)
        assert _holds(scale(a, factor), x * Fraction(factor))
        assert abs(x) <= reach(a)
        if x >= 0:
            assert Fraction(rooted.low) ** 2 <= x <= Fraction(rooted.high) ** 2
    assert square(a).low >= 0.0 and rooted.low >= 0.0
    assert a.low <= inside <= a.high
    assert Fraction(width(a)) >= Fraction(a.high) - Fraction(a.low)


@pytest.mark.parametrize("operation", [add, subtract, multiply, divide])
def test_rounding_is_accounted_for(operation):
    """Of numbers with 53 digits hardly any result is a double: an end that is not moved outwards lies inside of it."""
    random = np.random.default_rng(1)
    exact = {
        add: Fraction.__add__,
        subtract: Fraction.__sub__,
        multiply: Fraction.__mul__,
        divide: Fraction.__truediv__,
    }
    for x, y in random.uniform(0.5, 4.0, (2000, 2)) * random.choice([-1.0, 1.0], (2000, 2)):
        result, true = operation(point(x), point(y)), exact[operation](Fraction(x), Fraction(y))
        assert result.low < true < result.high


@settings(max_examples=400)
@given(numbers)
def test_moves_outwards_pass_the_neighbouring_double(x):
    """So that the exact result, at most half an ulp away, is passed too."""
    assert down(x) <= math.nextafter(x, -math.inf)
    assert up(x) >= math.nextafter(x, math.inf)


@given(numbers, st.floats(0.0, 1e100))
def test_around_holds_both_ends(x, radius):
    assert _holds(around(x, radius), Fraction(x) - Fraction(radius))
    assert _holds(around(x, radius), Fraction(x) + Fraction(radius))


def test_what_is_no_number_proves_nothing():
    nothing, some = point(math.nan), Interval(-1.0, 1.0)
    assert not lies_within(nothing, some) and not lies_within(some, nothing)
    assert not lies_within(add(nothing, some), some)
    assert math.isnan(divide(some, some).low)
    assert math.isnan(divide(point(1.0), Interval(0.0, 1.0)).high)


def test_an_interval_lies_within_another_strictly():
    assert lies_within(Interval(0.0, 1.0), Interval(-1.0, 2.0))
    assert not lies_within(Interval(-1.0, 1.0), Interval(-1.0, 2.0))
    assert not lies_within(Interval(0.0, 2.0), Interval(-1.0, 2.0))
