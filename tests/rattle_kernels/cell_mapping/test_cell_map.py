"""Images under lock and capture against the plain loop and an independent scalar computation."""

import numpy as np
import pytest

from rattle_kernels import NOT_CONVERGED, PERMANENT_CONTACT, SINK, CellGrid, Oscillator, map_cells
from rattle_kernels.cell_mapping.cell_grid import cell_number
from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.chatter import descent, is_captured
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.flight import rest_acceleration
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel

GRID = CellGrid(time_cells=28, velocity_cells=28)
PANELS = [
    Oscillator(damping, eccentricity, 0.6)
    for damping, eccentricity in [
        (0.6, 0.1),
        (0.5, 0.1),
        (0.55, 0.1),
        (0.65, 0.1),
        (0.7, 0.1),
        (0.6, 0.067),
        (0.6, 0.0835),
    ]
] + [Oscillator(0.06, 0.01, 0.06), Oscillator(0.3, 0.08, 0.2)]


def whole(oscillator, grid, iterations, **options):
    return map_cells(oscillator, grid, iterations, (0, grid.velocity_cells), (0, grid.time_cells), **options)


@kernel
def _plain_image(oscillator, bound, grid, t, v, iterations):
    """Image cell by the careful scalar path, all applications done; how far a displacement of 1e-9 ever grows."""
    near_t, near_v, grown = t + 1e-9, v, 0.0
    for _ in range(iterations):
        impact = next_impact(oscillator, t, v)
        t, v = impact.t, impact.v
        beside = next_impact(oscillator, near_t, near_v)
        near_t, near_v = beside.t, beside.v
        apart = abs(near_t - t)
        grown = max(grown, min(apart, 1.0 - apart) + abs(near_v - v))
    image = PERMANENT_CONTACT if is_captured(oscillator, bound, t, v) else cell_number(grid, t, v)
    return image, grown, t, v


def plain(oscillator, grid, iterations):
    bound = lane_tables(oscillator).capture_bound
    points = [(t, v) for v in grid.velocity_centres() for t in grid.time_centres()]
    found = [_plain_image(oscillator, bound, grid, t, v, iterations) for t, v in points]
    return tuple(np.array(column).reshape(grid.shape) for column in zip(*found, strict=True))


@pytest.mark.parametrize("oscillator", PANELS, ids=lambda o: f"{o.damping}-{o.eccentricity}")
@pytest.mark.parametrize("iterations", [1, 101, pytest.param(1499, marks=pytest.mark.slow)])
def test_no_image_of_a_regular_trajectory_depends_on_shortcuts(oscillator, iterations):
    image, grown, t, v = plain(oscillator, GRID, iterations)
    # Chaos on the way, however short, turns rounding into another image: regular is what never grows ten-thousandfold.
    regular = grown < 1e-5
    fast = whole(oscillator, GRID, iterations)
    assert regular.mean() > (0.3 if oscillator.damping >= 0.5 else 0.01)
    np.testing.assert_array_equal(fast.image_cell[regular], image[regular])
    landed = regular & (image >= SINK)
    turn = fast.landing_time[landed] - t[landed]
    # Rounding, ten-thousandfold: some 1e-10.
    np.testing.assert_allclose(turn - np.rint(turn), 0.0, atol=5e-9)
    np.testing.assert_allclose(fast.landing_velocity[landed], v[landed], rtol=0.0, atol=5e-9)


@pytest.mark.parametrize("oscillator", PANELS, ids=lambda o: f"{o.damping}-{o.eccentricity}")
def test_lanes_without_shortcuts_give_the_plain_loops_images(oscillator):
    image, grown, _, _ = plain(oscillator, GRID, 101)
    regular = grown < 1e-5
    np.testing.assert_array_equal(whole(oscillator, GRID, 101, shortcuts=False).image_cell[regular], image[regular])


def test_a_lock_at_the_very_application_of_a_checkpoint_ends():
    # P(16,16,12): the orbit's period is that of the checkpoints, so it locks when the next one is due.
    oscillator, t, v = Oscillator(damping=0.526), np.array([0.6037261424064686]), np.array([4.500776320171449])
    for applications in (32, 33, 47, 64, 65):
        locked, _ = run_lanes(oscillator, t, v, applications, shortcuts=True)
        plain_run, _ = run_lanes(oscillator, t, v, applications, shortcuts=False)
        np.testing.assert_allclose([locked.t, locked.v], [plain_run.t, plain_run.v], rtol=0.0, atol=1e-10)


