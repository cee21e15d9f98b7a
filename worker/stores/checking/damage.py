"""What is damaged or missing in a store of any kind: every file is read, and what is found is computed anew."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, product
from typing import Any

import numpy as np

from rattle_kernels import AttractorKind
from worker.additions import additions
from worker.errors import Damaged, DamagedChunk, StoreConflict, UnknownKind, as_store_failure
from worker.jobs.job import Job
from worker.kinds import KINDS, kind_of
from worker.storage.checked_chunks import CHUNKS, METADATA, SOME_CHUNKS
from worker.storage.location import storage_at
from worker.stores import layout
from worker.stores.analysis_store import PARTS, AnalysisStore, kind_of_store
from worker.stores.basin_store import BasinStore
from worker.stores.checking.metadata import (
    COPY_IS_WRONG,
    ROOT_IS_WRONG,
    Metadata,
    Root,
    array_of,
    read_root,
    restore_metadata,
    right_metadata,
)
from worker.stores.layout import TileState
from worker.stores.new_store import ATTRACTORS_A_CHUNK
from worker.stores.opening import demand_all_known, open_group
from worker.stores.solution_table import WITHOUT_POINTS, SolutionTable

_NEXT_STEP = f"put back a copy of its {METADATA}, or remove the store and compute it anew"
"""Where nothing tells any more what a store holds."""
Chunk = tuple[str, tuple[int, ...]]
"""Path of an array, and numbers of a chunk along each dimension."""
Report = Callable[[int, int], None]
"""Called with the number of files that have been read, and of all."""


@dataclass(frozen=True)
class Damage:
    """A file of a store that is damaged or missing.

    Parameters
    ----------
    array : str
        Path of the array; empty for the root's own metadata.
    chunk : tuple of int
        Numbers of the chunk along each dimension: one tile is one chunk. Empty for metadata.
    what : str
        What is wrong with it, in words.
    """

    array: str
    chunk: tuple[int, ...]
    what: str

    @property
    def path(self) -> str:
        """Path of the file within the store."""
        if not self.chunk:
            return f"{self.array}/{METADATA}".removeprefix("/")
        return "/".join([self.array, CHUNKS, *map(str, self.chunk)])

    def __str__(self) -> str:
        tile = "/".join(map(str, self.chunk))
        array = self.array or "the store itself"
        return f"{array}, tile {tile}: {self.what}" if tile else f"{array}, metadata: {self.what}"


@dataclass(frozen=True)
class Findings:
    """What a check of a store has found.

    Parameters
    ----------
    location : str
    job : Job
        What the store holds, or is to hold.
    complete : bool
        Whether the job had finished.
    files : int
        Files that were read.
    damages : tuple of Damage
        While the root is damaged, chunks that are missing are not among them.
    root : Root
    metadata : Metadata
    """

    location: str
    job: Job
    complete: bool
    files: int
    damages: tuple[Damage, ...]
    root: Root
    metadata: Metadata


def check_store(location: str, report: Report = lambda done, total: None) -> Findings:
    """Read every file of a store.

    Parameters
    ----------
    location : str
        As in `worker.storage.location`.
    report : callable

    Returns
    -------
    Findings

    Raises
    ------
    StoreConflict
        If there is no store, or its request is lost.
    StoreFailed
        If it cannot be read, or its metadata are damaged so far that nothing says what it holds.
    """
    root = read_root(location)
    with as_store_failure(location):
        paths = storage_at(location).paths()
    kind = str(root.attributes.get("kind", "basin"))
    job, complete = _job_of(location, kind, root.attributes), bool(root.attributes["complete"])
    metadata = right_metadata(location, job, root, paths)
    damages = [Damage("", (), ROOT_IS_WRONG if root.damaged else COPY_IS_WRONG)]
    damages = damages if root.damaged or metadata.copy_is_wrong else []
    damages += [Damage(path, (), what) for path, what in metadata.lost.items()]
    arrays = {
        path: array_of(location, path, node) for path, node in metadata.nodes.items() if node["node_type"] == "array"
    }
    if not root.damaged:
        arrays |= _arrays_of_parts(location, paths)
    chunks = [chunk for path in paths if (chunk := _chunk_of(path)) is not None and _has_place(arrays, *chunk)]
    for done, (array, numbers) in enumerate(chunks):
        report(done, len(chunks))
        if what := _damage_of(arrays[array], numbers):
            damages.append(Damage(array, numbers, what))
    if not root.damaged:
        there = set(chunks)
        expected = _of_basins(location, arrays) if kind == "basin" else chain(*map(_all_chunks, arrays.items()))
        damages += [Damage(*chunk, "it is missing") for chunk in expected if chunk not in there]
    report(len(chunks), len(chunks))
    return Findings(location, job, complete, len(paths), tuple(damages), root, metadata)


def _has_place(arrays: dict[str, Any], array: str, chunk: tuple[int, ...]) -> bool:
    """Whether an array has such a chunk. Another file with the name of one is none of the store."""
    if array not in arrays:
        return False
    shape = arrays[array].cdata_shape
    return len(chunk) == len(shape) and all(number < most for number, most in zip(chunk, shape, strict=True))


def _arrays_of_parts(location: str, paths: list[str]) -> dict[str, Any]:
    """Arrays of the parts that an unfinished analysis has completed. Its root does not list them."""
    files = [path for path in paths if path.startswith(f"{PARTS}/") and path.endswith(f"/{METADATA}")]
    if not files:
        return {}
    names = set(AnalysisStore(location).parts())
    with as_store_failure(location):
        root = open_group(location, "r")
        arrays = [path.removesuffix(f"/{METADATA}") for path in files if path.count("/") == 3]
        return {array: root[array] for array in arrays if array.split("/")[1] in names}


def _job_of(location: str, kind: str, attributes: Any) -> Job:
    """The job of a store, if its request is what it was."""
    try:
        request = json.loads(str(attributes["request"]))
        kind = kind_of(request) if kind == "basin" else kind
        return KINDS[kind].job_class.trusted(request, attributes["request_sha256"])
    except UnknownKind as error:
        raise StoreConflict(f"{location}: {error}") from error
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise StoreConflict(
            f"{location} has lost its request, so nothing can be computed anew: {error}; {_NEXT_STEP}"
        ) from error


def _chunk_of(path: str) -> Chunk | None:
    """Array and numbers of a chunk by the path of its file; None for other files."""
    array, is_chunk, numbers = path.rpartition(f"/{CHUNKS}/")
    if not is_chunk or not all(number.isdigit() for number in numbers.split("/")):
        return None
    return array, tuple(map(int, numbers.split("/")))


def _damage_of(array: Any, chunk: tuple[int, ...]) -> str:
    """What is wrong with a chunk; nothing if it can be read."""
    try:
        array.get_block_selection(chunk)
    except DamagedChunk:
        return "its checksum is wrong"
    except FileNotFoundError:
        return "it is missing"
    except OSError:
        raise
    except Exception as error:  # of a store without checksums, or of another array: codecs raise whatever they like
        return f"it cannot be decoded: {error}"
    return ""


def _all_chunks(array: tuple[str, Any]) -> Iterator[Chunk]:
    """Every chunk of an array, which comes with its path."""
    path, own = array
    return ((path, chunk) for chunk in product(*map(range, own.cdata_shape)) if own.size)


def _of_basins(location: str, arrays: dict[str, Any]) -> Iterator[Chunk]:
    """Chunks that a store of basins must have, from what its ledger says of each tile.

    Arrays whose length is found while computing are left out beyond their first chunk. Of an unfinished store, so is
    what is written when a job ends.
    """
    store = BasinStore(location, as_found=True)
    for variable, own in store.own_shapes():
        if variable.path in arrays and arrays[variable.path].shape != own:
            raise StoreConflict(f"{location} has lost its request: {variable.path} was made for another; {_NEXT_STEP}")
    states, of_tiles, from_request = _readable_ledger(store), _states_of_tiles(store), _from_request(store)
    for path, array in arrays.items():
        if path in of_tiles:
            tiles = np.flatnonzero(states >= of_tiles[path])
            if path == store.places.own_solution.path:  # the first basin's own numbers are those of all
                tiles = tiles[tiles >= store.tiling.tiles_of_basin]
            numbers = (each.tolist() for each in np.unravel_index(tiles, store.ledger_shape))
            yield from ((path, chunk) for chunk in zip(*numbers, strict=True))
        elif path in from_request or (store.complete and not path.startswith(SOME_CHUNKS)):
            yield from _all_chunks((path, array))
    table = _readable_table(store)
    assembled = (states.reshape(-1, store.tiling.tiles_of_basin) == TileState.ASSEMBLED).all(axis=1)
    for basin in np.flatnonzero(assembled).tolist():
        yield from _of_basin(store, basin, table, ends=layout.ENDS.path in arrays)


def _states_of_tiles(store: BasinStore) -> dict[str, TileState]:
    """The arrays that are written tile by tile, and the state from which a tile is there."""
    places = store.places
    labelled = (*places.labelled, places.solution, places.own_solution)
    return {variable.path: TileState.COMPUTED for variable in places.mapped} | {
        variable.path: TileState.ASSEMBLED for variable in labelled
    }


def _from_request(store: BasinStore) -> set[str]:
    """Arrays that are whole from the start."""
    coordinates = (*store.places.coordinates, *(each for level in store.levels[1:] for each in level.coordinates))
    whole = {variable.path for variable in (store.places.ledger, layout.IMAGE_COUNTS, *coordinates)}
    return whole | {level.own_path(axis.name) for level in store.levels for axis in store.job.axes}


def _readable_ledger(store: BasinStore) -> np.ndarray:
    """State of each tile; of a ledger that cannot be read what a store that is complete would say."""
    unreadable = TileState.ASSEMBLED if store.complete else TileState.PENDING
    try:
        states = store.read_ledger()
        return np.where(states == 0, unreadable, states)
    except Damaged:
        return np.full(store.tiling.tiles, unreadable, np.uint8)


def _readable_table(store: BasinStore) -> SolutionTable:
    """The table of solutions; an empty one if it cannot be read, as all is written anew then."""
    try:
        return store.solutions.read()
    except Damaged:
        return SolutionTable.empty(store.job)


def _of_basin(store: BasinStore, basin: int, table: SolutionTable, ends: bool) -> Iterator[Chunk]:
    """Chunks of an assembled basin: points of its attractors, what transients end in, its image set."""
    place, numbers = store.job.place_of(basin), table.numbers_in(basin)
    kinds = {number: table.motions[number].kind for number in numbers}
    for row in sorted({number // ATTRACTORS_A_CHUNK for number in numbers if kinds[number] not in WITHOUT_POINTS}):
        yield from ((variable.path, (*place, row, 0)) for variable in layout.POINTS)
    if ends and AttractorKind.CHAOTIC_TRANSIENT in kinds.values():  # up to its highest number each way
        rows = range(max(numbers) // ATTRACTORS_A_CHUNK + 1)
        yield from ((layout.ENDS.path, (*place, *chunk)) for chunk in product(rows, rows))
    if store.job.sample is None:
        found = layout.IMAGE_SET[:2] if _has_images(store, basin) else ()
        found = (layout.GRAZING, layout.IMAGE_WORDS, layout.IMAGE_SET[2], *found)
        yield from ((variable.path, (*place, 0)) for variable in found)


def _has_images(store: BasinStore, basin: int) -> bool:
    """Whether any image lies in the window, so that there are groups to look up."""
    try:
        return bool(store.read_image_words(basin).size)
    except Damaged:
        return True


def invalidate(found: Findings) -> None:
    """Make a damaged store an unfinished one, without its damaged files: the same job computes anew what it lacks.

    Metadata are restored; if nothing else was damaged, that is all. Otherwise tiles whose images are damaged are
    pending, and all others wait for their labels.

    Parameters
    ----------
    found : Findings
        With damages. If it is interrupted, the next check finds what is left to do.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    demand_all_known(found.location, found.job.unread)
    restore_metadata(found.location, found.root, found.metadata)
    if found.root.damaged:
        found = check_store(found.location)  # what was missing is seen only now
    chunks = [damage for damage in found.damages if damage.chunk]
    if not chunks:
        return
    if kind_of_store(found.location) != "basin":
        if found.complete:
            AnalysisStore(found.location).invalidate()
        _discard(found.location, chunks)
        return
    store = BasinStore(found.location)
    mapped = {variable.path for variable in store.places.mapped}
    states = np.minimum(_readable_ledger(store), TileState.COMPUTED)
    by_place = states.reshape(store.ledger_shape)
    for damage in chunks:
        if damage.array in mapped:
            by_place[damage.chunk] = TileState.PENDING
    _discard(found.location, chunks)
    for addition in additions():
        addition.invalidate(store, [damage.array for damage in chunks if addition.owns(damage.array)])
    store.invalidate(states)


def _discard(location: str, chunks: Sequence[Damage]) -> None:
    """Remove damaged chunks, and of parts what marks them complete."""
    parts = {damage.array.split("/")[1] for damage in chunks if damage.array.startswith(f"{PARTS}/")}
    marks = [f"{PARTS}/{name}/{METADATA}" for name in sorted(parts)]
    with as_store_failure(location):
        storage_at(location).discard([*marks, *(damage.path for damage in chunks)])
