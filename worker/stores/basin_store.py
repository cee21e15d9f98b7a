"""The Zarr store of one job.

Guarantees. One tile is one chunk of every array and has one writer, so writers never conflict. Chunks are replaced as
a whole (temporary file and rename), so a killed writer leaves the old chunk or the new one. Chunks equal to the fill
value are written, too. The ledger, the table of solutions and the metadata have one writer, the driver. Metadata are
consolidated whenever they change (when solutions are added). So readers that rely on the root, such as those
over HTTP, which cannot list a folder, always see everything.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import Any

import numpy as np

from rattle_kernels import CellGroups
from rattle_kernels.cell_mapping.image_set import ImageSet, with_counts
from worker.additions import asked_of
from worker.errors import DamagedMetadata, OtherArrays, StoreConflict, as_store_failure
from worker.fence import Fence, unfenced
from worker.jobs.basin_job import BasinJob, basin_job
from worker.rounding import demand_same_rounding
from worker.storage.chunks import write_chunk
from worker.storage.location import storage_at
from worker.stores import layout
from worker.stores.layout import Variable
from worker.stores.new_store import consolidate, create_store, places_of, tiling_of, write_coordinates
from worker.stores.open_arrays import OpenArrays
from worker.stores.opening import (
    check_same_request,
    create_unless_there,
    open_group,
    open_store_at,
    opened_for_tasks,
    opened_once,
    trusted_job,
)
from worker.stores.provenance import now
from worker.stores.pyramid import ATTRIBUTE, Level, levels_of
from worker.stores.solution_arrays import SolutionArrays
from worker.stores.tile_arrays import TileArrays

# Chunks are encoded without the GIL, and other workers may wait for this one. Three keep two cores busy.
_WRITERS = 3


class BasinStore:
    """A job's store, open for reading and writing. Those who only read, and tasks, share one: see `open`.

    Parameters
    ----------
    location : str
        Location as in `worker.storage.location`.
    fence : Fence
        The driver's fence.
    as_found : bool
        Whether its arrays are taken whatever their shapes are: by a check, which tells which of them to mend.

    Raises
    ------
    StoreConflict
        If the location holds something other than a basin's store.
    StoreFailed
        If it cannot be read.

    Attributes
    ----------
    tiles : TileArrays
        Cells, or points of a sample, tile by tile.
    solutions : SolutionArrays
        What is known of each solution.
    arrays : OpenArrays
        Handles on the arrays, for what packages add.
    """

    def __init__(self, location: str, fence: Fence = unfenced, *, as_found: bool = False) -> None:
        self.location, self._fence = location, fence
        self._group = open_store_at(location, "basin store", fence)
        if "kind" in self._group.attrs:
            raise StoreConflict(f"{location} is no basin store: it is one of kind {self._group.attrs['kind']}")
        if self._group.attrs.get("layout_version") not in layout.READABLE_LAYOUTS:
            raise StoreConflict(f"{location} is no basin store of layout {layout.LAYOUT_VERSION}")
        self.job = trusted_job(basin_job, location, self._group.attrs)
        self.digest = self.job.digest
        self.tiling = tiling_of(self.job)
        self.places = places_of(self.job)
        levels = levels_of(self.job, self.tiling)
        # Stores from before there were levels have none.
        self.levels = levels if ATTRIBUTE in self._group.attrs else levels[:1]
        self._storage = storage_at(location)
        self.arrays = OpenArrays(location, self.job, self._group, fence)
        self.tiles = TileArrays(self.arrays, self._storage)
        self.solutions = SolutionArrays(self.arrays, self.places.solution)
        if not as_found:
            self._check_own_arrays()

    @classmethod
    def open(cls, location: str, digest: str | None = None) -> "BasinStore":
        """The store at a location, opened once in each process; for a task that of its job, which has this digest.

        Raises
        ------
        StoreConflict
            If the location holds no basin's store, or that of another job.
        StoreFailed
            If it cannot be read.
        """
        return opened_once(cls, location) if digest is None else opened_for_tasks(cls, location, digest)

    @classmethod
    def create_or_resume(cls, location: str, job: BasinJob, fence: Fence = unfenced) -> "BasinStore":
        """Store of `job` at `location`: the existing one, or a new one.

        Raises
        ------
        StoreConflict
            If the location holds another job's store, one begun on a processor of another kind, or something else.
        StoreFailed
            If it cannot be written.
        """
        create_unless_there(location, "basin store", lambda: create_store(location, job, fence), fence)
        store = cls(location, fence)
        check_same_request(location, job.digest, store.digest, store.job.request())
        if not store.complete:
            demand_same_rounding(location, store.attributes, StoreConflict)
        return store

    @property
    def ledger_shape(self) -> tuple[int, ...]:
        """Number of tiles along each dimension of the ledger. A sample is one row of points."""
        return *self.job.sweep_shape, *self.tiling.shape[0 if self.job.sample is None else 1 :]

    def own_shapes(self) -> Iterator[tuple[Variable, tuple[int, ...]]]:
        """The arrays whose lengths the request gives from the start, and what they are."""
        cells = self.job.grid.shape[0 if self.job.sample is None else 1 :]
        yield self.places.ledger, self.ledger_shape
        yield self.places.solution, (*self.job.sweep_shape, *cells)

    def _check_own_arrays(self) -> None:
        """Refuse arrays that were made for another request. Those whose metadata are damaged are refused when read."""
        with as_store_failure(self.location):
            for variable, own in self.own_shapes():
                try:
                    there = self.arrays.array(variable).shape
                except DamagedMetadata:
                    continue
                if there != own:
                    raise OtherArrays(self.location, variable.path)

    @property
    def complete(self) -> bool:
        """Whether the job has finished and every array is whole."""
        return bool(self._group.attrs["complete"])

    @property
    def whole_levels(self) -> tuple[Level, ...]:
        """Levels that can be read: of an unfinished store only the basins themselves."""
        return self.levels if self.complete else self.levels[:1]

    def holds(self, variable: Variable) -> bool:
        """Whether an array is there, or comes since the request asks for it. Its metadata may be damaged."""
        asked = (own for addition in asked_of(self.job) for own in addition.arrays())
        return variable in asked or variable.path in self._group

    def read_whole(self, variables: Sequence[Variable]) -> tuple[np.ndarray, ...]:
        """Read some variables whole."""
        with as_store_failure(self.location):
            return tuple(np.asarray(self.arrays.fresh(variable)[...]) for variable in variables)

    def read_ledger(self) -> np.ndarray:
        """State of each tile, flat, basin by basin, as `TileState` codes."""
        return self.arrays.read(self.places.ledger, ...).ravel()

    def write_ledger(self, states: np.ndarray) -> None:
        """Replace the ledger (driver only)."""
        self._fence()
        with as_store_failure(self.location):
            array = self.arrays.array(self.places.ledger)
            array[...] = states.reshape(array.shape)

    def write_image_words(self, basin: int, words: np.ndarray) -> None:
        """Write the distinct images of a basin (driver only)."""
        self._fence()
        self.arrays.write(layout.IMAGE_WORDS, words, *self.job.place_of(basin), ...)

    def read_image_words(self, basin: int) -> ImageSet:
        """Read the distinct images of a basin."""
        return with_counts(self.arrays.read(layout.IMAGE_WORDS, *self.job.place_of(basin), ...))

    def write_groups(self, basin: int, groups: CellGroups) -> None:
        """Write Hsu's numbers on a basin's image set, for tiles to look up."""
        with as_store_failure(self.location), ThreadPoolExecutor(_WRITERS) as writers:
            # In the caller's context, as in Zarr's own threads.
            written = [
                writers.submit(
                    copy_context().run, write_chunk, self._storage, self.arrays.array(variable), chunk, values[part]
                )
                for variable, values in zip(layout.IMAGE_SET, groups[1:], strict=True)
                for chunk, part in self._chunks(variable, basin, values.size)
            ]
            for each in written:
                each.result()

    def read_solution(self, basin: int) -> np.ndarray:
        """Read the solution of every cell or point of a basin."""
        return self.arrays.read(self.places.solution, *self.job.place_of(basin), ...)

    def read_groups(self, basin: int) -> CellGroups:
        """Read Hsu's numbers on a basin's image set: as int16 if all groups and steps fit, which halves the memory."""
        members = self.read_image_words(basin)
        numbers = np.empty((members.size, 2), np.int16)
        for column, variable in enumerate(layout.IMAGE_SET[:2]):
            for chunk, part in self._chunks(variable, basin, members.size):
                some = self.tiles.read_chunk(variable, chunk).ravel()[: part.stop - part.start]
                fits = np.result_type(numbers, np.min_scalar_type(-1 - int(some.max())))
                numbers = numbers.astype(fits, copy=False)
                numbers[part, column] = some
        group, step = numbers.T
        period = self.arrays.read(layout.IMAGE_SET[2], *self.job.place_of(basin), slice(int(group.max(initial=0)) + 1))
        return CellGroups(members, group, step, period)

    def _chunks(self, variable: Variable, basin: int, size: int) -> list[tuple[str, slice]]:
        """Chunks of a basin's first numbers in an array. Zarr copies what it reads of several at once."""
        place, length = self.job.place_of(basin), self.arrays.array(variable).chunks[-1]
        return [
            ("/".join(map(str, (*place, number))), slice(number * length, min((number + 1) * length, size)))
            for number in range(-(-size // length))
        ]

    def write_grazing_velocity(self, basin: int, velocity: np.ndarray) -> None:
        """Write the grazing curve of a basin."""
        self.arrays.write(layout.GRAZING, velocity, *self.job.place_of(basin), ...)

    def write_image_counts(self, counts: np.ndarray) -> None:
        """Write how many cells of each basin have each reserved image, shape (basins, 3) (driver only)."""
        self._fence()
        self.arrays.write(layout.IMAGE_COUNTS, counts.reshape(*self.job.sweep_shape, 3), ...)

    def read_image_counts(self) -> np.ndarray:
        """Read these counts, shape (basins, 3). They are negative if a basin is not mapped yet."""
        return self.arrays.read(layout.IMAGE_COUNTS, ...).reshape(-1, 3)

    def finish(self, seconds: dict[str, float]) -> None:
        """Consolidate the store's metadata and mark it complete (driver only)."""
        self._fence()
        with as_store_failure(self.location):
            consolidate(self.location, self._fence)
            # One write, with the consolidated metadata: a complete store is complete for every reader.
            whole = open_group(self.location, "r+", consolidated=True, fence=self._fence)
            whole.update_attributes({"complete": True, "finished": now(), "seconds": seconds})

    def invalidate(self, states: np.ndarray) -> None:
        """Make the store unfinished again, so that the same job computes anew what the ledger no longer claims.

        Parameters
        ----------
        states : ndarray of uint8
            The new ledger. No tile is assembled: the tables of solutions are emptied.
        """
        self._fence()
        with as_store_failure(self.location):
            self._group.update_attributes({"complete": False, "finished": None})
            self.write_ledger(states)
            write_coordinates(self._group, self.job, self.levels)
            self.solutions.empty()
            self.arrays.write(layout.IMAGE_COUNTS, np.array(layout.IMAGE_COUNTS.fill), ...)
            consolidate(self.location, self._fence)

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the store."""
        return dict(self._group.attrs)

    def sweep_orphans(self) -> None:
        """Remove temporary files that killed writers left behind (driver only)."""
        self._fence()
        with as_store_failure(self.location):
            storage_at(self.location).sweep()
