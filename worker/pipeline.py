"""From a job to a complete store: every panel is mapped, assembled and labelled; panel by panel solutions are numbered.

One window of tasks lies over all panels. A task that a panel under way can do goes before the first of a panel that has
not begun, so panels end one after another, a few are under way at any time whatever their number, and while one is
assembled the tiles of the next keep all workers busy.

Truth is in the store: a tile counts as done when the ledger says so, and the ledger is written after the tile. Panels
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

from worker.basin_job import BasinJob
from worker.changes import list_changes
from worker.driver import run_tasks, window_size
from worker.fence import Fence, unfenced
from worker.layout import TileState
from worker.numbering import Numbered, Numbering
from worker.panel import Panel
from worker.progress import BasinProgress, Progress, Report, Stage
from worker.results import BasinSummary, summarise
from worker.store import BasinStore
from worker.tasks import (
    Task,
    assemble_panel,
    extend_catalogue,
    label_tile,
    map_tile,
    number_panel,
    number_tile,
    write_points,
)
from worker.whole_panel import PanelReceipt, solve_panel

_LEDGER_SECONDS = 0.5
_TABLE_SECONDS = 2.0
# Panels under way for each task in flight: one that takes long keeps the next ones from being numbered, and what they
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
        # Complete are the first panels, one after the other; the ledger is written after the table.
        assembled = (self.states.reshape(-1, store.tiling.tiles_of_panel) == TileState.ASSEMBLED).all(axis=1)
        self.panels = int(np.cumprod(self.table.complete & assembled).sum())
        self.table.forget_after(self.panels)
        after = self.states[self.panels * store.tiling.tiles_of_panel :]
        after[after > TileState.COMPUTED] = TileState.COMPUTED
        self._ledger_saved = self._table_saved = 0.0
        self._table_changed = False

    def announce(self, panel: Panel, numbered: Numbered) -> None:
        """Note what attractors a panel has, before their shares are known."""
        unknown = np.full(len(numbered.numbers), np.nan)
        self.table.enter(panel.number, numbered.numbers, numbered.attractors, unknown)
        self._table_changed = True

    def enter(self, panel: Panel, numbered: Numbered) -> None:
        """Note that a panel is complete, the next one after those that are."""
        shares = np.zeros(len(numbered.numbers))
        shares[: panel.counts.size] = panel.counts / self.store.job.grid.cells
        self.table.enter(panel.number, numbered.numbers, numbered.attractors, shares)
        self.states[self.store.tiling.numbers_of(panel.number)] = TileState.ASSEMBLED
        self.panels += 1
        self._table_changed = True

    def save_sometimes(self) -> None:
        """Write what has changed, if it is time to."""
        moment = time.monotonic()
        if self._table_changed:
            # The ledger says that panels are complete: never before their solutions are there.
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
    """A job under way: its panels, what is ready to be done, and how far it is."""

    def __init__(self, store: BasinStore, report: Report, most_panels: int) -> None:
        self.store, self.report, self.most_panels = store, report, most_panels
        self.record = _Record(store)
        self.numbering = Numbering(store.job, self.record.table, self._read)
        self.panels: dict[int, Panel] = {}
        self.numbered: dict[int, Numbered] = {}
        self._writes_left: dict[int, int] = {}
        self._admitted = self._to_number = self.record.panels
        self._assembled = self.record.panels
        self._ready: list[tuple[int, int, Task]] = []
        self._pushed = 0
        # Basins of one tile each: their tasks would be too small for a cluster.
        self._small = store.tiling.tiles_of_panel == 1 and store.job.panels > 1
        self._pace = _Pace(store, self.record.states)
        self._tell()

    def _read(self, panel: int) -> Numbered:
        numbers = self.record.table.numbers_in(panel)
        return Numbered(self.store.read_catalogue(panel, self.record.table, numbers), numbers)

    def _push(self, tasks: list[Task]) -> None:
        for task in tasks:
            self._pushed += 1
            heapq.heappush(self._ready, (task.panel, self._pushed, task))

    def following(self) -> Task | None:
        """The next task: of the first panel that has one, or of a panel that is begun for it."""
        if not self._ready and self._admitted < self.store.job.panels and len(self.panels) < self.most_panels:
            panel = Panel(self.store, self._admitted, self.record.states, numbered=self._admitted == 0)
            self.panels[panel.number] = panel
            self._admitted += 1
            self._push(self._begin(panel))
        return heapq.heappop(self._ready)[2] if self._ready else None

    def _begin(self, panel: Panel) -> list[Task]:
        if not self._small:
            return panel.begin()
        state = TileState(self.record.states[panel.number])
        return [Task(solve_panel, panel.number, panel.number, (state, panel.numbered))]

    def take(self, task: Task, receipt: Any) -> None:
        """Note what a task has done, and what can be done now."""
        panel = self.panels[task.panel]
        if task.function in (number_tile, number_panel, write_points):
            self._writes_left[panel.number] -= 1
        elif task.function is solve_panel:
            self._adopt(panel, receipt)
        else:
            self._push(panel.take(task, receipt))
            self._note(task, receipt, panel)
        self._number()
        self._complete()
        self.record.save_sometimes()
        self._tell()

    def _adopt(self, panel: Panel, receipt: PanelReceipt) -> None:
        """Take over a panel that one task has done."""
        for name, seconds in receipt.seconds.items():
            if name in _KERNELS:
                self._pace.add(_KERNELS[name], seconds)
        panel.adopt(receipt.attractors, receipt.counts, receipt.reserved)
        self.record.reserved[panel.number] = panel.reserved
        self.record.states[panel.number] = TileState.COMPUTED
        if panel.numbered:
            self._introduce(panel)

    def _note(self, task: Task, receipt: Any, panel: Panel) -> None:
        states = self.record.states
        if task.function.__name__ in _KERNELS:
            self._pace.add(_KERNELS[task.function.__name__], receipt.seconds)
        if task.function is map_tile:
            states[task.number] = TileState.COMPUTED
        elif task.function is label_tile and panel.numbered:
            states[task.number] = TileState.ASSEMBLED
        elif task.function in (assemble_panel, extend_catalogue):
            self._assembled += task.function is assemble_panel
            self.record.reserved[panel.number] = panel.reserved
            tiles = self.store.tiling.numbers_of(panel.number)
            states[tiles] = TileState.COMPUTED
            if panel.numbered:
                self._introduce(panel)

    def _introduce(self, panel: Panel) -> None:
        """Number a panel's attractors, and have everything written that needs the numbers."""
        if panel.numbered:
            self.record.table.forget_after(0)
        numbered = self.numbering.assign(panel.number, panel.attractors)
        self.record.announce(panel, numbered)
        self.store.make_room(self.record.table, max(attractor.time.size for attractor in numbered.attractors))
        self.numbered[panel.number] = numbered
        numbers, own = tuple(numbered.numbers), len(panel.attractors)
        tasks = [Task(write_points, panel.number, panel.number, (numbers, numbered.attractors))]
        if self._small and not panel.numbered:
            tasks = [Task(number_panel, panel.number, panel.number, (numbers, numbered.attractors, own))]
        elif not panel.numbered:
            tiles = self.store.tiling.numbers_of(panel.number)
            tasks += [Task(number_tile, tile, panel.number, (numbers[:own],)) for tile in tiles]
        self._writes_left[panel.number] = self._writes_left.get(panel.number, 0) + len(tasks)
        self._push(tasks)

    def _number(self) -> None:
        """Number the panels whose solutions are known, as far as all before them are."""
        while self._to_number in self.panels and self.panels[self._to_number].solved:
            if not self.panels[self._to_number].numbered:
                self._introduce(self.panels[self._to_number])
            self._to_number += 1

    def _complete(self) -> None:
        """Enter the panels of which everything is in the store, as far as all before them are."""
        while (number := self.record.panels) < self._to_number and self._writes_left[number] == 0:
            self.record.enter(self.panels.pop(number), self.numbered.pop(number))
            del self._writes_left[number]

    def _tell(self) -> None:
        if self.store.job.panels > 1:
            stage = Stage.COMPUTING
        elif (self.record.states < TileState.COMPUTED).any():
            stage = Stage.MAPPING
        else:
            stage = Stage.LABELLING if self._assembled else Stage.ASSEMBLING
        self.report(self._pace.progress(stage, self.record.panels, self._under_way()))

    def _under_way(self) -> tuple[BasinProgress, ...]:
        if self.store.job.panels == 1:
            return ()
        tiles = self.store.tiling.tiles_of_panel
        begun = [(panel, Stage.COMPUTING if self._small else panel.stage) for panel in self.panels.values()]
        return tuple(BasinProgress(panel.number, stage, panel.tiles_done, tiles) for panel, stage in begun)

    def finish(self) -> None:
        """Mark the store complete."""
        if self.store.job.vary:
            self.store.write_changes(list_changes(self.store.job, self.record.table))
        self.store.finish(self._pace.finish())
        self.report(self._pace.progress(Stage.DONE, self.record.panels))


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
        cells = self.job.grid.cells * self.job.panels
        whole = stage == Stage.DONE
        elapsed = time.monotonic() - (self.run_begun if whole else self.begun)
        fresh = done - (self.there_before if whole else self.at_start)
        pace = fresh / elapsed if fresh > 0 and elapsed > 0 else 0.0
        left = (total - done) / pace if pace else None
        return Progress(
            stage, done, total, round(done / total * cells), cells, pace * cells / total, left, basins_done,
            self.job.panels, under_way,
        )  # fmt: skip

    def finish(self) -> dict[str, float]:
        """Wall time of each stage, and the kernels' own time."""
        self._enter(Stage.DONE, 0)
        return self.seconds
