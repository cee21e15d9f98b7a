"""A panel of the paper, in one process and through the worker; what a tile costs beside its kernels."""

import threading

import pytest

from rattle_kernels import NOT_CONVERGED, CellGrid, Oscillator, map_cells
from worker.basins.tasks import map_tile
from worker.cluster.calls import Task
from worker.cluster.connection import local_cluster
from worker.cluster.driver import Driver
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import Spacing, SweptParameter
from worker.results.summary import summarise
from worker.run import run_job
from worker.stores.basin_store import BasinStore

PANELS = [
    Oscillator(),
    Oscillator(0.5, 0.1, 0.6),
    Oscillator(0.55, 0.1, 0.6),
    Oscillator(0.65, 0.1, 0.6),
    Oscillator(0.6, 0.067, 0.6),
    Oscillator(stiffness=1e2),
    Oscillator(stiffness=1e3),
    Oscillator(stiffness=1e4),
    Oscillator(stiffness=1e6),
]


@pytest.mark.parametrize("oscillator", PANELS, ids=lambda o: f"{o.damping:g}-{o.eccentricity:g}-{o.stiffness:g}")
def test_panel_kernel_on_one_core(benchmark, oscillator):
    """Seconds for 1000 x 1000 cells, k = 1499, on one core."""
    grid = CellGrid()
    images = benchmark.pedantic(map_cells, (oscillator, grid, 1499, (0, 1000), (0, 1000)), rounds=1)
    assert images.image_cell.shape == grid.shape and (images.image_cell == NOT_CONVERGED).mean() < 1e-3
    benchmark.extra_info["applications_per_cell"] = images.applications / grid.cells


def _warm_driver(client, folder):
    driver = Driver(client)
    _run(BasinJob(grid=CellGrid(time_cells=60, velocity_cells=60)), str(folder / "warm.zarr"), driver)
    return driver


def _run(job, location, driver):
    run_job(job, location, driver, report=lambda _: None, cancel=threading.Event())


@pytest.mark.parametrize("workers", [1, 2])
def test_panel_through_the_worker(benchmark, tmp_path, workers):
    """Seconds from job to complete store, warm: the driver has run jobs before."""
    locations = [str(tmp_path / f"{number}.zarr") for number in range(5)]
    with local_cluster(workers) as client:
        driver, following = _warm_driver(client, tmp_path), iter(locations)
        benchmark.pedantic(lambda: _run(BasinJob(), next(following), driver), rounds=len(locations))
    rounds = benchmark.stats.stats.data
    summary = summarise(locations[rounds.index(min(rounds))])
    assert {solution.name for solution in summary.solutions} == {"permanent contact", "P(1,1,0)", "chaotic"}
    seconds = summary.seconds
    benchmark.extra_info |= seconds
    kernels = (seconds["map_kernels"] + seconds["label_kernels"]) / workers
    benchmark.extra_info["wall_over_kernels"] = min(rounds) / kernels


def test_a_thousand_dampings(benchmark, tmp_path):
    """Seconds for 1,000 points at each of a thousand dampings, by two workers, warm."""
    swept = SweptParameter.spaced("damping", 0.5, 0.7, 1000, Spacing.LINEAR)
    job = SweepJob(sample=Sample(points=1000), vary=(swept,))
    location = str(tmp_path / "sweep.zarr")
    with local_cluster(2) as client:
        driver = _warm_driver(client, tmp_path)
        benchmark.pedantic(_run, (job, location, driver), rounds=1)
    seconds = BasinStore(location).attributes["seconds"]
    benchmark.extra_info |= {"milliseconds_a_basin": benchmark.stats.stats.min, "seconds_of_kernels": seconds}


def test_a_tile_without_work(benchmark, tmp_path):
    """Seconds that a tile of 64 x 64 cells, k = 1, costs: submission, chunks written, receipt."""
    job = BasinJob(grid=CellGrid(time_cells=64 * 16, velocity_cells=64 * 16), iterations=1)
    location = str(tmp_path / "small.zarr")
    store = BasinStore.create_or_resume(location, job)

    with local_cluster(2) as client:

        def map_all():
            tasks = iter([Task(map_tile, number) for number in range(store.tiling.tiles)])
            return list(
                Driver(client).run_tasks((location, store.digest), lambda: next(tasks, None), threading.Event())
            )

        map_all()
        assert len(benchmark.pedantic(map_all, rounds=3)) == store.tiling.tiles
    benchmark.extra_info["milliseconds_per_tile"] = 1e3 * benchmark.stats.stats.min / store.tiling.tiles
