"""The uncertainty exponent against boundaries of known dimension."""

import numpy as np
import pytest

from rattle_kernels import uncertainty_exponent
from tests.rattle_kernels.basin_measures.basin_pictures import cantor, disc, half_plane, noise

CANTOR = 1.0 - np.log(2.0) / np.log(3.0)


def test_an_upright_boundary_has_exponent_one_exactly():
    found = uncertainty_exponent(np.tile(np.arange(100) >= 50, (80, 1)).astype(int))
    assert found.exponent == pytest.approx(1.0, abs=1e-12) and found.error < 1e-12
    np.testing.assert_allclose(found.uncertain_share, 2 * found.distance / 68)
    assert found.boundary_dimension == pytest.approx(1.0)


@pytest.mark.parametrize("solution", [half_plane(400, 0.618), disc(400, 0.3)], ids=["line", "circle"])
def test_a_smooth_boundary_has_exponent_one(solution):
    found = uncertainty_exponent(solution)
    assert found.exponent == pytest.approx(1.0, abs=0.02) and found.error < 0.02


def stripes_of_gaps(levels, margin):
    """Every gap of the middle thirds a motion of its own, what is left another, and room on either side."""
    row = cantor(levels)
    changes = np.concatenate([[0], np.cumsum(np.diff(row) != 0)])
    gaps = np.where(row == levels, 0, 2 + changes)
    room = 2 * margin + 1
    return np.tile(np.pad(gaps, room, constant_values=1), (2 * margin + 2, 1))


def test_stripes_of_a_cantor_set_have_its_exponent_exactly():
    # Within 3^j of the set's level n lie 2.5 3^j 2^(n - j) cells: counting them is an exercise in gaps.
    found = uncertainty_exponent(stripes_of_gaps(7, 81), [1, 3, 9, 27, 81])
    assert found.exponent == pytest.approx(CANTOR, abs=1e-12) and found.error < 1e-12


def test_stripes_of_a_cantor_set_in_two_motions_have_its_exponent():
    row = cantor(7)
    solution = np.tile(np.pad(row % 2, 100, constant_values=0), (130, 1))
    found = uncertainty_exponent(solution, [1, 3, 9, 27])
    assert found.exponent == pytest.approx(CANTOR, abs=0.02)
    assert found.boundary_dimension == pytest.approx(2.0 - found.exponent)


def test_noise_stays_uncertain_however_close():
    found = uncertainty_exponent(noise((300, 300), 3))
    assert abs(found.exponent) < 0.01
    # All four neighbours agree with a cell one time in 3^4.
    np.testing.assert_allclose(found.uncertain_share, 1 - 3.0**-4, atol=2e-3)


def test_a_boundary_on_the_seam_is_seen_where_time_wraps():
    solution = np.tile(np.arange(100) >= 50, (80, 1)).astype(int)
    across = uncertainty_exponent(np.roll(solution, 50, axis=1), wraps=True)
    # Boundaries in the middle and on the seam, in every column.
    np.testing.assert_allclose(across.uncertain_share, 4 * across.distance / 100)
    assert across.exponent == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("shift", [0, 13, 50])
def test_where_time_wraps_the_beginning_of_the_period_does_not_matter(shift):
    solution = noise((60, 100), 2, seed=1)
    found = uncertainty_exponent(np.roll(solution, shift, axis=1), [1, 2, 5], wraps=True)
    np.testing.assert_array_equal(
        found.uncertain_share, uncertainty_exponent(solution, [1, 2, 5], wraps=True).uncertain_share
    )


def test_without_a_boundary_there_is_no_exponent():
    found = uncertainty_exponent(np.zeros((50, 50), int))
    assert np.isnan(found.exponent) and np.isnan(found.error) and not found.uncertain_share.any()


@pytest.mark.parametrize("distances", [[1, 2], [1, 2, 2], [0, 1, 2], [1, 2, 30]])
def test_distances_that_do_not_fit_are_refused(distances):
    with pytest.raises(ValueError, match="distances must be three or more between 1 and 24"):
        uncertainty_exponent(np.zeros((50, 60), int), distances)
