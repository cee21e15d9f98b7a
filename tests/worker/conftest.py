"""A store that no cluster has computed."""

import numpy as np
import pytest

from rattle_kernels import CellGrid
from tests.worker.basins.made_up import CHAOS, QUIET, RATTLE
from worker.jobs.basin_job import BasinJob
from worker.stores.basin_store import BasinStore
from worker.stores.layout import LABELLED, SOLUTION, TileState
from worker.stores.solution_table import SolutionTable, motion_of


@pytest.fixture
def store(tmp_path):
    """Made-up basin: lower half quiet, upper left P(1,1,0), upper right chaotic, in four tiles."""
    grid = CellGrid(time_cells=128, velocity_cells=128)
    store = BasinStore.create_or_resume(str(tmp_path / "made_up.zarr"), BasinJob(grid=grid, iterations=1))
    solution = np.zeros(grid.shape, np.int16)
    solution[64:, :64], solution[64:, 64:] = 1, 2
    group = np.where(solution == 2, np.arange(128) % 5, solution)
    for number in range(store.tiling.tiles):
        tile = store.tiling.tile(number)
        inside = slice(*tile.rows), slice(*tile.columns)
        labels = group[inside], group[inside], group[inside], solution[inside]
        store.tiles.write((*LABELLED, SOLUTION), tile, labels)
    table = SolutionTable.empty(store.job)
    numbers = [table.append(motion_of(attractor)) for attractor in (QUIET, RATTLE, CHAOS)]
    table.enter(0, numbers, (QUIET, RATTLE, CHAOS), np.array([0.5, 0.25, 0.25]))
    store.solutions.make_room(table, 1)
    store.solutions.write(table)
    store.solutions.write_points(0, numbers, (QUIET, RATTLE, CHAOS))
    store.write_ledger(np.full(store.tiling.tiles, TileState.ASSEMBLED))
    return store
