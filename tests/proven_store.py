"""A store with a proof, for tests that only look at one: its arrays and its certificate, as told."""

import numpy as np

from worker.stores import proof_layout
from worker.stores.basin_store import BasinStore
from worker.stores.new_store import consolidate, create_array

CERTIFICATE = {
    "levels": 1, "quiet": 0.09, "rattling": None,
    "discs": [{"motion": 1, "impacts": 1, "t": 0.5, "v": 3.5, "frame": [1.0, 0.0, 0.0, 0.5], "radius": 0.05}],
}  # fmt: skip


def lay_proof(location, proven, reason, certificate=CERTIFICATE):
    """Add a proof to a store of one basin; cells of 255 have not been tried."""
    store = BasinStore(location)
    tile = store.tiling.tile_rows, store.tiling.tile_columns
    for variable, values in ((proof_layout.PROVEN, proven), (proof_layout.UNPROVEN_REASON, reason)):
        array = create_array(store._group, store.job, variable, store.job.grid.shape, tile)
        array[...] = np.asarray(values, np.uint8)
    store._group.create_group("proof", attributes=certificate)
    consolidate(location)
    return BasinStore(location)
