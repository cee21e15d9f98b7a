"""How far a job is, and how fast it runs."""

import time
from collections import defaultdict

from worker.basins.ledger import Ledger
from worker.basins.schedule import Schedule
from worker.progress import BasinProgress, Progress, Stage
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState


class Pace:
    """Progress of a job, and the wall time of its stages.

    Parameters
    ----------
    store : BasinStore
    ledger : Ledger
    schedule : Schedule
    """

    def __init__(self, store: BasinStore, ledger: Ledger, schedule: Schedule) -> None:
        self._job, self._tiles = store.job, store.tiling.tiles_of_basin
        self._ledger, self._schedule = ledger, schedule
        self._stage: Stage | None = None
        self._begun, self._at_start = time.monotonic(), 0
        self._run_begun, self._there_before = self._begun, self._done(Stage.DONE)
        self._seconds: dict[str, float] = defaultdict(float)

    def _enter(self, stage: Stage, done: int) -> None:
        if self._stage is not None:
            passed = time.monotonic() - self._begun
            self._seconds[self._stage.value] += passed
        self._stage, self._begun, self._at_start = stage, time.monotonic(), done

    def _now(self) -> Stage:
        if self._job.basins > 1:
            return Stage.COMPUTING
        if (self._ledger.states < TileState.COMPUTED).any():
            return Stage.MAPPING
        labelling = self._ledger.basins or any(basin.attractors for basin in self._schedule.basins.values())
        return Stage.LABELLING if labelling else Stage.ASSEMBLING

    def _done(self, stage: Stage) -> int:
        """Number of tiles that have passed a stage."""
        under_way = self._schedule.basins.get(0)
        if stage == Stage.LABELLING and under_way is not None:
            return under_way.tiles_done
        if stage == Stage.ASSEMBLING:
            return 0
        reached = TileState.COMPUTED if stage == Stage.MAPPING else TileState.ASSEMBLED
        return int((self._ledger.states >= reached).sum())

    def progress(self, stage: Stage | None = None) -> Progress:
        """Progress of a stage, by default of the current one. `Stage.DONE` stands for the whole run."""
        stage = stage or self._now()
        done, total = self._done(stage), self._ledger.states.size
        if stage != self._stage:
            self._enter(stage, done)
        cells = self._job.grid.cells * self._job.basins
        whole = stage == Stage.DONE
        elapsed = time.monotonic() - (self._run_begun if whole else self._begun)
        fresh = done - (self._there_before if whole else self._at_start)
        pace = fresh / elapsed if fresh > 0 and elapsed > 0 else 0.0
        left = (total - done) / pace if pace else None
        return Progress(
            stage, done, total, round(done / total * cells), cells, pace * cells / total, left, self._ledger.basins,
            self._job.basins, self._under_way(),
        )  # fmt: skip

    def _under_way(self) -> tuple[BasinProgress, ...]:
        if self._job.basins == 1:
            return ()
        begun = [
            (basin, Stage.COMPUTING if self._schedule.small else basin.stage)
            for basin in self._schedule.basins.values()
        ]
        return tuple(BasinProgress(basin.number, stage, basin.tiles_done, self._tiles) for basin, stage in begun)

    def finish(self) -> dict[str, float]:
        """Wall time of each stage, and the kernels' own time."""
        self._enter(Stage.DONE, 0)
        # Zarr does not accept a defaultdict.
        return {**self._seconds, **self._schedule.seconds}
