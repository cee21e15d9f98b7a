"""What runs on workers: plain functions of a store and a tile or a panel. Running one again is harmless.

Each returns a receipt, never the arrays: those go straight from the worker into the store.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

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
    find_attractors,
    grazing_velocity,
    label_cells,
    map_cells,
    map_points,
    mark_images,
    name_solutions,
)
from rattle_kernels.attractors.seed_pass import scouted_traps
from rattle_kernels.attractors.seeds import Scouts, choose_scouts
from worker.basins.assembly import assemble_groups
from worker.cluster.task import stop_if_cancelled
from worker.errors import StoreConflict
from worker.stores.basin_store import BasinStore
from worker.stores.tiles import Tile, bands, runs_of_points


@dataclass(frozen=True)
class MapReceipt:
    """What one tile's images were.

    ``reserved`` counts the images -1, -2 and -3; ``image_set`` are the distinct image cells; ``scouts`` the seeds of
    the catalogue. ``seconds`` is the kernels' time, 0 where the tile was read from the store.
    """

    reserved: np.ndarray
    seconds: float
    image_set: MarkedWords
    scouts: Scouts


@dataclass(frozen=True)
class CatalogueReceipt:
    """Attractors that a panel has by itself."""

    attractors: tuple[Attractor, ...]
    seconds: float


@dataclass(frozen=True)
class LabelReceipt:
    """What one tile's solutions were: places of each attractor, and some of the landing points that arrived at none."""

    counts: np.ndarray
    seconds: float
    strangers: Scouts


def _receipt(store: BasinStore, panel: int, images: CellImages, seconds: float) -> MapReceipt:
    cells = images.image_cell
    return MapReceipt(
        reserved=np.array([(cells == code).sum() for code in (SINK, PERMANENT_CONTACT, UNDECIDED)]),
        seconds=seconds,
        image_set=mark_images(store.job.grid.cells, cells),
        scouts=choose_scouts(store.job.oscillator_of(panel), images.landing_time, images.landing_velocity),
    )


def _map_sample(store: BasinStore, tile: Tile) -> CellImages:
    job = store.job
    assert job.sample is not None
    oscillator = job.oscillator_of(tile.panel)
    t, v = job.sample.departures(job.grid, *tile.columns)
    traps = scouted_traps(oscillator, job.grid, job.iterations, job.sample.points, stop_if_cancelled)
    parts = []
    for points in runs_of_points(t.size, job.applications):
        here = slice(*points)
        part = map_points(
            oscillator, job.grid, job.iterations, t[here], v[here], traps=traps, pause=stop_if_cancelled
        )  # fmt: skip
        parts.append(part)
    images = _joined(parts)
    # A sample has no cells: what lands, lands outside of all.
    cells = np.minimum(images.image_cell, SINK)
    return CellImages(cells[None], images.landing_time[None], images.landing_velocity[None], images.applications)


def _map_in_bands(store: BasinStore, tile: Tile) -> CellImages:
    job, oscillator = store.job, store.job.oscillator_of(tile.panel)
    traps = scouted_traps(oscillator, job.grid, job.iterations, job.grid.cells, stop_if_cancelled)
    parts = []
    for rows in bands(tile, job.applications):
        part = map_cells(
            oscillator, job.grid, job.iterations, rows, tile.columns, traps=traps, pause=stop_if_cancelled
        )  # fmt: skip
        parts.append(part)
    return _joined(parts)


def _joined(parts: Sequence[CellImages]) -> CellImages:
    return CellImages(
        np.concatenate([part.image_cell for part in parts]),
        np.concatenate([part.landing_time for part in parts]),
        np.concatenate([part.landing_velocity for part in parts]),
        sum(part.applications for part in parts),
    )


def map_tile(location: str, digest: str, number: int) -> MapReceipt:
    """Compute the images of one tile and write them."""
    store = open_store(location, digest)
    tile = store.tiling.tile(number)
    begin = time.perf_counter()
    images = (_map_in_bands if store.job.sample is None else _map_sample)(store, tile)
    seconds = time.perf_counter() - begin
    store.write_tile(store.places.mapped, tile, images[:3])
    return _receipt(store, tile.panel, images, seconds)


def survey_tile(location: str, digest: str, number: int) -> MapReceipt:
    """Receipt of a tile that is in the store already, from the store."""
    store = open_store(location, digest)
    tile = store.tiling.tile(number)
    image, t, v = store.read_tile(store.places.mapped, tile)
    return _receipt(store, tile.panel, CellImages(image, t, v, 0), 0.0)


