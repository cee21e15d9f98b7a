"""The common structure of analyses: work is split into pieces, whose columns are assembled into tables.

Analyses are bifurcation diagrams, periodic orbits with their branches, manifolds, and pre-images of the grazing curve.
The pieces depend on the request and on the results of other pieces, never on timing. So the same request always gives
the same bytes.

Pieces run on workers, and their parts are assembled. A piece is done if its part is marked whole in the store.
"""

import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any, NamedTuple

import xarray as xr
from matplotlib.figure import Figure
from pydantic import BaseModel, Field

from worker.cluster.calls import Task, stop_if_cancelled
from worker.cluster.driver import Driver
from worker.errors import InvalidJob, StoreConflict, StoreFailed
from worker.fence import Fence
from worker.jobs.job import AnalysisJob
from worker.pictures.figure_file import new_figure
from worker.progress import Progress, Stage
from worker.results.panel import USUAL_LOOK, Look
from worker.run import Run
from worker.stores.analysis_store import AnalysisStore, StoredParts
from worker.stores.layout import Columns, Variable

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
        ``summarise(job, columns)``: what was found, as the fields that `view` adds.
    view : type
        The `AnalysisView` of its results.
    draw : callable
        ``draw(job, columns, figure)``.
    """

    title: str
    job: type[AnalysisJob]
    plan: Callable[[Any, StoredParts], Plan]
    assemble: Callable[[Any, Parts], Columns]
    layout: Callable[[Any], tuple[Variable, ...]]
    summarise: Callable[[Any, Columns], dict[str, Any]]
    view: type[AnalysisView]
    draw: Callable[[Any, Columns, Figure], object]

    def runs(self, job: AnalysisJob, location: str, driver: Driver, fence: Fence) -> Iterator[Run]:
        """The pieces of a job, computed into a store; nothing if it is complete. `summary` reads the result.

        Parameters
        ----------
        job : AnalysisJob
        location : str
            The store.
        driver : Driver
        fence : Fence

        Yields
        ------
        Run

        Raises
        ------
        LeaseLost, StoreConflict, StoreFailed
        """
        store = AnalysisStore.create_or_resume(location, self.title, job, fence)
        if store.complete:
            store.remove_parts()
        else:
            yield _Pieces(self, store)

    def read(self, location: str) -> tuple[Any, Columns, AnalysisStore]:
        """Job and columns of a store: its tables if it is complete, otherwise columns assembled from its parts.

        Raises
        ------
        StoreConflict, StoreFailed
        """
        store = self._opened(location)
        job = store.job
        if not store.complete:
            columns, failure = self._from_parts(job, store)
            # A driver marks the store complete before it removes the parts. If it is still unmarked, they were whole.
            store = AnalysisStore.open(location)
            if not store.complete:
                if failure is not None:
                    raise StoreFailed(f"the store {location} has lost a part of what was found: {failure}") from failure
                return job, columns, store
        return job, store.read_tables(), store

    def _opened(self, location: str) -> AnalysisStore:
        """The store at a location; refused if it is another kind's."""
        store = AnalysisStore.open(location)
        if not isinstance(store.job, self.job):
            raise StoreConflict(f"{location} holds an analysis of kind {store.job.kind}")
        return store

    def _from_parts(self, job: Any, store: AnalysisStore) -> tuple[Columns, Exception | None]:
        """Columns assembled from the parts, or the error that prevents it."""
        try:
            return self.assemble(job, store.parts()), None
        except (StoreFailed, KeyError) as error:
            return {}, error

    def summary(self, location: str, zarr: str | None = None) -> AnalysisView:
        """Summary of the store at a location, finished or not; `zarr` is where its reader finds the store.

        Raises
        ------
        StoreConflict, StoreFailed
        """
        job, columns, store = self.read(location)
        return self.view(
            complete=store.complete, request=store.request, pieces_done=len(store.parts()),
            seconds=store.attributes.get("seconds", {}), zarr=location if zarr is None else zarr, kind=job.kind,
            **self.summarise(job, columns),
        )  # fmt: skip

    def fingerprint(self, location: str) -> bytes:
        """Bytes that change whenever a picture of the store does: its parts, and whether it is complete.

        Raises
        ------
        StoreConflict, StoreFailed
        """
        store = self._opened(location)
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
        figure = new_figure()
        self.draw(job, columns, figure)
        return figure

    def draw_dataset(self, dataset: xr.Dataset, figure: Figure, look: Look = USUAL_LOOK) -> None:
        """Draw a result on an empty figure. Its look has nothing to say: that is of basins."""
        job = self.job.from_request(json.loads(dataset.attrs["request"]))
        self.draw(job, {str(name): array.values for name, array in dataset.variables.items()}, figure)


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
    store = AnalysisStore.open(location, digest)
    begin = time.perf_counter()
    columns = compute(*arguments, pause=stop_if_cancelled)
    stop_if_cancelled()
    store.write_part(name, columns)
    return time.perf_counter() - begin


class _Pieces:
    """The pieces of an analysis in progress."""

    within = staticmethod(nullcontext)  # a piece's part is marked as whole by the task itself, after it is on the disk

    def __init__(self, analysis: Analysis, store: AnalysisStore) -> None:
        self.address = store.location, store.digest
        self.seconds: dict[str, float] = {}
        self._analysis, self._store, self._parts = analysis, store, store.parts()
        self._under_way: set[str] = set()
        self._begun = 0
        self._stage: Stage | None = None
        self._plan_next()

    def _plan_next(self) -> None:
        self._plan = self._analysis.plan(self._store.job, self._parts)

    def next_task(self) -> Task | None:
        """The next piece that can be computed, as a task; None if there is none yet."""
        for piece in self._plan.ready:
            if piece.name not in self._under_way:
                self._under_way.add(piece.name)
                self._begun += 1
                return Task(compute_piece, self._begun, tuple(piece), name=f"piece {piece.name}")
        return None

    def take(self, task: Task, receipt: float) -> None:
        """Record that a piece is done, and plan again."""
        name, stage = task.arguments[0], self._plan.stage.value
        self.seconds[stage] = self.seconds.get(stage, 0.0) + receipt
        self._under_way.discard(name)
        self._parts.add(name)
        self._plan_next()

    def leave(self) -> None:
        """Write what the parts say so far."""
        analysis, job = self._analysis, self._store.job
        self._store.publish(analysis.layout(job), analysis.assemble(job, self._parts))

    def finish(self) -> None:
        """Mark the store as complete."""
        self._store.finish(self.seconds)

    def progress(self, stage: Stage | None = None) -> Progress:
        """How far a stage is, by default that of the plan."""
        stage = stage or self._plan.stage
        if stage != self._stage:
            self._stage, self._since, self._at_start = stage, time.monotonic(), self._plan.done
        elapsed, done = time.monotonic() - self._since, self._plan.done - self._at_start
        left = elapsed / done * (self._plan.total - self._plan.done) if done else None
        return Progress(stage, self._plan.done, self._plan.total, 0, 0, 0.0, left, 0, 0)
