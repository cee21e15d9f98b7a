"""The chunks that a store of basins must have, from what its ledger says of each tile."""

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from rattle_kernels import AttractorKind
from worker.additions import additions
from worker.errors import Damaged, StoreConflict
from worker.storage.checked_chunks import METADATA
from worker.stores import layout
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState, Variable
from worker.stores.new_store import ATTRACTORS_A_CHUNK
from worker.stores.solution_table import WITHOUT_POINTS, SolutionTable

NEXT_STEP = f"put back a copy of its {METADATA}, or remove the store and compute it anew"
"""Where nothing tells any more what a store holds."""

Chunk = tuple[str, tuple[int, ...]]
"""Path of an array, and numbers of a chunk along each dimension."""


def expected_chunks(location: str, arrays: dict[str, Any]) -> Iterator[Chunk]:
    """Chunks that must be there. Arrays whose length is found while computing are left out beyond their first chunk.

    Parameters
    ----------
    location : str
    arrays : dict of str to zarr.Array
        Of the store, by path.

    Raises
    ------
    StoreConflict
        If its request is not the one that they were made for.
    """
    store = BasinStore(location, as_found=True)
    for variable, own in store.own_shapes():
        if variable.path in arrays and arrays[variable.path].shape != own:
            raise StoreConflict(f"{location} has lost its request: {variable.path} was made for another; {NEXT_STEP}")
    places = store.places
    states = readable_ledger(store)
    swept = [swept.parameter for swept in store.job.vary]
    whole = [variable.path for variable in (places.ledger, *places.coordinates, layout.IMAGE_COUNTS)]
    sample = store.job.sample
    tables = [
        *layout.MOTIONS,
        *layout.measured(sample.scramblings if sample else None),
        *(layout.CHANGES if store.job.vary else ()),
    ]
    whole += [variable.path for variable in tables if store.complete]
    whole += [variable.path for level in store.levels[1:] for variable in level.coordinates]
    swept = [level.own_path(name) for level in store.levels for name in swept]
    for path in (*whole, *swept):
        if path in arrays and arrays[path].size:
            yield from ((path, chunk) for chunk in product(*map(range, arrays[path].cdata_shape)))
    shape = arrays[places.ledger.path].shape
    for number, state in enumerate(states.tolist()):
        tile = tuple(int(index) for index in np.unravel_index(number, shape))
        yield from ((variable.path, tile) for variable in _of_tile(store, number, state))
    for addition in additions():
        yield from addition.expected_chunks(store, arrays)
    assembled = (states.reshape(-1, store.tiling.tiles_of_basin) == TileState.ASSEMBLED).all(axis=1)
    table = _readable_table(store)
    for basin in np.flatnonzero(assembled).tolist():
        yield from _of_basin(store, basin, table)
        if layout.ENDS.path in arrays:
            yield from _of_ends(store, basin, table)
        if store.complete or table.complete[basin]:
            yield from _of_levels(store, basin)


def readable_ledger(store: BasinStore) -> np.ndarray:
    """State of each tile; of a ledger that cannot be read what a store that is complete would say."""
    try:
        states = store.read_ledger()
        return np.where(states == 0, _unreadable(store), states)
    except Damaged:
        return np.full(store.tiling.tiles, _unreadable(store), np.uint8)


def _unreadable(store: BasinStore) -> TileState:
    return TileState.ASSEMBLED if store.complete else TileState.PENDING


def _of_tile(store: BasinStore, number: int, state: int) -> list[Variable]:
    places, basin = store.places, number // store.tiling.tiles_of_basin
    needed: list[Variable] = []
    if state >= TileState.COMPUTED:
        needed += places.mapped
    if state == TileState.ASSEMBLED:
        needed += (*places.labelled, places.solution)
        needed += (places.own_solution,) if basin else ()  # the first basin's own numbers are those of all
    return needed


def _readable_table(store: BasinStore) -> SolutionTable:
    """The table of solutions; an empty one if it cannot be read, as all is written anew then."""
    try:
        return store.solutions.read()
    except Damaged:
        return SolutionTable.empty(store.job)


def _of_basin(store: BasinStore, basin: int, table: SolutionTable) -> Iterator[Chunk]:
    place = store.job.place_of(basin)
    with_points = [number for number in table.numbers_in(basin) if table.motions[number].kind not in WITHOUT_POINTS]
    for row in sorted({number // ATTRACTORS_A_CHUNK for number in with_points}):
        yield from ((variable.path, (*place, row, 0)) for variable in layout.POINTS)
    if store.job.sample is None:
        labels = layout.IMAGE_SET[:2] if _has_images(store, basin) else ()
        found = (layout.GRAZING, layout.IMAGE_WORDS, layout.IMAGE_SET[2], *labels)
        yield from ((variable.path, (*place, 0)) for variable in found)


def _of_ends(store: BasinStore, basin: int, table: SolutionTable) -> Iterator[Chunk]:
    """Chunks that say what the chaotic transients of a basin end in: written up to its highest number each way."""
    numbers = table.numbers_in(basin)
    if any(table.motions[number].kind == AttractorKind.CHAOTIC_TRANSIENT for number in numbers):
        chunks = range(max(numbers) // ATTRACTORS_A_CHUNK + 1)
        yield from ((layout.ENDS.path, (*store.job.place_of(basin), *chunk)) for chunk in product(chunks, chunks))


def _of_levels(store: BasinStore, basin: int) -> Iterator[Chunk]:
    place = store.job.place_of(basin)
    for level in store.levels[1:]:
        for variable, tile in product(level.labels, np.ndindex(level.tiling.shape)):
            yield variable.path, (*place, *tile)


def _has_images(store: BasinStore, basin: int) -> bool:
    """Whether any image lies in the window, so that there are groups to look up."""
    try:
        return bool(store.read_image_words(basin).size)
    except Damaged:
        return True
