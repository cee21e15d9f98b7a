"""From a job to a complete store: each basin is mapped, assembled and labelled, and solutions are numbered in order.

A tile is done if the ledger says so, and the ledger is written after the tile is on the disk, since its receipt is sent
after that. Basins are completed in order.
"""

import time
from collections import defaultdict
from collections.abc import Iterator
from functools import partial
from typing import Any

from worker.additions import asked_of
from worker.basins.ledger import Ledger
from worker.basins.schedule import Schedule
from worker.cluster.calls import Task
from worker.cluster.driver import Driver
from worker.fence import Fence
from worker.jobs.basin_job import BasinJob
from worker.progress import BasinProgress, Progress, Stage
from worker.run import Run
from worker.storage.folder import synced_together
from worker.stores.basin_store import BasinStore
from worker.stores.changes import list_changes
from worker.stores.layout import TileState
from worker.stores.opening import demand_all_known

# Basins in progress for each task in flight. A slow basin delays the numbering of the next ones, whose results wait in
# memory.
_BASINS_A_TASK = 4


def basin_runs(job: BasinJob, location: str, driver: Driver, fence: Fence) -> Iterator[Run]:
    """How a job's basins are computed into a store: their tiles, and then what packages add to them.

    `worker.results.summary.summarise` reads the result.

    Parameters
    ----------
    job : BasinJob
    location : str
        The store.
    driver : Driver
        Its window says how many basins are in progress.
    fence : Fence

    Yields
    ------
    Run
        Each when the one before has finished; none if the store is complete.

    Raises
    ------
    LeaseLost, StoreConflict, StoreFailed, ClusterFailed
    """
    demand_all_known(location, job.unread)
    store = BasinStore.create_or_resume(location, job, fence)
    if store.complete:
        return
    tiles = _Tiles(store, driver.window_size)
    yield tiles
    seconds = tiles.all_seconds()
    for addition in asked_of(job):
        run: Run = addition.run(store, tiles.ledger.catalogue(0).attractors)
        yield run
        seconds |= run.seconds
    store.finish(seconds)


class _Tiles:
    """The tiles of all basins in progress. It knows how far they are, how fast they go, and how long stages took."""

    def __init__(self, store: BasinStore, window_size: int) -> None:
        self.address, self.within = (store.location, store.digest), partial(synced_together, store.location)
        self.ledger = Ledger(store)
        self._store, self._job = store, store.job
        self._schedule = Schedule(store, self.ledger, _BASINS_A_TASK * window_size)
        self.seconds = self._schedule.seconds
        self._stage: Stage | None = None
        self._begun, self._at_start = time.monotonic(), 0
        self._run_begun, self._there_before = self._begun, self._done(Stage.DONE)
        self._of_stages: dict[str, float] = defaultdict(float)

    def next_task(self) -> Task | None:
        """The next task; None if there is none yet."""
        return self._schedule.next_task()

    def take(self, task: Task, receipt: Any) -> None:
        """Take the receipt of a task."""
        self._schedule.take(task, receipt)
        self.ledger.save_sometimes()

    def leave(self) -> None:
        """Write the ledger, and remove what writes that were cut off have left."""
        self.ledger.save()
        self._store.sweep_orphans()

    def finish(self) -> None:
        """Write what changes from basin to basin of a sweep."""
        if self._job.axes:
            self._store.solutions.write_changes(list_changes(self._job, self.ledger.table))
        self._enter(Stage.DONE, 0)

    def all_seconds(self) -> dict[str, float]:
        """Wall time of each stage, and the kernels' own time."""
        # Zarr does not accept a defaultdict.
        return {**self._of_stages, **self.seconds}

    def _enter(self, stage: Stage, done: int) -> None:
        if self._stage is not None:
            passed = time.monotonic() - self._begun
            self._of_stages[self._stage.value] += passed
        self._stage, self._begun, self._at_start = stage, time.monotonic(), done

    def _now(self) -> Stage:
        if self._job.basins > 1:
            return Stage.COMPUTING
        if (self.ledger.states < TileState.COMPUTED).any():
            return Stage.MAPPING
        labelling = self.ledger.basins or any(basin.attractors for basin in self._schedule.basins.values())
        return Stage.LABELLING if labelling else Stage.ASSEMBLING

    def _done(self, stage: Stage) -> int:
        """Number of tiles that have passed a stage."""
        under_way = self._schedule.basins.get(0)
        if stage == Stage.LABELLING and under_way is not None:
            return under_way.tiles_done
        if stage == Stage.ASSEMBLING:
            return 0
        reached = TileState.COMPUTED if stage == Stage.MAPPING else TileState.ASSEMBLED
        return int((self.ledger.states >= reached).sum())

    def progress(self, stage: Stage | None = None) -> Progress:
        """Progress of a stage, by default of the current one. `Stage.DONE` stands for the whole run."""
        stage = stage or self._now()
        done, total = self._done(stage), self.ledger.states.size
        if stage != self._stage:
            self._enter(stage, done)
        cells = self._job.grid.cells * self._job.basins
        whole = stage == Stage.DONE
        elapsed = time.monotonic() - (self._run_begun if whole else self._begun)
        fresh = done - (self._there_before if whole else self._at_start)
        pace = fresh / elapsed if fresh > 0 and elapsed > 0 else 0.0
        left = (total - done) / pace if pace else None
        return Progress(
            stage, done, total, round(done / total * cells), cells, pace * cells / total, left, self.ledger.basins,
            self._job.basins, self._under_way(),
        )  # fmt: skip

    def _under_way(self) -> tuple[BasinProgress, ...]:
        if self._job.basins == 1:
            return ()
        tiles = self._store.tiling.tiles_of_basin
        begun = [
            (basin, Stage.COMPUTING if self._schedule.small else basin.stage)
            for basin in self._schedule.basins.values()
        ]
        return tuple(BasinProgress(basin.number, stage, basin.tiles_done, tiles) for basin, stage in begun)
