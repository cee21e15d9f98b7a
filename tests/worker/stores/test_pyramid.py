"""Levels of large basins: which cells they have, how the pipeline writes them, and how little is read of 1e10 cells."""

import shutil
import threading
from math import ceil, prod

import numpy as np
import pytest
import xarray as xr
import zarr

import rattle
from rattle_kernels import CellGrid
from tests.large_store import LARGE, ChunksRead, fill, finish, label, large_store, tiles_of
from tests.store_content import content
from tests.worker.storage.test_flipped_bits import flip
from worker.basins.coarsening import coarsen_tile
from worker.cluster.driver import Driver
from worker.errors import InvalidJob, JobCancelled, StoreFailed
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.swept_parameter import SweptParameter
from worker.pictures.window import Window
from worker.results.figure import basin_figure
from worker.results.panel import Look
from worker.results.viewer import outline_basin, read_tile_labels
from worker.run import run_job
from worker.stores.basin_store import BasinStore
from worker.stores.pyramid import LABELS

LONG = BasinJob(grid=CellGrid(time_cells=4100, velocity_cells=20), iterations=7)
NAMES = [each.name for each in LABELS]
# Chunks of a store that hold no cells, but its ledger and its table of motions: each array has one.
TABLES = 20


def run(job, location, client, *, report=lambda _: None, cancel=None):
    run_job(job, str(location), Driver(client), report=report, cancel=cancel or threading.Event())


def every(dataset, n):
    return dataset.isel(time=slice(None, None, n), velocity=slice(None, None, n))


