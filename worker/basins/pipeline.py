"""From a job to a complete store: every basin is mapped, assembled and labelled; basin by basin solutions are numbered.

One window of tasks lies over all basins. A task that a basin under way can do goes before the first of a basin that has
not begun, so basins end one after another, a few are under way at any time whatever their number, and while one is
assembled the tiles of the next keep all workers busy.

Truth is in the store: a tile counts as done when the ledger says so, and the ledger is written after the tile. Basins
are complete in their order. After any crash the same call computes only what is missing, and the result is the same to
the byte.
"""

import contextlib
import heapq
import threading
import time
from typing import Any

import numpy as np
from distributed import Client

from worker.basins.basin_run import BasinRun
from worker.basins.numbering import Numbered, Numbering
from worker.basins.tasks import (
    assemble_basin,
    extend_catalogue,
    label_tile,
    map_tile,
    number_basin,
    number_tile,
    write_points,
)
from worker.basins.whole_basin import PanelReceipt, solve_basin
from worker.cluster.driver import run_tasks, window_size
from worker.cluster.task import Task
from worker.fence import Fence, unfenced
from worker.jobs.basin_job import BasinJob
from worker.progress import BasinProgress, Progress, Report, Stage
from worker.stores.basin_store import BasinStore
from worker.stores.changes import list_changes
from worker.stores.layout import TileState
from worker.stores.summary import BasinSummary, summarise

_LEDGER_SECONDS = 0.5
_TABLE_SECONDS = 2.0
# Basins under way for each task in flight: one that takes long keeps the next ones from being numbered, and what they
# have found waits in memory.
_PANELS_A_TASK = 4
_KERNELS = {
    "map_tile": "map_kernels", "assemble_panel": "assemble_kernels", "extend_catalogue": "assemble_kernels",
    "label_tile": "label_kernels",
}  # fmt: skip


def run_basin(
    job: BasinJob,
    location: str,
    client: Client,
    *,
    report: Report,
    cancel: threading.Event,
    fence: Fence = unfenced,
) -> BasinSummary:
    """Compute a job's basins into a store, or finish what was begun.

    Parameters
    ----------
    job : BasinJob
    location : str
        Where the store is, or shall be.
    client : distributed.Client
    report : callable
        Called with a `Progress` after every task.
    cancel : threading.Event
        Set it to stop; the store stays readable and can be resumed.
    fence : Fence
        Where another driver may take the job over.

    Returns
    -------
    BasinSummary

    Raises
    ------
    JobCancelled, LeaseLost, StoreConflict, StoreFailed, TileFailed, ClusterFailed, UnlikeWorkers
    """
    store = BasinStore.create_or_resume(location, job, fence)
    if not store.complete:
        run = _Run(store, report, _PANELS_A_TASK * window_size(client))
        try:
            with contextlib.closing(run_tasks(client, (location, store.digest), run.following, cancel)) as done:
                for task, receipt in done:
                    run.take(task, receipt)
        finally:
            run.record.save()
            store.sweep_orphans()
        run.finish()
    return summarise(location)


class _Record:
    """What is in the store: ledger and table of solutions, written a few times a second at the most."""

    def __init__(self, store: BasinStore) -> None:
        self.store = store
        self.states = store.read_ledger().copy()
        self.table = store.read_solutions()
        self.reserved = store.read_image_counts().copy()
        # Complete are the first basins, one after the other; the ledger is written after the table.
        assembled = (self.states.reshape(-1, store.tiling.tiles_of_basin) == TileState.ASSEMBLED).all(axis=1)
        self.basins = int(np.cumprod(self.table.complete & assembled).sum())
        self.table.forget_after(self.basins)
        after = self.states[self.basins * store.tiling.tiles_of_basin :]
        after[after > TileState.COMPUTED] = TileState.COMPUTED
        self._ledger_saved = self._table_saved = 0.0
        self._table_changed = False

    def announce(self, basin: BasinRun, numbered: Numbered) -> None:
        """Note what attractors a basin has, before their shares are known."""
        unknown = np.full(len(numbered.numbers), np.nan)
        self.table.enter(basin.number, numbered.numbers, numbered.attractors, unknown)
        self._table_changed = True

    def enter(self, basin: BasinRun, numbered: Numbered) -> None:
        """Note that a basin is complete, the next one after those that are."""
        shares = np.zeros(len(numbered.numbers))
        shares[: basin.counts.size] = basin.counts / self.store.job.grid.cells
        self.table.enter(basin.number, numbered.numbers, numbered.attractors, shares)
        self.states[self.store.tiling.numbers_of(basin.number)] = TileState.ASSEMBLED
        self.basins += 1
        self._table_changed = True

    def save_sometimes(self) -> None:
        """Write what has changed, if it is time to."""
        moment = time.monotonic()
        if self._table_changed:
            # The ledger says that basins are complete: never before their solutions are there.
            if moment - self._table_saved > _TABLE_SECONDS:
                self.save()
        elif moment - self._ledger_saved > _LEDGER_SECONDS:
            self.store.write_ledger(self.states)
            self._ledger_saved = moment

    def save(self) -> None:
        """Write everything."""
        self.store.write_image_counts(self.reserved)
        self.store.write_solutions(self.table)
        self.store.write_ledger(self.states)
        self._ledger_saved = self._table_saved = time.monotonic()
        self._table_changed = False


