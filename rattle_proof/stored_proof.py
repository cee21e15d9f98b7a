"""The proof in a basin's store, as it was written."""

from typing import Any, NamedTuple

import numpy as np

from rattle_kernels import Attractor
from rattle_proof.arrays import proof_of
from rattle_proof.layout import NEVER_QUIET, PROOF, PROVEN
from worker.errors import StoreConflict, as_store_failure
from worker.jobs.basin_job import BasinJob
from worker.stores import layout
from worker.stores.basin_store import BasinStore
from worker.stores.opening import open_group

_ARRAYS = ("ends", "rounds", "rattling", "never_quiet", "window_ends", "window_order")


class StoredProof(NamedTuple):
    """A certificate, the arrays beside it, what is proven of cells, and what is drawn."""

    job: BasinJob
    attractors: tuple[Attractor, ...]
    certificate: dict[str, Any]
    arrays: dict[str, np.ndarray]
    solution: np.ndarray
    proven: np.ndarray
    never_quiet: np.ndarray


def read_proof(location: str) -> StoredProof:
    """Read the proof of a store.

    Raises
    ------
    StoreConflict
        If the store is not a finished one of one basin with a proof.
    StoreFailed
        If it cannot be read.
    """
    store = BasinStore(location)
    if store.job.axes or store.job.sample is not None:
        raise StoreConflict(f"{location} is not a picture of one basin: only those carry a proof")
    if not store.complete:
        raise StoreConflict(f"{location} is not finished: the command that began it goes on from what is there")
    with as_store_failure(location):
        root = open_group(location, "r")
        if not proof_of(store).wanted or PROOF not in root or "certificate" not in root[PROOF].attrs:
            raise StoreConflict(f"{location} carries no proof: it was computed without --prove")
        group = root[PROOF]
        arrays = {name: np.asarray(group[name][...]) for name in _ARRAYS if name in group}
        certificate = dict(group.attrs["certificate"])
    solution, proven = store.read_whole((layout.SOLUTION, PROVEN))
    # Stores of the first edition have none.
    never_quiet = store.read_whole((NEVER_QUIET,))[0] if NEVER_QUIET.path in root else np.zeros_like(proven)
    table = store.solutions.read()
    attractors = store.solutions.read_catalogue(0, table, range(len(table.motions)))
    return StoredProof(store.job, attractors, certificate, arrays, solution, proven, never_quiet)
