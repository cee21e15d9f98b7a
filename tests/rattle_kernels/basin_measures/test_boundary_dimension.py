"""The dimension of a boundary from random pairs, against boundaries of known dimension."""

import math

import numpy as np
import pytest

from rattle_kernels import Oscillator, boundary_dimension, find_attractors
from rattle_kernels.basin_measures.boundary_dimension import exponent_of_labels

SQUARE = (0.0, 1.0), (0.0, 1.0)
CANTOR = 1.0 - math.log(2.0) / math.log(3.0)
SEEDS = 300


def below_a_line(t, v):
    """Two sides of a smooth curve."""
    return (v < 0.5 + 0.618 * (t - 0.5)).astype(int)


def gap_of_a_cantor_set(t, v):
    """Number of the gap of the middle thirds that a time lies in; the set fills [1/3, 2/3], with gaps beyond its ends.

    Within r beyond the left of the set lie V(r) of length, and V(r/3) = 2 V(r)/3 exactly while r is below the middle
    gap. So at distances of powers of 1/3 the shares are a power law without any correction.
    """
    x = 3.0 * t - 1.0
    inside = (x >= 0.0) & (x <= 1.0)
    gap = np.where(inside, 2, np.where(x > 1.0, 1, 0))
    for _ in range(30):  # digits in base 3 until the first 1
        x = np.where(inside, 3.0 * x, x)
        digit = np.minimum(np.floor(x), 2.0)
        x = np.where(inside, x - digit, x)
        gap = np.where(inside, 2 * gap + (digit > 0.0), gap)
        inside &= digit != 1.0
    return gap


def fine_stripes(t, v):
    """Stripes that thin out by halves towards t = 0: f ~ e ln(1/e), which is no power law."""
    return np.where(t > 0.0, -np.floor(np.log2(np.maximum(np.abs(t), 1e-300))), 0).astype(int)


@pytest.mark.parametrize(
    ("label", "exponent", "distances"),
    [
        (below_a_line, 1.0, 10.0 ** -np.arange(1.5, 3.6, 0.5)),
        pytest.param(gap_of_a_cantor_set, CANTOR, 3.0 ** -np.arange(3, 9), marks=pytest.mark.slow),
    ],
    ids=["line", "Cantor"],
)
def test_the_error_covers_the_truth_and_the_fit_is_as_good_as_it_says(label, exponent, distances):
    found = [exponent_of_labels(label, *SQUARE, distances, 4000, seed) for seed in range(SEEDS)]
    off = np.array([(each.exponent - exponent) / each.error for each in found])
    # Shares of so many seeds scatter by sqrt(p (1 - p)/n); four of these.
    for covered, share in ((np.abs(off) < 1.0, 0.6827), (np.abs(off) < 2.0, 0.9545)):
        assert covered.mean() == pytest.approx(share, abs=4.0 * math.sqrt(share * (1.0 - share) / SEEDS))
    assert abs(off.mean()) < 4.0 / math.sqrt(SEEDS)
    good = np.array([each.goodness_of_fit for each in found])
    assert (good < 0.5).mean() == pytest.approx(0.5, abs=4.0 * 0.5 / math.sqrt(SEEDS))


def test_stripes_that_thin_out_are_told_from_a_power_law():
    distances, pairs = 10.0 ** -np.arange(1.0, 4.6), [20_000, 40_000, 80_000, 160_000]
    stripes = exponent_of_labels(fine_stripes, *SQUARE, distances, pairs, 0)
    assert stripes.goodness_of_fit < 1e-3


