"""A chunk written or read as a whole, in the thread of the caller: a tile is one chunk of each array.

Zarr finds out which parts of which chunks a write concerns, and hands each step to another thread. That takes longer
than compressing a tile (docs/decisions/0043-whole-chunks.md). The bytes are those that Zarr writes: little endian, row
by row, compressed as the array's metadata say, with their CRC-32C at the end.
"""

from typing import Any

import numpy as np
from numcodecs.blosc import Blosc
from numcodecs.zstd import Zstd
from zarr.codecs import BloscCodec, Crc32cCodec

from worker.errors import DamagedChunk
from worker.storage.checked_chunks import CHECKSUM_BYTES, CHUNKS, checksum_of, has_checksum
from worker.storage.location import storage_at
from worker.storage.protocol import Storage, whole

# Zarr does not store this: a handle opened without it would delete chunks that equal the fill value.
CONFIG = {"write_empty_chunks": True}
# The checksum is of the compressed bytes, as they lie on the disk.
CODECS = (BloscCodec(cname="lz4", clevel=5, shuffle="shuffle"), Crc32cCodec())
_CHECKSUM = CODECS[-1]


def write_chunk(storage: Storage, array: Any, numbers: str, values: np.ndarray) -> None:
    """Write a chunk. Where it ends beyond the array, its rest has the fill value.

    Parameters
    ----------
    storage : Storage
        Of the store.
    array : zarr.Array
    numbers : str
        Numbers of the chunk along each dimension, with slashes between.
    values : ndarray
        As many dimensions as the array, or fewer if the chunk has one value along the first ones.
    """
    chunk = array.chunks[-values.ndim :]
    stored = array.dtype.newbyteorder("<")
    if values.shape == chunk:
        values = np.ascontiguousarray(values, stored)
    else:
        inside = tuple(map(slice, values.shape))
        values, part = np.full(chunk, array.fill_value, stored), values
        values[inside] = part
    content: bytes = _compression(array).encode(values)
    storage.write(_file(array, numbers), content + checksum_of(content) if _is_checked(array) else content)


def read_chunk(storage: Storage, array: Any, numbers: str, name: str) -> np.ndarray | None:
    """Read a chunk with all dimensions of its array; None if it is not there.

    Parameters
    ----------
    storage : Storage
        Of the store.
    array : zarr.Array
    numbers : str
        Numbers of the chunk along each dimension, with slashes between.
    name : str
        Name of the store in errors.

    Raises
    ------
    DamagedChunk
        If it does not hold what was written.
    """
    file = storage.read(_file(array, numbers), whole)
    if file is None:
        return None
    content = np.frombuffer(file.content, np.uint8)
    if _is_checked(array):
        if not has_checksum(content):
            raise DamagedChunk(name, array.path, numbers)
        content = content[:-CHECKSUM_BYTES]
    values = np.empty(array.chunks, array.dtype.newbyteorder("<"))
    try:
        _decompress(_compression(array), content, values)
    # Where there is no checksum, where the file is another chunk's, or where the metadata are those of another array.
    except (RuntimeError, ValueError, LookupError) as error:
        raise DamagedChunk(name, array.path, numbers, "cannot be decompressed") from error
    return values.astype(array.dtype, copy=False)


def write_over(array: Any, index: tuple[int | slice, ...], values: np.ndarray) -> None:
    """Write a part of an array. A damaged chunk there counts as none.

    Zarr reads a chunk of which it writes a part. If a power cut has left it empty, it would be refused. The values must
    be all that its writer has to say, since what else was in a damaged chunk is gone.

    Parameters
    ----------
    array : zarr.Array
        Of an open store.
    index : tuple of int or slice
    values : ndarray

    Raises
    ------
    StoreFailed
        If it cannot be written.
    """
    try:
        array[index] = values
    except DamagedChunk as damaged:
        storage_at(damaged.store).discard([f"{damaged.array}/{CHUNKS}/{damaged.chunk}"])
        write_over(array, index, values)


def _file(array: Any, numbers: str) -> str:
    return f"{array.path}/{CHUNKS}/{numbers}"


def _compression(array: Any) -> Blosc | Zstd:
    """What compresses the chunks of an array: Zstandard in stores of layouts 3 and 4."""
    codec = array.compressors[0]
    # As it is stored: in some versions of Zarr names are members of an enumeration, in others strings.
    stored = codec.to_dict()["configuration"]
    if isinstance(codec, BloscCodec):
        return Blosc(stored["cname"], stored["clevel"], Blosc.SHUFFLE, stored["blocksize"], stored["typesize"])
    return Zstd(level=stored["level"])


def _decompress(compression: Blosc | Zstd, content: np.ndarray, values: np.ndarray) -> None:
    """Fill an array; `ValueError` if what was compressed has another length."""
    if isinstance(compression, Zstd):
        # Into too large an array it would fill the beginning, and say nothing.
        values[...] = np.frombuffer(compression.decode(content), values.dtype).reshape(values.shape)
        return
    # So would Blosc, which trusts what its header says of both lengths.
    decompressed, _, compressed = np.frombuffer(content[4:16].tobytes(), "<u4").tolist()
    if (decompressed, compressed) != (values.nbytes, content.size):
        raise ValueError(f"{decompressed} bytes of {compressed}, where {values.nbytes} of {content.size} are expected")
    compression.decode(content, out=values)


def _is_checked(array: Any) -> bool:
    """Whether the chunks of an array have checksums, which those of layout 3 lack."""
    return _CHECKSUM in array.compressors