def test_shortcuts_save_most_of_the_work():
    cells = GRID.cells
    assert whole(PANELS[0], GRID, 1499, shortcuts=False).applications == 1499 * cells
    assert whole(PANELS[0], GRID, 1499).applications < 0.4 * 1499 * cells


@pytest.mark.parametrize("rows", [7, 13, 28])
def test_an_image_does_not_depend_on_the_rectangle_it_was_computed_in(rows):
    together = whole(PANELS[0], GRID, 101)
    for start in range(0, 28, rows):
        stop = min(start + rows, 28)
        part = map_cells(PANELS[0], GRID, 101, (start, stop), (5, 23))
        np.testing.assert_array_equal(part.image_cell, together.image_cell[start:stop, 5:23])
        np.testing.assert_array_equal(part.landing_velocity, together.landing_velocity[start:stop, 5:23])


def test_what_leaves_the_grid_and_comes_back_is_not_in_the_sink():
    # One application leads out of this window; the periodic orbit at v = 1.2 pi pulls most of it back.
    grid = CellGrid(0.85, 0.95, 20, 3.6, 3.9, 20)
    once, often = whole(Oscillator(), grid, 1), whole(Oscillator(), grid, 101)
    assert (once.image_cell == SINK).any()
    assert (often.image_cell[once.image_cell == SINK] >= 0).any()


def test_landing_points_are_missing_exactly_where_captured():
    images = whole(Oscillator(), GRID, 101)
    captured = images.image_cell == PERMANENT_CONTACT
    assert captured.any() and not (images.image_cell == NOT_CONVERGED).any()
    np.testing.assert_array_equal(np.isnan(images.landing_time), captured)
    np.testing.assert_array_equal(np.isnan(images.landing_velocity), captured)


@kernel
def _highest_bounce(oscillator, t, v, impacts):
    highest = 0.0
    for _ in range(impacts):
        impact = next_impact(oscillator, t, v)
        t, v = impact.t, impact.v
        highest = max(highest, v * v * v / rest_acceleration(oscillator, t))
    return highest


@pytest.mark.parametrize("oscillator", PANELS + [Oscillator(0.6, 0.18, 0.6), Oscillator(6e-4, 1e-4, 6e-4)], ids=str)
def test_what_is_captured_never_rattles_again(oscillator):
    bound = lane_tables(oscillator).capture_bound
    assert bound > 0.0
    rng = np.random.default_rng(2)
    for phase in rng.random(40):
        edge = float((bound * rest_acceleration(oscillator, phase)) ** (1 / 3))
        # Where the bound rests on the corrected action, the plain one may rise by its margin.
        assert _highest_bounce(oscillator, phase, 0.999 * edge, 2000) < 1.06 * bound


def test_the_descent_tends_to_its_limit_for_low_bounces():
    for phase in np.linspace(0.0, 1.0, 17):
        assert descent(Oscillator(), phase, 1e-3) == pytest.approx(-1.0, abs=5e-3)


def test_a_pause_changes_nothing_and_what_is_raised_there_ends_the_work():
    t, v = np.random.default_rng(3).random((2, 100)) * [[1.0], [7.0]]
    pauses = []
    whole, run = run_lanes(PANELS[0], t, v, 120_000, shortcuts=False, pause=lambda: pauses.append(1))
    assert len(pauses) >= 3 and run.applications <= 120_000 * 100
    half, _ = run_lanes(PANELS[0], t, v, 60_000, shortcuts=False)
    again, _ = run_lanes(PANELS[0], half.t, half.v, 60_000, shortcuts=False)
    rattles = again.outcome == OUTCOME_RETURNED
    assert rattles.sum() > 30
    np.testing.assert_array_equal(whole.t[rattles], again.t[rattles])

    def stop():
        raise InterruptedError

    with pytest.raises(InterruptedError):
        run_lanes(PANELS[0], t, v, 7, shortcuts=False, pause=stop)
