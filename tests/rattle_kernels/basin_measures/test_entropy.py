"""Basin entropy against pictures whose entropy is known."""

import numpy as np
import pytest
from scipy.integrate import quad

from rattle_kernels import basin_entropy
from tests.rattle_kernels.basin_measures.basin_pictures import cantor, disc, half_plane, noise


def entropy_of(part):
    return -sum(p * np.log(p) for p in (part, 1.0 - part) if p > 0.0)


@pytest.mark.parametrize("column", [1, 3, 4])
def test_an_upright_boundary_cuts_every_box_it_meets_alike(column):
    solution = np.zeros((40, 60), np.int8)
    solution[:, 30 + column :] = 1
    found = basin_entropy(solution, 5)
    assert (found.boxes, found.boundary_boxes) == (96, 8)
    assert found.boundary_entropy == pytest.approx(entropy_of(column / 5))
    assert found.basin_entropy == pytest.approx(entropy_of(column / 5) / 12)
    assert not found.fractal


def test_an_upright_boundary_wherever_it_is_has_one_half_on_average():
    # The integral of -p ln p - (1 - p) ln(1 - p) over (0, 1).
    assert quad(entropy_of, 0.0, 1.0)[0] == pytest.approx(0.5)
    found = [basin_entropy(np.arange(200) >= np.full((200, 1), place), 100) for place in range(1, 100)]
    assert np.mean([entropy.boundary_entropy for entropy in found]) == pytest.approx(0.5, abs=5e-3)


def part_below(slope, offset):
    """Share of the unit square below v = offset + slope t, 0 < slope <= 1."""
    low, high = offset, offset + slope
    corner_low, corner_high = max(-low, 0.0) ** 2 / (2 * slope), max(high - 1.0, 0.0) ** 2 / (2 * slope)
    return 0.5 * (low + high) + corner_low - corner_high


def test_a_straight_boundary_has_the_entropy_of_a_line_at_random():
    # Offsets of an irrational slope are spread evenly over (-slope, 1).
    slope = (np.sqrt(5.0) - 1.0) / 2.0
    expected = quad(lambda offset: entropy_of(part_below(slope, offset)), -slope, 1.0)[0] / (1.0 + slope)
    found = basin_entropy(half_plane(4000, slope), 40)
    assert found.boundary_entropy == pytest.approx(expected, abs=0.01)
    assert expected == pytest.approx(0.3735, abs=1e-4) and not found.fractal


@pytest.mark.parametrize("motions", [2, 3, 7])
def test_noise_has_the_logarithm_of_its_motions_less_what_small_boxes_miss(motions):
    for box in (10, 100):
        found = basin_entropy(noise((500, 500), motions), box)
        missed = (motions - 1) / (2 * box**2)
        assert found.basin_entropy == pytest.approx(np.log(motions) - missed, abs=1e-3)
        assert found.basin_entropy == found.boundary_entropy
        assert found.fractal == (motions > 2)


def test_a_disc_is_smooth_and_its_entropy_goes_with_the_size_of_a_box():
    solution = disc(2000, 0.3)
    coarse, fine = basin_entropy(solution, 20), basin_entropy(solution, 10)
    assert not coarse.fractal
    assert coarse.basin_entropy / fine.basin_entropy == pytest.approx(2.0, rel=0.05)
    assert coarse.boundary_entropy == pytest.approx(fine.boundary_entropy, rel=0.05)


@pytest.mark.parametrize("box_levels", [1, 2, 3])
def test_stripes_of_a_cantor_set_have_the_entropy_of_its_gaps(box_levels):
    levels = 5
    row = cantor(levels)
    solution = np.tile(np.where(row == levels, 2, row % 2), (27, 1))
    found = basin_entropy(solution, 3**box_levels)
    # 2^n of 3^n boxes meet the set; each holds gaps of levels n, n + 1, ..., of two motions in turn, and a third.
    n = levels - box_levels
    assert found.boundary_boxes / found.boxes == pytest.approx((2 / 3) ** n)
    parts = np.zeros(3)
    for level in range(box_levels):
        parts[(n + level) % 2] += (2 / 3) ** level / 3
    parts[2] = 1.0 - parts.sum()
    parts = parts[parts > 0.0]
    assert found.boundary_entropy == pytest.approx(-(parts * np.log(parts)).sum())


def test_wholly_one_motion_is_certain():
    found = basin_entropy(np.full((20, 20), 4))
    assert found.basin_entropy == 0.0 and np.isnan(found.boundary_entropy) and not found.fractal


def test_rows_and_columns_left_over_are_not_counted():
    solution = np.zeros((23, 12), np.int16)
    solution[20:], solution[:, 10:] = 1, 2
    assert basin_entropy(solution, 5) == basin_entropy(np.zeros((20, 10), np.int16), 5)[:1] + (
        pytest.approx(np.nan, nan_ok=True), 8, 0,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("solution", "says"),
    [
        (np.full((9, 9), -1), "no solution"),
        (np.zeros((9, 9)), "integers"),
        (np.zeros(9, int), "plane"),
        (np.zeros((4, 9), int), "box_cells must be between 2 and 4"),
    ],
)
def test_what_is_no_picture_is_refused(solution, says):
    with pytest.raises(ValueError, match=says):
        basin_entropy(solution)
