"""Basin boundaries: cells of made-up pictures, and the paper's claim that stable manifolds form them (Sec. 6.2)."""

import numpy as np
import pytest

from rattle_kernels import CellGrid, Oscillator, find_attractors, map_cells, name_solutions
from rattle_kernels.attractors.seeds import landing_boxes
from rattle_kernels.basin_measures.boundary import boundary_cells, boundary_share, cells_along
from rattle_kernels.cell_mapping.cell_map import PERMANENT_CONTACT
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.manifolds.polyline import Piece, arclength
from rattle_kernels.manifolds.saddle import find_saddle
from rattle_kernels.manifolds.stable_manifold import ManifoldLimits, stable_manifold
from tests.rattle_kernels.basin_measures.basin_pictures import half_plane

UNIT = CellGrid(0.0, 1.0, 10, 0.0, 1.0, 10)


def test_boundary_cells_are_those_on_both_sides_of_a_change():
    picture = np.zeros((4, 6), int)
    picture[:2] = 1
    assert (boundary_cells(picture) == np.isin(np.arange(4), [1, 2])[:, None]).all()


def test_a_boundary_may_lie_at_the_wrap_of_time():
    picture = np.zeros((3, 6), int)
    picture[:, :3] = 1
    assert boundary_cells(picture, wraps=True)[0].tolist() == [True, False, True, True, False, True]
    assert boundary_cells(picture, wraps=False)[0].tolist() == [False, False, True, True, False, False]


def test_cells_along_a_curve_are_put_on_the_cylinder_and_clipped():
    curve = Piece(np.array([0.85, 1.25]), np.array([0.05, 0.05]))
    assert np.flatnonzero(cells_along([curve], UNIT)[0]).tolist() == [0, 1, 2, 8, 9]
    assert not cells_along([Piece(curve.t, curve.v + 1.0)], UNIT).any()
    window = UNIT._replace(time_start=0.8, time_stop=1.1, time_cells=3)
    assert cells_along([curve], window)[0].all()


@pytest.mark.parametrize("slope", [0.3, 1.7])
def test_a_straight_boundary_lies_on_its_line(slope):
    picture = half_plane(50, slope)
    grid = CellGrid(0.0, 1.0 - 1e-9, 50, 0.0, 1.0, 50)
    ends = np.array([0.0, 1.0 - 1e-9])
    line = Piece(ends, 0.5 + slope * (ends - 0.5))
    assert boundary_share(picture, grid, [line]) == 1.0
    assert boundary_share(picture, grid, [Piece(ends, line.v + 0.2)]) < 0.1


def test_a_picture_without_boundary_has_no_share_and_a_wrong_shape_is_refused():
    assert np.isnan(boundary_share(np.zeros((10, 10), int), UNIT, []))
    with pytest.raises(ValueError, match="are not those of a grid"):
        boundary_share(np.zeros((10, 11), int), UNIT, [])


def basin(oscillator, cells, highest=7.0):
    """Grid and solutions of a panel."""
    grid = CellGrid(time_cells=cells, velocity_stop=highest, velocity_cells=cells)
    images = map_cells(oscillator, grid, 1499, (0, cells), (0, cells))
    landed = images.image_cell != PERMANENT_CONTACT
    t, v = images.landing_time[landed], images.landing_velocity[landed]
    _, first = np.unique(landing_boxes(oscillator, t, v), return_index=True)
    solution = np.zeros(grid.shape, np.int16)
    solution[landed] = name_solutions(oscillator, find_attractors(oscillator, t[first], v[first]), t, v)
    return grid, solution


def stable_pieces(oscillator, saddle, limits):
    return [piece for branch in stable_manifold(oscillator, saddle, limits) for piece in branch.pieces]


CELLS = [200, pytest.param(400, marks=pytest.mark.slow)]


@pytest.mark.parametrize("cells", CELLS)
def test_the_boundary_lies_on_the_stable_manifolds_of_the_papers_saddles(cells):
    """Figs. 15, 16: all of it on that of P(1,1,0), and the edge of the basin P(1,1,0) on that of P(1,1,1) too."""
    oscillator = Oscillator()
    grid, solution = basin(oscillator, cells)
    limits = ManifoldLimits(100.0, 0.0, 7.0)
    quiet_edge = stable_pieces(oscillator, find_saddle(oscillator, 0.6, 3.77), limits)
    assert boundary_share(solution, grid, quiet_edge) == 1.0
    periodic_edge = stable_pieces(oscillator, find_saddle(oscillator, 0.89, 3.988), limits)
    assert arclength(periodic_edge, lane_tables(oscillator).largest_grazing_speed) == pytest.approx(3.23, abs=0.01)
    assert boundary_share(solution == 1, grid, periodic_edge) == 1.0
    assert boundary_share(solution, grid, periodic_edge) < 0.4


