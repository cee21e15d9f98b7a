"""Tiles that take long go first; the order changes nothing in the store."""

import numpy as np
import pytest

from rattle_kernels import CellGrid, map_cells
from worker.basins.basin_run import BasinRun
from worker.basins.tasks import map_tile, survey_tile, weigh_tiles
from worker.basins.weights import worth_weighing
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter
from worker.stores.basin_store import BasinStore

_GRID = CellGrid(time_cells=260, velocity_cells=260)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return _store(tmp_path_factory, BasinJob(grid=_GRID))


def _store(folders, job):
    return BasinStore.create_or_resume(str(folders.mktemp("weights") / "basin.zarr"), job)


def test_a_weight_is_what_the_tile_takes(store):
    weights = weigh_tiles(store.location, store.digest, 0, range(16))
    assert len(weights) == store.tiling.tiles == 16
    takes = []
    for number in range(16):
        tile = store.tiling.tile(number)
        takes.append(map_cells(store.job.oscillator_of(0), _GRID, 1499, tile.rows, tile.columns).applications)
    parts = np.array(weights) / sum(weights), np.array(takes) / sum(takes)
    # A cell takes 1499 at the most, four times the mean, so the mean of 64 errs by 2/8 of the mean part at the most.
    assert np.abs(parts[0] - parts[1]).max() < 4 * 0.25 / 16


def test_the_uppermost_tiles_go_first_and_then_the_longest(store):
    weigh, *first = BasinRun(store, 0, frozenset(), numbered=True).begin()
    assert weigh.function is weigh_tiles
    assert [(task.function, task.number) for task in first] == [(map_tile, number) for number in (15, 14, 13, 12)]
    assert weigh.arguments == (list(range(11, -1, -1)),)
    rest = [task.number for task in weigh.then(0, [10, 11, 0, 4, 6, 7, 8, 9, 2, 3, 1, 5])]
    assert rest == [10, 11, 4, 5, 6, 7, 0, 8, 2, 3, 1, 9]


def test_tiles_in_the_store_are_not_weighed(store):
    weigh, *others = BasinRun(store, 0, frozenset({14, 3, 2, 1}), numbered=True).begin()
    assert weigh.arguments == ([11, 10, 9, 8, 7, 6, 5, 4, 0],)
    assert [(task.function, task.number) for task in others] == [
        (map_tile, 15), (survey_tile, 14), (map_tile, 13), (map_tile, 12),
        (survey_tile, 3), (survey_tile, 2), (survey_tile, 1),
    ]  # fmt: skip
    all_of_them = BasinRun(store, 0, frozenset(range(16)), numbered=True).begin()
    assert [(task.function, task.number) for task in all_of_them] == [(survey_tile, tile) for tile in range(15, -1, -1)]


@pytest.mark.parametrize(
    "job",
    [
        BasinJob(grid=_GRID, iterations=1),
        BasinJob(grid=CellGrid(time_cells=64, velocity_cells=64)),
        SweepJob(sample=Sample(points=200_000), vary=(SweptParameter("damping", (0.6, 0.61)),)),
        SweepJob(grid=_GRID, vary=(SweptParameter("damping", (0.6, 0.61)),)),
    ],
    ids=["tiles alike", "one tile", "points", "others wait"],
)
def test_the_order_does_not_matter(tmp_path_factory, job):
    tiling = _store(tmp_path_factory, job).tiling
    assert not worth_weighing(job, tiling.tiles_of_basin)
