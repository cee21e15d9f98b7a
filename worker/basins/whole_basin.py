"""A basin of one tile, done by one task: what `worker.basins.basin_run` asks for, one after the other in one process.

Through the cluster every one of its tasks would wait for a message, and the tables of its oscillator be built in
whatever process gets it. What reaches the store is the same.
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from rattle_kernels import Attractor
from worker.basins.basin_run import BasinRun
from worker.basins.tasks import open_store
from worker.cluster.task import Task, stop_if_cancelled
from worker.stores.layout import TileState


@dataclass(frozen=True)
class PanelReceipt:
    """A basin that is solved: its own catalogue, places of each attractor and of each reserved image, and seconds.

    ``seconds`` are of the kernels, by the name of their task.
    """

    attractors: tuple[Attractor, ...]
    counts: np.ndarray
    reserved: np.ndarray
    seconds: dict[str, float]


def solve_basin(location: str, digest: str, number: int, state: TileState, numbered: bool) -> PanelReceipt:
    """Map, assemble and label the one tile of a basin; `state` is what the ledger says of it."""
    store = open_store(location, digest)
    basin = BasinRun(store, number, {tile: state for tile in store.tiling.numbers_of(number)}, numbered=numbered)
    seconds: Counter[str] = Counter()
    ready: list[Task] = basin.begin()
    while ready:
        stop_if_cancelled()
        task = ready.pop()
        receipt = task.function(location, digest, task.number, *task.arguments)
        seconds[task.function.__name__] += receipt.seconds
        ready += basin.take(task, receipt)
    return PanelReceipt(basin.attractors, basin.counts, basin.reserved, dict(seconds))
