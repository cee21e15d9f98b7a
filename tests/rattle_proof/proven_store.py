"""A store with a proof, for tests that only look at one: its arrays and its certificate, as told."""

import numpy as np

from rattle_proof import layout as proof_layout
from worker.stores.basin_store import BasinStore
from worker.stores.layout import NOT_THERE
from worker.stores.new_store import consolidate, create_array

CERTIFICATE = {
    "levels": 1, "quiet": 0.09, "rattling": None,
    "discs": [{"motion": 1, "impacts": 1, "t": 0.5, "v": 3.5, "frame": [1.0, 0.0, 0.0, 0.5], "radius": 0.05}],
}  # fmt: skip


def lay_proof(location, proven, reason, certificate=CERTIFICATE):
    """Add a proof to a store of one basin; tiles that hold a 255 have not been tried."""
    store = BasinStore(location)
    shape = store.tiling.tile_rows, store.tiling.tile_columns
    never_quiet = np.where(np.asarray(proven) == NOT_THERE, NOT_THERE, 0)
    variables = proof_layout.PROVEN, proof_layout.NEVER_QUIET, proof_layout.UNPROVEN_REASON
    for variable, values in zip(variables, (proven, never_quiet, reason), strict=True):
        create_array(store._group, store.job, variable, store.job.grid.shape, shape)
        for tile in map(store.tiling.tile, store.tiling.numbers_of(0)):
            cells = np.asarray(values, np.uint8)[slice(*tile.rows), slice(*tile.columns)]
            if (cells != NOT_THERE).all():
                store.tiles.write((variable,), tile, (cells,))
    store._group.create_group("proof", attributes=certificate)
    consolidate(location)
    return BasinStore(location)
