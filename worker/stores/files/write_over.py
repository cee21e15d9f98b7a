"""Writes into a part of a chunk, whatever is left of what was there."""

from typing import Any

import numpy as np

from worker.errors import DamagedChunk
from worker.stores.files.checked_chunks import CHUNKS
from worker.stores.storage import place_at


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
        place_at(damaged.store).discard([f"{damaged.array}/{CHUNKS}/{damaged.chunk}"])
        write_over(array, index, values)
