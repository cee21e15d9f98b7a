"""What runs on workers: plain functions of a store and a tile. Running one again is harmless.

Each returns a receipt, never the arrays: those go straight from the worker into the store.
"""

import time
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from distributed import get_worker

from rattle_kernels import (
    PERMANENT_CONTACT,
    SINK,
    STRANGER,
    UNDECIDED,
    Attractor,
    AttractorKind,
    CellGroups,
    CellImages,
    MarkedWords,
    label_cells,
    landing_boxes,
    map_cells,
    mark_images,
    name_solutions,
)
from worker.basin_job import BasinJob
from worker.errors import JobCancelled, StoreConflict
from worker.layout import LABELLED, MAPPED
from worker.store import BasinStore
from worker.tiles import Tile, bands


@dataclass(frozen=True)
class MapReceipt:
    """What one tile's images were.

    ``image_set`` are its distinct image cells; ``scout_time``, ``scout_velocity`` one landing point of each box
    (``scout_box``) of a coarse lattice that it landed in, the seeds of the catalogue. ``seconds`` is the kernels' time,
    0 where the tile was read from the store.
    """

    tile: int
    sink: int
    captured: int
    undecided: int
    seconds: float
    image_set: MarkedWords
    scout_box: np.ndarray
    scout_time: np.ndarray
    scout_velocity: np.ndarray


@dataclass(frozen=True)
class LabelReceipt:
    """What one tile's solutions were: cells of each attractor, and landing points that arrived at none."""

    tile: int
    counts: np.ndarray
    seconds: float
    stranger_time: np.ndarray
    stranger_velocity: np.ndarray


def _stop_if_cancelled() -> None:
    """Leave a task that has been cancelled: `Future.cancel` alone does not stop a running function."""
    try:
        worker = get_worker()
        state = worker.state.tasks.get(worker.get_current_task())
    except ValueError:  # not on a worker: called as a plain function
        return
    if state is not None and state.state in ("cancelled", "resumed"):
        raise JobCancelled("cancelled while a tile was computed")


def _receipt(job: BasinJob, number: int, images: CellImages, seconds: float) -> MapReceipt:
    cells = images.image_cell
    boxes = landing_boxes(job.oscillator, images.landing_time.ravel(), images.landing_velocity.ravel())
    numbers, first = np.unique(boxes, return_index=True)
    scouts = first[numbers >= 0]
    return MapReceipt(
        tile=number,
        sink=int((cells == SINK).sum()),
        captured=int((cells == PERMANENT_CONTACT).sum()),
        undecided=int((cells == UNDECIDED).sum()),
        seconds=seconds,
        image_set=mark_images(job.grid.cells, cells),
        scout_box=numbers[numbers >= 0],
        scout_time=images.landing_time.ravel()[scouts],
        scout_velocity=images.landing_velocity.ravel()[scouts],
    )


def _map_in_bands(job: BasinJob, tile: Tile) -> CellImages:
    parts = []
    for rows in bands(tile, job.iterations):
        _stop_if_cancelled()
        parts.append(map_cells(job.oscillator, job.grid, job.iterations, rows, tile.columns))
    return CellImages(
        np.concatenate([part.image_cell for part in parts]),
        np.concatenate([part.landing_time for part in parts]),
        np.concatenate([part.landing_velocity for part in parts]),
        sum(part.applications for part in parts),
    )


def map_tile(location: str, digest: str, number: int) -> MapReceipt:
    """Compute the images of one tile and write them."""
    store = _open(location, digest)
    tile = store.tiling.tile(number)
    begin = time.perf_counter()
    images = _map_in_bands(store.job, tile)
    seconds = time.perf_counter() - begin
    store.write_tile(MAPPED, tile, images[:3])
    return _receipt(store.job, number, images, seconds)


def survey_tile(location: str, digest: str, number: int) -> MapReceipt:
    """Receipt of a tile that is in the store already, from the store."""
    store = _open(location, digest)
    image, t, v = store.read_tile(MAPPED, store.tiling.tile(number))
    return _receipt(store.job, number, CellImages(image, t, v, 0), 0.0)


@lru_cache(maxsize=4)
def _open(location: str, digest: str) -> BasinStore:
    """Store of the job with this digest, opened once per process: the same digest is the same layout."""
    store = BasinStore(location)
    if store.job.digest != digest:
        raise StoreConflict(f"{location} holds the store of another request by now")
    return store


@lru_cache(maxsize=4)
def _catalogue(location: str, catalogue_sha256: str) -> tuple[CellGroups, tuple[Attractor, ...]]:
    """What labels are looked up in, read once per process and catalogue: it costs more than labelling a tile."""
    store = BasinStore(location)
    return store.read_image_set(), store.read_attractors()


def _solutions(
    store: BasinStore, attractors: tuple[Attractor, ...], image: np.ndarray, t: np.ndarray, v: np.ndarray
) -> np.ndarray:
    solution = np.full(image.shape, STRANGER, np.int16)
    solution[image == PERMANENT_CONTACT] = 0
    landed = image >= SINK
    solution[landed] = name_solutions(store.job.oscillator, attractors, t[landed], v[landed])
    return solution


def label_tile(location: str, digest: str, catalogue_sha256: str, number: int) -> LabelReceipt:
    """Look up group, period and step of one tile's cells, name their solutions, and write them."""
    store = _open(location, digest)
    tile = store.tiling.tile(number)
    _stop_if_cancelled()
    image, t, v = store.read_tile(MAPPED, tile)
    groups, attractors = _catalogue(location, catalogue_sha256)
    begin = time.perf_counter()
    rows, columns = np.arange(*tile.rows), np.arange(*tile.columns)
    own = rows[:, None] * store.job.grid.time_cells + columns
    labels = label_cells(groups, own, image)
    solution = _solutions(store, attractors, image, t, v)
    strangers = (solution == STRANGER) & (image >= SINK)
    kinds = [attractor.kind for attractor in attractors]
    if AttractorKind.UNDECIDED in kinds:
        solution[solution == STRANGER] = kinds.index(AttractorKind.UNDECIDED)
    seconds = time.perf_counter() - begin
    store.write_tile(LABELLED, tile, (*labels, solution))
    counts = np.bincount(solution[solution >= 0], minlength=len(kinds))
    return LabelReceipt(number, counts, seconds, t[strangers], v[strangers])