class _Run:
    """A job under way: its basins, what is ready to be done, and how far it is."""

    def __init__(self, store: BasinStore, report: Report, most_basins: int) -> None:
        self.store, self.report, self.most_basins = store, report, most_basins
        self.record = _Record(store)
        self.numbering = Numbering(store.job, self.record.table, self._read)
        self.basins: dict[int, BasinRun] = {}
        self.numbered: dict[int, Numbered] = {}
        self._writes_left: dict[int, int] = {}
        self._admitted = self._to_number = self.record.basins
        self._assembled = self.record.basins
        self._ready: list[tuple[int, int, Task]] = []
        self._pushed = 0
        # Basins of one tile each: their tasks would be too small for a cluster.
        self._small = store.tiling.tiles_of_basin == 1 and store.job.basins > 1
        self._pace = _Pace(store, self.record.states)
        self._tell()

    def _read(self, basin: int) -> Numbered:
        numbers = self.record.table.numbers_in(basin)
        return Numbered(self.store.read_catalogue(basin, self.record.table, numbers), numbers)

    def _push(self, tasks: list[Task]) -> None:
        for task in tasks:
            self._pushed += 1
            heapq.heappush(self._ready, (task.basin, self._pushed, task))

    def following(self) -> Task | None:
        """The next task: of the first basin that has one, or of a basin that is begun for it."""
        if not self._ready and self._admitted < self.store.job.basins and len(self.basins) < self.most_basins:
            basin = BasinRun(self.store, self._admitted, self.record.states, numbered=self._admitted == 0)
            self.basins[basin.number] = basin
            self._admitted += 1
            self._push(self._begin(basin))
        return heapq.heappop(self._ready)[2] if self._ready else None

    def _begin(self, basin: BasinRun) -> list[Task]:
        if not self._small:
            return basin.begin()
        state = TileState(self.record.states[basin.number])
        return [Task(solve_basin, basin.number, basin.number, (state, basin.numbered))]

    def take(self, task: Task, receipt: Any) -> None:
        """Note what a task has done, and what can be done now."""
        basin = self.basins[task.basin]
        if task.function in (number_tile, number_basin, write_points):
            self._writes_left[basin.number] -= 1
        elif task.function is solve_basin:
            self._adopt(basin, receipt)
        else:
            self._push(basin.take(task, receipt))
            self._note(task, receipt, basin)
        self._number()
        self._complete()
        self.record.save_sometimes()
        self._tell()

    def _adopt(self, basin: BasinRun, receipt: PanelReceipt) -> None:
        """Take over a basin that one task has done."""
        for name, seconds in receipt.seconds.items():
            if name in _KERNELS:
                self._pace.add(_KERNELS[name], seconds)
        basin.adopt(receipt.attractors, receipt.counts, receipt.reserved)
        self.record.reserved[basin.number] = basin.reserved
        self.record.states[basin.number] = TileState.COMPUTED
        if basin.numbered:
            self._introduce(basin)

    def _note(self, task: Task, receipt: Any, basin: BasinRun) -> None:
        states = self.record.states
        if task.function.__name__ in _KERNELS:
            self._pace.add(_KERNELS[task.function.__name__], receipt.seconds)
        if task.function is map_tile:
            states[task.number] = TileState.COMPUTED
        elif task.function is label_tile and basin.numbered:
            states[task.number] = TileState.ASSEMBLED
        elif task.function in (assemble_basin, extend_catalogue):
            self._assembled += task.function is assemble_basin
            self.record.reserved[basin.number] = basin.reserved
            tiles = self.store.tiling.numbers_of(basin.number)
            states[tiles] = TileState.COMPUTED
            if basin.numbered:
                self._introduce(basin)

    def _introduce(self, basin: BasinRun) -> None:
        """Number a panel's attractors, and have everything written that needs the numbers."""
        if basin.numbered:
            self.record.table.forget_after(0)
        numbered = self.numbering.assign(basin.number, basin.attractors)
        self.record.announce(basin, numbered)
        self.store.make_room(self.record.table, max(attractor.time.size for attractor in numbered.attractors))
        self.numbered[basin.number] = numbered
        numbers, own = tuple(numbered.numbers), len(basin.attractors)
        tasks = [Task(write_points, basin.number, basin.number, (numbers, numbered.attractors))]
        if self._small and not basin.numbered:
            tasks = [Task(number_basin, basin.number, basin.number, (numbers, numbered.attractors, own))]
        elif not basin.numbered:
            tiles = self.store.tiling.numbers_of(basin.number)
            tasks += [Task(number_tile, tile, basin.number, (numbers[:own],)) for tile in tiles]
        self._writes_left[basin.number] = self._writes_left.get(basin.number, 0) + len(tasks)
        self._push(tasks)

    def _number(self) -> None:
        """Number the basins whose solutions are known, as far as all before them are."""
        while self._to_number in self.basins and self.basins[self._to_number].solved:
            if not self.basins[self._to_number].numbered:
                self._introduce(self.basins[self._to_number])
            self._to_number += 1

    def _complete(self) -> None:
        """Enter the basins of which everything is in the store, as far as all before them are."""
        while (number := self.record.basins) < self._to_number and self._writes_left[number] == 0:
            self.record.enter(self.basins.pop(number), self.numbered.pop(number))
            del self._writes_left[number]

    def _tell(self) -> None:
        if self.store.job.basins > 1:
            stage = Stage.COMPUTING
        elif (self.record.states < TileState.COMPUTED).any():
            stage = Stage.MAPPING
        else:
            stage = Stage.LABELLING if self._assembled else Stage.ASSEMBLING
        self.report(self._pace.progress(stage, self.record.basins, self._under_way()))

    def _under_way(self) -> tuple[BasinProgress, ...]:
        if self.store.job.basins == 1:
            return ()
        tiles = self.store.tiling.tiles_of_basin
        begun = [(basin, Stage.COMPUTING if self._small else basin.stage) for basin in self.basins.values()]
        return tuple(BasinProgress(basin.number, stage, basin.tiles_done, tiles) for basin, stage in begun)

    def finish(self) -> None:
        """Mark the store complete."""
        if self.store.job.vary:
            self.store.write_changes(list_changes(self.store.job, self.record.table))
        self.store.finish(self._pace.finish())
        self.report(self._pace.progress(Stage.DONE, self.record.basins))


