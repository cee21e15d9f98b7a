"""The kinds of jobs: one entry each, from which come its route, its command, its part of the API and how it is run.

To add an analysis, write its job (a class in `worker.jobs`) and its `Analysis` (in `worker.analyses`), and enter both
here. Entries name their modules and load them when they are first used: a command that only calls a service needs
neither Numba nor Dask.
"""

import pkgutil
import threading
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Protocol

from worker.fence import Fence
from worker.progress import Report

if TYPE_CHECKING:
    from worker.jobs.job import Job

_AGAIN = (
    "The same request again answers with the same job. After a failure or a cancellation it makes a new one, which "
    "continues from what is there."
)


class Run(Protocol):
    """How a job is run: into a new store at a location, or continuing the one that is there."""

    def __call__(
        self, job: Any, location: str, driver: Any, *, report: Report, cancel: threading.Event, fence: Fence
    ) -> None:
        """Run a job; see `worker.basins.pipeline.run_basin`."""


@dataclass(frozen=True)
class JobKind:
    """One kind of job.

    Parameters
    ----------
    path : str
        Its route: requests are posted to ``/v1/PATH``.
    summary, description : str
        Of the route.
    command : str
        What ``rattle --help`` says of its command.
    job : str
        Its class, as ``module:name``.
    analysis : str or None
        Its `Analysis`, as ``module:name``; None for basins and sweeps.
    """

    path: str
    summary: str
    description: str
    command: str
    job: str
    analysis: str | None = None

    @cached_property
    def job_class(self) -> "type[Job]":
        """Class of its jobs."""
        found: type[Job] = pkgutil.resolve_name(self.job)
        return found

    @cached_property
    def loaded_analysis(self) -> Any:
        """Its `Analysis`.

        Raises
        ------
        ValueError
            If it is a basin or a sweep.
        """
        if self.analysis is None:
            raise ValueError(f"{self.path} are no analysis")
        return pkgutil.resolve_name(self.analysis)

    @property
    def run(self) -> Run:
        """How its jobs are run."""
        if self.analysis is None:
            basins: Run = pkgutil.resolve_name("worker.basins.pipeline:run_basin")
            return basins
        return partial(pkgutil.resolve_name("worker.analyses.run:run_analysis"), self.loaded_analysis)


KINDS: dict[str, JobKind] = {
    "basin": JobKind(
        path="basins",
        summary="Submit a basin",
        description=f"Compute one basin of attraction.\n\n{_AGAIN}",
        command="Compute one basin on this machine, without a service.",
        job="worker.jobs.basin_job:BasinJob",
    ),
    "sweep": JobKind(
        path="sweeps",
        summary="Submit a sweep",
        description=f"Compute basins over one or two parameters, all into one store.\n\n{_AGAIN}",
        command="Compute basins over one or two parameters into one store, on this machine.",
        job="worker.jobs.basin_job:SweepJob",
    ),
    "bifurcation": JobKind(
        path="bifurcations",
        summary="Submit a bifurcation diagram",
        description=f"Compute a bifurcation diagram.\n\n{_AGAIN}",
        command="Compute a bifurcation diagram: last departures at each value, the very last seeding the next value.",
        job="worker.jobs.bifurcation_job:BifurcationJob",
        analysis="worker.analyses.bifurcation:BIFURCATION",
    ),
    "orbits": JobKind(
        path="orbits",
        summary="Submit a search for periodic orbits",
        description=f"Find periodic orbits, and on request follow them in one parameter or two.\n\n{_AGAIN}",
        command="Find periodic orbits, stable or not; follow them in a parameter and locate special points.",
        job="worker.jobs.orbits_job:OrbitsJob",
        analysis="worker.analyses.orbits:ORBITS_ANALYSIS",
    ),
    "manifold": JobKind(
        path="manifolds",
        summary="Submit manifolds of saddles",
        description="Grow manifolds of saddles.\n\nWhether a seed leads to a saddle is known only when the job runs. "
        f"If it does not, the job fails and says what is there. {_AGAIN}",
        command="Grow stable and unstable manifolds of saddles of the impacting model.",
        job="worker.jobs.manifold_job:ManifoldJob",
        analysis="worker.analyses.manifolds:MANIFOLD",
    ),
    "grazing_curve": JobKind(
        path="grazing-curves",
        summary="Submit a grazing curve",
        description=f"Compute the grazing curve and its pre-images.\n\n{_AGAIN}",
        command="Draw the grazing curve of the impacting model and its pre-images.",
        job="worker.jobs.grazing_curve_job:GrazingCurveJob",
        analysis="worker.analyses.grazing_curves:GRAZING_CURVE",
    ),
}
"""By name, as in ``Job.kind`` and in the records of jobs."""
