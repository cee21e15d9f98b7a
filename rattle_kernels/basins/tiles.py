"""Tiles: the rectangles of cells that are computed, stored and retried as one. Pure arithmetic.

A tile's size depends on the request alone, never on the cluster. So the same request gives the same chunks and the same
bytes.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from rattle_kernels.cell_mapping.cell_grid import CellGrid
from rattle_kernels.lanes.lane_fields import LANES

# One application of P costs some 12 ns, and shortcuts leave about a third of those expected.
_SECONDS_PER_APPLICATION = 4e-9
_TILE_SECONDS = 0.25
_BAND_SECONDS = 0.1
# At least 16 tiles, four for each of four workers, unless a tile is not worth its overhead of a few milliseconds.
_LEAST_TILES = 16
_LEAST_CELLS = 64 * 64
# At the end of a band all lanes wait for the last. If trajectories are long and their lengths differ a lot, 16,384 in a
# band keep the wait to a few per cent. 256 would double the time.
_LEAST_LONG_CELLS = 128 * 128
_LONG_APPLICATIONS = 10_000
# A tile of 1024 x 1024 is 24 MB in memory while it is computed.
_MOST_CELLS = 1024 * 1024


class Tile(NamedTuple):
    """Rectangle of cells: indices in the grid of tiles, rows and columns of cells as (start, stop), and its basin."""

    row: int
    column: int
    rows: tuple[int, int]
    columns: tuple[int, int]
    basin: int = 0

    @property
    def cells(self) -> int:
        """Number of cells."""
        return (self.rows[1] - self.rows[0]) * (self.columns[1] - self.columns[0])


class Tiling(NamedTuple):
    """How the grid of every basin is cut: cells of a full tile each way. Tiles at the upper edges may be smaller."""

    grid: CellGrid
    tile_rows: int
    tile_columns: int
    basins: int = 1

    @property
    def shape(self) -> tuple[int, int]:
        """Tiles along velocity and along time."""
        return (
            math.ceil(self.grid.velocity_cells / self.tile_rows),
            math.ceil(self.grid.time_cells / self.tile_columns),
        )

    @property
    def tiles_of_basin(self) -> int:
        """Number of tiles of each basin."""
        return self.shape[0] * self.shape[1]

    @property
    def tiles(self) -> int:
        """Number of tiles of all basins."""
        return self.basins * self.tiles_of_basin

    def numbers_of(self, basin: int) -> range:
        """Numbers of a basin's tiles."""
        return range(basin * self.tiles_of_basin, (basin + 1) * self.tiles_of_basin)

    def tile(self, number: int) -> Tile:
        """Tile by number, counted along time first, then along velocity, then basin by basin."""
        basin, within = divmod(number, self.tiles_of_basin)
        row, column = divmod(within, self.shape[1])
        rows = row * self.tile_rows, min((row + 1) * self.tile_rows, self.grid.velocity_cells)
        columns = column * self.tile_columns, min((column + 1) * self.tile_columns, self.grid.time_cells)
        return Tile(row, column, rows, columns, basin)


def _least_cells(applications: int) -> int:
    return _LEAST_CELLS if applications < _LONG_APPLICATIONS else _LEAST_LONG_CELLS


def _cells_wanted(grid: CellGrid, applications: int, basins: int) -> float:
    """Cells in a tile of about a quarter of a second of work; the whole basin if basins are small and many."""
    by_work = _TILE_SECONDS / (_SECONDS_PER_APPLICATION * applications)
    return max(min(by_work, grid.cells * basins / _LEAST_TILES, _MOST_CELLS), _least_cells(applications))


def cut(grid: CellGrid, applications: int, basins: int = 1) -> Tiling:
    """Cut a grid into tiles of about a quarter of a second of work each.

    Parameters
    ----------
    grid : CellGrid
    applications : int
        Applications of P expected for each cell.
    basins : int
        Basins that share this grid.

    Returns
    -------
    Tiling
    """
    side = math.sqrt(_cells_wanted(grid, applications, basins))
    # Equal parts each way: 1000 cells become 4 x 250, not 3 x 267 and a remainder.
    down = max(1, round(grid.velocity_cells / side))
    across = max(1, round(grid.time_cells / side))
    return Tiling(grid, math.ceil(grid.velocity_cells / down), math.ceil(grid.time_cells / across), basins)


def cut_row(row: CellGrid, applications: int, basins: int = 1) -> Tiling:
    """Cut the points of a sample, one row of cells, into tiles of a power of two points each.

    Parameters
    ----------
    row : CellGrid
    applications : int
        Applications of P expected for each cell.
    basins : int
        Basins that share this sample.

    Returns
    -------
    Tiling
    """
    return Tiling(row, 1, 1 << int(math.log2(_cells_wanted(row, applications, basins))), basins)


def bands(tile: Tile, applications: int) -> Iterator[tuple[int, int]]:
    """Runs of rows of a tile, each about a tenth of a second of work, so that each takes little memory."""
    width = tile.columns[1] - tile.columns[0]
    rows = max(1, int(_cells_of_band(applications) / width))
    for start in range(tile.rows[0], tile.rows[1], rows):
        yield start, min(start + rows, tile.rows[1])


def _cells_of_band(applications: int) -> float:
    cells = _BAND_SECONDS / (_SECONDS_PER_APPLICATION * applications)
    return cells if applications < _LONG_APPLICATIONS else max(cells, _LEAST_LONG_CELLS)


def runs_of_points(points: int, applications: int) -> Iterator[tuple[int, int]]:
    """Runs of a sample's points, each about a tenth of a second of work, of whole lanes."""
    run = LANES * max(1, int(_cells_of_band(applications) / LANES))
    for start in range(0, points, run):
        yield start, min(start + run, points)
