"""The functions that workers run. Each takes a store and a tile or a basin, and may safely be run again.

Each returns a receipt, never the arrays. The worker itself writes those to the store.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rattle_kernels import SINK, CellImages, grazing_velocity, label_cells, map_points
from rattle_kernels.attractors.seed_pass import traps_of_seeds
from rattle_kernels.attractors.seeds import Seeds
from rattle_kernels.basins.basin import Survey, map_bands, survey_images
from rattle_kernels.basins.naming import Catalogue, first_catalogue, name_landings, next_catalogue
from rattle_kernels.basins.tiles import Tile, runs_of_points
from rattle_kernels.cell_mapping.cell_map import join_images
from worker.basins import image_cache
from worker.basins.assembly import assemble_groups, groups_of
from worker.basins.weights import weigh
from worker.cluster.calls import stop_if_cancelled
from worker.rounding import demand_same_rounding
from worker.stores.basin_store import BasinStore
from worker.stores.opening import demand_same_digest


@dataclass(frozen=True)
class MapReceipt:
    """Images of one tile: what they are, and the kernels' time, 0 if the tile was read from the store."""

    survey: Survey
    seconds: float


@dataclass(frozen=True)
class CatalogueReceipt:
    """A basin's own attractors."""

    attractors: Catalogue
    seconds: float


@dataclass(frozen=True)
class LabelReceipt:
    """Solutions of one tile: the cells of each attractor, and some of the landing points that reached none.

    ``counts`` has a row for each set of a sample, and one for cells.
    """

    counts: np.ndarray
    seconds: float
    unassigned: Seeds


def _receipt(store: BasinStore, basin: int, images: CellImages, seconds: float) -> MapReceipt:
    return MapReceipt(survey_images(store.job.oscillator_of(basin), store.job.grid, images), seconds)


def _map(store: BasinStore, tile: Tile) -> CellImages:
    job, oscillator = store.job, store.job.oscillator_of(tile.basin)
    if job.sample is None:
        return map_bands(oscillator, job.grid, job.iterations, tile, stop_if_cancelled)
    t, v = job.sample.departures(job.grid, *tile.columns)
    traps = traps_of_seeds(oscillator, job.grid, job.iterations, job.sample.points, stop_if_cancelled)
    parts = []
    for points in runs_of_points(t.size, job.applications):
        here = slice(*points)
        part = map_points(
            oscillator, job.grid, job.iterations, t[here], v[here], traps=traps, pause=stop_if_cancelled
        )  # fmt: skip
        parts.append(part)
    images = join_images(parts)
    # A sample has no cells, so every landing point lies outside.
    cells = np.minimum(images.image_cell, SINK)
    return CellImages(cells[None], images.landing_time[None], images.landing_velocity[None], images.applications)


def map_tile(location: str, digest: str, number: int) -> MapReceipt:
    """Compute the images of one tile and write them."""
    store = open_store(location, digest)
    tile = store.tiling.tile(number)
    begin = time.perf_counter()
    images = _map(store, tile)
    seconds = time.perf_counter() - begin
    store.tiles.write(store.places.mapped, tile, images[:3])
    image_cache.keep(location, digest, number, images)
    return _receipt(store, tile.basin, images, seconds)


def weigh_tiles(location: str, digest: str, basin: int, numbers: Sequence[int]) -> list[int]:
    """How long each of some tiles of a basin will take, beside the others."""
    store = open_store(location, digest)
    return [weigh(store, store.tiling.tile(number), stop_if_cancelled) for number in numbers]


def _read_images(store: BasinStore, tile: Tile) -> CellImages:
    image, t, v = store.tiles.read(store.places.mapped, tile)
    return CellImages(image, t, v, 0)


def _images(location: str, digest: str, number: int) -> CellImages:
    """Images of a tile, from the store unless this process has just mapped it."""
    images = image_cache.take(location, digest, number)
    if images is not None:
        return images
    store = open_store(location, digest)
    return _read_images(store, store.tiling.tile(number))


def survey_tile(location: str, digest: str, number: int) -> MapReceipt:
    """Receipt of a tile that is already in the store."""
    store = open_store(location, digest)
    tile = store.tiling.tile(number)
    return _receipt(store, tile.basin, _read_images(store, tile), 0.0)