class _Pace:
    """How fast the stages of a job go by."""

    def __init__(self, store: BasinStore, states: np.ndarray) -> None:
        self.job, self.states = store.job, states
        self.stage: Stage | None = None
        self.begun, self.at_start = time.monotonic(), 0
        self.run_begun, self.there_before = self.begun, self._reached(TileState.ASSEMBLED)
        self.seconds: dict[str, float] = {}

    def add(self, what: str, seconds: float) -> None:
        """Add to the seconds of something."""
        self.seconds[what] = self.seconds.get(what, 0.0) + seconds

    def _reached(self, state: TileState) -> int:
        return int((self.states >= state).sum())

    def _enter(self, stage: Stage, done: int) -> None:
        if self.stage is not None:
            self.add(self.stage.value, time.monotonic() - self.begun)
        self.stage, self.begun, self.at_start = stage, time.monotonic(), done

    def progress(self, stage: Stage, basins_done: int, under_way: tuple[BasinProgress, ...] = ()) -> Progress:
        """Progress of a stage, by how many tiles have reached its state; at the end, of the whole run."""
        reached = TileState.COMPUTED if stage == Stage.MAPPING else TileState.ASSEMBLED
        done, total = self._reached(reached), self.states.size
        if stage != self.stage:
            self._enter(stage, done)
        cells = self.job.grid.cells * self.job.basins
        whole = stage == Stage.DONE
        elapsed = time.monotonic() - (self.run_begun if whole else self.begun)
        fresh = done - (self.there_before if whole else self.at_start)
        pace = fresh / elapsed if fresh > 0 and elapsed > 0 else 0.0
        left = (total - done) / pace if pace else None
        return Progress(
            stage, done, total, round(done / total * cells), cells, pace * cells / total, left, basins_done,
            self.job.basins, under_way,
        )  # fmt: skip

    def finish(self) -> dict[str, float]:
        """Wall time of each stage, and the kernels' own time."""
        self._enter(Stage.DONE, 0)
        return self.seconds
