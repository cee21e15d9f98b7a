"""The labels of one tile as bytes, for a viewer."""

from dataclasses import dataclass

from worker.additions import additions
from worker.errors import InvalidJob
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState
from worker.stores.pyramid import LABELS, Level
from worker.views.outline import open_cells

_BY_NAME = {variable.name: variable for variable in LABELS}
# Wider types first, so that each array is aligned.
_ORDER = tuple(_BY_NAME[name] for name in ("step", "group", "period", "solution"))


@dataclass(frozen=True)
class TileLabels:
    """Step, group and period as int32, then solution as int16: little endian, row by row from the lowest speed.

    What packages add to the tile follows. ``final`` is true if it will never change, because the job is complete.
    """

    content: bytes
    rows: int
    columns: int
    final: bool


def read_tile_labels(location: str, number: int, every: int = 1, level: int = 0) -> TileLabels | None:
    """Labels of a tile; None if it is not labelled yet or does not exist.

    Parameters
    ----------
    location : str
        The store.
    number : int
        Number of the tile in its level, counted through all basins.
    every : int
        Keep only cells whose row and column in the level are multiples of this; labels are not averaged.
    level : int
        Which level; 0 is the basin itself.

    Raises
    ------
    InvalidJob
        If the store holds a sample, which has no cells, or there is no such level.
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    store = open_cells(location)
    final = store.complete
    if not 0 <= level < len(store.levels):
        raise InvalidJob(f"there is no level {level}: this basin has levels up to {len(store.levels) - 1}")
    shown = store.levels[level]
    if not _is_there(store, shown, number):
        return None
    tile = shown.tiling.tile(number)
    kept = tuple(slice(-start % every, None, every) for start in (tile.rows[0], tile.columns[0]))
    added = [values for addition in additions() for values in addition.read_tile(store, tile)]
    labels = [values[kept] for values in (*store.tiles.read(tuple(map(shown.own, _ORDER)), tile), *added)]
    content = b"".join(values.astype(values.dtype.newbyteorder("<")).tobytes() for values in labels)
    rows, columns = labels[0].shape
    return TileLabels(content, rows, columns, final)


def _is_there(store: BasinStore, level: Level, number: int) -> bool:
    """Whether there is a tile of this number, with its labels. Levels come last, when the basin is whole."""
    if not 0 <= number < level.tiling.tiles:
        return False
    return store.complete if level.number else bool(store.read_ledger()[number] == TileState.ASSEMBLED)
