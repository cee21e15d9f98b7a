"""What is damaged or missing in a store of any kind: every file is read."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

from worker.errors import DamagedChunk, StoreConflict, UnknownKind, as_store_failure
from worker.jobs.job import Job
from worker.kinds import KINDS
from worker.storage.checked_chunks import CHUNKS, METADATA
from worker.storage.location import storage_at
from worker.stores.analysis_store import PARTS, AnalysisStore
from worker.stores.checking.expected import NEXT_STEP, expected_chunks
from worker.stores.checking.metadata import (
    COPY_IS_WRONG,
    ROOT_IS_WRONG,
    Metadata,
    Root,
    array_of,
    read_root,
    right_metadata,
)
from worker.stores.opening import open_group

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
    def restored(self) -> bool:
        """Whether it is metadata that are written anew."""
        return not self.chunk and self.what != COPY_IS_WRONG

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
    damages = [Damage("", (), ROOT_IS_WRONG)] if root.damaged else []
    damages += [Damage(path, (), what) for path, what in metadata.damages]
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
        expected = expected_chunks(location, arrays) if kind == "basin" else _all_chunks(arrays)
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
        kind = "sweep" if kind == "basin" and request.get("vary") else kind
        return KINDS[kind].job_class.trusted(request, attributes["request_sha256"])
    except UnknownKind as error:
        raise StoreConflict(f"{location}: {error}") from error
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise StoreConflict(
            f"{location} has lost its request, so nothing can be computed anew: {error}; {NEXT_STEP}"
        ) from error


def _chunk_of(path: str) -> tuple[str, tuple[int, ...]] | None:
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


def _all_chunks(arrays: Any) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Every chunk of tables."""
    for path, array in arrays.items():
        if array.size:
            yield from ((path, chunk) for chunk in product(*map(range, array.cdata_shape)))
