"""A basin of one tile as a single task, which runs the tasks of `worker.basins.basin_run` one after another.

On the cluster every one of those tasks would wait for a message, and each process would build the tables of the basin's
oscillator again. The store is the same either way.
"""

from dataclasses import dataclass

import numpy as np

from rattle_kernels import Attractor
from worker.basins.basin_run import BasinRun
from worker.cluster.calls import stop_if_cancelled
from worker.stores.basin_store import BasinStore


@dataclass(frozen=True)
class BasinReceipt:
    """A solved basin: its own catalogue, cells of each attractor and of each reserved image, and time in kernels."""

    attractors: tuple[Attractor, ...]
    counts: np.ndarray
    reserved: np.ndarray
    seconds: dict[str, float]


def solve_basin(location: str, digest: str, number: int, mapped: bool, numbered: bool) -> BasinReceipt:
    """Map, assemble and label the only tile of a basin. `mapped` says whether its images are in the store."""
    store = BasinStore.open(location, digest)
    basin = BasinRun(store, number, store.tiling.numbers_of(number) if mapped else (), numbered=numbered)
    ready = basin.begin()
    while ready:
        stop_if_cancelled()
        task = ready.pop()
        ready += task.then(task.number, task.function(location, digest, task.number, *task.arguments))
    return BasinReceipt(basin.attractors, basin.counts, basin.reserved, basin.seconds)
