"""Assembly scales with the image set, not with the grid.

Under ``P^k`` with a large k all cells are sent into few. Let R be the set of distinct image cells: it is closed under
the map and holds every cycle. So the tiles report their images, the map is read on R alone, Hsu's algorithm runs on R
in memory, and then every tile labels its own cells by look-up. No array is ever whole in one memory.
"""

from collections.abc import Sequence

import numpy as np

from rattle_kernels import (
    Attractor,
    CellGroups,
    ImageSet,
    coarser_boxes,
    find_attractors,
    find_groups,
    has_members,
    place_images,
    unite,
)
from worker.layout import MAPPED
from worker.store import BasinStore
from worker.tasks import MapReceipt

_IMAGE_CELL = MAPPED[:1]
# Every scout is followed for some thousand impacts by the driver alone: a quarter of a second for this many.
_MOST_SCOUTS = 4096


def places_of_images(store: BasinStore, members: ImageSet) -> np.ndarray:
    """Where each member's image stands, read tile by tile: only tiles that hold members are opened."""
    place = np.empty(members.size, np.int32)
    time_cells = store.job.grid.time_cells
    for number in range(store.tiling.tiles):
        tile = store.tiling.tile(number)
        if has_members(members, tile.rows, tile.columns, time_cells):
            (tile_images,) = store.read_tile(_IMAGE_CELL, tile)
            place_images(members, (tile.rows[0], tile.columns[0]), time_cells, tile_images, place)
    return place


def assemble_groups(store: BasinStore, receipts: Sequence[MapReceipt]) -> CellGroups:
    """Hsu's group, period and step on the image set."""
    members = unite(store.job.grid.cells, [receipt.image_set for receipt in receipts])
    return find_groups(members, places_of_images(store, members))


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
