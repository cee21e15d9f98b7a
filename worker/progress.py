"""How far a job is."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum


class Stage(StrEnum):
    """What a running job does at the moment; of a sweep, what the basin does that is least far."""

    MAPPING = "mapping"
    """Tiles compute the images of their cells."""
    ASSEMBLING = "assembling"
    """Hsu's algorithm on the image set, and the catalogue of attractors."""
    LABELLING = "labelling"
    """Tiles look up group, period and step and name solutions."""
    DONE = "done"
    """Everything is in the store."""


@dataclass(frozen=True)
class Progress:
    """State of one stage; tiles already in the store when a job is resumed count as done."""

    stage: Stage
    tiles_done: int
    tiles_total: int
    cells_done: int
    cells_total: int
    cells_per_second: float
    """Cells that this run has mapped per second; 0 until the first tile."""
    seconds_left: float | None
    """Estimate for this stage; None until there is one."""
    basins_done: int
    basins_total: int
    """Basins of a sweep that are complete, and how many there are; one where nothing is swept."""


Report = Callable[[Progress], None]
