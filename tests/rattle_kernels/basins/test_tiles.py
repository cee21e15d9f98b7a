import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rattle_kernels import CellGrid
from rattle_kernels.basins.tiles import bands, cut, cut_row

grids = st.builds(
    lambda columns, rows: CellGrid(time_cells=columns, velocity_cells=rows), st.integers(1, 400), st.integers(1, 400)
)


@given(grids, st.sampled_from([1, 7, 1499, 100_003]))
def test_tiles_and_their_bands_cover_every_cell_once(grid, iterations):
    covered = np.zeros(grid.shape, np.int64)
    tiling = cut(grid, iterations)
    for number in range(tiling.tiles):
        tile = tiling.tile(number)
        assert (tile.row, tile.column) == divmod(number, tiling.shape[1])
        for rows in bands(tile, iterations):
            covered[slice(*rows), slice(*tile.columns)] += 1
    assert (covered == 1).all()


@given(grids, st.sampled_from([1, 1499]))
def test_every_tile_begins_at_a_chunk_border(grid, iterations):
    tiling = cut(grid, iterations)
    for number in range(tiling.tiles):
        tile = tiling.tile(number)
        assert tile.rows[0] % tiling.tile_rows == 0 and tile.columns[0] % tiling.tile_columns == 0


def test_the_papers_map_is_cut_into_enough_tiles_for_several_workers():
    assert 16 <= cut(CellGrid(), 1499).tiles <= 64
    assert 16 <= cut(CellGrid(), 1).tiles <= 64


def test_where_trajectories_are_long_a_band_fills_the_lanes():
    tiling = cut(CellGrid(), 90_000)
    assert 40 <= tiling.tiles <= 70
    assert all(rows[1] - rows[0] == tiling.tile_rows for rows in bands(tiling.tile(0), 90_000))


def test_a_few_cells_are_one_tile():
    assert cut(CellGrid(time_cells=20, velocity_cells=20), 1499).tiles == 1


def test_a_very_large_map_has_tiles_that_fit_in_memory():
    tiling = cut(CellGrid(time_cells=20_000, velocity_cells=20_000), 1)
    assert tiling.tile_rows * tiling.tile_columns <= 1.2 * 1024 * 1024


def test_of_many_small_panels_a_tile_is_a_whole_one():
    tiling = cut(CellGrid(time_cells=200, velocity_cells=200), 1499, basins=1000)
    assert (tiling.tiles_of_basin, tiling.tiles) == (1, 1000)
    assert cut(CellGrid(time_cells=200, velocity_cells=200), 1499).tiles_of_basin > 1


def test_tiles_are_numbered_panel_by_panel():
    tiling = cut(CellGrid(time_cells=400, velocity_cells=400), 1499, basins=3)
    numbers = [number for basin in range(3) for number in tiling.numbers_of(basin)]
    assert numbers == list(range(tiling.tiles))
    basins = [tiling.tile(number).basin for number in numbers]
    assert basins == sorted([0, 1, 2] * tiling.tiles_of_basin)
    assert tiling.tile(numbers[-1])[:4] == tiling.tile(tiling.tiles_of_basin - 1)[:4]


@given(st.integers(1, 100_000), st.sampled_from([1, 1499]), st.integers(1, 50))
def test_a_sample_is_cut_into_powers_of_two(points, iterations, basins):
    tiling = cut_row(CellGrid(time_cells=points, velocity_cells=1), iterations, basins)
    assert tiling.tile_columns.bit_count() == 1
    covered = [tiling.tile(number).columns for number in tiling.numbers_of(0)]
    assert covered[0][0] == 0 and covered[-1][1] == points
    assert all(one[1] == other[0] for one, other in zip(covered, covered[1:], strict=False))