@lru_cache(maxsize=4)
def open_store(location: str, digest: str) -> BasinStore:
    """Store of the job with this digest, opened once per process. The same digest means the same layout."""
    store = BasinStore(location)
    demand_same_digest(location, store.digest, digest)
    demand_same_rounding(location, store.attributes)
    return store


def assemble_basin(location: str, digest: str, basin: int, seeds: Seeds, lost: bool) -> CatalogueReceipt:
    """Run Hsu's algorithm on a basin's image set, and find the attractors that its seeds end in."""
    store = open_store(location, digest)
    begin = time.perf_counter()
    oscillator = store.job.oscillator_of(basin)
    if store.job.sample is None:
        assemble_groups(store, basin, stop_if_cancelled)
        store.write_grazing_velocity(basin, grazing_velocity(oscillator, store.job.grid.time_centres()))
    attractors = first_catalogue(oscillator, seeds, lost, stop_if_cancelled)
    return CatalogueReceipt(attractors, time.perf_counter() - begin)


def extend_catalogue(
    location: str, digest: str, basin: int, known: Catalogue, unassigned: Seeds, rounds: int
) -> CatalogueReceipt:
    """Extend a basin's catalogue by the attractors that unassigned landing points end in, unless it is final."""
    begin = time.perf_counter()
    oscillator = open_store(location, digest).job.oscillator_of(basin)
    attractors = next_catalogue(oscillator, known, unassigned, rounds, stop_if_cancelled)
    return CatalogueReceipt(attractors, time.perf_counter() - begin)


def label_tile(location: str, digest: str, number: int, attractors: Catalogue, numbered: bool) -> LabelReceipt:
    """Look up group, period and step of one tile's cells, name their solutions, and write them.

    Solutions are indices into the basin's own catalogue. They are written beside the basin's image set, unless the
    indices are already the numbers.
    """
    store = open_store(location, digest)
    tile = store.tiling.tile(number)
    stop_if_cancelled()
    images = _images(location, digest, number)
    job, groups = store.job, groups_of(store, tile.basin) if store.places.labelled else None
    begin = time.perf_counter()
    labels = label_cells(groups, job.grid.cell_numbers(tile.rows, tile.columns), images.image_cell) if groups else ()
    oscillator = job.oscillator_of(tile.basin)
    solution, unassigned = name_landings(oscillator, attractors, images, stop_if_cancelled)
    seconds = time.perf_counter() - begin
    named = store.places.solution if numbered else store.places.own_solution
    store.tiles.write((*store.places.labelled, named), tile, (*labels, solution))
    return LabelReceipt(_counts(store, tile, solution, len(attractors)), seconds, unassigned)


def _counts(store: BasinStore, tile: Tile, solution: np.ndarray, attractors: int) -> np.ndarray:
    sample = store.job.sample
    sets, of_set = (1, 0) if sample is None else (sample.scramblings, sample.set_of(*tile.columns)[None])
    known = solution >= 0
    counts = np.bincount((of_set * attractors + solution)[known], minlength=sets * attractors)
    return counts.reshape(sets, attractors)


def number_tile(location: str, digest: str, number: int, numbers: tuple[int, ...]) -> None:
    """Write one tile's solutions under the numbers that all basins share."""
    store = open_store(location, digest)
    tile = store.tiling.tile(number)
    (own,) = store.tiles.read((store.places.own_solution,), tile)
    store.tiles.write((store.places.solution,), tile, (np.array(numbers, np.int16)[own],))


def write_points(location: str, digest: str, basin: int, numbers: tuple[int, ...], attractors: Catalogue) -> None:
    """Write the points of a basin's attractors under their numbers."""
    open_store(location, digest).solutions.write_points(basin, numbers, attractors)


def number_basin(
    location: str, digest: str, basin: int, numbers: tuple[int, ...], attractors: Catalogue, own: int
) -> None:
    """Write everything of a small basin that needs numbers. The first `own` of them are those of its own catalogue."""
    write_points(location, digest, basin, numbers, attractors)
    for tile in open_store(location, digest).tiling.numbers_of(basin):
        number_tile(location, digest, tile, numbers[:own])
