"""Solutions in the store of basins: the motion of each number, its properties in each basin, and its points.

The number of solutions is not known when a store is created, so these arrays grow as solutions are found. Readers may
read them at any moment.
"""

from collections.abc import Sequence

import numpy as np

from rattle_kernels import Attractor, AttractorKind
from worker.errors import as_store_failure
from worker.storage.chunks import write_over
from worker.stores import layout
from worker.stores.layout import Variable
from worker.stores.new_store import consolidate, create_array
from worker.stores.open_arrays import OpenArrays
from worker.stores.solution_table import Motion, SolutionTable, ends_in


class SolutionArrays:
    """Solutions of a store.

    Parameters
    ----------
    arrays : OpenArrays
    numbers : Variable
        The array with the solution of each cell or point: its metadata name the numbers.
    """

    def __init__(self, arrays: OpenArrays, numbers: Variable) -> None:
        self._arrays, self._numbers = arrays, numbers
        self._location, self._job, self._group, self._fence = arrays.location, arrays.job, arrays.group, arrays.fence

    def make_room(self, table: SolutionTable, points: int) -> None:
        """Extend the arrays of solutions if they are too short, and name the new solutions (driver only).

        Parameters
        ----------
        table : SolutionTable
        points : int
            Most points of an attractor.
        """
        self._fence()
        with as_store_failure(self._location):
            there = self._arrays.array_with_room(layout.POINTS[0], (len(table.motions), points)).shape[-2:]
            room = max(there[0], len(table.motions)), max(there[1], points)
            if room == there:
                return
            names = [motion.name for motion in table.motions]
            *columns, _ = (np.array(column) for column in zip(*table.motions, strict=True))
            for variable in self._measured():
                self._arrays.array(variable).resize((*self._job.sweep_shape, room[0]))
            columns.append(np.array(names, np.dtypes.StringDType()))
            for variable, values in zip(layout.MOTIONS, columns, strict=True):
                array = self._arrays.array(variable)
                array.resize(room[:1])
                array[: len(names)] = values
            flags = {"flag_values": list(range(len(names))), "flag_meanings": " ".join(_words(names))}
            self._group[self._numbers.path].update_attributes(flags)
            if self._lists_ends:
                self._arrays.array(layout.ENDS).resize((*self._job.sweep_shape, room[0], room[0]))
            # Points come last, because their shape says how much room there is. A driver killed earlier starts over.
            for variable in reversed(layout.POINTS):
                self._arrays.array(variable).resize((*self._job.sweep_shape, *room))
            consolidate(self._location, self._fence)

    def empty(self) -> None:
        """Forget all solutions, as in a new store (driver only)."""
        for variable in (*layout.POINTS, *((layout.ENDS,) if self._lists_ends else ())):
            self._arrays.fresh(variable).resize((*self._job.sweep_shape, 0, 0))
        for variable in self._measured():
            self._arrays.fresh(variable).resize((*self._job.sweep_shape, 0))
        for variable in layout.MOTIONS:
            self._arrays.fresh(variable).resize((0,))
        self._arrays.forget_handles()

    @property
    def _lists_ends(self) -> bool:
        """Whether the store has an array for what chaotic transients end in. Older ones have none."""
        return layout.ENDS.path in self._group

    def _measured(self) -> tuple[Variable, ...]:
        return layout.measured(self._job.sample.scramblings if self._job.sample else None)

    def write_points(self, basin: int, numbers: Sequence[int], attractors: Sequence[Attractor]) -> None:
        """Write the points of a basin's attractors, and what its transients end in, under their numbers.

        Only the basin's own numbers are written, so its chunks do not depend on the room that other basins need.
        """
        place = self._job.place_of(basin)
        shape = max(numbers) + 1, max(attractor.time.size for attractor in attractors)
        with as_store_failure(self._location):
            for variable, field in zip(layout.POINTS, ("time", "velocity"), strict=True):
                padded = np.full(shape, np.nan)
                for number, attractor in zip(numbers, attractors, strict=True):
                    values = getattr(attractor, field)
                    padded[number, : values.size] = values
                write_over(self._arrays.array_with_room(variable, shape), (*place, *map(slice, shape)), padded)
            if any(attractor.ends for attractor in attractors) and self._lists_ends:
                shares = np.full((max(numbers) + 1, max(numbers) + 1), np.nan)
                for number, attractor in zip(numbers, attractors, strict=True):
                    for end, share in attractor.ends:
                        shares[number, numbers[end]] = share
                write_over(
                    self._arrays.array_with_room(layout.ENDS, shares.shape), (*place, *map(slice, shares.shape)), shares
                )

    def write(self, table: SolutionTable) -> None:
        """Write the properties of solutions in each basin, as far as there is room (driver only)."""
        self._fence()
        with as_store_failure(self._location):
            # Shares come last, because they say which basins are complete.
            for variable, values in reversed(list(zip(self._measured(), table.columns, strict=False))):
                array = self._arrays.array(variable)
                room = min(array.shape[-1], len(table.motions))
                array[..., :room] = values[:, :room].reshape(*self._job.sweep_shape, room)

    def read(self) -> SolutionTable:
        """Solutions and their properties in each basin, as far as known."""
        with as_store_failure(self._location):
            motions = [np.asarray(self._arrays.fresh(variable)[...]) for variable in layout.MOTIONS[:4]]
            columns = [np.asarray(self._arrays.fresh(variable)[...]) for variable in self._measured()]
        if self._job.sample is None:
            columns.append(np.full_like(columns[0], np.nan))
        # A driver killed while it made room leaves some arrays longer than others, or empty at their ends.
        room = min(column.shape[-1] for column in motions + columns)
        filled = [column[:room] != variable.fill for column, variable in zip(motions, layout.MOTIONS[:4], strict=True)]
        known = int(np.cumprod(np.all(filled, axis=0)).sum())
        columns = [column.reshape(self._job.basins, column.shape[-1])[:, :known] for column in columns]
        rests = np.any(np.isneginf(columns[1]), axis=0)
        listed = [
            Motion(AttractorKind(kind), *contacts)
            for kind, *contacts in zip(*(column[:known].tolist() for column in (*motions, rests)), strict=True)
        ]
        return SolutionTable(listed, *columns)

    def read_catalogue(self, basin: int, table: SolutionTable, numbers: Sequence[int]) -> tuple[Attractor, ...]:
        """Attractors of a basin with these numbers. An attractor whose points are still being written has none.

        Transients say by number what they end in.
        """
        with as_store_failure(self._location):
            place = self._job.place_of(basin)
            points = [np.asarray(self._arrays.fresh(variable)[*place, :, :]) for variable in layout.POINTS]
            transient = any(table.motions[number].kind == AttractorKind.CHAOTIC_TRANSIENT for number in numbers)
            read_ends = transient and self._lists_ends
            ends = np.asarray(self._arrays.fresh(layout.ENDS)[*place, :, :]) if read_ends else np.empty((0, 0))
        # The two arrays are extended and written one after the other. This read may fall in between.
        rows, columns = np.min([each.shape for each in points], axis=0)
        nothing = np.full((1, columns), np.nan)
        time, velocity = (np.vstack([each[:rows, :columns], nothing]) for each in points)
        there = np.isfinite(time) & np.isfinite(velocity)
        return tuple(
            Attractor(
                *table.motions[number][:4], float(table.exponent[basin, number]), float(table.error[basin, number]),
                time[row][there[row]], velocity[row][there[row]], float(table.mean_life[basin, number]),
                ends_in(ends[number]) if number < len(ends) else (),
            )
            for number, row in ((number, min(number, rows)) for number in numbers)
        )  # fmt: skip

    def write_changes(self, columns: Sequence[np.ndarray]) -> None:
        """Write the births and deaths of solutions (driver only)."""
        self._fence()
        with as_store_failure(self._location):
            for variable, values in zip(layout.CHANGES, columns, strict=True):
                if variable.name in self._group:
                    del self._group[variable.name]
                create_array(self._group, self._job, variable, values.shape)[...] = values


def _words(names: list[str]) -> list[str]:
    """CF flag meanings: one word per solution. Names that recur are numbered."""
    words = [name.replace(" ", "_") for name in names]
    return [word if words.count(word) == 1 else f"{word}_{words[: i + 1].count(word)}" for i, word in enumerate(words)]
