"""The next tasks of a job: those of all its basins in one queue, and the numbers of their solutions.

Tasks of a basin that has begun come before the first task of the next one. So basins finish one after another, and only
a few are in progress at any time. While one is assembled, tiles of the next keep all workers busy.
"""

import heapq
from collections import defaultdict
from collections.abc import Iterable
from functools import partial
from typing import Any

from worker.basins.basin_run import BasinRun
from worker.basins.coarsening import Coarsening
from worker.basins.ledger import Ledger
from worker.basins.numbering import Numbered, Numbering
from worker.basins.tasks import number_basin, number_tile, write_points
from worker.basins.whole_basin import BasinReceipt, solve_basin
from worker.cluster.calls import Task
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState


class Schedule:
    """The tasks of a job.

    Parameters
    ----------
    store : BasinStore
    ledger : Ledger
    most_basins : int
        Largest number of basins in progress.

    Attributes
    ----------
    basins : dict of int to BasinRun
        Basins in progress, by number.
    small : bool
        Whether one task solves a whole basin. The separate tasks of a basin of one tile are too small for a cluster.
    seconds : dict of str to float
        Time spent in kernels.
    """

    def __init__(self, store: BasinStore, ledger: Ledger, most_basins: int) -> None:
        self._store, self._ledger, self._most_basins = store, ledger, most_basins
        self._numbering = Numbering(store.job, ledger.table, ledger.catalogue)
        self.basins: dict[int, BasinRun] = {}
        self.seconds: dict[str, float] = defaultdict(float)
        self._numbered: dict[int, Numbered] = {}
        self._writes_left: dict[int, int] = {}
        self._coarsening: Coarsening | None = None
        self._admitted = self._to_number = ledger.basins
        self._ready: list[tuple[int, int, Task]] = []
        self._pushed = 0
        # Whether a task has been given since the last receipt, so that another receipt will come.
        self._given = False
        self.small = store.tiling.tiles_of_basin == 1 and store.job.basins > 1

    def _push(self, tasks: Iterable[Task]) -> None:
        for task in tasks:
            self._pushed += 1
            heapq.heappush(self._ready, (task.priority, self._pushed, task))

    def next_task(self) -> Task | None:
        """The next task, from the first basin that has one or from a basin that begins. None if there is none yet."""
        if not self._ready and not self._given:
            self._catch_up()
        if not self._ready and self._admitted < self._store.job.basins and len(self.basins) < self._most_basins:
            self._begin(self._admitted)
            self._admitted += 1
        if not self._ready:
            return None
        self._given = True
        return heapq.heappop(self._ready)[2]

    def _begin(self, number: int) -> None:
        mapped, numbered = self._ledger.mapped(number), number == 0
        basin = BasinRun(self._store, number, mapped, numbered=numbered, set_state=self._ledger.set_state)
        self.basins[number] = basin
        if self.small:
            self._push([Task(solve_basin, number, (bool(mapped), numbered), self._solved, priority=number)])
        else:
            self._push(basin.begin())

    def take(self, task: Task, receipt: Any) -> None:
        """Take the receipt of a task, and queue the tasks that it makes possible."""
        self._catch_up()
        self._given = False
        self._push(task.then(task.number, receipt))

    def _solved(self, number: int, receipt: BasinReceipt) -> Iterable[Task]:
        self._ledger.set_state(number, TileState.COMPUTED)
        self.basins[number].take_over(receipt.attractors, receipt.counts, receipt.reserved, receipt.seconds)
        return ()

    def _catch_up(self) -> None:
        """Number and complete the basins that the receipts taken so far allow to.

        Where the store has to grow for new solutions, this takes tens of milliseconds. So it waits for the next receipt
        if the last one has made a task possible. Meanwhile the workers have that.
        """
        self._number()
        self._complete()

    def _number(self) -> None:
        """Number the solutions of each basin, once it and all basins before it are solved.

        The first basin keeps the numbers of its own catalogue. They are known as soon as the catalogue is, and again
        when it grows.
        """
        while (basin := self.basins.get(self._to_number)) is not None:
            known = self._numbered.get(basin.number)
            longer = len(basin.attractors) > (len(known.attractors) if known else 0)
            if longer and (basin.solved or basin.numbered):
                self._introduce(basin)
            if not basin.solved:
                return
            self._to_number += 1

    def _introduce(self, basin: BasinRun) -> None:
        """Number a basin's attractors, and queue the writes that need the numbers."""
        if basin.numbered:
            self._ledger.table.forget_after(0)
        numbered = self._numbering.assign(basin.number, basin.attractors)
        self._ledger.add_attractors(basin, numbered)
        self._numbered[basin.number] = numbered
        numbers, own = tuple(numbered.numbers), len(basin.attractors)
        task = partial(Task, then=partial(self._written, basin.number), priority=basin.number)
        tasks = [task(write_points, basin.number, (numbers, numbered.attractors))]
        if self.small and not basin.numbered:
            tasks = [task(number_basin, basin.number, (numbers, numbered.attractors, own))]
        elif not basin.numbered:
            tiles = self._store.tiling.numbers_of(basin.number)
            tasks += [task(number_tile, tile, (numbers[:own],)) for tile in tiles]
        self._writes_left[basin.number] = self._writes_left.get(basin.number, 0) + len(tasks)
        self._push(tasks)

    def _written(self, basin: int, number: int, receipt: None) -> Iterable[Task]:
        self._writes_left[basin] -= 1
        return ()

    def _complete(self) -> None:
        """Record basins as complete, in order, once all their writes are done and all their levels are there."""
        while (number := self._ledger.basins) < self._to_number and self._writes_left[number] == 0:
            if self._coarsening is None:
                self._coarsening = Coarsening(self._store, number)
                self._push(self._coarsening.begin())
            if not self._coarsening.done:
                return
            self._coarsening = None
            basin = self.basins.pop(number)
            for what, seconds in basin.seconds.items():
                self.seconds[what] += seconds
            self._ledger.complete(basin, self._numbered.pop(number))
            del self._writes_left[number]
