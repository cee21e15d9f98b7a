import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle_kernels import SINK, CellGrid
from rattle_kernels.cell_mapping.cell_grid import cell_number, check_grid
from rattle_kernels.cell_mapping.iterations import (
    check_iterations,
    expected_applications,
    is_prime,
    nearest_primes,
    settled_iterations,
)
from rattle_kernels.numerics.jit import inlined


@inlined
def number_of(grid, t, v):
    return cell_number(grid, t, v)


@st.composite
def grids(draw):
    start = draw(st.floats(0.0, 1.0, exclude_max=True))
    span = draw(st.one_of(st.just(1.0), st.floats(0.01, 0.999)))
    low = draw(st.floats(0.0, 10.0))
    grid = CellGrid(
        start, start + span, draw(st.integers(1, 50)), low, low + draw(st.floats(0.01, 10.0)), draw(st.integers(1, 50))
    )
    return check_grid(grid)


@given(grids())
def test_every_centre_lies_in_its_cell(grid):
    t, v = np.meshgrid(grid.time_centres(), grid.velocity_centres())
    cells = [number_of(grid, *point) for point in zip(t.ravel().tolist(), v.ravel().tolist(), strict=True)]
    assert cells == list(range(grid.cells))


@given(grids(), st.floats(0.0, 1.0, exclude_max=True), st.floats(0.0, 25.0))
def test_a_point_is_in_the_cell_whose_borders_hold_it_or_in_the_sink(grid, t, v):
    cell = number_of(grid, t, v)
    width = (grid.time_stop - grid.time_start) / grid.time_cells
    height = (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells
    into, up = (t - grid.time_start) % 1.0, v - grid.velocity_start
    if cell == SINK:
        span = grid.time_stop - grid.time_start
        assert not 0.0 <= up < grid.velocity_stop - grid.velocity_start or (into >= span and not grid.wraps)
    else:
        i_v, i_t = divmod(cell, grid.time_cells)
        assert -1e-9 <= up / height - i_v <= 1.0 + 1e-9
        assert -1e-9 <= into / width - i_t <= 1.0 + 1e-9 or (into == 1.0 and i_t == grid.time_cells - 1)


def test_the_borders_are_half_open():
    grid = CellGrid(0.25, 0.75, 2, 1.0, 3.0, 2)
    assert number_of(grid, 0.25, 1.0) == 0
    assert number_of(grid, 0.5, 2.0) == 3
    assert number_of(grid, 0.75, 1.0) == number_of(grid, 0.3, 3.0) == number_of(grid, 0.2, 2.0) == SINK
    assert number_of(grid, 0.3, np.nextafter(1.0, 0.0)) == SINK


def test_a_whole_period_has_no_outside_in_time():
    grid = CellGrid(0.3, 1.3, 10, 0.0, 1.0, 1)
    assert grid.wraps
    assert number_of(grid, 0.2999, 0.5) == 9 and number_of(grid, 0.3, 0.5) == 0
    assert number_of(grid, np.nextafter(0.3, 0.0), 0.5) in (0, 9)


@given(st.floats(0.0, 1.0, exclude_max=True), st.floats(0.0, 1.0, exclude_max=True))
def test_every_whole_period_wraps_wherever_it_starts(start, t):
    grid = check_grid(CellGrid(start, start + 1.0, 10, 0.0, 1.0, 1))
    assert grid.wraps and number_of(grid, t, 0.5) != SINK
    assert number_of(grid, np.nextafter(start, -1.0) % 1.0, 0.5) != SINK


def test_a_window_across_phase_zero_holds_both_sides():
    grid = CellGrid(0.9, 1.1, 2, 0.0, 1.0, 1)
    assert [number_of(grid, t, 0.5) for t in (0.95, 0.05, 0.5)] == [0, 1, SINK]


@pytest.mark.parametrize(
    ("number", "prime"),
    [(0, False), (1, False), (2, True), (3, True), (4, False), (1499, True), (1501, False), (9, False)],
)
def test_primes_are_told(number, prime):
    assert is_prime(number) == prime


def test_primality_agrees_with_a_sieve():
    sieve = np.ones(5000, bool)
    sieve[:2] = False
    for divisor in range(2, 71):
        sieve[divisor * divisor :: divisor] = False
    assert [n for n in range(5000) if is_prime(n)] == np.flatnonzero(sieve).tolist()


def test_refused_iterations_name_the_nearest_primes():
    assert check_iterations(1) == 1 and check_iterations(1499) == 1499
    assert nearest_primes(1500) == (1499, 1511) and nearest_primes(0) == (2,) and nearest_primes(4) == (3, 5)
    with pytest.raises(ValueError, match="nearest: 1499 or 1511"):
        check_iterations(1500)


@pytest.mark.parametrize("iterations", [10**12 + 1, 2**61 - 1, 2**61, 10**300])
def test_what_is_too_large_to_be_tried_for_divisors_is_refused_at_once(iterations):
    with pytest.raises(ValueError, match="iterations must be at most 1000000000000"):
        check_iterations(iterations)


def test_the_largest_iterations_are_tried_in_no_time():
    assert check_iterations(999_999_999_989) == 999_999_999_989
    with pytest.raises(ValueError, match="nearest: 999999999989 or 1000000000039"):
        check_iterations(10**12)


def test_a_request_without_iterations_gets_as_many_damping_times_as_the_papers():
    assert [settled_iterations(damping) for damping in (0.7, 0.6, 0.5)] == [1499] * 3
    for damping in (0.4, 0.06, 6e-3, 6e-4, 1e-4):
        k = settled_iterations(damping)
        assert is_prime(k) and 900.0 <= k * damping < 901.0
    assert settled_iterations(1e-9) == settled_iterations(9e-5)


def test_work_is_counted_by_what_trajectories_take_where_damping_is_weak():
    assert expected_applications(0.6, 1499) == 1499 and expected_applications(6e-4, 101) == 101
    assert expected_applications(6e-4, 1_500_007) == pytest.approx(90_000)
