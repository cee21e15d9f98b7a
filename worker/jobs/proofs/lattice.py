"""How large the lattice of a proof is: columns over a period, and how often its boxes are cut."""

import math

from rattle_kernels import CellGrid

LEVELS = 4
"""How often the lattice grows: as it is first, and each time that its boxes have been cut into four."""
# Its columns at the end: eight for each cell of the longer side of the grid. A box of 1/8192 serves finer grids, too.
_COLUMNS_A_CELL, _FEWEST_COLUMNS, _MOST_COLUMNS = 8, 512, 8192
# Lattices of several parts have as many boxes together as one of these columns: much of them is never proven.
_COLUMNS_OF_PARTS = 4096


def first_columns(grid: CellGrid, parts: int) -> int:
    """Columns of each lattice before its boxes are cut, where tolerances are cut into so many parts."""
    wanted = _COLUMNS_A_CELL * max(grid.time_cells, grid.velocity_cells)
    most = _MOST_COLUMNS if parts == 1 else 2 ** math.floor(math.log2(_COLUMNS_OF_PARTS / math.sqrt(parts)))
    columns = min(max(2 ** math.ceil(math.log2(wanted)), _FEWEST_COLUMNS), most)
    return columns >> (LEVELS - 1)


def most_boxes(grid: CellGrid, parts: int) -> int:
    """Boxes of all lattices at the end, at most, where the grid holds the fastest motion."""
    columns = first_columns(grid, parts) << (LEVELS - 1)
    # A row is at least half as high as the speeds of all columns divided by their number.
    return 2 * parts * columns * columns
