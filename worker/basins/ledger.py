"""Contents of a job's store: the state of each tile and the table of solutions. Only the driver writes them."""

import time

import numpy as np

from worker.basins.basin_run import BasinRun
from worker.basins.numbering import Numbered
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState
from worker.stores.solution_table import share_error

# Least time between two writes of each.
_LEDGER_SECONDS = 0.5
_TABLE_SECONDS = 2.0


class Ledger:
    """States of tiles, and solutions of basins. A tile's state never goes back, and basins are completed in order.

    Parameters
    ----------
    store : BasinStore

    Attributes
    ----------
    states : ndarray of uint8
        State of each tile.
    table : SolutionTable
    basins : int
        Number of complete basins. They are the first ones.
    """

    def __init__(self, store: BasinStore) -> None:
        self._store = store
        self.states = store.read_ledger().copy()
        self.table = store.solutions.read()
        self._image_counts = store.read_image_counts().copy()
        # The ledger is written after the table, so a basin is complete if both say so.
        assembled = (self.states.reshape(-1, store.tiling.tiles_of_basin) == TileState.ASSEMBLED).all(axis=1)
        self.basins = int(np.cumprod(self.table.complete & assembled).sum())
        self.table.forget_after(self.basins)
        self._ledger_saved = self._table_saved = time.monotonic()
        self._table_changed = False

    def mapped(self, basin: int) -> frozenset[int]:
        """Tiles of a basin whose images are in the store."""
        tiles = np.array(self._store.tiling.numbers_of(basin))
        return frozenset(tiles[self.states[tiles] >= TileState.COMPUTED].tolist())

    def set_state(self, tiles: int | range, state: TileState) -> None:
        """Record that tiles have reached a state."""
        self.states[tiles] = np.maximum(self.states[tiles], state)

    def catalogue(self, basin: int) -> Numbered:
        """Attractors of a complete basin, with their numbers."""
        numbers = self.table.numbers_in(basin)
        return Numbered(self._store.solutions.read_catalogue(basin, self.table, numbers), numbers)

    def add_attractors(self, basin: BasinRun, numbered: Numbered) -> None:
        """Record the attractors of a basin before their shares are known, and make room for them in the store."""
        self._image_counts[basin.number] = basin.reserved
        unknown = np.full(len(numbered.numbers), np.nan)
        self._enter(basin.number, numbered, unknown, unknown)
        self._store.solutions.make_room(self.table, max(attractor.time.size for attractor in numbered.attractors))

    def complete(self, basin: BasinRun, numbered: Numbered) -> None:
        """Record that a basin is complete. Basins are completed in order."""
        counts = np.zeros((basin.counts.shape[0], len(numbered.numbers)), np.int64)
        counts[:, : basin.counts.shape[1]] = basin.counts
        cells = self._store.job.grid.cells
        shares = counts.sum(axis=0) / cells
        errors = share_error(counts, cells) if self._store.job.sample else np.full(shares.shape, np.nan)
        self._enter(basin.number, numbered, shares, errors)
        self.set_state(self._store.tiling.numbers_of(basin.number), TileState.ASSEMBLED)
        self.basins += 1

    def _enter(self, basin: int, numbered: Numbered, shares: np.ndarray, errors: np.ndarray) -> None:
        self.table.enter(basin, numbered.numbers, numbered.attractors, shares, errors)
        self._table_changed = True

    def save_sometimes(self) -> None:
        """Write the changes, if the last write is long enough ago."""
        now = time.monotonic()
        if self._table_changed:
            # The ledger marks basins as complete, so it is never written without their solutions.
            if now - self._table_saved > _TABLE_SECONDS:
                self.save()
        elif now - self._ledger_saved > _LEDGER_SECONDS:
            self._store.write_ledger(self.states)
            self._ledger_saved = now

    def save(self) -> None:
        """Write everything. Each file is synced by itself: the next driver reads the tables, whatever is claimed."""
        self._store.write_image_counts(self._image_counts)
        self._store.solutions.write(self.table)
        self._store.write_ledger(self.states)
        self._ledger_saved = self._table_saved = time.monotonic()
        self._table_changed = False
