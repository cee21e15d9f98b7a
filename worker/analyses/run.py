"""From the job of an analysis to its complete store: pieces run on workers, and what they find is put together.

Truth is in the store: a piece counts as done when its part is marked whole there. After any crash, or a cancellation,
the same call computes only what is missing.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from distributed import Client

from worker.analyses.analysis import Analysis, Plan
from worker.cluster.driver import run_tasks
from worker.cluster.task import Task, stop_if_cancelled
from worker.errors import StoreConflict, StoreFailed
from worker.fence import Fence, unfenced
from worker.jobs.job import AnalysisJob
from worker.progress import Progress, Report, Stage
from worker.stores.analysis_store import AnalysisStore, StoredParts
from worker.stores.layout import Columns


@dataclass(frozen=True)
class AnalysisSummary:
    """What a store holds, in short; a result that is not complete says so."""

    kind: str
    complete: bool
    request: dict[str, Any]
    pieces_done: int
    seconds: dict[str, float]
    told: dict[str, Any]


def compute_piece(
    location: str, digest: str, number: int, name: str, compute: Callable[..., Columns], arguments: tuple[Any, ...]
) -> float:
    """Compute one piece and write its part; the seconds that it took."""
    store = AnalysisStore(location)
    if store.digest != digest:
        raise StoreConflict(f"{location} holds the store of another request by now")
    begin = time.perf_counter()
    columns = compute(*arguments, pause=stop_if_cancelled)
    stop_if_cancelled()
    store.write_part(name, columns)
    return time.perf_counter() - begin


def run_analysis(
    analysis: Analysis,
    job: AnalysisJob,
    location: str,
    client: Client,
    *,
    report: Report,
    cancel: threading.Event,
    fence: Fence = unfenced,
) -> AnalysisSummary:
    """Compute an analysis into a store, or finish what was begun.

    Parameters
    ----------
    analysis : Analysis
    job : AnalysisJob
    location : str
        Where the store is, or shall be.
    client : distributed.Client
    report : callable
        Called with a `Progress` after every piece.
    cancel : threading.Event
        Set it to stop; the store stays readable and can be resumed.
    fence : Fence
        Called before everything that only the driver writes.

    Returns
    -------
    AnalysisSummary

    Raises
    ------
    JobCancelled, LeaseLost, NotFound, StoreConflict, StoreFailed, TileFailed, ClusterFailed, UnlikeWorkers
    """
    store = AnalysisStore.create_or_resume(location, analysis.title, job, fence)
    if store.complete:
        store.remove_parts()
        return summarise_analysis(analysis, location)
    run = _Run(analysis, job, store.parts(), report)
    try:
        for task, seconds in run_tasks(client, (location, store.digest), run.following, cancel):
            run.take(task, seconds)
    finally:
        store.publish(analysis.layout(job), analysis.assemble(job, run.parts))
    store.finish(run.seconds)
    run.tell(Stage.DONE)
    return summarise_analysis(analysis, location)


@dataclass
class _Run:
    """An analysis under way."""

    analysis: Analysis
    job: AnalysisJob
    parts: StoredParts
    report: Report
    seconds: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._under_way: set[str] = set()
        self._begun = 0
        self._stage: Stage | None = None
        self._plan = self._next()

    def _next(self) -> Plan:
        self._plan = self.analysis.plan(self.job, self.parts)
        self.tell(self._plan.stage)
        return self._plan

    def following(self) -> Task | None:
        """The next piece that can be computed, as a task."""
        for piece in self._plan.ready:
            if piece.name not in self._under_way:
                self._under_way.add(piece.name)
                self._begun += 1
                return Task(compute_piece, self._begun, 0, tuple(piece), f"piece {piece.name}")
        return None

    def take(self, task: Task, seconds: float) -> None:
        """Note that a piece is done, and what can be done now."""
        name = task.arguments[0]
        self.seconds[self._plan.stage.value] = self.seconds.get(self._plan.stage.value, 0.0) + seconds
        self._under_way.discard(name)
        self.parts.add(name)
        self._next()

    def tell(self, stage: Stage) -> None:
        """Report how far the stage is."""
        if stage != self._stage:
            self._stage, self._since, self._at_start = stage, time.monotonic(), self._plan.done
        elapsed, done = time.monotonic() - self._since, self._plan.done - self._at_start
        left = elapsed / done * (self._plan.total - self._plan.done) if done else None
        self.report(Progress(stage, self._plan.done, self._plan.total, 0, 0, 0.0, left, 0, 0))


def read_analysis(analysis: Analysis, location: str) -> tuple[Any, Columns, AnalysisStore]:
    """Job and columns of a store: its tables where it is complete, else what the parts that are there give.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    store = AnalysisStore(location)
    job = analysis.from_request(store.request)
    if not store.complete:
        columns, failure = _from_parts(analysis, job, store)
        # A driver that finishes says so before it removes the parts: where it has not yet, they were whole.
        store = AnalysisStore(location)
        if not store.complete:
            if failure is not None:
                raise StoreFailed(f"the store {location} has lost a part of what was found: {failure}") from failure
            return job, columns, store
    return job, store.read_tables(), store


def _from_parts(analysis: Analysis, job: Any, store: AnalysisStore) -> tuple[Columns, Exception | None]:
    """What the parts that are there give, or why they give nothing."""
    try:
        return analysis.assemble(job, store.parts()), None
    except (StoreFailed, KeyError) as error:
        return {}, error


def fingerprint_of_analysis(location: str) -> bytes:
    """What changes whenever a picture of the store does: which parts are there, and whether it is complete.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    store = AnalysisStore(location)
    return " ".join([str(store.complete), *sorted(store.parts())]).encode()


def summarise_analysis(analysis: Analysis, location: str) -> AnalysisSummary:
    """Read what a store holds.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    job, columns, store = read_analysis(analysis, location)
    return AnalysisSummary(
        job.kind, store.complete, store.request, len(store.parts()), dict(store.attributes.get("seconds", {})),
        without_nan(analysis.tell(job, columns)),
    )  # fmt: skip


def without_nan(told: Any) -> Any:
    """The same with None for every number that is none, as JSON has it."""
    if isinstance(told, dict):
        return {name: without_nan(value) for name, value in told.items()}
    if isinstance(told, list | tuple):
        return [without_nan(value) for value in told]
    return None if isinstance(told, float) and not np.isfinite(told) else told
