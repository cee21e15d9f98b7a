"""The levels of a large basin: each has every second cell of the one before, each way. Pure arithmetic.

Cell (i, j) of level n is cell (2**n i, 2**n j) of the basin, with all of its labels. Labels have no mean, and the most
frequent one of a block would hide the motions that share it (docs/decisions/0037-pyramids.md).
"""

from dataclasses import replace
from typing import NamedTuple

from rattle_kernels.basins.tiles import Tiling
from worker.jobs.basin_job import BasinJob
from worker.stores.layout import COORDINATES, LABELLED, SOLUTION, Variable

LABELS = (*LABELLED, SOLUTION)
"""What the cells of every level have."""
# Longest side of the last level.
_LONGEST_LAST = 1000
# Longest side of a level's chunk, if tiles are not larger. A screen then shows four chunks or fewer.
_LONGEST_CHUNK = 2048


class Level(NamedTuple):
    """Every ``2**number``-th cell of a basin each way, in its own arrays. Level 0 is the basin itself.

    ``tiling`` is that of the level's cells, which it counts one by one; of its grid only the numbers of cells hold.
    """

    number: int
    tiling: Tiling

    @property
    def every(self) -> int:
        """Cells of the basin from one cell of the level to the next."""
        return 1 << self.number

    @property
    def group(self) -> str:
        """Path of the level's arrays; empty for the basin itself."""
        return f"pyramid/{self.number}" if self.number else ""

    def own_path(self, name: str) -> str:
        """Path of an array of the level."""
        return f"{self.group}/{name}" if self.group else name

    def own(self, variable: Variable) -> Variable:
        """A variable of the basin's cells as it lies in this level."""
        return replace(variable, group=self.group)

    @property
    def labels(self) -> tuple[Variable, ...]:
        """Labels of the level's cells."""
        return tuple(map(self.own, LABELS))

    @property
    def coordinates(self) -> tuple[Variable, ...]:
        """Coordinates of the level's cells."""
        return tuple(map(self.own, COORDINATES))


def levels_of(job: BasinJob, tiling: Tiling) -> tuple[Level, ...]:
    """Levels of a job's basins, the basins themselves first.

    Parameters
    ----------
    job : BasinJob
    tiling : Tiling

    Returns
    -------
    tuple of Level
        The basins alone, if they have 4,000 cells or fewer each way or are sampled. Otherwise the last level has 1,000
        or fewer each way.
    """
    levels = [Level(0, tiling)]
    if job.has_levels:
        while max(levels[-1].tiling.grid.shape) > _LONGEST_LAST:
            levels.append(_level(tiling, len(levels)))
    return tuple(levels)


def _level(basins: Tiling, number: int) -> Level:
    rows, columns = (-(-cells // (1 << number)) for cells in basins.grid.shape)
    grid = basins.grid._replace(velocity_cells=rows, time_cells=columns)
    tile = min(_chunk(basins.tile_rows), rows), min(_chunk(basins.tile_columns), columns)
    return Level(number, Tiling(grid, *tile, basins.basins))


def _chunk(side: int) -> int:
    """Side of a chunk: that of so many tiles, a power of two, that four chunks make one of the next level."""
    while 2 * side <= _LONGEST_CHUNK:
        side *= 2
    return side


def level_for(levels: tuple[Level, ...], every: int) -> Level:
    """The smallest level that has every n-th cell, for n a multiple of its own.

    Parameters
    ----------
    levels : tuple of Level
    every : int

    Returns
    -------
    Level

    Examples
    --------
    >>> from rattle_kernels import CellGrid
    >>> from worker.jobs.basin_job import basin_job
    >>> from rattle_kernels.basins.tiles import cut
    >>> grid = {"time": {"cells": 100_000}, "velocity": {"cells": 100_000}}
    >>> oscillator = {"damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6}
    >>> job = basin_job({"oscillator": oscillator, "grid": grid})
    >>> levels = levels_of(job, cut(job.grid, job.applications))
    >>> [level.tiling.grid.time_cells for level in levels]
    [100000, 50000, 25000, 12500, 6250, 3125, 1563, 782]
    >>> level_for(levels, 48).every, level_for(levels, 50).every, level_for(levels, 4096).every
    (16, 2, 128)
    """
    return [level for level in levels if every % level.every == 0][-1]
