"""What a figure of the paper is: the basins that it needs, and how a sheet is made of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from rattle_kernels import CellGrid
from worker.jobs.basin_job import BasinJob

Tell = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and how much there is; it raises where work shall stop."""


@dataclass(frozen=True)
class Sheet:
    """A figure, drawn, and its numbers: what JSON can hold, the same for the same request."""

    drawing: Figure
    numbers: dict[str, Any]


def no_basins(grid: CellGrid) -> dict[str, BasinJob]:
    """Basins of a figure that shows none."""
    return {}


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper.

    Parameters
    ----------
    name : str
        As in ``fig7``.
    shows : str
        What it shows, in a line.
    make : callable
        Draws the sheet from the complete stores of its basins: where they are, by the names that they have below.
    basins : callable
        Jobs that it needs, of one basin or a sweep, by name, over the grid that is asked for.
    """

    name: str
    shows: str
    make: Callable[[Mapping[str, str], Tell], Sheet]
    basins: Callable[[CellGrid], dict[str, BasinJob]] = no_basins
