"""Tiles in an open store of basins: each is one chunk of every array of cells, or of a sample's points."""

from collections.abc import Sequence

import numpy as np

from rattle_kernels.basins.tiles import Tile
from worker.errors import DamagedChunk, StoreFailed, as_store_failure
from worker.storage.chunks import read_chunk, write_chunk
from worker.storage.protocol import Storage
from worker.stores.layout import Variable
from worker.stores.open_arrays import OpenArrays


class TileArrays:
    """Tiles of a store, whose chunks are read and written whole.

    Parameters
    ----------
    arrays : OpenArrays
    storage : Storage
        Of the store.
    """

    def __init__(self, arrays: OpenArrays, storage: Storage) -> None:
        self._arrays, self._storage = arrays, storage
        self._location, self._job, self._group = arrays.location, arrays.job, arrays.group

    def _chunk(self, tile: Tile) -> str:
        """Numbers of a tile's chunk in any array of cells. The one row of a sample has no dimension of its own."""
        within = (tile.row, tile.column) if self._job.sample is None else (tile.column,)
        return "/".join(map(str, (*self._job.place_of(tile.basin), *within)))

    def write(self, variables: Sequence[Variable], tile: Tile, values: Sequence[np.ndarray]) -> None:
        """Write one tile, of shape (rows, columns), of some variables."""
        chunk = self._chunk(tile)
        with as_store_failure(self._location):
            for variable, value in zip(variables, values, strict=True):
                own = value if self._job.sample is None else value[0]
                write_chunk(self._storage, self._arrays.array(variable), chunk, own)

    def read(self, variables: Sequence[Variable], tile: Tile) -> tuple[np.ndarray, ...]:
        """Read one tile, of shape (rows, columns), of some variables. All of them must have been written.

        Raises
        ------
        StoreFailed
            If it cannot be read or is missing.
        """
        return tuple(_within(self.read_chunk(each, self._chunk(tile)), tile) for each in variables)

    def read_chunk(self, variable: Variable, numbers: str) -> np.ndarray:
        """Read a chunk of any array, with all its dimensions. It must have been written.

        Raises
        ------
        StoreFailed
            If it cannot be read or is missing.
        """
        values = self._read(variable, numbers)
        if values is not None:
            return values
        if self._group.attrs["complete"]:
            raise DamagedChunk(self._location, variable.path, numbers, "is missing")
        raise StoreFailed(f"the store {self._location} has lost a part of {variable.path}: chunk {numbers}")

    def read_one(self, variable: Variable, tile: Tile) -> np.ndarray | None:
        """One tile of one variable; None if it is not there."""
        values = self._read(variable, self._chunk(tile))
        return None if values is None else _within(values, tile)

    def _read(self, variable: Variable, numbers: str) -> np.ndarray | None:
        with as_store_failure(self._location):
            return read_chunk(self._storage, self._arrays.array(variable), numbers, self._location)

    def read_cells(
        self, variable: Variable, basin: int, rows: tuple[int, int], columns: tuple[int, int], every: int
    ) -> np.ndarray:
        """Read every n-th cell, each way, of a rectangle of a basin. All of it must have been written.

        Raises
        ------
        StoreFailed
            If it cannot be read or a part is missing. Zarr returns fill values there, which are not data.
        """
        values = self._arrays.read(variable, *self._job.place_of(basin), slice(*rows, every), slice(*columns, every))
        if (values == variable.fill).any():
            raise StoreFailed(f"the store {self._location} has lost a part of {variable.path}")
        return values


def _within(chunk: np.ndarray, tile: Tile) -> np.ndarray:
    """Cells of a tile in its chunk, which is larger at the upper edges."""
    rows, columns = (stop - start for start, stop in (tile.rows, tile.columns))
    return np.ascontiguousarray(chunk.reshape(-1, chunk.shape[-1])[:rows, :columns])
