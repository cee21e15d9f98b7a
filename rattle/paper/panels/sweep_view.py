"""A sweep over one parameter as a figure shows it: the basin at each value, and births and deaths between them."""

from dataclasses import dataclass

from rattle.paper.panels.basin_view import BasinView, view_basin
from worker.jobs.basin_job import BasinJob, basin_job
from worker.stores.summary import Change, summarise


@dataclass(frozen=True)
class SweepView:
    """Contents of a complete store of a sweep. ``basins`` are in the order of the values and share one numbering."""

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
        If there is no store.
    """
    summary = summarise(location)
    basins = tuple(view_basin(location, panel) for panel in range(len(summary.basins)))
    return SweepView(basin_job(summary.request), basins, summary.changes)
