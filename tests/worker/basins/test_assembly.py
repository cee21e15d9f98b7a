"""Assembly over tiles against Hsu on the whole map, for random maps written into stores."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rattle_kernels import CellGrid, CellGroups, CellImages, find_groups, label_cells
from rattle_kernels.basins.tiles import Tiling
from rattle_kernels.cell_mapping.image_set import members_of, unite, with_counts
from tests.rattle_kernels.cell_mapping.test_cell_groups import direct_hsu
from worker.basins.assembly import _kept_groups, assemble_groups, groups_of, places_of_images
from worker.basins.tasks import _images, map_tile, survey_tile
from worker.errors import StoreFailed
from worker.jobs.basin_job import BasinJob
from worker.stores.basin_store import BasinStore
from worker.stores.layout import MAPPED
from worker.stores.tile_arrays import TileArrays

_GRID = CellGrid(time_cells=12, velocity_cells=10)
_READ_TILE = TileArrays.read


@st.composite
def images(draw):
    highest = draw(st.integers(0, _GRID.cells - 1))
    cells = draw(st.lists(st.integers(-3, highest), min_size=_GRID.cells, max_size=_GRID.cells))
    return np.array(cells, np.int64).reshape(_GRID.shape)


def _stored(folder, image, tiling):
    """Store that holds a made-up map, written tile by tile."""
    store = BasinStore.create_or_resume(str(folder), BasinJob(grid=_GRID, iterations=1))
    store.tiling = tiling
    landing = np.where(image >= -1, 0.5, np.nan)
    for number in range(tiling.tiles):
        tile = tiling.tile(number)
        inside = slice(*tile.rows), slice(*tile.columns)
        store.tiles.write(MAPPED, tile, (image[inside], landing[inside], landing[inside]))
    return store


@given(images(), st.integers(1, 12), st.integers(1, 12))
@settings(max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_assembly_is_hsus_whatever_the_tiling(tmp_path_factory, image, tile_rows, tile_columns):
    tiling = Tiling(_GRID, tile_rows, tile_columns)
    store = _stored(tmp_path_factory.mktemp("store") / "map.zarr", image, tiling)
    receipts = [_receipt_of(store, number) for number in range(tiling.tiles)]
    words = unite(_GRID.cells, [receipt.survey.image_set for receipt in receipts]).words
    store.write_image_words(0, words)
    for groups in assemble_groups(store, 0), store.read_groups(0):
        labels = [np.empty(_GRID.shape, np.int32) for _ in range(3)]
        for number in range(tiling.tiles):
            tile = tiling.tile(number)
            inside = slice(*tile.rows), slice(*tile.columns)
            own = np.arange(_GRID.cells).reshape(_GRID.shape)[inside]
            for whole, part in zip(labels, label_cells(groups, own, image[inside]), strict=True):
                whole[inside] = part
        for ours, direct in zip(labels, direct_hsu(image.ravel().tolist()), strict=True):
            np.testing.assert_array_equal(ours.ravel(), direct)


def _receipt_of(store, number):
    from worker.basins.tasks import _receipt

    arrays = store.tiles.read(MAPPED, store.tiling.tile(number))
    return _receipt(store, 0, CellImages(*arrays, 0), 0.0)


def test_a_survey_of_a_stored_tile_counts_what_is_there(tmp_path):
    image = np.full(_GRID.shape, -2)
    image[0, :5] = [3, 3, 7, -1, -3]
    store = BasinStore.create_or_resume(str(tmp_path / "b.zarr"), BasinJob(grid=_GRID, iterations=1))
    landing = np.where(image >= -1, 0.5, np.nan)
    store.tiles.write(MAPPED, store.tiling.tile(0), (image, landing, landing))
    receipt = survey_tile(store.location, store.job.digest, 0)
    assert receipt.survey.reserved.tolist() == [1, 115, 1]
    members = unite(_GRID.cells, [receipt.survey.image_set])
    assert members_of(members).tolist() == [3, 7]
    assert find_groups(members, np.array([-1, -2], np.int32)).group.tolist() == [0, -1]


def test_who_found_the_groups_reads_them_no_more_and_others_read_the_same(tmp_path, monkeypatch):
    image = np.arange(_GRID.cells).reshape(_GRID.shape) // 7 * 5 % _GRID.cells
    store = _stored(tmp_path / "map.zarr", image, Tiling(_GRID, 4, 5))
    words = unite(
        _GRID.cells, [_receipt_of(store, number).survey.image_set for number in range(store.tiling.tiles)]
    ).words
    store.write_image_words(0, words)
    found = assemble_groups(store, 0)
    with monkeypatch.context() as nothing_to_read:
        nothing_to_read.delattr(BasinStore, "read_groups")
        assert groups_of(store, 0) is found
    _kept_groups.cache_clear()  # as in another process
    read = groups_of(store, 0)
    assert read is not found and groups_of(store, 0) is read
    for one, other in zip((*found.members, *found[1:]), (*read.members, *read[1:]), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(("group", "step", "kept"), [(1, 7, np.int16), (32767, 32768, np.int32), (32768, 7, np.int32)])
def test_groups_are_read_as_written_in_half_of_the_memory_where_they_fit(tmp_path, group, step, kept):
    grid = CellGrid(time_cells=2112, velocity_cells=2112)
    store = BasinStore.create_or_resume(str(tmp_path / "map.zarr"), BasinJob(grid=grid, iterations=1))
    members = with_counts(np.full(grid.cells // 64, ~np.uint64(0)))
    assert members.size > (1 << 22)  # more than one chunk, and the last one holds the largest
    numbers = np.full((2, members.size), [[-2], [0]], np.int32)
    numbers[:, -1] = group, step
    written = CellGroups(members, *numbers, np.arange(group + 1, dtype=np.int32))
    store.write_image_words(0, members.words)
    store.write_groups(0, written)
    read = store.read_groups(0)
    assert read.group.dtype == read.step.dtype == kept
    for one, other in zip(written[1:], read[1:], strict=True):
        np.testing.assert_array_equal(one, other)


def test_lost_groups_are_not_taken_for_others(tmp_path):
    """Zarr would say that every member has the fill value."""
    store = _stored(tmp_path / "map.zarr", np.zeros(_GRID.shape, np.int64), Tiling(_GRID, 10, 12))
    store.write_image_words(0, unite(_GRID.cells, [_receipt_of(store, 0).survey.image_set]).words)
    store.write_groups(0, assemble_groups(store, 0))
    assert store.read_groups(0).step.tolist() == [0]
    (lost,) = (tmp_path / "map.zarr" / "assembly" / "step" / "c").rglob("0")
    lost.unlink()
    with pytest.raises(StoreFailed, match=r"map\.zarr has lost a part of assembly/step"):
        store.read_groups(0)


def test_who_stops_while_images_are_read_reads_no_more_tiles(tmp_path, monkeypatch):
    image = np.arange(_GRID.cells).reshape(_GRID.shape)
    store = _stored(tmp_path / "map.zarr", image, Tiling(_GRID, 1, 1))
    members = unite(_GRID.cells, [_receipt_of(store, number).survey.image_set for number in range(store.tiling.tiles)])
    read = []
    monkeypatch.setattr(TileArrays, "read", lambda self, *what: read.append(what) or _READ_TILE(self, *what))

    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        places_of_images(store, 0, members, stop)
    assert 0 < len(read) < store.tiling.tiles


def test_a_basin_of_one_tile_is_labelled_without_reading_it_once(tmp_path, monkeypatch):
    store = BasinStore.create_or_resume(str(tmp_path / "b.zarr"), BasinJob(grid=_GRID, iterations=1))
    assert store.tiling.tiles_of_basin == 1
    address = store.location, store.digest
    map_tile(*address, 0)
    read = []
    monkeypatch.setattr(TileArrays, "read", lambda self, *what: read.append(what) or _READ_TILE(self, *what))
    mapped = _images(*address, 0)
    assert not read
    again = _images(*address, 0)
    assert len(read) == 1
    for one, other in zip(mapped[:3], again[:3], strict=True):
        np.testing.assert_array_equal(one, other)
