"""The Zarr store of one job.

Guarantees. One tile is one chunk of every array and one writer writes it, so writers never meet. Chunks are replaced as
a whole (temporary file and rename), so a killed writer leaves the old chunk or the new one. Chunks equal to the fill
value are written, too. The ledger, the table of solutions and the metadata have one writer, the driver; metadata are
consolidated anew whenever they change (when there are more solutions than before), so that readers that trust the root,
such as those over HTTP, which cannot list a folder, see all there is at any moment.
"""

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle_kernels import Attractor, AttractorKind, CellGroups, ImageSet, with_counts
from worker.errors import StoreConflict, StoreFailed, told_as_store_failure
from worker.fence import Fence, unfenced
from worker.jobs.basin_job import BasinJob
from worker.stores import layout
from worker.stores.layout import Variable
from worker.stores.new_store import (
    CONFIG,
    consolidate,
    create_array,
    create_store,
    now,
    places_of,
    tiling_of,
)
from worker.stores.object_storage import place_at
from worker.stores.opening import create_unless_there, demand_same_request, open_group, open_store_at
from worker.stores.solution_table import Motion, SolutionTable, share_error
from worker.stores.tiles import Tile


class BasinStore:
    """A job's store, open for reading and writing.

    Parameters
    ----------
    location : str
        As in `worker.stores.object_storage`.
    fence : Fence
        Of the driver.

    Raises
    ------
    StoreConflict
        Where the location holds something else than a basin's store.
    StoreFailed
        Where it cannot be read.
    """

    def __init__(self, location: str, fence: Fence = unfenced) -> None:
        self.location, self._fence = location, fence
        self._group = open_store_at(location, "basin store", fence)
        if "kind" in self._group.attrs:
            raise StoreConflict(f"{location} is no basin store: it is one of kind {self._group.attrs['kind']}")
        if self._group.attrs.get("layout_version") != layout.LAYOUT_VERSION:
            raise StoreConflict(f"{location} is no basin store of layout {layout.LAYOUT_VERSION}")
        self.job = BasinJob.from_request(json.loads(str(self._group.attrs["request"])))
        self.digest = self.job.digest
        self.tiling = tiling_of(self.job)
        self.places = places_of(self.job)
        # Arrays of cells never change their shape: their handles are kept, as opening one costs half as much as a tile.
        self._handles: dict[str, Any] = {}

    @classmethod
    def create_or_resume(cls, location: str, job: BasinJob, fence: Fence = unfenced) -> "BasinStore":
        """Store of `job` at `location`: the one that is there, or a new one.

        Raises
        ------
        StoreConflict
            Where the location holds another job's store, or something else.
        StoreFailed
            Where it cannot be written.
        """
        create_unless_there(location, "basin store", lambda: create_store(location, job, fence), fence)
        store = cls(location, fence)
        demand_same_request(location, job.digest, store.digest, store.job.request())
        return store

    def _array(self, variable: Variable) -> Any:
        return self._group[variable.path].with_config(CONFIG)

    def _kept(self, variable: Variable) -> Any:
        if variable.path not in self._handles:
            self._handles[variable.path] = self._array(variable)
        return self._handles[variable.path]

    @property
    def complete(self) -> bool:
        """Whether the job has finished and every array is whole."""
        return bool(self._group.attrs["complete"])

    def _kept_with_room(self, variable: Variable, shape: tuple[int, ...]) -> Any:
        """An array whose last dimensions the driver lengthens, as it is where what is known of it is too short."""
        if any(there < needed for there, needed in zip(self._kept(variable).shape[-len(shape) :], shape, strict=True)):
            del self._handles[variable.path]
        return self._kept(variable)

    def _region(self, tile: Tile) -> tuple[int | slice, ...]:
        """Where a tile lies in an array; the one row of a sample has no dimension of its own."""
        within = (slice(*tile.rows), slice(*tile.columns)) if self.job.sample is None else (slice(*tile.columns),)
        return (*self.job.place_of(tile.basin), *within)

    def write_tile(self, variables: Sequence[Variable], tile: Tile, values: Sequence[np.ndarray]) -> None:
        """Write one tile, of shape (rows, columns), of some variables."""
        region = self._region(tile)
        with told_as_store_failure(self.location):
            for variable, value in zip(variables, values, strict=True):
                self._kept(variable)[region] = value if self.job.sample is None else value[0]

    def read_tile(self, variables: Sequence[Variable], tile: Tile) -> tuple[np.ndarray, ...]:
        """Read one tile of some variables, all of it written before.

        Raises
        ------
        StoreFailed
            Where it cannot be read, or is not there: Zarr takes what is missing for fill values, which are no data.
        """
        region = self._region(tile)
        shape = tile.rows[1] - tile.rows[0], tile.columns[1] - tile.columns[0]
        with told_as_store_failure(self.location):
            values = tuple(np.asarray(self._kept(variable)[region]).reshape(shape) for variable in variables)
        for variable, value in zip(variables, values, strict=True):
            if (value == variable.fill).any():
                raise StoreFailed(f"the store {self.location} has lost a part of {variable.path}: {tile}")
        return values

    def read_whole(self, variables: Sequence[Variable]) -> tuple[np.ndarray, ...]:
        """Read some variables whole."""
        with told_as_store_failure(self.location):
            return tuple(np.asarray(self._array(variable)[...]) for variable in variables)

    def read_ledger(self) -> np.ndarray:
        """State of each tile, flat, basin by basin, as `TileState` codes."""
        with told_as_store_failure(self.location):
            return np.asarray(self._array(self.places.ledger)[...]).ravel()

    def write_ledger(self, states: np.ndarray) -> None:
        """Replace the ledger (driver only)."""
        self._fence()
        with told_as_store_failure(self.location):
            array = self._kept(self.places.ledger)
            array[...] = states.reshape(array.shape)

    def write_image_words(self, basin: int, words: np.ndarray) -> None:
        """Write the distinct images of a basin (driver only)."""
        self._fence()
        with told_as_store_failure(self.location):
            self._kept(layout.IMAGE_WORDS)[*self.job.place_of(basin), :] = words

    def read_image_words(self, basin: int) -> ImageSet:
        """Read the distinct images of a basin."""
        with told_as_store_failure(self.location):
            return with_counts(np.asarray(self._kept(layout.IMAGE_WORDS)[*self.job.place_of(basin), :]))

    def write_groups(self, basin: int, groups: CellGroups) -> None:
        """Write Hsu's numbers on a basin's image set, for tiles to look up."""
        with told_as_store_failure(self.location):
            for variable, values in zip(layout.IMAGE_SET, groups[1:], strict=True):
                self._kept(variable)[*self.job.place_of(basin), : values.size] = values

    def read_groups(self, basin: int) -> CellGroups:
        """Read Hsu's numbers on a basin's image set."""
        members = self.read_image_words(basin)
        place = self.job.place_of(basin)
        with told_as_store_failure(self.location):
            group, step = (np.asarray(self._kept(each)[*place, : members.size]) for each in layout.IMAGE_SET[:2])
            cycles = int(group.max(initial=0)) + 1
            period = np.asarray(self._kept(layout.IMAGE_SET[2])[*place, :cycles])
        return CellGroups(members, group, step, period)

    def write_grazing_velocity(self, basin: int, velocity: np.ndarray) -> None:
        """Write the grazing curve of a basin."""
        with told_as_store_failure(self.location):
            self._kept(layout.GRAZING)[*self.job.place_of(basin), :] = velocity

    def write_image_counts(self, counts: np.ndarray) -> None:
        """Note how many places of each basin have each reserved image, shape (basins, 3) (driver only)."""
        self._fence()
        with told_as_store_failure(self.location):
            self._array(layout.IMAGE_COUNTS)[...] = counts.reshape(*self.job.sweep_shape, 3)

    def read_image_counts(self) -> np.ndarray:
        """Read them, shape (basins, 3); negative where a basin is not mapped yet."""
        with told_as_store_failure(self.location):
            return np.asarray(self._array(layout.IMAGE_COUNTS)[...]).reshape(-1, 3)

    def make_room(self, table: SolutionTable, points: int) -> None:
        """Lengthen the arrays of solutions, where they are too short, and say what the new ones are (driver only).

        Parameters
        ----------
        table : SolutionTable
        points : int
            Most points of an attractor.
        """
        self._fence()
        with told_as_store_failure(self.location):
            there = self._kept_with_room(layout.POINTS[0], (len(table.motions), points)).shape[-2:]
            room = max(there[0], len(table.motions)), max(there[1], points)
            if room == there:
                return
            names = [motion.name for motion in table.motions]
            columns = [np.array(column) for column in zip(*table.motions, strict=True)]
            for variable in self._measured():
                self._array(variable).resize((*self.job.sweep_shape, room[0]))
            for variable, values in zip(
                layout.MOTIONS, (*columns, np.array(names, np.dtypes.StringDType())), strict=True
            ):
                array = self._array(variable)
                array.resize(room[:1])
                array[: len(names)] = values
            flags = {"flag_values": list(range(len(names))), "flag_meanings": " ".join(_words(names))}
            self._group[self.places.solution.path].update_attributes(flags)
            # Last of all the one that tells how much room there is: a driver that is killed before does it all again.
            for variable in reversed(layout.POINTS):
                self._array(variable).resize((*self.job.sweep_shape, *room))
            consolidate(self.location, self._fence)

    def _measured(self) -> tuple[Variable, ...]:
        return layout.MEASURED if self.job.sample is None else (*layout.MEASURED, layout.SHARE_ERROR)

    def write_points(self, basin: int, numbers: Sequence[int], attractors: Sequence[Attractor]) -> None:
        """Write the points of a basin's attractors, under their numbers.

        Only as many as there are: which chunks a basin has does not depend on how much room others needed before.
        """
        place = self.job.place_of(basin)
        shape = max(numbers) + 1, max(attractor.time.size for attractor in attractors)
        with told_as_store_failure(self.location):
            for variable, field in zip(layout.POINTS, ("time", "velocity"), strict=True):
                padded = np.full(shape, np.nan)
                for number, attractor in zip(numbers, attractors, strict=True):
                    values = getattr(attractor, field)
                    padded[number, : values.size] = values
                self._kept_with_room(variable, shape)[*place, : shape[0], : shape[1]] = padded

    def write_solutions(self, table: SolutionTable) -> None:
        """Write what solutions are like in each basin, those that there is room for (driver only)."""
        self._fence()
        columns = table.columns
        if self.job.sample is not None:
            columns.append(share_error(table.share, self.job.sample.points))
        with told_as_store_failure(self.location):
            # Shares last: they tell which basins are complete.
            for variable, values in reversed(list(zip(self._measured(), columns, strict=True))):
                array = self._array(variable)
                room = min(array.shape[-1], len(table.motions))
                array[..., :room] = values[:, :room].reshape(*self.job.sweep_shape, room)

    def read_solutions(self) -> SolutionTable:
        """What solutions there are and what they are like in each basin, as far as that is known."""
        with told_as_store_failure(self.location):
            motions = [np.asarray(self._array(variable)[...]) for variable in layout.MOTIONS[:4]]
            columns = [np.asarray(self._array(variable)[...]) for variable in layout.MEASURED]
        # A driver that was killed while it made room has left some longer than others, or empty at their ends.
        room = min(column.shape[-1] for column in motions + columns)
        filled = [column[:room] != variable.fill for column, variable in zip(motions, layout.MOTIONS[:4], strict=True)]
        known = int(np.cumprod(np.all(filled, axis=0)).sum())
        listed = [
            Motion(AttractorKind(kind), *contacts)
            for kind, *contacts in zip(*(column[:known].tolist() for column in motions), strict=True)
        ]
        return SolutionTable(
            listed, *(column.reshape(self.job.basins, column.shape[-1])[:, :known] for column in columns)
        )

    def read_catalogue(self, basin: int, table: SolutionTable, numbers: Sequence[int]) -> tuple[Attractor, ...]:
        """Some of the attractors of a basin, by their numbers; those whose points are being written have none yet."""
        with told_as_store_failure(self.location):
            place = self.job.place_of(basin)
            points = [np.asarray(self._array(variable)[*place, :, :]) for variable in layout.POINTS]
        # A reader may come between the two arrays, which are lengthened and written one after the other.
        rows, columns = np.min([each.shape for each in points], axis=0)
        nothing = np.full((1, columns), np.nan)
        time, velocity = (np.vstack([each[:rows, :columns], nothing]) for each in points)
        there = np.isfinite(time) & np.isfinite(velocity)
        return tuple(
            Attractor(
                *table.motions[number], float(table.exponent[basin, number]), float(table.error[basin, number]),
                time[row][there[row]], velocity[row][there[row]], float(table.mean_life[basin, number]),
            )
            for number, row in ((number, min(number, rows)) for number in numbers)
        )  # fmt: skip

    def write_changes(self, columns: Sequence[np.ndarray]) -> None:
        """Write the births and deaths of solutions (driver only)."""
        self._fence()
        with told_as_store_failure(self.location):
            for variable, values in zip(layout.CHANGES, columns, strict=True):
                if variable.name in self._group:
                    del self._group[variable.name]
                create_array(self._group, self.job, variable, values.shape)[...] = values

    def finish(self, seconds: dict[str, float]) -> None:
        """Consolidate the store's metadata and mark it complete (driver only)."""
        self._fence()
        with told_as_store_failure(self.location):
            consolidate(self.location, self._fence)
            # Written with the consolidated metadata, in one piece: what is complete is so for every reader.
            whole = open_group(self.location, "r+", consolidated=True, fence=self._fence)
            whole.update_attributes({"complete": True, "finished": now(), "seconds": seconds})

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the store."""
        return dict(self._group.attrs)

    def sweep_orphans(self) -> None:
        """Remove temporary files that killed writers left behind (driver only)."""
        self._fence()
        with told_as_store_failure(self.location):
            place_at(self.location).sweep()


def _words(names: list[str]) -> list[str]:
    """CF flag meanings: blank-separated words, one of them for each solution, so names that recur are numbered."""
    words = [name.replace(" ", "_") for name in names]
    return [word if words.count(word) == 1 else f"{word}_{words[: i + 1].count(word)}" for i, word in enumerate(words)]
