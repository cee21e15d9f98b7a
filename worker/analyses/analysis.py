"""The common structure of analyses: work is split into pieces, whose columns are assembled into tables.

Analyses are bifurcation diagrams, periodic orbits with their branches, manifolds, and pre-images of the grazing curve.
The pieces depend on the request and on the results of other pieces, never on timing. So the same request always gives
the same bytes.

From the job of an analysis to its complete store: pieces run on workers, and their parts are assembled. The store is
authoritative: a piece is done if its part is marked whole there. After any crash or cancellation the same call computes
only what is missing.
"""

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

from matplotlib.figure import Figure
from pydantic import BaseModel, Field

from rattle_kernels import OutsideDomain
from worker.cluster.calls import Task, stop_if_cancelled
from worker.cluster.driver import Driver
from worker.errors import InvalidJob, StoreFailed
from worker.fence import Fence, unfenced
from worker.jobs.job import AnalysisJob
from worker.pictures.figure_file import new_figure
from worker.pictures.panel_picture import USUAL_LOOK, Look
from worker.progress import Progress, Report, Stage
from worker.rounding import demand_same_rounding
from worker.stores.analysis_store import AnalysisStore, StoredParts
from worker.stores.layout import Columns, Variable
from worker.stores.opening import demand_own_request, demand_same_digest
from worker.stores.summary import without_nan

Parts = Mapping[str, Columns]
"""Columns of the finished pieces, by name."""


class Piece(NamedTuple):
    """Work for one worker: ``compute(*arguments, pause=...)`` returns its columns. Its name is unique in the job."""

    name: str
    compute: Callable[..., Columns]
    arguments: tuple[Any, ...]


class Plan(NamedTuple):
    """The current stage: the pieces that can be computed now, how many are done, and how many there are."""

    stage: Stage
    ready: tuple[Piece, ...]
    done: int
    total: int


class AnalysisView(BaseModel):
    """What all results of analyses have as JSON, complete or not. Each kind adds its own, and `kind`."""

    complete: bool
    request: dict[str, Any]
    pieces_done: int = Field(description="Pieces that are done and not yet assembled; 0 when complete")
    seconds: dict[str, float] = Field(description="Time of the kernels in each stage, summed over pieces")
    zarr: str


@dataclass(frozen=True)
class AnalysisSummary:
    """Summary of the result in a store, complete or not."""

    kind: str
    complete: bool
    request: dict[str, Any]
    pieces_done: int
    seconds: dict[str, float]
    result: dict[str, Any]

    def as_json(self) -> dict[str, Any]:
        """All of it, as the `AnalysisView` of its kind describes it but for ``zarr``."""
        return {
            "kind": self.kind, "complete": self.complete, "request": self.request, "pieces_done": self.pieces_done,
            "seconds": self.seconds,
        } | self.result  # fmt: skip

    def found(self) -> dict[str, Any]:
        """What was found, and the time that it took."""
        return self.result | {"seconds": self.seconds}


