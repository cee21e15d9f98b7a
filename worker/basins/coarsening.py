"""The levels of a large basin, one after another, once its labels are final: each is read from the one before."""

from collections.abc import Iterable
from functools import partial

from worker.cluster.calls import Task, stop_if_cancelled
from worker.stores.basin_store import BasinStore
from worker.stores.pyramid import LABELS


def coarsen_tile(location: str, digest: str, number: int, level: int) -> None:
    """Write one tile of a level: every second cell, each way, of the level before."""
    store = BasinStore.open(location, digest)
    finer, coarser = store.levels[level - 1], store.levels[level]
    tile = coarser.tiling.tile(number)
    cells = zip((tile.rows, tile.columns), finer.tiling.grid.shape, strict=True)
    rows, columns = ((2 * start, min(2 * stop, most)) for (start, stop), most in cells)
    for variable in LABELS:  # one at a time, to take less memory
        stop_if_cancelled()
        values = store.tiles.read_cells(finer.own(variable), tile.basin, rows, columns, every=2)
        store.tiles.write((coarser.own(variable),), tile, (values,))


class Coarsening:
    """The tasks that write a basin's levels.

    Parameters
    ----------
    store : BasinStore
    basin : int
    """

    def __init__(self, store: BasinStore, basin: int) -> None:
        self._levels, self._basin = store.levels, basin
        self._level = self._tiles_left = 0

    @property
    def done(self) -> bool:
        """Whether all levels are there."""
        return self._tiles_left == 0 and self._level == len(self._levels) - 1

    def begin(self) -> list[Task]:
        """Tasks of the first level; none if the basin has no levels."""
        return [] if self.done else self._next_level()

    def _next_level(self) -> list[Task]:
        self._level += 1
        tiles = self._levels[self._level].tiling.numbers_of(self._basin)
        self._tiles_left = len(tiles)
        task = partial(Task, arguments=(self._level,), then=self._take, priority=self._basin)
        return [task(coarsen_tile, tile) for tile in tiles]

    def _take(self, tile: int, receipt: None) -> Iterable[Task]:
        self._tiles_left -= 1
        return [] if self._tiles_left or self.done else self._next_level()
