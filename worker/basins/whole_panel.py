"""A panel of one tile, done by one task: what `worker.basins.panel` asks for, one after the other in one process.

Through the cluster every one of its tasks would wait for a message, and the tables of its oscillator be built in
whatever process gets it. What reaches the store is the same.
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from rattle_kernels import Attractor
from worker.basins.panel import Panel
from worker.basins.tasks import open_store
from worker.cluster.task import Task, stop_if_cancelled
from worker.stores.layout import TileState


@dataclass(frozen=True)
class PanelReceipt:
    """A panel that is solved: its own catalogue, places of each attractor and of each reserved image, and seconds.

    ``seconds`` are of the kernels, by the name of their task.
    """

    attractors: tuple[Attractor, ...]
    counts: np.ndarray
    reserved: np.ndarray
    seconds: dict[str, float]


def solve_panel(location: str, digest: str, number: int, state: TileState, numbered: bool) -> PanelReceipt:
    """Map, assemble and label the one tile of a panel; `state` is what the ledger says of it."""
    store = open_store(location, digest)
    panel = Panel(store, number, {tile: state for tile in store.tiling.numbers_of(number)}, numbered=numbered)
    seconds: Counter[str] = Counter()
    ready: list[Task] = panel.begin()
    while ready:
        stop_if_cancelled()
        task = ready.pop()
        receipt = task.function(location, digest, task.number, *task.arguments)
        seconds[task.function.__name__] += receipt.seconds
        ready += panel.take(task, receipt)
    return PanelReceipt(panel.attractors, panel.counts, panel.reserved, dict(seconds))
