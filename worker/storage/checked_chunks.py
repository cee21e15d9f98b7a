"""Chunks are checked when they are read: a flipped bit is an error that names the store, the array and the tile.

Every chunk ends in the CRC-32C of its other bytes (Zarr's codec ``crc32c``). Zarr checks it, too, but says neither in
which store nor in which chunk it fails. Arrays of older stores have no checksums, and are read without a check.
Metadata have none either. Those that cannot be read any more are named. So is a chunk that a finished store has lost.
"""

import json
from collections.abc import Awaitable, Callable
from typing import Any

import google_crc32c
import numpy as np
from zarr.core.buffer import default_buffer_prototype

from worker.errors import DamagedChunk, DamagedMetadata

CHECKSUM_BYTES = 4
METADATA = "zarr.json"
"""Name of the file of each array and each group."""
CHUNKS = "c"
"""Folder of an array's chunks."""
# Arrays whose length is found while computing, and which are not filled up. Most basins have no chaotic transient.
SOME_CHUNKS = ("assembly/", "attractor_", "transient_ends")


async def checked(read: Callable[..., Awaitable[Any]], name: str, key: str, prototype: Any, byte_range: Any) -> Any:
    """Read a file, and check it if it is a chunk with a checksum, or metadata.

    Parameters
    ----------
    read : callable
        Reads a file of the store, as `zarr.abc.store.Store.get` does.
    name : str
        Name of the store in messages.
    key : str
        Path of the file.
    prototype, byte_range
        As of `zarr.abc.store.Store.get`.

    Raises
    ------
    DamagedChunk
        If its checksum is wrong, or a finished store has lost it.
    DamagedMetadata
        If they cannot be read.
    """
    prototype = prototype or default_buffer_prototype()
    found = await read(key, prototype, byte_range)
    node, _, file = key.rpartition("/")
    if found is not None and file == METADATA and not _are_metadata(found.to_bytes()):
        raise DamagedMetadata(name, node)
    array, is_chunk, chunk = key.rpartition(f"/{CHUNKS}/")
    if found is None and is_chunk and await _has_all_chunks(read, array):
        raise DamagedChunk(name, array, chunk, "is missing")
    if found is None or byte_range is not None or not is_chunk or has_checksum(found.as_numpy_array()):
        return found
    metadata = await read(f"{array}/{METADATA}", prototype)
    if metadata is None or not is_checked(json.loads(metadata.to_bytes())):
        return found
    raise DamagedChunk(name, array, chunk)


async def _has_all_chunks(read: Callable[..., Awaitable[Any]], array: str) -> bool:
    """Whether this is a finished store, which has every chunk of an array: Zarr takes a missing one for empty."""
    if array.startswith(SOME_CHUNKS):
        return False
    prototype = default_buffer_prototype()
    files = [await read(path, prototype) for path in (METADATA, f"{array}/{METADATA}")]
    try:
        root, own = (json.loads(file.to_bytes()) for file in files if file is not None)
    except ValueError:  # one of them is not there, or no JSON
        return False
    return bool(root["attributes"].get("complete")) and is_checked(own)


def _are_metadata(content: bytes) -> bool:
    """Whether this can be the ``zarr.json`` of an array or a group. A root of this project has a request as well."""
    document = _object_of(content)
    if document is None or not isinstance(document.get("consolidated_metadata"), dict | None):
        return False
    attributes = document.get("attributes", {})
    if not isinstance(attributes, dict):
        return False
    if "layout_version" not in attributes:
        return True
    return isinstance(attributes.get("complete"), bool) and _object_of(attributes.get("request")) is not None


def _object_of(text: Any) -> dict[str, Any] | None:
    """The object that a text of JSON is; None if it is no text, no JSON, nested too deeply to be read, or no object."""
    try:
        document = json.loads(text)
    except (TypeError, ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) else None


def checksum_of(content: Any) -> bytes:
    """CRC-32C of bytes, as it stands at the end of a chunk."""
    computed: int = google_crc32c.value(content)
    return computed.to_bytes(CHECKSUM_BYTES, "little")


def has_checksum(content: np.ndarray) -> bool:
    """Whether bytes end in the CRC-32C of the others."""
    return checksum_of(content[:-CHECKSUM_BYTES]) == content[-CHECKSUM_BYTES:].tobytes()


def is_checked(metadata: dict[str, Any]) -> bool:
    """Whether the chunks of an array have checksums, from its ``zarr.json``."""
    return any(codec["name"] == "crc32c" for codec in metadata.get("codecs", []))
