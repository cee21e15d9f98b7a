"""A sweep over one parameter as a figure sees it: the basin at each value, and what is born and dies between them."""

from dataclasses import dataclass

from rattle.paper.panels.basin_view import BasinView, view_basin
from worker.jobs.basin_job import BasinJob, basin_job
from worker.stores.summary import Change, summarise


@dataclass(frozen=True)
class SweepView:
    """What a complete store of a sweep says; ``basins`` are in the order of the values, under one numbering."""

    job: BasinJob
    basins: tuple[BasinView, ...]
    changes: tuple[Change, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each solution, by number."""
        return tuple(attractor.name for attractor in self.basins[0].attractors)


def view_sweep(location: str) -> SweepView:
    """Read a complete store of a sweep.

    Raises
    ------
    StoreConflict
        Where there is none.
    """
    summary = summarise(location)
    basins = tuple(view_basin(location, panel) for panel in range(len(summary.basins)))
    return SweepView(basin_job(summary.request), basins, summary.changes)
