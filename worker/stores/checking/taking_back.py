"""A damaged store becomes an unfinished one: the same job then computes anew what it lacks, to the same bytes."""

import numpy as np

from worker.additions import additions
from worker.errors import as_store_failure
from worker.storage.checked_chunks import METADATA
from worker.storage.location import storage_at
from worker.stores import layout
from worker.stores.analysis_store import PARTS, AnalysisStore, kind_of_store
from worker.stores.basin_store import BasinStore
from worker.stores.checking.damage import Damage, Findings, check_store
from worker.stores.checking.expected import readable_ledger
from worker.stores.checking.metadata import restore_metadata
from worker.stores.layout import TileState
from worker.stores.opening import demand_all_known


def take_back(found: Findings) -> None:
    """Remove the damaged files of a store, and everything that the ledger says of them.

    Tiles whose images are damaged are computed anew. So are the labels of all tiles of their basins, and those of the
    basins after them, which take their numbers from the ones before. Everything else is kept.

    Parameters
    ----------
    found : Findings
        With damages. If it is interrupted, the next check finds what is left to do.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    demand_all_known(found.location, found.job.unread)
    restored = [damage.array for damage in found.damages if damage.restored and damage.array]
    restore_metadata(found.location, found.root, found.metadata, restored)
    if found.root.damaged:
        found = check_store(found.location)  # what was missing is seen only now
        if not found.damages:
            return
    if kind_of_store(found.location) != "basin":
        if found.complete:
            AnalysisStore(found.location).take_back()
        _discard(found)
        return
    store = BasinStore(found.location)
    states = readable_ledger(store)
    tiles = {damage: tile for damage in found.damages if (tile := _tile_of(store, damage)) is not None}
    mapped = {variable.path for variable in store.places.mapped}
    lost = [tile for damage, tile in tiles.items() if damage.array in mapped]
    first = min((_first_basin(store, damage, tiles.get(damage)) for damage in found.damages), default=0)
    states[first * store.tiling.tiles_of_basin :] = np.minimum(
        states[first * store.tiling.tiles_of_basin :], TileState.COMPUTED
    )
    states[lost] = TileState.PENDING
    _discard(found)
    for addition in additions():
        addition.take_back(store, [damage.array for damage in found.damages if addition.owns(damage.array)])
    store.take_back(states, tables=any(_is_table(store, damage) for damage in found.damages))


def _discard(found: Findings) -> None:
    """Remove the damaged chunks, and of parts what marks them complete."""
    chunks = [damage for damage in found.damages if damage.chunk]
    parts = {damage.array.split("/")[1] for damage in chunks if damage.array.startswith(f"{PARTS}/")}
    marks = [f"{PARTS}/{name}/{METADATA}" for name in sorted(parts)]
    with as_store_failure(found.location):
        storage_at(found.location).discard([*marks, *(damage.path for damage in chunks)])


def _tile_of(store: BasinStore, damage: Damage) -> int | None:
    """Number of the tile of a damaged chunk; None if it is none of a tile."""
    places = store.places
    of_tiles = {variable.path for variable in (*places.mapped, *places.labelled, places.solution, places.own_solution)}
    if damage.array not in of_tiles or not damage.chunk:
        return None
    shape = store.tiling.shape[1:] if store.job.sample else store.tiling.shape
    return int(np.ravel_multi_index(damage.chunk, (*store.job.sweep_shape, *shape)))


def _first_basin(store: BasinStore, damage: Damage, tile: int | None) -> int:
    """The first basin that has to be assembled anew; the number of basins if none has to."""
    if tile is not None:
        return tile // store.tiling.tiles_of_basin
    levels = store.levels[1:]
    of_basins = {variable.path for variable in (layout.GRAZING, layout.IMAGE_WORDS, *layout.IMAGE_SET)}
    of_basins |= {variable.path for variable in (*layout.POINTS, layout.ENDS)}
    of_basins |= {variable.path for level in levels for variable in level.labels}
    if damage.array in of_basins and damage.chunk:
        place = damage.chunk[: len(store.job.vary)]
        return int(np.ravel_multi_index(place, store.job.sweep_shape)) if place else 0
    by_request = {variable.path for variable in (*store.places.coordinates, *layout.CHANGES)}
    by_request |= {variable.path for level in levels for variable in level.coordinates}
    by_request |= {level.own_path(swept.parameter) for level in store.levels for swept in store.job.vary}
    apart = damage.array in by_request or any(addition.owns(damage.array) for addition in additions())
    return store.job.basins if apart or not damage.chunk else 0


def _is_table(store: BasinStore, damage: Damage) -> bool:
    tables = {variable.path for variable in (*layout.MOTIONS, *layout.measured(1), layout.IMAGE_COUNTS)}
    return bool(damage.chunk) and (damage.array in tables or damage.array == store.places.ledger.path)
