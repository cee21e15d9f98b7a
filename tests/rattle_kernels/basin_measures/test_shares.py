"""Shares of motions among given departures, and that their errors cover the truth."""

import math

import numpy as np
import pytest

from rattle_kernels import AttractorKind, Oscillator, find_attractors, name_solutions, shares_of
from rattle_kernels.basin_measures.shares import weighted_shares


def test_equal_weights_give_the_binomial_error():
    share, error, size = weighted_shares(np.array([0] * 30 + [1] * 70), np.full(100, 5.0), 2)
    np.testing.assert_allclose(share, [0.3, 0.7])
    np.testing.assert_allclose(error, math.sqrt(0.3 * 0.7 / 100))
    assert size == pytest.approx(100.0)


def test_where_all_departures_agree_the_error_is_laplaces():
    share, error, _ = weighted_shares(np.zeros(8, int), np.ones(8), 3)
    np.testing.assert_array_equal(share, [1.0, 0.0, 0.0])
    # Beta(9, 1) and Beta(1, 9).
    np.testing.assert_allclose(error, math.sqrt(9.0 / (100.0 * 11.0)))


def test_the_error_covers_the_truth_where_weights_and_motions_go_together():
    """Uniform x of weight 2 x stands for the density 2 x, of which 0.09 lies below 0.3 and 0.51 above 0.7."""
    truth, seeds, off = np.array([0.09, 0.40, 0.51]), 400, []
    for seed in range(seeds):
        x = np.random.default_rng(seed).random(2000)
        share, error, size = weighted_shares(np.digitize(x, [0.3, 0.7]), 2.0 * x, 3)
        off.append((share - truth) / error)
        # (E w)^2/E w^2 = 3/4.
        assert size == pytest.approx(1500.0, rel=0.1)
    for covered, expected in ((np.abs(off) < 1.0, 0.6827), (np.abs(off) < 2.0, 0.9545)):
        spread = 4.0 * math.sqrt(expected * (1.0 - expected) / seeds)
        np.testing.assert_allclose(np.mean(covered, axis=0), expected, atol=spread)


def test_weights_stand_for_another_distribution_of_departures():
    """Uniform speeds of weight v agree with speeds drawn from the density that grows with v."""
    rng = np.random.default_rng(3)
    uniform = 6.0 * (1.0 - rng.random(20_000))
    weighted = shares_of(Oscillator(), rng.random(20_000), uniform, uniform)
    drawn = shares_of(Oscillator(), rng.random(20_000), 6.0 * np.sqrt(1.0 - rng.random(20_000)))
    names = [[attractor.name for attractor in found.attractors] for found in (weighted, drawn)]
    assert names[0] == names[1]
    assert weighted.share.sum() == pytest.approx(1.0) and drawn.share.sum() == pytest.approx(1.0)
    assert (np.abs(weighted.share - drawn.share) < 4.0 * np.hypot(weighted.error, drawn.error)).all()
    assert weighted.effective_size == pytest.approx(15_000.0, rel=0.02)
    assert drawn.effective_size == pytest.approx(20_000.0)


def test_each_departure_is_named_and_what_the_catalogue_lacks_is_undecided():
    rng = np.random.default_rng(4)
    t, v = rng.random(500), 7.0 * (1.0 - rng.random(500))
    attractors = find_attractors(Oscillator(), t, v)
    found = shares_of(Oscillator(), t, v, attractors=attractors)
    np.testing.assert_array_equal(found.solution, name_solutions(Oscillator(), attractors, t, v))
    without = shares_of(Oscillator(), t, v, attractors=attractors[:1])
    assert [attractor.kind for attractor in without.attractors] == [
        AttractorKind.PERMANENT_CONTACT,
        AttractorKind.UNDECIDED,
    ]
    assert without.share[0] == pytest.approx(found.share[0])
    np.testing.assert_array_equal(without.solution > 0, found.solution > 0)


@pytest.mark.parametrize(
    ("t", "v", "weights", "told"),
    [
        ([0.1], [-1.0], None, r"v\[0\] must be"),
        ([0.1, 0.2], [1.0], None, "lists of the same length"),
        ([], [], None, "lists of the same length"),
        ([0.1, 0.2], [1.0, 1.0], [1.0], "one for each departure"),
        ([0.1, 0.2], [1.0, 1.0], [1.0, -1.0], "finite and not negative"),
        ([0.1, 0.2], [1.0, 1.0], [0.0, 0.0], "one at least above 0"),
    ],
)
def test_what_does_not_fit_is_refused(t, v, weights, told):
    with pytest.raises(ValueError, match=told):
        shares_of(Oscillator(), t, v, weights)
