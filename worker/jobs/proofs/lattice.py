"""How large the lattice of a proof is: columns over a period, and how often its boxes are cut."""

import math

from rattle_kernels import CellGrid

LEVELS = 4
"""How often the lattice grows: as it is first, and each time that its boxes have been cut into four."""
# Its columns at the end: eight for each cell of the longer side of the grid. A box of 1/8192 serves finer grids, too.
_COLUMNS_A_CELL, _FEWEST_COLUMNS, _MOST_COLUMNS = 8, 512, 8192


def first_columns(grid: CellGrid) -> int:
    """Columns of the lattice before its boxes are cut."""
    wanted = _COLUMNS_A_CELL * max(grid.time_cells, grid.velocity_cells)
    columns = min(max(2 ** math.ceil(math.log2(wanted)), _FEWEST_COLUMNS), _MOST_COLUMNS)
    return columns >> (LEVELS - 1)


def most_boxes(grid: CellGrid) -> int:
    """Boxes of the lattice at the end, at most, where the grid holds the fastest motion."""
    columns = first_columns(grid) << (LEVELS - 1)
    # A row is at least half as high as the speeds of all columns divided by their number.
    return 2 * columns * columns
