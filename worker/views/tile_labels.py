"""The labels of one tile as bytes, for a viewer that draws them itself."""

from dataclasses import dataclass

from worker.stores.layout import LABELLED, SOLUTION, TileState
from worker.views.outline import open_cells

_BY_NAME = {variable.name: variable for variable in (*LABELLED, SOLUTION)}
# The wider ones first, so that each array begins where its type may.
_ORDER = tuple(_BY_NAME[name] for name in ("step", "group", "period", "solution"))


@dataclass(frozen=True)
class TileLabels:
    """Step, group and period as int32, then solution as int16: little endian, each row by row from the lowest speed.

    ``final`` says that they will never change: the job is complete.
    """

    content: bytes
    rows: int
    columns: int
    final: bool


def read_tile_labels(location: str, number: int, every: int = 1) -> TileLabels | None:
    """Labels of a tile; None where it is not labelled yet, or there is none of this number.

    Parameters
    ----------
    location : str
        The store.
    number : int
        Of the tile, counted through all basins.
    every : int
        Only the cells whose row and whose column in the whole grid are multiples of this: labels are not averaged.

    Raises
    ------
    InvalidJob
        Where the store is of a sample, which has no cells.
    StoreConflict, StoreFailed
        Where there is no basin's store, or it cannot be read.
    """
    store = open_cells(location)
    final = store.complete
    if not 0 <= number < store.tiling.tiles or store.read_ledger()[number] != TileState.ASSEMBLED:
        return None
    tile = store.tiling.tile(number)
    kept = tuple(slice(-start % every, None, every) for start in (tile.rows[0], tile.columns[0]))
    labels = [values[kept] for values in store.read_tile(_ORDER, tile)]
    content = b"".join(values.astype(values.dtype.newbyteorder("<")).tobytes() for values in labels)
    rows, columns = labels[0].shape
    return TileLabels(content, rows, columns, final)
