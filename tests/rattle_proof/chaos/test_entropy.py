"""Growth of the number of words from what crosses what: of maps whose entropy is known."""

import math

import numpy as np
import pytest

from rattle_proof.chaos.crossings import Crossings
from rattle_proof.chaos.entropy import growth_of, holds


def crossings(*strips):
    """By strips, for each number of impacts (first, last)."""
    both = np.array(strips)
    return Crossings(both[..., 0], both[..., 1])


_GOLDEN = 0.5 * (1.0 + math.sqrt(5.0))


@pytest.mark.parametrize(
    ("strips", "factor"),
    [
        ([[(0, 2)], [(0, 2)]], 2.0),
        ([[(0, 1)], [(0, 2)]], 1.0),
        ([[(0, 2)], [(0, 1)]], _GOLDEN),
        ([[(0, 3)], [(0, 3)], [(0, 0)]], 2.0),
        # Both strips after two impacts.
        ([[(0, 0), (0, 2)], [(0, 0), (0, 2)]], math.sqrt(2.0)),
        # One strip after one impact, the other after two: 1 = 1/x + 1/x^2.
        ([[(0, 2), (0, 0)], [(0, 0), (0, 2)]], _GOLDEN),
        # More after two impacts, and still the better choice is one.
        ([[(0, 2), (0, 3)], [(0, 2), (0, 3)], [(0, 0), (0, 0)]], 2.0),
    ],
)
def test_growth_is_that_of_the_shift(strips, factor):
    growth = growth_of(crossings(*strips))
    if factor == 1.0:
        assert growth is None
        return
    assert 0.0 <= math.log(factor) - growth.entropy < 1e-5
    assert holds(crossings(*strips), growth)


def test_nothing_crossed_shows_nothing():
    assert growth_of(crossings([(0, 0)], [(0, 0)])) is None
    assert growth_of(crossings([(0, 1)], [(1, 2)])) is None, "two strips that each cross themselves alone"


def test_a_growth_that_is_too_large_or_shown_by_nothing_does_not_hold():
    golden = crossings([(0, 2)], [(0, 1)])
    growth = growth_of(golden)
    assert not holds(golden, growth._replace(numerator=growth.numerator + 20))
    assert not holds(golden, growth._replace(weights=np.zeros(2, np.int64)))
    assert not holds(golden, growth._replace(weights=-growth.weights))
    assert not holds(golden, growth._replace(weights=growth.weights[::-1]))
    assert not holds(crossings([(0, 1)], [(0, 1)]), growth), "the first crosses itself alone"
    twice = crossings([(0, 0), (0, 2)], [(0, 0), (0, 2)])
    growth = growth_of(twice)
    assert not holds(twice, growth._replace(numerator=growth.numerator + 20)), "after two impacts"
