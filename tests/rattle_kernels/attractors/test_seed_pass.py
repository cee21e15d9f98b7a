"""The seed pass finds what to be trapped by where damping is weak, and keeps out of the way elsewhere."""

import numpy as np
import pytest

from rattle_kernels import CellGrid, Oscillator, map_points
from rattle_kernels.attractors.seed_pass import traps_of_seeds
from rattle_kernels.lanes.traps import NO_TRAPS
from worker.jobs.basin_job import BasinJob

WEAK = Oscillator(6e-3, 1e-3, 6e-3)
WINDOW = CellGrid(0.0, 1.0, 1000, 0.0, 0.072, 1000)


def test_the_papers_damping_and_small_jobs_are_not_scouted():
    assert traps_of_seeds(Oscillator(), CellGrid(), 1499, 1_000_000) is NO_TRAPS
    assert traps_of_seeds(WEAK, WINDOW, 150_001, 100) is NO_TRAPS


@pytest.mark.slow
def test_scouted_traps_shorten_what_they_do_not_change():
    iterations = BasinJob(oscillator=WEAK, grid=WINDOW).iterations
    traps = traps_of_seeds(WEAK, WINDOW, iterations, WINDOW.cells)
    assert traps.period.size >= 3
    rng = np.random.default_rng(1)
    t, v = rng.random(200), rng.random(200) * 0.072
    caught = map_points(WEAK, WINDOW, iterations, t, v, traps=traps)
    plain = map_points(WEAK, WINDOW, iterations, t, v, shortcuts=False)
    np.testing.assert_array_equal(caught.image_cell, plain.image_cell)
    assert caught.applications < 0.1 * plain.applications
