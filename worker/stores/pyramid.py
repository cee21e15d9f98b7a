"""The levels of a large basin: each has every second cell of the one before, each way; and how a store says so.

Cell (i, j) of level n is cell (2**n i, 2**n j) of the basin, with all of its labels. Labels have no mean, and the most
frequent one of a block would hide the motions that share it (docs/decisions/0037-pyramids.md).

A store says that it has levels by the convention `multiscales` of zarr-conventions
(https://github.com/zarr-conventions/multiscales, version 0.1).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from rattle_kernels.basins.tiles import Tiling
from worker.jobs.basin_job import BasinJob
from worker.stores.layout import COORDINATES, LABELLED, SOLUTION, Variable

LABELS = (*LABELLED, SOLUTION)
"""What the cells of every level have."""
# Longest side of the last level.
_LONGEST_LAST = 1000
# Longest side of a level's chunk, if tiles are not larger. A screen then shows four chunks or fewer.
_LONGEST_CHUNK = 2048
ATTRIBUTE = "multiscales"
"""Attribute of a store that has levels."""
_CONVENTION = {
    "uuid": "d35379db-88df-4056-af3a-620245f8e347",
    "name": ATTRIBUTE,
    "schema_url": "https://raw.githubusercontent.com/zarr-conventions/multiscales/refs/tags/v0.1/schema.json",
    "spec_url": "https://github.com/zarr-conventions/multiscales/blob/v0.1/README.md",
    "description": "Multiscale layout of zarr datasets",
}
_SAMPLED = (
    "a cell of a level is the first of its block, with all of its labels, and stands for the others: it is sampled, "
    "neither a mean nor the most frequent one. The coordinates are those of this cell."
)


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


def multiscales(levels: Sequence[Level], swept: int) -> dict[str, Any]:
    """Attributes of a store with levels; none if there is only the basin itself.

    Parameters
    ----------
    levels : sequence of Level
    swept : int
        Number of swept parameters, whose dimensions come first.

    Returns
    -------
    dict
        Each asset is an array of solutions. ``group``, ``period`` and ``step`` lie beside it.
    """
    if len(levels) == 1:
        return {}
    layout: list[dict[str, Any]] = [
        {"asset": SOLUTION.path, "transform": _transform(swept, 1.0)},
    ]
    for finer, level in zip(levels, levels[1:], strict=False):
        source, own = finer.own(SOLUTION).path, level.own(SOLUTION).path
        layout.append({"asset": own, "derived_from": source, "transform": _transform(swept, 2.0)})
    return {
        "zarr_conventions": [_CONVENTION],
        ATTRIBUTE: {"layout": layout, "resampling_method": "nearest", "comment": _SAMPLED},
    }


def _transform(swept: int, scale: float) -> dict[str, list[float]]:
    """From the cells of the finer level to this one's. Both begin at the same cell, so nothing is moved."""
    axes = [1.0] * swept
    return {"scale": [*axes, scale, scale], "translation": [0.0] * (swept + 2)}
