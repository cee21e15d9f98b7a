"""One basin, from a job to a complete store: map tiles, assemble, label tiles, consolidate.

Truth is in the store: a tile counts as done when the ledger says so, and the ledger is written after the tile. After
any crash the same call computes only what is missing, and the result is the same to the byte.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from distributed import Client

from rattle_kernels import Attractor, AttractorKind, find_attractors
from rattle_kernels.attractor import UNDECIDED_ATTRACTOR
from worker.assembly import assemble_attractors, assemble_groups
from worker.basin_job import BasinJob
from worker.driver import run_tiles
from worker.layout import TileState
from worker.progress import Progress, Report, Stage
from worker.results import BasinSummary, summarise
from worker.store import BasinStore
from worker.tasks import LabelReceipt, MapReceipt, label_tile, map_tile, survey_tile

_T = TypeVar("_T")

_LEDGER_SECONDS = 0.5
# How often the catalogue is extended by landing points that arrived at none of its attractors, before they are called
# undecided.
_CATALOGUE_ROUNDS = 3


@dataclass
class _Run:
    """A job under way: its store and ledger, and what is known of its pace."""

    store: BasinStore
    client: Client
    report: Report
    cancel: threading.Event
    states: np.ndarray
    seconds: dict[str, float] = field(default_factory=dict)
    ledger_written: float = 0.0

    @property
    def address(self) -> tuple[str, str]:
        """What tasks find the store by: its location, and the digest of the job they expect there."""
        return self.store.location, self.store.job.digest

    def note(self, tile: int, state: TileState) -> None:
        """Enter a tile in the ledger, which is written at most twice a second."""
        self.states[tile] = state
        if time.monotonic() - self.ledger_written > _LEDGER_SECONDS:
            self.save_ledger()

    def save_ledger(self) -> None:
        self.store.write_ledger(self.states)
        self.ledger_written = time.monotonic()

    def tell(self, stage: Stage, reached: TileState, begun: float, at_start: int) -> None:
        """Report how many tiles have reached a state."""
        cells = self.store.job.grid.cells
        total = self.states.size
        done = int((self.states >= reached).sum())
        elapsed = time.monotonic() - begun
        pace = (done - at_start) / elapsed if done > at_start and elapsed > 0 else 0.0
        left = (total - done) / pace if pace else None
        share = done / total
        self.report(Progress(stage, done, total, round(share * cells), cells, pace * cells / total, left))


def run_basin(job: BasinJob, location: str, client: Client, *, report: Report, cancel: threading.Event) -> BasinSummary:
    """Compute a basin into a store, or finish one that was begun.

    Parameters
    ----------
    job : BasinJob
    location : str
        Where the store is, or shall be.
    client : distributed.Client
    report : callable
        Called with a `Progress` after every tile.
    cancel : threading.Event
        Set it to stop; the store stays readable and can be resumed.

    Returns
    -------
    BasinSummary

    Raises
    ------
    JobCancelled, StoreConflict, StoreFailed, TileFailed, ClusterFailed
    """
    store = BasinStore.create_or_resume(location, job)
    if store.complete:
        return summarise(location)
    run = _Run(store, client, report, cancel, store.read_ledger().copy())
    try:
        receipts = _timed(run, "map", _map)
        _timed(run, "assemble", lambda run: _assemble(run, receipts))
        _timed(run, "label", _label)
    finally:
        run.save_ledger()
    store.finish(run.seconds)
    run.tell(Stage.DONE, TileState.ASSEMBLED, time.monotonic(), run.states.size)
    return summarise(location)


def _timed(run: _Run, name: str, stage: Callable[[_Run], _T]) -> _T:
    begin = time.monotonic()
    result = stage(run)
    run.seconds[name] = time.monotonic() - begin
    return result


def _map(run: _Run) -> list[MapReceipt]:
    """Map what is missing, survey what is there; receipts in the order of tiles, so that nothing depends on timing."""
    begun, at_start = time.monotonic(), int((run.states >= TileState.COMPUTED).sum())
    # From the top: low departures are captured soon, so that the last tiles are light and the workers end together.
    missing = np.flatnonzero(run.states < TileState.COMPUTED)[::-1].tolist()
    present = np.flatnonzero(run.states >= TileState.COMPUTED).tolist()
    run.tell(Stage.MAPPING, TileState.COMPUTED, begun, at_start)
    receipts: dict[int, MapReceipt] = {}
    for receipt in run_tiles(run.client, map_tile, run.address, missing, run.cancel):
        receipts[receipt.tile] = receipt
        run.note(receipt.tile, TileState.COMPUTED)
        run.tell(Stage.MAPPING, TileState.COMPUTED, begun, at_start)
    run.save_ledger()
    for receipt in run_tiles(run.client, survey_tile, run.address, present, run.cancel):
        receipts[receipt.tile] = receipt
    run.seconds["map_kernels"] = sum(receipt.seconds for receipt in receipts.values())
    run.store.write_image_counts(
        {
            "sink": sum(receipt.sink for receipt in receipts.values()),
            "permanent_contact": sum(receipt.captured for receipt in receipts.values()),
            "undecided": sum(receipt.undecided for receipt in receipts.values()),
        }
    )
    return [receipts[tile] for tile in sorted(receipts)]


def _assemble(run: _Run, receipts: list[MapReceipt]) -> None:
    run.tell(Stage.ASSEMBLING, TileState.ASSEMBLED, time.monotonic(), 0)
    run.store.write_image_set(assemble_groups(run.store, receipts))
    attractors = assemble_attractors(run.store, receipts)
    if any(receipt.undecided for receipt in receipts):
        attractors = _with_undecided(attractors)
    run.store.write_attractors(attractors, np.full(len(attractors), np.nan))


def _with_undecided(attractors: tuple[Attractor, ...]) -> tuple[Attractor, ...]:
    known = any(attractor.kind == AttractorKind.UNDECIDED for attractor in attractors)
    return attractors if known else (*attractors, UNDECIDED_ATTRACTOR)


def _label(run: _Run) -> None:
    """Label every tile; where points arrive at no known attractor, extend the catalogue by them and label again."""
    run.seconds["label_kernels"] = 0.0
    for round_ in range(_CATALOGUE_ROUNDS + 1):
        receipts = _label_once(run)
        run.seconds["label_kernels"] += sum(receipt.seconds for receipt in receipts)
        attractors = run.store.read_attractors()
        extended = _extended(run.store, attractors, receipts, last=round_ >= _CATALOGUE_ROUNDS - 1)
        if len(extended) == len(attractors):
            break
        run.store.write_attractors(extended, np.full(len(extended), np.nan))
    counts = np.sum([receipt.counts for receipt in receipts], axis=0)
    run.store.write_attractors(attractors, counts / run.store.job.grid.cells)


def _label_once(run: _Run) -> list[LabelReceipt]:
    # The catalogue has just been written: labels of an earlier one are void.
    run.states[:] = TileState.COMPUTED
    begun, receipts = time.monotonic(), []
    address = *run.address, run.store.catalogue_sha256
    for receipt in run_tiles(run.client, label_tile, address, reversed(range(run.states.size)), run.cancel):
        receipts.append(receipt)
        run.note(receipt.tile, TileState.ASSEMBLED)
        run.tell(Stage.LABELLING, TileState.ASSEMBLED, begun, 0)
    return sorted(receipts, key=lambda receipt: receipt.tile)


def _extended(
    store: BasinStore, attractors: tuple[Attractor, ...], receipts: list[LabelReceipt], *, last: bool
) -> tuple[Attractor, ...]:
    """The catalogue with what strangers end in; with the undecided motion where that cannot be found."""
    times = np.concatenate([receipt.stranger_time for receipt in receipts])
    velocities = np.concatenate([receipt.stranger_velocity for receipt in receipts])
    if not times.size:
        return attractors
    found = attractors if last else find_attractors(store.job.oscillator, times, velocities, known=attractors)
    return found if len(found) > len(attractors) else _with_undecided(attractors)
