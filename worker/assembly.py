"""Assembly scales with the image set, not with the grid.

Under ``P^k`` with a large k all cells are sent into few. Let R be the set of distinct image cells: it is closed under
the map and holds every cycle. So the tiles report their images, the map is read on R alone, Hsu's algorithm runs on R
in memory, and then every tile labels its own cells by look-up. No array is ever whole in one memory.
"""

from collections.abc import Sequence

import numpy as np

from rattle_kernels import Attractor, CellGroups, coarser_boxes, find_attractors, find_groups
from worker.layout import MAPPED
from worker.store import BasinStore
from worker.tasks import MapReceipt

_IMAGE_CELL = MAPPED[:1]
# Every scout is followed for some thousand impacts by the driver alone: a quarter of a second for this many.
_MOST_SCOUTS = 4096


def image_set(receipts: Sequence[MapReceipt]) -> np.ndarray:
    """R, the distinct image cells of the whole map, ascending."""
    return np.unique(np.concatenate([receipt.image_set for receipt in receipts]))


def images_of(store: BasinStore, cells: np.ndarray) -> np.ndarray:
    """Images of some cells, read tile by tile: only tiles that hold one of them are opened."""
    grid, tiling = store.job.grid, store.tiling
    i_v, i_t = np.divmod(cells, grid.time_cells)
    tile_of = (i_v // tiling.tile_rows) * tiling.shape[1] + i_t // tiling.tile_columns
    images = np.empty_like(cells)
    for number in np.unique(tile_of):
        tile = tiling.tile(int(number))
        inside = tile_of == number
        (tile_images,) = store.read_tile(_IMAGE_CELL, tile)
        images[inside] = tile_images[i_v[inside] - tile.rows[0], i_t[inside] - tile.columns[0]]
    return images


def assemble_groups(store: BasinStore, receipts: Sequence[MapReceipt]) -> CellGroups:
    """Hsu's group, period and step on the image set."""
    cells = image_set(receipts)
    return find_groups(cells, images_of(store, cells))


def assemble_attractors(store: BasinStore, receipts: Sequence[MapReceipt]) -> tuple[Attractor, ...]:
    """Catalogue of the motions that the tiles' scouts end in."""
    boxes = np.concatenate([receipt.scout_box for receipt in receipts])
    times = np.concatenate([receipt.scout_time for receipt in receipts])
    velocities = np.concatenate([receipt.scout_velocity for receipt in receipts])
    first = _one_of_each_box(boxes)
    return find_attractors(store.job.oscillator, times[first], velocities[first])


def _one_of_each_box(boxes: np.ndarray) -> np.ndarray:
    """Index of the first scout of each box, of boxes so coarse that a few thousand scouts are left.

    Receipts come in the order of tiles, so the first is the same whenever its tile was computed. What a thinned crowd
    of scouts misses, landing points that arrive nowhere report when they are named.
    """
    _, first = np.unique(boxes, return_index=True)
    while first.size > _MOST_SCOUTS:
        boxes = coarser_boxes(boxes)
        _, first = np.unique(boxes, return_index=True)
    return first