def test_the_likelihood_is_greatest_and_its_curvature_is_the_error():
    """Three numbers for which the summit has a closed form: shares 0.1, 0.01, 0.001 are exactly e."""
    found = exponent_of_labels(
        lambda t, v: every_so_often(t.size // 2), *SQUARE, (0.1, 0.01, 0.001), [1000, 10_000, 100_000], 0
    )
    np.testing.assert_array_equal(found.uncertain, [100, 100, 100])
    assert found.exponent == pytest.approx(1.0, abs=1e-9) and found.chi_square == pytest.approx(0.0, abs=1e-9)
    assert found.goodness_of_fit == pytest.approx(1.0, abs=1e-4)
    # The variance of ln f is (1 - f)/(f n); the slope of weighted least squares has this error.
    weight, log = 100.0 / (1.0 - found.distance), np.log(found.distance)
    spread = (weight * (log - np.average(log, weights=weight)) ** 2).sum()
    assert found.error == pytest.approx(1.0 / math.sqrt(spread), rel=1e-9)
    np.testing.assert_allclose(found.share_error, np.sqrt(found.distance * (1.0 - found.distance) / found.pairs))


def every_so_often(pairs):
    """Labels of the two ends of pairs, of which 100 differ."""
    first, second = np.zeros(pairs, int), np.zeros(pairs, int)
    second[:100] = 1
    return np.concatenate([first, second])


@pytest.mark.parametrize(("degrees", "chi_square"), [(1, 3.841459), (2, 5.991465), (3, 7.814728), (4, 9.487729)])
def test_the_goodness_of_fit_is_that_of_tables(degrees, chi_square):
    found = exponent_of_labels(below_a_line, *SQUARE, (0.1, 0.01, 0.001), 10_000, 0)
    told = found._replace(chi_square=chi_square, degrees_of_freedom=degrees)
    assert told.goodness_of_fit == pytest.approx(0.05, abs=1e-7)


def test_ends_that_are_not_known_are_left_out_and_counted():
    found = exponent_of_labels(
        lambda t, v: np.where(v < 0.25, -1, below_a_line(t, v)), *SQUARE, (0.1, 0.03, 0.01), 10_000, 0
    )
    np.testing.assert_array_equal(found.pairs + found.undecided, 10_000)
    assert (found.undecided > 2000).all() and found.exponent == pytest.approx(1.0, abs=5.0 * found.error)


def test_without_a_boundary_there_is_no_exponent():
    found = exponent_of_labels(lambda t, v: np.zeros(t.size, int), *SQUARE, (0.1, 0.01, 0.001), 100, 0)
    assert np.isnan([found.exponent, found.error, found.dimension, found.goodness_of_fit]).all()


def test_where_every_pair_ends_differently_there_is_no_power_law():
    with pytest.raises(ValueError, match="all pairs end differently"):
        exponent_of_labels(lambda t, v: np.arange(t.size), *SQUARE, (0.1, 0.01, 0.001), 100, 0)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"distances": (0.1, 0.01)}, "distances must be three or more"),
        ({"distances": (0.1, 0.01, 0.01)}, "distances must be three or more"),
        ({"distances": (0.1, 0.01, 0.0)}, "distances must be three or more"),
        ({"distances": (0.1, 0.01, np.nan)}, "distances must be three or more"),
        ({"time": (0.5, 0.5)}, "time must go"),
        ({"time": (0.0, 1.5)}, "time must go"),
        ({"velocity": (-1.0, 7.0)}, "velocity must go"),
        ({"velocity": (0.0, np.inf)}, "velocity must go"),
        ({"pairs": 0}, "pairs must be"),
        ({"pairs": (10, 20)}, "pairs must be"),
        ({"pairs": 10.5}, "pairs must be"),
    ],
)
def test_what_is_not_valid_is_refused_before_anything_is_followed(arguments, told):
    with pytest.raises(ValueError, match=told):
        boundary_dimension(Oscillator(), **arguments)


@pytest.mark.slow
def test_of_the_papers_panel_it_is_above_what_a_picture_shows():
    """A grid of 200, 400, 800 cells gives alpha 0.62, 0.71, 0.76. Pairs of smaller distances give more."""
    rng = np.random.default_rng(7)
    attractors = find_attractors(Oscillator(), rng.random(1000), 7.0 - 7.0 * rng.random(1000))
    found = boundary_dimension(Oscillator(), attractors=attractors, pairs=100_000, seed=1)
    assert found.exponent - 0.76 > 2.0 * found.error and found.error < 0.05
    again = boundary_dimension(Oscillator(), attractors=attractors, pairs=100_000, seed=1)
    np.testing.assert_array_equal(found.uncertain, again.uncertain)
