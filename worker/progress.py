"""How far a job is."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

from worker.additions import additions


class Stage(StrEnum):
    """What a running job does at the moment, or one basin of it."""

    COMPUTING = "computing"
    """All of the following: of a sweep whose basins are at different stages, or of a small basin in one go."""
    COMPILING = "compiling"
    """Workers compile kernels, a minute or so: the first job with harmonics needs its own."""
    MAPPING = "mapping"
    """Tiles compute the images of their cells."""
    ASSEMBLING = "assembling"
    """Hsu's algorithm on the image set, and the catalogue of attractors."""
    LABELLING = "labelling"
    """Tiles look up group, period and step and name solutions."""
    # What basins are asked for beside their labels comes after these.
    vars().update({stage.upper(): stage for addition in additions() for stage in addition.stages})
    SEARCHING = "searching"
    """Attractors, periodic orbits or saddles are looked for."""
    SETTLING = "settling"
    """Motions are followed from value to value of a parameter."""
    CONTINUING = "continuing"
    """Orbits are followed in one parameter."""
    TRACING = "tracing"
    """Curves are drawn: of special points in two parameters, or pre-images of the grazing curve."""
    GROWING = "growing"
    """Branches of manifolds grow."""
    DONE = "done"
    """Everything is in the store."""


@dataclass(frozen=True)
class BasinProgress:
    """How far one basin of a sweep is: its number, its stage, and how many of its tiles have passed that."""

    basin: int
    stage: Stage
    tiles_done: int
    tiles_total: int


@dataclass(frozen=True)
class Progress:
    """State of one stage; tiles already in the store when a job is resumed count as done.

    A sweep is in one stage, computing, from beginning to end: its tiles are done when their basin is complete.
    What has no tiles has pieces in their place, and neither cells nor basins: 0 of 0.

    Examples
    --------
    >>> import rattle
    >>> seen = []
    >>> basin = rattle.basin(cells=20, store="followed.zarr", progress=seen.append)
    >>> seen[-1].stage.value, seen[-1].tiles_done, seen[-1].tiles_total
    ('done', 1, 1)
    """

    stage: Stage
    tiles_done: int
    tiles_total: int
    cells_done: int
    cells_total: int
    cells_per_second: float
    """Cells that this run has done per second of the stage, 0 until its first tile; at the end, of the whole run."""
    seconds_left: float | None
    """Estimate for this stage; None until there is one."""
    basins_done: int
    basins_total: int
    """Basins of a sweep that are complete, and how many there are; one where nothing is swept."""
    under_way: tuple[BasinProgress, ...] = ()
    """Basins of a sweep that are begun and not complete, a few at any time."""

    def while_compiling(self) -> "Progress":
        """The same progress, while workers compile and nothing else goes on."""
        return replace(self, stage=Stage.COMPILING, seconds_left=None)


Report = Callable[[Progress], None]
