"""The kinds of jobs there are: how each is read from its request, and how it is run."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

from worker.analyses.kinds import ANALYSES
from worker.analyses.run import run_analysis
from worker.basins.pipeline import run_basin
from worker.cluster.driver import Driver
from worker.fence import Fence
from worker.job import Job
from worker.jobs.basin_job import BasinJob
from worker.progress import Report


class Run(Protocol):
    """How a job is run: into a store at a location, or on from what lies there."""

    def __call__(
        self, job: Any, location: str, driver: Driver, *, report: Report, cancel: threading.Event, fence: Fence
    ) -> None:
        """Run a job; see `worker.basins.pipeline.run_basin`."""


@dataclass(frozen=True)
class JobKind:
    """One kind of job."""

    from_request: Callable[[dict[str, Any]], Job]
    run: Run


_BASINS = JobKind(BasinJob.from_request, run_basin)
JOB_KINDS: dict[str, JobKind] = {"basin": _BASINS, "sweep": _BASINS} | {
    kind: JobKind(analysis.from_request, partial(run_analysis, analysis)) for kind, analysis in ANALYSES.items()
}
"""By name, as ``Job.kind`` says it."""