@pytest.mark.parametrize("cells", CELLS)
def test_a_saddle_within_a_basin_is_on_no_boundary(cells):
    """Another P(1,1,1), amid chaos: its manifold comes close to boundaries, as it does to all of chaos."""
    oscillator = Oscillator()
    grid, solution = basin(oscillator, cells)
    within = stable_pieces(oscillator, find_saddle(oscillator, 0.63, 4.57), ManifoldLimits(10.0, 0.0, 7.0))
    assert boundary_share(solution, grid, within) < 0.4
    assert sides_of(oscillator, within) == (["chaotic"], ["chaotic"])


@pytest.mark.parametrize("cells", CELLS)
def test_before_the_saddle_node_two_saddles_share_the_boundary(cells):
    """At damping 0.575 the saddle P(1,2,0) of Fig. 10 holds what that of P(1,1,0) leaves."""
    oscillator = Oscillator(damping=0.575)
    grid, solution = basin(oscillator, cells)
    limits = ManifoldLimits(100.0, 0.0, 7.0)
    one = stable_pieces(oscillator, find_saddle(oscillator, 0.59, 3.61), limits)
    other = stable_pieces(oscillator, find_saddle(oscillator, 0.786, 1.613, 2), limits)
    assert boundary_share(solution, grid, one) < 0.7
    assert boundary_share(solution, grid, one + other) == 1.0


@pytest.mark.slow
def test_the_boundary_lies_on_the_manifold_up_to_velocity_40():
    oscillator = Oscillator()
    grid, solution = basin(oscillator, 400, highest=40.0)
    pieces = stable_pieces(oscillator, find_saddle(oscillator, 0.6, 3.77), ManifoldLimits(1600.0, 0.0, 40.0))
    assert boundary_share(solution, grid, pieces) == 1.0


def sides_of(oscillator, pieces):
    """Motions on the two sides of curves at damping 0.6, in the order of the catalogue."""
    attractors = find_attractors(oscillator, [0.89829, 0.553], [3.76991, 4.703])
    t, v = (np.concatenate([values[1:-1] for values in field]) for field in zip(*pieces, strict=True))
    dt, dv = (np.concatenate([values[2:] - values[:-2] for values in field]) for field in zip(*pieces, strict=True))
    shift = 1e-9 / np.hypot(dt, dv)
    sides = [name_solutions(oscillator, attractors, t - s * dv, v + s * dt) for s in (shift, -shift)]
    lower, upper = (np.unique(side) for side in (np.minimum(*sides), np.maximum(*sides)))
    return [attractors[index].name for index in lower], [attractors[index].name for index in upper]


@pytest.mark.parametrize(
    "seed, one, other",
    [
        ((0.6, 3.77), ["permanent contact"], ["chaotic"]),
        ((0.89, 3.988), ["permanent contact", "P(1,1,0)"], ["P(1,1,0)", "chaotic"]),
    ],
    ids=["P(1,1,0)", "P(1,1,1)"],
)
def test_motions_differ_on_the_two_sides_of_a_manifold(seed, one, other):
    """Hence it is a boundary itself, not a curve next to one; every point of the second borders on P(1,1,0)."""
    oscillator = Oscillator()
    pieces = stable_pieces(oscillator, find_saddle(oscillator, *seed), ManifoldLimits(10.0, 0.0, 7.0))
    assert sides_of(oscillator, pieces) == (one, other)


def test_a_curve_a_rounding_before_the_period_is_in_its_first_column():
    grid = CellGrid(time_cells=4, velocity_stop=4.0, velocity_cells=4)
    there = cells_along([Piece(np.array([-1e-17, -1e-17]), np.array([0.5, 1.5]))], grid)
    assert there.nonzero()[0].tolist() == [0, 1] and there.nonzero()[1].tolist() == [0, 0]
