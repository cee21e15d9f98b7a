"""A panel of the paper, in one process and through the worker; assembly alone."""

import threading

import numpy as np
import pytest

from rattle_kernels import CellGrid, Oscillator, find_groups, label_cells, map_cells
from worker.basin_job import BasinJob
from worker.cluster import local_cluster
from worker.pipeline import run_basin

PANELS = [
    Oscillator(),
    Oscillator(0.5, 0.1, 0.6),
    Oscillator(0.55, 0.1, 0.6),
    Oscillator(0.65, 0.1, 0.6),
    Oscillator(0.6, 0.067, 0.6),
]


@pytest.mark.parametrize("oscillator", PANELS, ids=lambda o: f"{o.damping:g}-{o.eccentricity:g}")
def test_panel_kernel_on_one_core(benchmark, oscillator):
    """Seconds for 1000 x 1000 cells, k = 1499, on one core."""
    grid = CellGrid()
    images = benchmark.pedantic(map_cells, (oscillator, grid, 1499, (0, 1000), (0, 1000)), rounds=1)
    benchmark.extra_info["applications_per_cell"] = images.applications / grid.cells


@pytest.mark.parametrize("workers", [1, 2])
def test_panel_through_the_worker(benchmark, tmp_path, workers):
    """Seconds from job to complete store, warm."""
    with local_cluster(workers) as client:
        warm = BasinJob(grid=CellGrid(time_cells=60, velocity_cells=60))
        run_basin(warm, str(tmp_path / "warm.zarr"), client, report=lambda _: None, cancel=threading.Event())
        counter = iter(range(100))

        def basin():
            location = str(tmp_path / f"{next(counter)}.zarr")
            return run_basin(BasinJob(), location, client, report=lambda _: None, cancel=threading.Event())

        summary = benchmark.pedantic(basin, rounds=3)
    seconds = summary.seconds
    benchmark.extra_info |= seconds
    kernels = (seconds["map_kernels"] + seconds["label_kernels"]) / workers
    benchmark.extra_info["wall_over_kernels"] = benchmark.stats.stats.min / kernels


def test_labels_of_a_map_by_look_up(benchmark):
    """Cells a second that `label_cells` unravels, of a map of 4 million cells with 100,000 images."""
    rng = np.random.default_rng(0)
    cells = np.unique(rng.integers(0, 4_000_000, 100_000))
    image = cells[rng.integers(0, cells.size, 4_000_000)]
    groups = find_groups(cells, image[cells])
    benchmark(label_cells, groups, np.arange(image.size), image)
    benchmark.extra_info["million_cells_per_second"] = image.size / benchmark.stats.stats.min / 1e6


def test_groups_of_an_image_set(benchmark):
    """Cells a second that `find_groups` unravels, when every cell is an image."""
    image = np.random.default_rng(0).permutation(2_000_000)
    benchmark.pedantic(find_groups, (np.arange(image.size), image), rounds=3)
    benchmark.extra_info["million_cells_per_second"] = image.size / benchmark.stats.stats.min / 1e6
