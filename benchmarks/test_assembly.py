"""Hsu's algorithm: cells a second, alone and through the store, for maps of up to 1e8 cells; and its memory."""

import shutil
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from rattle_kernels import CellGrid, CellGroups, Oscillator, find_groups, label_cells, map_cells
from rattle_kernels.cell_mapping.image_set import mark_images, members_of, place_images, unite
from worker.basins.assembly import assemble_groups, groups_of
from worker.basins.tasks import map_tile
from worker.cluster.calls import Task
from worker.cluster.connection import local_cluster
from worker.cluster.driver import Driver
from worker.jobs.basin_job import BasinJob
from worker.storage.folder import synced_together
from worker.stores.basin_store import BasinStore
from worker.stores.layout import LABELLED, MAPPED

SIDE = 10_000
ROWS = 1_000


def standard_map(side, first_row, rows):
    """Image cells of Chirikov's standard map, K = 1.5, on the unit torus: a smooth map that scatters its images."""
    centres = (np.arange(side) + 0.5) / side
    x, y = np.meshgrid(centres, centres[first_row : first_row + rows])
    momentum = (y + 1.5 / (2.0 * np.pi) * np.sin(2.0 * np.pi * x)) % 1.0
    angle = (x + momentum) % 1.0
    return (momentum * side).astype(np.int64) * side + (angle * side).astype(np.int64)


def impact_map(side, first_row, rows):
    """Image cells of P itself, k = 1, at the parameters of Fig. 7."""
    grid = CellGrid(time_cells=side, velocity_cells=side)
    return map_cells(Oscillator(), grid, 1, (first_row, first_row + rows), (0, side)).image_cell


def groups_of_bands(side, bands):
    """Hsu's numbers of a map given in bands of rows."""
    cells = side * side
    members = unite(cells, [mark_images(cells, band) for band in bands])
    place = np.empty(members.size, np.int32)
    for number, band in enumerate(bands):
        place_images(members, (number * band.shape[0], 0), side, band, place)
    return find_groups(members, place)


def assemble(side, bands) -> CellGroups:
    """Groups, and every band labelled by them."""
    groups = groups_of_bands(side, bands)
    for number, band in enumerate(bands):
        first = number * band.size
        label_cells(groups, np.arange(first, first + band.size).reshape(band.shape), band)
    return groups


def _rate(benchmark, cells):
    benchmark.extra_info["million_cells_per_second"] = cells / benchmark.stats.stats.min / 1e6


def _demand_whole_cycles(groups):
    """What is fast, but wrong, is no figure: cycles hold as many cells as their groups' periods say."""
    on_a_cycle = (groups.group > 0) & (groups.step == 0)
    assert (np.bincount(groups.group[on_a_cycle])[1:] == groups.period_of_group[1:]).all()


def test_labels_by_look_up(benchmark):
    """4 million cells with 100,000 images."""
    rng = np.random.default_rng(0)
    images = np.unique(rng.integers(0, 4_000_000, 100_000))
    image = images[rng.integers(0, images.size, 4_000_000)].reshape(2000, 2000)
    groups = groups_of_bands(2000, [image])
    group, _, _ = benchmark(label_cells, groups, np.arange(image.size), image.ravel())
    assert (group == group[image.ravel()]).all()
    _rate(benchmark, image.size)


@pytest.mark.parametrize("kind", ["permutation", "random"])
def test_groups_of_a_map_without_order(benchmark, kind):
    """2 million cells whose images are anywhere: every look-up misses the caches."""
    rng = np.random.default_rng(0)
    image = rng.permutation(2_000_000) if kind == "permutation" else rng.integers(0, 2_000_000, 2_000_000)
    members = unite(image.size, [mark_images(image.size, image)])
    place = np.searchsorted(members_of(members), image[members_of(members)]).astype(np.int32)
    groups = benchmark.pedantic(find_groups, setup=lambda: ((members, place.copy()), {}), rounds=3)
    _demand_whole_cycles(groups)
    _rate(benchmark, image.size)


@pytest.mark.parametrize("kind", [standard_map, impact_map], ids=["standard", "impact"])
def test_a_hundred_million_cells_in_one_process(benchmark, kind):
    """10,000 x 10,000 cells, the images in memory."""
    bands = [kind(SIDE, row, ROWS) for row in range(0, SIDE, ROWS)]
    before = _peak()
    groups = benchmark.pedantic(assemble, (SIDE, bands), rounds=2)
    _demand_whole_cycles(groups)
    _rate(benchmark, SIDE * SIDE)
    benchmark.extra_info["members"] = groups.members.size
    benchmark.extra_info["groups"] = groups.period_of_group.size - 1
    benchmark.extra_info["gibibytes_beside_the_images"] = _peak() - before


def _peak():
    """Most memory this process has held, in GiB (its own: `getrusage` starts from that of the parent)."""
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 2**20


def find_groups_in_store(location: str, digest: str, basin: int) -> None:
    """Run Hsu's algorithm on the image set in a store."""
    assemble_groups(BasinStore.open(location, digest), basin)


def label_groups(location: str, digest: str, number: int) -> None:
    """Label one tile by the image set in its store, without naming solutions."""
    store = BasinStore.open(location, digest)
    groups = groups_of(store, 0)
    tile = store.tiling.tile(number)
    (image,) = store.tiles.read(MAPPED[:1], tile)
    own = np.arange(*tile.rows)[:, None] * store.job.grid.time_cells + np.arange(*tile.columns)
    store.tiles.write(LABELLED[:3], tile, label_cells(groups, own, image))


def test_a_hundred_million_cells_through_the_store(benchmark, tmp_path):
    """P with k = 1 on 10,000 x 10,000 cells: mapped, assembled and labelled by two workers, solutions not named."""
    job = BasinJob(grid=CellGrid(time_cells=SIDE, velocity_cells=SIDE), iterations=1)
    location = str(tmp_path / "large.zarr")
    store = BasinStore.create_or_resume(location, job)
    seconds = {}
    # Tests before this one, which hold all images, are no part of the driver: its peak counts from here.
    Path("/proc/self/clear_refs").write_text("5")

    def whole(client):
        def run(function, numbers):
            tasks = iter([Task(function, number) for number in numbers])
            results = Driver(client).run_tasks(
                (location, store.digest),
                lambda: next(tasks, None),
                threading.Event(),
                partial(synced_together, location),
            )
            return [receipt for _, receipt in results]

        marks = [time.perf_counter()]
        receipts = run(map_tile, range(store.tiling.tiles))
        marks.append(time.perf_counter())
        store.write_image_words(0, unite(SIDE * SIDE, [receipt.survey.image_set for receipt in receipts]).words)
        run(find_groups_in_store, [0])
        marks.append(time.perf_counter())
        run(label_groups, range(store.tiling.tiles))
        marks.append(time.perf_counter())
        seconds.update(zip(("map", "groups", "label"), np.diff(marks).tolist(), strict=True))

    with local_cluster(2) as client:
        benchmark.pedantic(whole, (client,), rounds=1)
        for number in (0, store.tiling.tiles - 1):
            store.tiles.read(LABELLED[:3], store.tiling.tile(number))  # raises where a cell is without its labels
        benchmark.extra_info["gibibytes_of_workers"] = sorted(client.run(_peak).values())
    benchmark.extra_info |= {"seconds_of_stages": seconds, "gibibytes_of_driver": _peak()}
    benchmark.extra_info["million_cells_per_second"] = SIDE * SIDE / (seconds["groups"] + seconds["label"]) / 1e6
    shutil.rmtree(location)
