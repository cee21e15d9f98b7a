"""From the job of an analysis to its complete store: pieces run on workers, and their parts are assembled.

The store is authoritative: a piece is done if its part is marked whole there. After any crash or cancellation the same
call computes only what is missing.
"""

import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rattle_kernels import OutsideDomain
from worker.analyses.analysis import Analysis, Plan
from worker.cluster.calls import Task, stop_if_cancelled
from worker.cluster.driver import Driver
from worker.errors import InvalidJob, StoreFailed
from worker.fence import Fence, unfenced
from worker.jobs.job import AnalysisJob
from worker.progress import Progress, Report, Stage
from worker.stores.analysis_store import AnalysisStore, StoredParts
from worker.stores.layout import Columns
from worker.stores.opening import demand_own_request, demand_same_digest
from worker.stores.summary import without_nan


@dataclass(frozen=True)
class AnalysisSummary:
    """Summary of the result in a store, complete or not."""

    kind: str
    complete: bool
    request: dict[str, Any]
    pieces_done: int
    seconds: dict[str, float]
    result: dict[str, Any]


def compute_piece(
    location: str, digest: str, number: int, name: str, compute: Callable[..., Columns], arguments: tuple[Any, ...]
) -> float:
    """Compute one piece and write its part. Return the time that it took, in seconds."""
    store = AnalysisStore(location)
    demand_same_digest(location, store.digest, digest)
    begin = time.perf_counter()
    columns = compute(*arguments, pause=stop_if_cancelled)
    stop_if_cancelled()
    store.write_part(name, columns)
    return time.perf_counter() - begin


def run_analysis(
    analysis: Analysis,
    job: AnalysisJob,
    location: str,
    driver: Driver,
    *,
    report: Report,
    cancel: threading.Event,
    fence: Fence = unfenced,
) -> None:
    """Compute an analysis into a store, or continue the store that is there.

    `summarise_analysis` reads the result.

    Parameters
    ----------
    analysis : Analysis
    job : AnalysisJob
    location : str
        The store.
    driver : Driver
    report : callable
        Called with a `Progress` after every piece.
    cancel : threading.Event
        Set it to stop. The store stays readable and can be resumed.
    fence : Fence
        Needed if another driver may take over the job.

    Raises
    ------
    JobCancelled, LeaseLost, NotFound, StoreConflict, StoreFailed, TileFailed, ClusterFailed, UnlikeWorkers
    """
    store = AnalysisStore.create_or_resume(location, analysis.title, job, fence)
    if store.complete:
        store.remove_parts()
        return
    run = _Run(analysis, job, store.parts(), report)
    try:
        tasks = driver.run_tasks(
            (location, store.digest), run.next_task, cancel, compiling=lambda: report(run.progress().while_compiling())
        )
        for task, seconds in tasks:
            task.then(task.number, seconds)
    finally:
        store.publish(analysis.layout(job), analysis.assemble(job, run.parts))
    store.finish(run.seconds)
    run.report_stage(Stage.DONE)


@dataclass
class _Run:
    """An analysis in progress."""

    analysis: Analysis
    job: AnalysisJob
    parts: StoredParts
    report: Report
    seconds: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._under_way: set[str] = set()
        self._begun = 0
        self._stage: Stage | None = None
        self._plan_next()

    def _plan_next(self) -> None:
        self._plan: Plan = self.analysis.plan(self.job, self.parts)
        self.report_stage(self._plan.stage)

    def next_task(self) -> Task | None:
        """The next piece that can be computed, as a task."""
        for piece in self._plan.ready:
            if piece.name not in self._under_way:
                self._under_way.add(piece.name)
                self._begun += 1
                done = partial(self._done, piece.name)
                return Task(compute_piece, self._begun, tuple(piece), done, f"piece {piece.name}")
        return None

    def _done(self, name: str, number: int, seconds: float) -> Iterable[Task]:
        """Record that a piece is done, and plan again."""
        self.seconds[self._plan.stage.value] = self.seconds.get(self._plan.stage.value, 0.0) + seconds
        self._under_way.discard(name)
        self.parts.add(name)
        self._plan_next()
        return ()

    def report_stage(self, stage: Stage) -> None:
        """Report the progress of a stage."""
        if stage != self._stage:
            self._stage, self._since, self._at_start = stage, time.monotonic(), self._plan.done
        self.report(self.progress())

    def progress(self) -> Progress:
        """Progress of the stage that was reported last."""
        elapsed, done = time.monotonic() - self._since, self._plan.done - self._at_start
        left = elapsed / done * (self._plan.total - self._plan.done) if done else None
        stage = self._stage or self._plan.stage
        return Progress(stage, self._plan.done, self._plan.total, 0, 0, 0.0, left, 0, 0)


def read_analysis(analysis: Analysis, location: str) -> tuple[Any, Columns, AnalysisStore]:
    """Job and columns of a store: its tables if it is complete, otherwise columns assembled from its parts.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    store = AnalysisStore(location)
    job = _job_of(analysis, store)
    if not store.complete:
        columns, failure = _from_parts(analysis, job, store)
        # A driver marks the store complete before it removes the parts. If it is still unmarked, they were whole.
        store = AnalysisStore(location)
        if not store.complete:
            if failure is not None:
                raise StoreFailed(f"the store {location} has lost a part of what was found: {failure}") from failure
            return job, columns, store
    return job, store.read_tables(), store


def _job_of(analysis: Analysis, store: AnalysisStore) -> Any:
    """The job of a store; refused if its request was changed since the store was made, when it was accepted."""
    try:
        job = analysis.from_request(store.request)
    except (InvalidJob, OutsideDomain) as error:
        told = f"the request of the store {store.location} cannot be read: {error}"
        raise StoreFailed(f"{told}; `rattle check` tells whether it is what was stored") from error
    demand_own_request(store.location, job.digest, store.digest)
    return job


def _from_parts(analysis: Analysis, job: Any, store: AnalysisStore) -> tuple[Columns, Exception | None]:
    """Columns assembled from the parts, or the error that prevents it."""
    try:
        return analysis.assemble(job, store.parts()), None
    except (StoreFailed, KeyError) as error:
        return {}, error


def fingerprint_of_analysis(analysis: Analysis, location: str) -> bytes:
    """Bytes that change whenever a picture of the store does. They list its parts and say whether it is complete.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    store = AnalysisStore(location)
    _job_of(analysis, store)
    return " ".join([str(store.complete), *sorted(store.parts())]).encode()


def summarise_analysis(analysis: Analysis, location: str) -> AnalysisSummary:
    """Summary of the store at a location, finished or not.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    job, columns, store = read_analysis(analysis, location)
    return AnalysisSummary(
        job.kind, store.complete, store.request, len(store.parts()), dict(store.attributes.get("seconds", {})),
        without_nan(analysis.summarise(job, columns)),
    )  # fmt: skip
