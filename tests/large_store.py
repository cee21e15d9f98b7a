"""Stores of large basins that nobody has computed: labels follow from the number of a cell, and only some are there."""

from itertools import product

import numpy as np
from zarr.storage import LocalStore

from rattle_kernels import CellGrid
from tests.worker.basins.made_up import CHAOS, QUIET, RATTLE
from worker.jobs.basin_job import BasinJob
from worker.storage.folder import _Folder
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState
from worker.stores.pyramid import LABELS
from worker.stores.solution_table import SolutionTable, motion_of

LARGE = BasinJob(grid=CellGrid(time_cells=100_000, velocity_cells=100_000))
"""1e10 cells."""
_FACTORS = {"group": (3, 5, 101), "period": (7, 1, 13), "step": (11, 2, 997), "solution": (1, 2, 3)}


def label(name, rows, columns):
    """Label of cells by their numbers in the basin."""
    down, across, most = _FACTORS[name]
    return (down * rows[:, None] + across * columns) % most


def fill(store, level, tiles):
    """Write the labels of some tiles of a level."""
    for number in tiles:
        tile = level.tiling.tile(number)
        rows, columns = (np.arange(*side) * level.every for side in (tile.rows, tile.columns))
        values = [label(each.name, rows, columns).astype(each.dtype) for each in LABELS]
        store.tiles.write(level.labels, tile, values)


def tiles_of(level, rows, columns):
    """Numbers of the tiles of a level that hold some of the basin's cells."""
    tiling = level.tiling
    sides = zip((rows, columns), (tiling.tile_rows, tiling.tile_columns), strict=True)
    down, across = (range(a // level.every // side, (b - 1) // level.every // side + 1) for (a, b), side in sides)
    return [row * tiling.shape[1] + column for row, column in product(down, across)]


def finish(store):
    """Mark a store complete, with three made-up motions."""
    table = SolutionTable.empty(store.job)
    numbers = [table.append(motion_of(attractor)) for attractor in (QUIET, RATTLE, CHAOS)]
    table.enter(0, numbers, (QUIET, RATTLE, CHAOS), np.full(3, 1 / 3))
    store.solutions.make_room(table, 1)
    store.solutions.write(table)
    store.solutions.write_points(0, numbers, (QUIET, RATTLE, CHAOS))
    store.write_ledger(np.full(store.tiling.tiles, TileState.ASSEMBLED))
    store.finish({})


def large_store(location):
    """The store of `LARGE`, complete, of whose labels only those of the two last levels are there."""
    store = BasinStore.create_or_resume(str(location), LARGE)
    for level in store.levels[-2:]:
        fill(store, level, range(level.tiling.tiles))
    finish(store)
    return store


class ChunksRead:
    """Counts the chunks that are read from folders, by array: by Zarr, and whole tiles."""

    def __init__(self, monkeypatch):
        self.arrays = []
        get, read = LocalStore.get, _Folder.read

        async def counted_get(store, key, *arguments, **options):
            self._count(key)
            return await get(store, key, *arguments, **options)

        def counted_read(folder, path, part):
            self._count(path)
            return read(folder, path, part)

        monkeypatch.setattr(LocalStore, "get", counted_get)
        monkeypatch.setattr(_Folder, "read", counted_read)

    def _count(self, path):
        array, is_chunk, _ = path.rpartition("/c/")
        if is_chunk:
            self.arrays.append(array)

    @property
    def of_cells(self):
        """How many of them hold labels of cells."""
        return sum(array.split("/")[-1] in _FACTORS and not array.startswith("assembly") for array in self.arrays)