@pytest.fixture(scope="module")
def computed(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("computed") / "basin.zarr"
    run(LONG, location, client)
    return location


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    location = tmp_path_factory.mktemp("large") / "basin.zarr"
    return str(location), large_store(location)


@pytest.mark.parametrize("cells", [(4000, 4000), (1, 4000)])
def test_basins_of_4000_cells_a_side_have_no_levels_and_nothing_of_them_in_their_stores(tmp_path, cells):
    grid = CellGrid(velocity_cells=cells[0], time_cells=cells[1])
    store = BasinStore.create_or_resume(str(tmp_path / "basin.zarr"), BasinJob(grid=grid))
    assert len(store.levels) == 1 and not (tmp_path / "basin.zarr/pyramid").exists()
    assert not {"multiscales", "zarr_conventions"} & store.attributes.keys()


@pytest.mark.parametrize("cells", [pytest.param((4097, 4999), marks=pytest.mark.slow), (4097, 499), (4001, 1)])
def test_each_level_has_every_second_cell_of_the_one_before(tmp_path, cells):
    grid = CellGrid(velocity_cells=cells[0], time_cells=cells[1])
    store = BasinStore.create_or_resume(str(tmp_path / "basin.zarr"), BasinJob(grid=grid, iterations=1))
    fill(store, store.levels[0], range(store.tiling.tiles))
    for level in store.levels[1:]:
        assert level.tiling.grid.shape == tuple(ceil(side / level.every) for side in cells)
        for number in level.tiling.numbers_of(0):
            coarsen_tile(store.location, store.digest, number, level.number)
        opened = xr.open_zarr(store.location, group=f"pyramid/{level.number}")
        rows, columns = (np.arange(0, side, level.every) for side in cells)
        np.testing.assert_array_equal(opened.time, grid.time_centres()[columns])
        np.testing.assert_array_equal(opened.velocity, grid.velocity_centres()[rows])
        for name in NAMES:
            np.testing.assert_array_equal(opened[name], label(name, rows, columns))
    assert max(store.levels[-1].tiling.grid.shape) <= 1000 < max(store.levels[-2].tiling.grid.shape)


def test_the_pipeline_writes_levels_that_open_with_xarray(computed):
    with xr.open_zarr(computed) as whole:
        for level in (1, 2, 3):
            with xr.open_zarr(computed, group=f"pyramid/{level}") as coarse:
                assert coarse.equals(every(whole[NAMES], 2**level))
    assert rattle.open(computed).rattle.levels == {0: (20, 4100), 1: (10, 2050), 2: (5, 1025), 3: (3, 513)}


def test_the_convention_names_arrays_that_are_there_each_half_of_the_one_before(computed):
    root = zarr.open_group(computed, mode="r")
    (convention,) = root.attrs["zarr_conventions"]
    assert convention["name"] == "multiscales" and convention["uuid"] == "d35379db-88df-4056-af3a-620245f8e347"
    layout = root.attrs["multiscales"]["layout"]
    assert [each["asset"] for each in layout] == ["solution", *(f"pyramid/{n}/solution" for n in (1, 2, 3))]
    for finer, coarser in zip(layout, layout[1:], strict=False):
        assert coarser["derived_from"] == finer["asset"]
        scale = coarser["transform"]["scale"]
        shape = tuple(ceil(side / by) for side, by in zip(root[finer["asset"]].shape, scale, strict=True))
        assert root[coarser["asset"]].shape == shape


@pytest.mark.slow
def test_a_sweep_has_levels_of_each_basin(client, tmp_path):
    vary = (SweptParameter("damping", (0.7, 0.6)),)
    grid = CellGrid(time_cells=4100, velocity_cells=2)
    run(SweepJob(grid=grid, iterations=7, vary=vary), tmp_path / "sweep.zarr", client)
    whole, coarse = rattle.open(tmp_path / "sweep.zarr"), rattle.open(tmp_path / "sweep.zarr", level=2)
    assert coarse.solution.dims == ("damping", "velocity", "time") and coarse.solution.shape == (2, 1, 1025)
    sampled = every(whole, 4)
    for name in (*NAMES, "share", "grazing_velocity", "damping"):
        assert coarse[name].equals(sampled[name]), name


@pytest.mark.slow
def test_a_job_that_is_stopped_within_its_levels_resumes_to_the_same_bytes(client, computed, tmp_path):
    location, cancel = tmp_path / "basin.zarr", threading.Event()

    def cancel_within_levels(progress):
        if (location / "pyramid/1/step/c").exists():
            cancel.set()

    with pytest.raises(JobCancelled):
        run(LONG, location, client, report=cancel_within_levels, cancel=cancel)
    assert not (location / "pyramid/3/step/c").exists()
    assert rattle.check(location).damages == ()
    run(LONG, location, client)
    assert content(location) == content(computed)


@pytest.mark.parametrize(
    ("damage", "path"),
    [
        ("flipped", "pyramid/1/solution/c/0/1"),
        *(
            pytest.param("missing", f"pyramid/{path}", marks=pytest.mark.slow)
            for path in ("3/group/c/0/0", "2/time/c/0")
        ),
    ],
)
def test_a_damaged_level_is_found_and_mended(computed, tmp_path, path, damage):
    store = shutil.copytree(computed, tmp_path / "store")
    if damage == "flipped":
        flip(store / path)
    else:
        (store / path).unlink()
    found = rattle.check(store, workers=2)
    assert [each.path for each in found.damages] == [path] and found.mended
    assert content(store) == content(computed)


def test_a_store_from_before_there_were_levels_is_read_as_it_is(computed, tmp_path):
    store = shutil.copytree(computed, tmp_path / "store")
    shutil.rmtree(store / "pyramid")
    root = zarr.open_group(store, mode="r+", use_consolidated=False)
    for name in ("multiscales", "zarr_conventions"):
        del root.attrs[name]
    with pytest.warns(zarr.errors.ZarrUserWarning):
        zarr.consolidate_metadata(store)
    assert rattle.check(store, dry_run=True).damages == ()
    assert rattle.open(store).rattle.levels == {0: (20, 4100)}
    assert outline_basin(str(store), 0).levels == ()
    with pytest.raises(InvalidJob, match="no level 1: only basins of more than 4,000 cells"):
        rattle.open(store, level=1)


def test_a_level_is_no_basin_to_measure(computed):
    coarse = rattle.open(computed, level=1)
    for measure in (coarse.rattle.measures, coarse.rattle.least_disturbance):
        with pytest.raises(InvalidJob, match="this is level 1"):
            measure()
    with pytest.raises(InvalidJob, match="levels from 0 to 3"):
        rattle.open(computed, level=4)


@pytest.mark.slow
def test_xarray_opens_1e10_cells_without_reading_any_and_a_level_by_its_chunks(large, monkeypatch):
    location, store = large
    read = ChunksRead(monkeypatch)
    whole, coarse = rattle.open(location), rattle.open(location, level=7)
    assert whole.solution.shape == (100_000, 100_000) and read.of_cells == 0
    np.testing.assert_array_equal(coarse.solution, label("solution", *[np.arange(0, 100_000, 128)] * 2))
    assert read.of_cells == store.levels[7].tiling.tiles == 1


def test_the_page_shows_1e10_cells_by_the_chunks_of_one_level(large, monkeypatch):
    location, store = large
    read = ChunksRead(monkeypatch)
    outline = outline_basin(location, 0)
    level = outline.levels[-1]
    for number in level.tiling.numbers_of(0):
        labels = read_tile_labels(location, number, level=level.number)
        assert labels.final and (labels.rows, labels.columns) == (782, 782)
    assert read.of_cells == len(NAMES) * level.tiling.tiles == 4
    assert len(read.arrays) <= read.of_cells + TABLES
    with pytest.raises(InvalidJob, match="no level 8"):
        read_tile_labels(location, 0, level=8)
    assert read_tile_labels(location, 1, level=7) is None


@pytest.mark.parametrize("width", [pytest.param(each, marks=pytest.mark.slow) for each in (1.0, 0.3, 0.05, 0.004)])
def test_a_picture_of_any_window_reads_few_chunks_and_shows_its_cells(large, monkeypatch, width):
    location, store = large
    cells = (40_000, min(40_000 + round(width * 100_000), 100_000)) if width < 1.0 else (0, 100_000)
    shown = 1 << max(0, ceil(np.log2((cells[1] - cells[0]) / 2000)))
    level = store.levels[min(shown.bit_length() - 1, 7)]
    tiles = tiles_of(level, cells, cells)
    fill(store, level, tiles)
    read = ChunksRead(monkeypatch)
    edges = [cell / 100_000 for cell in cells]
    window = Window(*edges, *(7.0 * edge for edge in edges))
    image = basin_figure(location, Look(window=window if width < 1.0 else None, overlays=())).axes[0].images[0]
    side = image.get_array().shape[0]
    assert abs(side - (cells[1] - cells[0]) / shown) <= 2
    # Solutions and, for the shades of chaos, groups: of the tiles that the window can touch.
    most = 2 * prod(ceil(side * shown / level.every / tile) + 1 for tile in level.tiling[1:3])
    # The usual shade of chaos is that of the whole basin, as a picture of all of it reads it.
    whole = store.levels[6]
    most += 2 * prod(ceil(100_000 / whole.every / tile) for tile in whole.tiling[1:3]) if width < 1.0 else 0
    assert 2 <= read.of_cells <= most <= 2 * (2000 // min(level.tiling.tile_rows, 2000) + 2) ** 2 + 8


def test_what_a_level_lacks_is_an_error_that_names_the_level(large):
    with pytest.raises(StoreFailed, match="tile 0/0 of pyramid/2/step is missing"):
        read_tile_labels(large[0], 0, level=2)


def test_an_unfinished_store_shows_no_levels(tmp_path):
    store = BasinStore.create_or_resume(str(tmp_path / "basin.zarr"), LARGE)
    assert len(store.levels) == 8 and outline_basin(store.location, 0).levels == ()
    assert read_tile_labels(store.location, 0, level=7) is None
    finish(store)
    assert len(outline_basin(store.location, 0).levels) == 7
