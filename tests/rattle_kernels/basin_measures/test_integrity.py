"""Integrity measures against discs and strips, and the distance transform against a search over all cells."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle_kernels import (
    Attractor,
    AttractorKind,
    CellGrid,
    global_integrity_measure,
    integrity_factor,
    local_integrity_measure,
)
from rattle_kernels.numerics.distance_transform import distance_outside

# Half a cell's diagonal for the disc's ragged edge, and half for the centre that is no cell's centre.
RAGGED = np.hypot(1 / 300, 7 / 400 / 5)

QUIET = Attractor(AttractorKind.PERMANENT_CONTACT, 0, 0, 0, np.nan, np.nan, np.empty(0), np.empty(0))


def motion(t, v):
    return Attractor(AttractorKind.PERIODIC, 1, 1, 0, -1.0, 0.0, np.atleast_1d(t), np.atleast_1d(v))


def painted(grid, centre, radius, velocity_scale):
    """Cells whose centres lie in a disc of the scaled plane, round the cylinder."""
    t, v = np.meshgrid(grid.time_centres(), grid.velocity_centres())
    apart = np.abs(t - centre[0]) % 1.0
    return (np.hypot(np.minimum(apart, 1.0 - apart), (v - centre[1]) / velocity_scale) < radius).astype(int)


def search(inside, width, height, wraps):
    """Distances to cells outside and to the ends of the window, cell by cell."""
    rows, columns = inside.shape
    found = np.zeros(inside.shape)
    away_row, away_column = np.nonzero(~inside)
    for i, j in np.argwhere(inside):
        best = min(i + 0.5, rows - i - 0.5) * height
        best = best if wraps else min(best, (j + 0.5) * width, (columns - j - 0.5) * width)
        across = np.abs(away_column - j)
        across = np.minimum(across, columns - across) if wraps else across
        gaps = np.hypot(np.maximum(across - 0.5, 0) * width, np.maximum(np.abs(away_row - i) - 0.5, 0) * height)
        found[i, j] = min(best, gaps.min(initial=np.inf))
    return found


@given(st.integers(1, 14), st.integers(1, 14), st.data())
def test_the_distance_transform_finds_the_nearest_cell_outside(rows, columns, data):
    often = data.draw(st.sampled_from([0.0, 0.05, 0.3]))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    inside = rng.random((rows, columns)) >= often
    width, height = data.draw(st.floats(0.1, 5.0)), data.draw(st.floats(0.1, 5.0))
    for wraps in (False, True):
        found = distance_outside(inside, width, height, wraps=wraps)
        np.testing.assert_allclose(found, search(inside, width, height, wraps), rtol=1e-12)


def test_the_global_measure_is_the_share_of_the_cells():
    solution = np.repeat([0, 1, 1, 2], 25).reshape(4, 25)
    assert [global_integrity_measure(solution, index) for index in range(4)] == [0.25, 0.5, 0.25, 0.0]


@pytest.mark.parametrize("centre", [(0.5, 3.5), (0.03, 2.0)])
def test_the_largest_disc_in_a_disc_is_the_disc(centre):
    grid = CellGrid(time_cells=300, velocity_cells=400)
    scale, radius = 5.0, 0.2
    disc = integrity_factor(painted(grid, centre, radius, scale), grid, 1, velocity_scale=scale)
    assert disc.radius == pytest.approx(radius, abs=RAGGED)
    assert (disc.time, disc.velocity) == pytest.approx(centre, abs=0.04)


def test_a_disc_across_the_seam_is_cut_where_time_does_not_wrap():
    whole = CellGrid(time_cells=300, velocity_cells=400)
    part = whole._replace(time_stop=0.9)
    solution = painted(whole, (0.0, 3.5), 0.2, 5.0)
    assert integrity_factor(solution, whole, 1, velocity_scale=5.0).radius == pytest.approx(0.2, abs=RAGGED)
    assert integrity_factor(solution, part, 1, velocity_scale=5.0).radius < 0.12


@pytest.mark.parametrize(("index", "width"), [(0, 3.0), (1, 4.0)])
def test_the_largest_disc_in_a_strip_has_half_its_width(index, width):
    grid = CellGrid(time_cells=70, velocity_cells=70)
    solution = np.zeros(grid.shape, int)
    solution[30:] = 1
    disc = integrity_factor(solution, grid, index, velocity_scale=2.0)
    # The middle of an odd number of rows is a centre; of an even number the nearest centre is half a row off.
    assert disc.radius == pytest.approx((width / 2 - 0.05) / 2.0)


def test_an_empty_basin_has_no_disc():
    disc = integrity_factor(np.zeros((5, 5), int), CellGrid(time_cells=5, velocity_cells=5), 3, velocity_scale=1.0)
    assert disc.radius == 0.0 and np.isnan(disc.time)


@pytest.mark.parametrize("state", [(0.5, 3.5), (0.03, 3.5), (0.45, 3.1)])
def test_the_local_measure_is_the_distance_to_the_edge_of_a_disc(state):
    grid = CellGrid(time_cells=300, velocity_cells=400)
    solution = painted(grid, (state[0] - 0.05, 3.5), 0.2, 5.0)
    found = local_integrity_measure(solution, grid, [QUIET, motion(*state)], 1, velocity_scale=5.0)
    assert found == pytest.approx(0.2 - np.hypot(0.05, (state[1] - 3.5) / 5.0), abs=RAGGED)


@given(st.integers(0, 2**32), st.booleans())
def test_the_local_measure_at_a_centre_agrees_with_the_distance_transform(seed, wraps):
    rng = np.random.default_rng(seed)
    grid = CellGrid(0.3, 1.3 if wraps else 0.9, 11, 1.0, 3.0, 9)
    solution = (rng.random(grid.shape) < 0.9).astype(int)
    i, j = rng.integers(9), rng.integers(11)
    state = motion(grid.time_centres()[j] % 1.0, grid.velocity_centres()[i])
    found = local_integrity_measure(solution, grid, [QUIET, state], 1, velocity_scale=0.7)
    width, height = (grid.time_stop - grid.time_start) / 11, 2.0 / 9 / 0.7
    expected = distance_outside(solution == 1, width, height, wraps=wraps)[i, j]
    assert found == pytest.approx(expected, abs=1e-12)


def test_of_several_states_the_least_safe_one_counts():
    grid = CellGrid(time_cells=100, velocity_cells=100, velocity_stop=1.0)
    solution = np.ones(grid.shape, int)
    solution[:, 50] = 0
    orbit = motion([0.1, 0.4], [0.5, 0.5])
    assert local_integrity_measure(solution, grid, [QUIET, orbit], 1, velocity_scale=1.0) == pytest.approx(0.1)


def test_no_speed_below_zero_ends_a_basin():
    grid = CellGrid(time_cells=10, velocity_cells=10, velocity_stop=1.0)
    states = [QUIET, motion(0.5, 0.05)]
    assert local_integrity_measure(np.ones(grid.shape, int), grid, states, 1, velocity_scale=1.0) == 0.95


def test_permanent_contact_is_safe_up_to_the_lowest_row_of_another_motion():
    grid = CellGrid(time_cells=50, velocity_cells=70)
    solution = np.zeros(grid.shape, int)
    assert local_integrity_measure(solution, grid, [QUIET], velocity_scale=2.0) == pytest.approx(3.5)
    solution[40, 7] = 1
    assert local_integrity_measure(solution, grid, [QUIET], velocity_scale=2.0) == pytest.approx(2.0)
    assert np.isnan(local_integrity_measure(solution, grid._replace(velocity_start=0.5), [QUIET], velocity_scale=2.0))


def test_a_state_in_another_basin_has_no_room_and_one_outside_the_window_is_not_known():
    grid = CellGrid(time_stop=0.5, time_cells=10, velocity_cells=10)
    catalogue = [QUIET, motion(0.25, 3.0), motion(0.75, 3.0), motion(0.25, 8.0)]
    found = [
        local_integrity_measure(np.zeros(grid.shape, int), grid, catalogue, i, velocity_scale=1.0) for i in (1, 2, 3)
    ]
    assert found[0] == 0.0 and np.isnan(found[1:]).all()


def test_what_does_not_fit_together_is_refused():
    grid = CellGrid(time_cells=5, velocity_cells=4)
    with pytest.raises(ValueError, match=r"shape \(5, 4\) are not those of a grid of shape \(4, 5\)"):
        integrity_factor(np.zeros((5, 4), int), grid, velocity_scale=1.0)
    with pytest.raises(ValueError, match="velocity_scale must be positive"):
        integrity_factor(np.zeros((4, 5), int), grid, velocity_scale=0.0)


def test_a_disc_with_a_free_centre_is_larger_by_half_the_diagonal_of_a_cell_at_most():
    """Where the basin is two cells wide, the largest disc touches both sides; centred on a cell it has half of that."""
    grid = CellGrid(time_cells=8, velocity_stop=4.0, velocity_cells=8)
    solution = np.zeros(grid.shape, int)
    solution[3:5, 1:7] = 1
    width, height = 1 / 8, 0.5 / 2.0
    free = height
    disc = integrity_factor(solution, grid, 1, velocity_scale=2.0)
    assert disc.time in grid.time_centres() and disc.velocity in grid.velocity_centres()
    assert disc.radius == pytest.approx(height / 2)
    assert free - disc.radius <= np.hypot(width, height) / 2
