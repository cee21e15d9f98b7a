"""What a basin says, read from its store."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from rattle_kernels import Attractor
from worker.layout import TileState
from worker.store import BasinStore


@dataclass(frozen=True)
class BasinSummary:
    """Answer of one job: its motions with their shares, and how complete it is.

    ``shares`` are NaN until every tile is labelled; ``image_counts`` says how many cells
    have each reserved image, once all are mapped; ``seconds`` has the wall time of each stage and the kernels' own
    time.
    """

    request: dict[str, Any]
    complete: bool
    tiles: int
    tiles_computed: int
    tiles_assembled: int
    attractors: tuple[Attractor, ...]
    shares: tuple[float, ...]
    image_counts: dict[str, int]
    seconds: dict[str, float]


def summarise(location: str) -> BasinSummary:
    """Summary of the store at a location, finished or not.

    Raises
    ------
    StoreConflict, StoreFailed
        Where there is no basin's store, or it cannot be read.
    """
    store = BasinStore(location)
    states = store.read_ledger()
    attractors = store.read_attractors()
    return BasinSummary(
        request=store.job.request(),
        complete=store.complete,
        tiles=states.size,
        tiles_computed=int((states >= TileState.COMPUTED).sum()),
        tiles_assembled=int((states == TileState.ASSEMBLED).sum()),
        attractors=attractors,
        shares=tuple(np.asarray(store.read_shares(), np.float64).tolist()) if attractors else (),
        image_counts=store.attributes.get("image_counts", {}),
        seconds=store.attributes.get("seconds", {}),
    )