@dataclass(frozen=True)
class Analysis:
    """One kind of analysis.

    Parameters
    ----------
    title : str
        Title of its stores.
    job : type
        Class of its jobs.
    plan : callable
        ``plan(job, parts)``: what to do next. The job ends when no piece is ready or in progress.
    assemble : callable
        ``assemble(job, parts)``: the store's columns, from the parts found so far.
    layout : callable
        ``layout(job)``: variables of the store, one for each column.
    summarise : callable
        ``summarise(job, columns)``: a summary of the result, as JSON.
    view : type
        An `AnalysisView` that describes that summary.
    draw : callable
        ``draw(job, columns, figure)``.
    """

    title: str
    job: type[AnalysisJob]
    plan: Callable[[Any, Parts], Plan]
    assemble: Callable[[Any, Parts], Columns]
    layout: Callable[[Any], tuple[Variable, ...]]
    summarise: Callable[[Any, Columns], dict[str, Any]]
    view: type[AnalysisView]
    draw: Callable[[Any, Columns, Figure], object]

    def run(
        self, job: AnalysisJob, location: str, driver: Driver, *, report: Report, cancel: threading.Event,
        fence: Fence = unfenced,
    ) -> None:  # fmt: skip
        """Compute a job into a store, or continue the store that is there.

        `summary` reads the result.

        Parameters
        ----------
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
        store = AnalysisStore.create_or_resume(location, self.title, job, fence)
        if store.complete:
            store.remove_parts()
            return
        run = _Run(self, job, store.parts(), report)
        try:
            tasks = driver.run_tasks(
                (location, store.digest), run.next_task, cancel,
                compiling=lambda: report(run.progress().while_compiling()),
            )  # fmt: skip
            for task, seconds in tasks:
                task.then(task.number, seconds)
        finally:
            store.publish(self.layout(job), self.assemble(job, run.parts))
        store.finish(run.seconds)
        run.report_stage(Stage.DONE)

    def read(self, location: str) -> tuple[Any, Columns, AnalysisStore]:
        """Job and columns of a store: its tables if it is complete, otherwise columns assembled from its parts.

        Raises
        ------
        StoreConflict, StoreFailed
        """
        store = AnalysisStore(location)
        job = self._job_of(store)
        if not store.complete:
            columns, failure = self._from_parts(job, store)
            # A driver marks the store complete before it removes the parts. If it is still unmarked, they were whole.
            store = AnalysisStore(location)
            if not store.complete:
                if failure is not None:
                    raise StoreFailed(f"the store {location} has lost a part of what was found: {failure}") from failure
                return job, columns, store
        return job, store.read_tables(), store

    def _job_of(self, store: AnalysisStore) -> Any:
        """The job of a store; refused if its request was changed since the store was made, when it was accepted."""
        try:
            job = self.job.from_request(store.request)
        except (InvalidJob, OutsideDomain) as error:
            told = f"the request of the store {store.location} cannot be read: {error}"
            raise StoreFailed(f"{told}; `rattle check` tells whether it is what was stored") from error
        demand_own_request(store.location, job.digest, store.digest)
        return job

    def _from_parts(self, job: Any, store: AnalysisStore) -> tuple[Columns, Exception | None]:
        """Columns assembled from the parts, or the error that prevents it."""
        try:
            return self.assemble(job, store.parts()), None
        except (StoreFailed, KeyError) as error:
            return {}, error

    def summary(self, location: str) -> AnalysisSummary:
        """Summary of the store at a location, finished or not.

        Raises
        ------
        StoreConflict, StoreFailed
        """
        job, columns, store = self.read(location)
        return AnalysisSummary(
            job.kind, store.complete, store.request, len(store.parts()), dict(store.attributes.get("seconds", {})),
            without_nan(self.summarise(job, columns)),
        )  # fmt: skip

    def fingerprint(self, location: str) -> bytes:
        """Bytes that change whenever a picture of the store does: its parts, and whether it is complete.

        Raises
        ------
        StoreConflict, StoreFailed
        """
        store = AnalysisStore(location)
        self._job_of(store)
        return " ".join([str(store.complete), *sorted(store.parts())]).encode()

    def figure(self, location: str, look: Look = USUAL_LOOK) -> Figure:
        """Picture of the store at a location, finished or not.

        Raises
        ------
        InvalidJob
            If a window or a panel is asked for, which it has none of.
        StoreConflict, StoreFailed
        """
        if look.window is not None or look.panel is not None:
            raise InvalidJob("only basins and sweeps have a window and a panel: leave them out")
        job, columns, _ = self.read(location)
        figure = new_figure(10.0, 6.5)
        self.draw(job, columns, figure)
        return figure


def in_order(parts: Parts, prefix: str) -> list[Columns]:
    """Columns of the parts whose names begin with a prefix, in the order of their names."""
    return [parts[name] for name in sorted(parts) if name.startswith(prefix)]


def ready_of(stage: Stage, pieces: list[Piece], parts: Parts) -> Plan:
    """Plan of a stage whose pieces are all known and do not depend on each other."""
    ready = tuple(piece for piece in pieces if piece.name not in parts)
    return Plan(stage, ready, len(pieces) - len(ready), len(pieces))


def compute_piece(
    location: str, digest: str, number: int, name: str, compute: Callable[..., Columns], arguments: tuple[Any, ...]
) -> float:
    """Compute one piece and write its part. Return the time that it took, in seconds."""
    store = AnalysisStore(location)
    demand_same_digest(location, store.digest, digest)
    demand_same_rounding(location, store.attributes)
    begin = time.perf_counter()
    columns = compute(*arguments, pause=stop_if_cancelled)
    stop_if_cancelled()
    store.write_part(name, columns)
    return time.perf_counter() - begin


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