@lru_cache(maxsize=4)
def open_store(location: str, digest: str) -> BasinStore:
    """Store of the job with this digest, opened once per process: the same digest is the same layout."""
    store = BasinStore(location)
    if store.digest != digest:
        raise StoreConflict(f"{location} holds the store of another request by now")
    return store


def assemble_panel(location: str, digest: str, panel: int, scouts: Scouts) -> CatalogueReceipt:
    """Run Hsu's algorithm on a panel's image set, and find the attractors that its scouts end in."""
    store = open_store(location, digest)
    begin = time.perf_counter()
    if store.job.sample is None:
        store.write_groups(panel, assemble_groups(store, panel, stop_if_cancelled))
        store.write_grazing_velocity(
            panel, grazing_velocity(store.job.oscillator_of(panel), store.job.grid.time_centres())
        )
    oscillator = store.job.oscillator_of(panel)
    attractors = find_attractors(oscillator, scouts.time, scouts.velocity, pause=stop_if_cancelled)
    return CatalogueReceipt(attractors, time.perf_counter() - begin)


def extend_catalogue(
    location: str, digest: str, panel: int, known: tuple[Attractor, ...], strangers: Scouts
) -> CatalogueReceipt:
    """A panel's catalogue with what strangers end in."""
    store = open_store(location, digest)
    begin = time.perf_counter()
    oscillator = store.job.oscillator_of(panel)
    attractors = find_attractors(oscillator, strangers.time, strangers.velocity, known=known, pause=stop_if_cancelled)
    return CatalogueReceipt(attractors, time.perf_counter() - begin)


@lru_cache(maxsize=4)
def _groups(location: str, digest: str, panel: int) -> CellGroups:
    """What labels are looked up in, read once per process: it costs more than labelling a tile."""
    return open_store(location, digest).read_groups(panel)


def label_tile(
    location: str, digest: str, number: int, attractors: tuple[Attractor, ...], numbered: bool
) -> LabelReceipt:
    """Look up group, period and step of one tile's cells, name their solutions, and write them.

    Solutions are indices into the panel's own catalogue; they are written as such, beside the panel's image set, unless
    those are their numbers already.
    """
    store = open_store(location, digest)
    tile = store.tiling.tile(number)
    stop_if_cancelled()
    image, t, v = store.read_tile(store.places.mapped, tile)
    groups = _groups(location, digest, tile.panel) if store.places.labelled else None
    begin = time.perf_counter()
    labels = label_cells(groups, _own_cells(store, tile), image) if groups is not None else ()
    solution = np.full(image.shape, STRANGER, np.int16)
    solution[image == PERMANENT_CONTACT] = 0
    landed = image >= SINK
    solution[landed] = name_solutions(
        store.job.oscillator_of(tile.panel), attractors, t[landed], v[landed], pause=stop_if_cancelled
    )
    strangers = (solution == STRANGER) & landed
    kinds = [attractor.kind for attractor in attractors]
    if AttractorKind.UNDECIDED in kinds:
        solution[solution == STRANGER] = kinds.index(AttractorKind.UNDECIDED)
    seconds = time.perf_counter() - begin
    named = store.places.solution if numbered else store.places.own_solution
    store.write_tile((*store.places.labelled, named), tile, (*labels, solution))
    counts = np.bincount(solution[solution >= 0], minlength=len(kinds))
    return LabelReceipt(counts, seconds, choose_scouts(store.job.oscillator_of(tile.panel), t[strangers], v[strangers]))


def _own_cells(store: BasinStore, tile: Tile) -> np.ndarray:
    rows, columns = np.arange(*tile.rows), np.arange(*tile.columns)
    return rows[:, None] * store.job.grid.time_cells + columns


def number_tile(location: str, digest: str, number: int, numbers: tuple[int, ...]) -> None:
    """Write one tile's solutions by the numbers that all panels share."""
    store = open_store(location, digest)
    tile = store.tiling.tile(number)
    (own,) = store.read_tile((store.places.own_solution,), tile)
    store.write_tile((store.places.solution,), tile, (np.array(numbers, np.int16)[own],))


def write_points(
    location: str, digest: str, panel: int, numbers: tuple[int, ...], attractors: tuple[Attractor, ...]
) -> None:
    """Write the points of a panel's attractors under their numbers."""
    open_store(location, digest).write_points(panel, numbers, attractors)


def number_panel(
    location: str, digest: str, panel: int, numbers: tuple[int, ...], attractors: tuple[Attractor, ...], own: int
) -> None:
    """Write all of a small panel that needs its numbers; the first `own` of them are of its own catalogue."""
    write_points(location, digest, panel, numbers, attractors)
    for tile in open_store(location, digest).tiling.numbers_of(panel):
        number_tile(location, digest, tile, numbers[:own])
