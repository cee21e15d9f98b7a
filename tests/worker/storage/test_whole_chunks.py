"""A chunk written as a whole has the bytes that Zarr writes, and Zarr's bytes are read as a whole."""

import numpy as np
import pytest
import zarr
from numcodecs.blosc import Blosc
from numcodecs.zstd import Zstd
from zarr.codecs import Crc32cCodec, GzipCodec, ZstdCodec

from worker.errors import DamagedChunk
from worker.storage.checked_chunks import checksum_of
from worker.storage.chunks import CODECS, CONFIG, read_chunk, write_chunk
from worker.storage.location import storage_at

TYPES = [(np.int8, -9), (np.uint8, 255), (np.int16, -9), (np.int32, -9), (np.int64, -9), (np.float64, np.inf)]
SHAPE, CHUNKS = (2, 70, 50), (1, 40, 20)
OF_LAYOUT_3 = (ZstdCodec(level=0),)
LAYOUTS = pytest.mark.parametrize(
    "codecs", [CODECS, (*OF_LAYOUT_3, Crc32cCodec()), OF_LAYOUT_3], ids=["layout 5", "layout 4", "layout 3"]
)


def array_at(location, dtype, fill, codecs=CODECS):
    group = zarr.open_group(storage_at(str(location)).zarr, mode="a", zarr_format=3)
    return group.create_array(
        "group/values", shape=SHAPE, chunks=CHUNKS, dtype=dtype, fill_value=fill, compressors=codecs, config=CONFIG
    )


def rectangles():
    """Numbers of each chunk, and the part of the array that it holds: two of three are cut by an edge."""
    for basin, row, column in np.ndindex(2, 2, 3):
        yield f"{basin}/{row}/{column}", np.s_[basin, 40 * row : 40 * row + 40, 20 * column : 20 * column + 20]


def some(dtype):
    return np.random.default_rng(1).integers(0, 100, SHAPE).astype(dtype)


@LAYOUTS
@pytest.mark.parametrize("dtype, fill", TYPES)
def test_bytes_are_those_of_zarr(tmp_path, dtype, fill, codecs):
    values = some(dtype)
    by_zarr, whole = (array_at(tmp_path / name, dtype, fill, codecs) for name in ("zarr", "whole"))
    by_zarr[...] = values
    for numbers, part in rectangles():
        write_chunk(storage_at(str(tmp_path / "whole")), whole, numbers, values[part])
    files = sorted(path.relative_to(tmp_path / "zarr") for path in (tmp_path / "zarr").rglob("c/*/*/*"))
    assert len(files) == 12
    for file in files:
        assert (tmp_path / "whole" / file).read_bytes() == (tmp_path / "zarr" / file).read_bytes()


@LAYOUTS
@pytest.mark.parametrize("dtype, fill", TYPES)
def test_what_zarr_wrote_is_read(tmp_path, dtype, fill, codecs):
    array, values = array_at(tmp_path / "zarr", dtype, fill, codecs), some(dtype)
    array[...] = values
    for numbers, part in rectangles():
        chunk = read_chunk(storage_at(str(tmp_path / "zarr")), array, numbers, "zarr")
        inside = tuple(map(slice, values[part].shape))
        assert chunk.dtype == dtype and chunk.flags.writeable
        np.testing.assert_array_equal(chunk[0][inside], values[part])
        beyond = np.ones(CHUNKS[1:], bool)
        beyond[inside] = False
        assert (chunk[0][beyond] == fill).all()


def test_what_is_not_there_is_none_and_what_cannot_be_decompressed_is_damaged(tmp_path):
    array = array_at(tmp_path / "zarr", np.int16, -9, OF_LAYOUT_3)
    place = storage_at(str(tmp_path / "zarr"))
    assert read_chunk(place, array, "0/0/0", "name") is None
    whole = Zstd().encode(np.zeros(CHUNKS, np.int16))
    for content in (b"", whole[:-3], *(Zstd().encode(np.zeros(size, np.int16)) for size in (400, 799, 9999))):
        place.write("group/values/c/0/0/0", content)
        with pytest.raises(DamagedChunk, match="store name is damaged: tile 0/0/0 of group/values cannot be decompr"):
            read_chunk(place, array, "0/0/0", "name")


@pytest.mark.parametrize("bit", [0, 100, -1])
def test_a_flipped_bit_is_told(tmp_path, bit):
    array = array_at(tmp_path / "zarr", np.int32, -9)
    place, file = storage_at(str(tmp_path / "zarr")), tmp_path / "zarr" / "group" / "values" / "c" / "0" / "0" / "0"
    write_chunk(place, array, "0/0/0", some(np.int32)[0, :40, :20])
    content = np.frombuffer(file.read_bytes(), np.uint8).copy()
    content[bit // 8] ^= 1 << bit % 8
    file.write_bytes(content.tobytes())
    with pytest.raises(DamagedChunk, match="does not have its checksum"):
        read_chunk(place, array, "0/0/0", "name")


@pytest.mark.parametrize("size", [0, 1, 400, 799, 801, 9999])
def test_a_whole_chunk_of_another_length_is_told(tmp_path, size):
    """Such as a file of another array, whose checksum is right."""
    array, place = array_at(tmp_path / "zarr", np.int16, -9), storage_at(str(tmp_path / "zarr"))
    content = Blosc("lz4", 5, Blosc.SHUFFLE).encode(np.arange(size, dtype=np.int16))
    for own in (content, content[:6], b""):
        place.write("group/values/c/0/0/0", own + checksum_of(own))
        with pytest.raises(DamagedChunk, match="tile 0/0/0 of group/values cannot be decompressed"):
            read_chunk(place, array, "0/0/0", "name")


@pytest.mark.parametrize("codecs", [(), (GzipCodec(), Crc32cCodec()), (Crc32cCodec(),)], ids=["none", "gzip", "crc"])
def test_a_chunk_that_its_metadata_do_not_describe_is_told(tmp_path, codecs):
    array, place = array_at(tmp_path / "zarr", np.int16, -9), storage_at(str(tmp_path / "zarr"))
    write_chunk(place, array, "0/0/0", some(np.int16)[0, :40, :20])
    other = array_at(tmp_path / "other", np.int16, -9, codecs)
    with pytest.raises(DamagedChunk, match="tile 0/0/0 of group/values cannot be decompressed"):
        read_chunk(place, other, "0/0/0", "name")
