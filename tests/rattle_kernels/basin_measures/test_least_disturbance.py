"""The least disturbance against a saddle on the boundary, and against what must hold."""

import numpy as np
import pytest

from rattle_kernels import CellGrid, Oscillator, least_disturbance, local_integrity_measure, name_solutions
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit
from tests.rattle_kernels.attractors.test_classify import catalogue_of


@pytest.fixture(scope="module")
def fig7():
    return catalogue_of(Oscillator(), cells=60)


def test_it_ends_at_the_saddle_on_the_boundary_of_quiet():
    # At damping 0.6 the stable manifold of the saddle P(1,1,0), of speed 1.2 pi, is the edge of the quiet basin there.
    saddle = find_periodic_orbit(Oscillator(), 0.3, 3.7, 1, 5.5)
    cells = 40
    start = float(saddle.t[0]) - 0.5 / cells
    grid = CellGrid(start, start + 1.0, cells, velocity_cells=100)
    attractors, solution = catalogue_of(Oscillator(), grid=grid)
    found = least_disturbance(Oscillator(), attractors, solution, grid, 1e-10)
    assert found.time[0] == pytest.approx(saddle.t[0], abs=1e-12)
    assert found.velocity[0] == pytest.approx(1.2 * np.pi, abs=2e-10)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-8])
def test_on_one_side_it_is_quiet_and_on_the_other_it_rattles(fig7, tolerance):
    attractors, solution = fig7
    found = least_disturbance(Oscillator(), attractors, solution, CellGrid(time_cells=60, velocity_cells=60), tolerance)
    above = name_solutions(Oscillator(), attractors, found.time, found.velocity)
    below = name_solutions(Oscillator(), attractors, found.time, found.velocity - tolerance)
    np.testing.assert_array_equal(above, found.solution)
    assert (above > 0).all() and (below == 0).all()


def test_a_finer_picture_finds_the_same_where_no_tongue_is_thinner_than_a_cell(fig7):
    coarse = least_disturbance(Oscillator(), *fig7, CellGrid(time_cells=60, velocity_cells=60), 1e-9)
    grid = CellGrid(time_cells=180, velocity_cells=180)  # every third phase is one of the coarse ones
    fine = least_disturbance(Oscillator(), *catalogue_of(Oscillator(), grid=grid), grid, 1e-9)
    np.testing.assert_allclose(fine.time[1::3], coarse.time, atol=1e-12)
    apart = np.abs(fine.velocity[1::3] - coarse.velocity)
    assert (apart < 2e-9).mean() > 0.95


def test_its_least_is_the_local_integrity_measure_to_within_a_cell(fig7):
    attractors, solution = fig7
    grid = CellGrid(time_cells=60, velocity_cells=60)
    found = least_disturbance(Oscillator(), attractors, solution, grid)
    measure = local_integrity_measure(solution, grid, attractors, velocity_scale=2.0)
    # The lowest cell's centre rattles and the one's below is quiet; the measure is the edge between them.
    assert 2.0 * measure == pytest.approx(found.velocity.min(), abs=0.5 * 7.0 / 60)


@pytest.mark.parametrize("oscillator", [Oscillator(damping=0.7), Oscillator(eccentricity=0.0)], ids=["0.7", "unforced"])
def test_where_everything_falls_quiet_no_disturbance_rattles(oscillator):
    grid = CellGrid(time_cells=12, velocity_cells=12)
    attractors, solution = catalogue_of(oscillator, grid=grid)
    found = least_disturbance(oscillator, attractors, solution, grid)
    assert np.isnan(found.velocity).all() and not found.solution.any()


def test_a_bracket_closer_than_neighbouring_numbers_ends_too(fig7):
    grid = CellGrid(time_cells=60, velocity_cells=60)
    found = least_disturbance(Oscillator(), *fig7, grid, 1e-300)
    below = name_solutions(Oscillator(), fig7[0], found.time, np.nextafter(found.velocity, 0.0))
    assert (below == 0).all()


@pytest.mark.parametrize(
    ("grid", "tolerance", "says"),
    [
        (CellGrid(time_cells=61, velocity_cells=60), 1e-6, "must be that of a grid"),
        (CellGrid(0.0, 1.0, 60, 1.0, 7.0, 60), 1e-6, "from velocity 0 up"),
        (CellGrid(time_cells=60, velocity_cells=60), 0.0, "tolerance must be positive"),
    ],
)
def test_what_cannot_be_answered_is_refused(fig7, grid, tolerance, says):
    with pytest.raises(ValueError, match=says):
        least_disturbance(Oscillator(), *fig7, grid, tolerance)
