"""Assembly scales with the image set, not with the grid.

For large k, ``P^k`` sends all cells into few. Let R be the set of distinct image cells. It is closed under the map and
contains every cycle. So tiles report their images, the map is read on R alone, and Hsu's algorithm runs on R in memory.
Then every tile labels its own cells by look-up. No process ever holds an array of all cells.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from rattle_kernels import CellGroups, find_groups
from rattle_kernels.basins.tiles import Tile
from rattle_kernels.cell_mapping.image_set import ImageSet, has_members, place_images
from worker.stores.basin_store import BasinStore
from worker.stores.layout import MAPPED

_IMAGE_CELL = MAPPED[:1]
# Chunks are decoded without the GIL, and other workers may wait for this one. Three keep two cores busy.
_READERS = 3


def _tiles_with_members(store: BasinStore, basin: int, members: ImageSet) -> list[Tile]:
    tiles = map(store.tiling.tile, store.tiling.numbers_of(basin))
    return [tile for tile in tiles if has_members(members, tile.rows, tile.columns, store.job.grid.time_cells)]


def places_of_images(
    store: BasinStore, basin: int, members: ImageSet, pause: Callable[[], None] = lambda: None
) -> np.ndarray:
    """Index of each member's image. Only tiles that hold members are read; `pause` is called after each."""
    place = np.empty(members.size, np.int32)

    def place_tile(tile: Tile) -> None:
        (images,) = store.tiles.read(_IMAGE_CELL, tile)
        place_images(members, (tile.rows[0], tile.columns[0]), store.job.grid.time_cells, images, place)

    readers = ThreadPoolExecutor(_READERS)
    try:
        for _ in readers.map(place_tile, _tiles_with_members(store, basin, members)):
            pause()
    finally:
        readers.shutdown(cancel_futures=True)
    return place


@dataclass(frozen=True)
class _Source:
    """Where groups come from: found in this process, or else read from a store. No part of a cache's key."""

    store: BasinStore = field(compare=False)
    found: CellGroups | None = field(default=None, compare=False)


@lru_cache(maxsize=4)
def _kept_groups(location: str, digest: str, basin: int, source: _Source) -> CellGroups:
    return source.found or source.store.read_groups(basin)


def groups_of(store: BasinStore, basin: int) -> CellGroups:
    """Hsu's numbers on a basin's image set, once they have been assembled.

    Reading them costs more than labelling a tile, and takes as much memory as finding them. So each process reads them
    once, and the one that has found them does not.
    """
    return _kept_groups(store.location, store.digest, basin, _Source(store))


def assemble_groups(store: BasinStore, basin: int, pause: Callable[[], None] = lambda: None) -> CellGroups:
    """Find Hsu's group, period and step on a basin's image set, write and keep them for its tiles.

    `pause` is called between reads and may raise to stop.
    """
    members = store.read_image_words(basin)
    groups = find_groups(members, places_of_images(store, basin, members, pause))
    store.write_groups(basin, groups)
    _kept_groups(store.location, store.digest, basin, _Source(store, groups))
    return groups
