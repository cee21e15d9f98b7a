"""Assembly scales with the image set, not with the grid.

For large k, ``P^k`` sends all cells into few. Let R be the set of distinct image cells. It is closed under the map and
contains every cycle. So tiles report their images, the map is read on R alone, and Hsu's algorithm runs on R in memory.
Then every tile labels its own cells by look-up. No process ever holds an array of all cells.
"""

from collections.abc import Callable, Iterable

import numpy as np

from rattle_kernels import CellGroups, find_groups
from rattle_kernels.cell_mapping.image_set import ImageSet, has_members, place_images
from worker.stores.basin_store import BasinStore
from worker.stores.layout import MAPPED
from worker.stores.tiles import Tile

_IMAGE_CELL = MAPPED[:1]


def places_of_images(store: BasinStore, members: ImageSet, tiles: Iterable[Tile]) -> np.ndarray:
    """Index of each member's image, read row by row of tiles. Only rows that hold members are opened."""
    place = np.empty(members.size, np.int32)
    time_cells = store.job.grid.time_cells
    for tile in tiles:
        if has_members(members, tile.rows, tile.columns, time_cells):
            (tile_images,) = store.read_tile(_IMAGE_CELL, tile)
            place_images(members, (tile.rows[0], tile.columns[0]), time_cells, tile_images, place)
    return place


def assemble_groups(store: BasinStore, basin: int, pause: Callable[[], None] = lambda: None) -> CellGroups:
    """Hsu's group, period and step on a basin's image set. `pause` is called between reads and may raise to stop."""
    members = store.read_image_words(basin)

    def rows() -> Iterable[Tile]:
        for row in store.tiling.rows_of(basin):
            pause()
            yield row

    return find_groups(members, places_of_images(store, members, rows()))
