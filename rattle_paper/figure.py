"""A figure of the paper: the jobs it needs, and the function that makes a sheet from their results."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from rattle import BasinJob
from rattle_chart.job import ChartJob
from rattle_kernels import CellGrid

Job = BasinJob | ChartJob
"""What a figure may need."""

Results = Mapping[str, xr.Dataset]
"""Results of the jobs that a figure needs, by name."""

Report = Callable[[str, int, int], None]
"""Called with the current step, how much of it is done, and the total."""


@dataclass(frozen=True)
class Sheet:
    """A drawn figure and its numbers. These fit into JSON, and the same request gives the same ones."""

    drawing: Figure
    numbers: dict[str, Any]


@dataclass(frozen=True)
class Printed:
    """A number that the paper prints, and where the figure's own numbers have it.

    Parameters
    ----------
    what : str
    value : float
        As printed.
    place : tuple of str
        Keys that lead to it in `Sheet.numbers`.
    """

    what: str
    value: float
    place: tuple[str, ...]

    def beside(self, numbers: dict[str, Any]) -> dict[str, Any]:
        """The paper's value beside the one found."""
        found: Any = numbers
        for key in self.place:
            found = found[key]
        return {"what": self.what, "paper": self.value, "found": found}


def no_jobs(grid: CellGrid) -> dict[str, Job]:
    """No jobs, for a figure that shows no basin."""
    return {}


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper.

    Parameters
    ----------
    name : str
        Such as ``fig7``.
    shows : str
        What it shows, in one line.
    make : callable
        Draws the sheet. It takes the results, by the names that `jobs` gives them.
    jobs : callable
        Returns the jobs that the figure needs, by name, for a given grid of basins.
    printed : tuple of Printed
        What the paper prints of it in numbers.
    """

    name: str
    shows: str
    make: Callable[[Results, Report], Sheet]
    jobs: Callable[[CellGrid], Mapping[str, Job]] = no_jobs
    printed: tuple[Printed, ...] = ()
