"""What a viewer draws a basin from: the basin without its cells, their labels tile by tile, and overlays."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from rattle_kernels import (
    Attractor,
    ExpectedLoudness,
    Loudness,
    Oscillator,
    UncertaintyExponent,
    grazing_velocity,
    loudness,
    uncertainty_exponent,
)
from rattle_kernels.basins.tiles import Tiling
from worker.additions import additions
from worker.errors import InvalidJob
from worker.pictures.overlay import Overlay
from worker.pictures.overlay_kind import OverlayKind, masks_among, overlays_for
from worker.results.summary import expected_in, representatives
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState
from worker.stores.pyramid import LABELS, Level
from worker.stores.solution_table import SolutionTable

_CURVE_POINTS = 512
# Most points of an attractor: enough to see its shape on a screen, few enough for a network.
_MOST_POINTS = 3000
# Fewest cells each way and most in all from which an uncertainty exponent is told at once.
_LEAST_SIDE, _MOST_CELLS = 33, 25_000_000
_BY_NAME = {variable.name: variable for variable in LABELS}
# Wider types first, so that each array is aligned.
_ORDER = tuple(_BY_NAME[name] for name in ("step", "group", "period", "solution"))


@dataclass(frozen=True)
class PanelOutline:
    """A basin without its cells.

    ``solutions`` are those of the whole store, by number, with this basin's own points (none if it lacks the solution)
    and ``shares`` (NaN until the basin is complete), and their ``loudness`` here. ``expected`` is its mean over the
    window, None until the basin is complete. ``states`` are `TileState` codes of the basin's tiles, numbered from
    ``first_tile``. ``levels`` are the coarser ones that can be read. ``added`` has what packages say of it.
    ``curve`` holds phases and speeds of the grazing curve.
    """

    basin: int
    values: dict[str, float]
    oscillator: Oscillator
    tiling: Tiling
    first_tile: int
    states: tuple[int, ...]
    levels: tuple[Level, ...]
    complete: bool
    added: dict[str, Any]
    solutions: tuple[Attractor, ...]
    shares: tuple[float, ...]
    loudness: tuple[Loudness, ...]
    expected: ExpectedLoudness | None
    curve: tuple[np.ndarray, np.ndarray]


def open_cells(location: str, basin: int = 0) -> BasinStore:
    """Open a store of a grid of cells, and check that it has a basin of this number.

    Raises
    ------
    InvalidJob
        If there is no such basin, or the store holds a sample.
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    store = BasinStore.open(location)
    if store.job.sample is not None:
        raise InvalidJob("a sample has no cells, and so no tiles: picture.png draws its points")
    if not 0 <= basin < store.job.basins:
        raise InvalidJob(f"basin {basin} is none of the job's {store.job.basins}, which count from 0")
    return store


def catalogue_of(store: BasinStore, table: SolutionTable, basin: int) -> dict[int, Attractor]:
    """Solutions of a basin by number, with its own points; for the first basin as soon as they are known."""
    numbers = table.numbers_in(basin) or (list(range(len(table.motions))) if basin == 0 else [])
    return dict(zip(numbers, store.solutions.read_catalogue(basin, table, numbers), strict=True)) if numbers else {}


def outline_basin(location: str, basin: int) -> PanelOutline:
    """Outline of a basin, complete or not, of the store at a location.

    Raises
    ------
    InvalidJob
        If there is no such basin, or the store holds a sample.
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    store = open_cells(location, basin)
    table = store.solutions.read()
    tiles = store.tiling.numbers_of(basin)
    states = store.read_ledger()[tiles]
    everywhere = representatives(store, table)
    there = catalogue_of(store, table, basin)
    solutions = [there.get(number) or _without_points(each) for number, each in enumerate(everywhere)]
    grid, oscillator = store.job.grid, store.job.oscillator_of(basin)
    phases = np.linspace(grid.time_start, grid.time_stop, _CURVE_POINTS)
    return PanelOutline(
        basin=basin,
        values=store.job.values_of(basin),
        oscillator=oscillator,
        tiling=store.tiling,
        first_tile=tiles.start,
        states=tuple(states.tolist()),
        levels=store.whole_levels[1:],
        complete=bool((states == TileState.ASSEMBLED).all()),
        added={name: value for addition in additions() for name, value in addition.of_outline(store).items()},
        solutions=tuple(_thinned(each) for each in solutions),
        shares=tuple(table.share[basin].tolist()),
        loudness=tuple(loudness(oscillator, each) for each in solutions),
        expected=expected_in(store, table, basin),
        curve=(phases, grazing_velocity(oscillator, phases)),
    )


def _thinned(attractor: Attractor) -> Attractor:
    every = -(-attractor.time.size // _MOST_POINTS) or 1
    return attractor._replace(time=attractor.time[::every], velocity=attractor.velocity[::every])


def _without_points(attractor: Attractor) -> Attractor:
    return attractor._replace(time=np.empty(0), velocity=np.empty(0), ends=())


def overlay_basin(location: str, basin: int, kind: OverlayKind) -> tuple[Overlay, ...]:
    """Overlays of one kind for a basin of the store at a location.

    Parameters
    ----------
    location : str
    basin : int
    kind : OverlayKind

    Returns
    -------
    tuple of Overlay
        From speed zero to the highest of the window, so curves are not cut where the window begins.

    Raises
    ------
    InvalidJob
        If there is no such basin, or its model lacks the overlay; or if cells have it, which come tile by tile.
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    if masks_among((kind,)):
        raise InvalidJob(f"what is {kind} comes with the cells, tile by tile: see tiles")
    store = open_cells(location, basin)
    catalogue = catalogue_of(store, store.solutions.read(), basin)
    attractors = tuple(catalogue[number] for number in sorted(catalogue))
    return overlays_for((kind,), store.job.oscillator_of(basin), attractors, (0.0, store.job.grid.velocity_stop))


def uncertainty_of_basin(location: str, basin: int) -> UncertaintyExponent | None:
    """Uncertainty exponent of the window of a basin of the store at a location; None until the basin is complete.

    Raises
    ------
    InvalidJob
        If there is no such basin, the store holds a sample, or the basin has too few cells or too many.
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    store = open_cells(location, basin)
    if (store.read_ledger()[store.tiling.numbers_of(basin)] != TileState.ASSEMBLED).any():
        return None
    grid = store.job.grid
    if min(grid.shape) < _LEAST_SIDE:
        raise InvalidJob(
            f"an uncertainty exponent needs {_LEAST_SIDE} x {_LEAST_SIDE} cells at least, not {grid.shape}"
        )
    if grid.time_cells * grid.velocity_cells > _MOST_CELLS:
        raise InvalidJob(f"beyond {_MOST_CELLS} cells it takes long: `measures()` of the result in Python has it")
    return uncertainty_exponent(store.read_solution(basin), wraps=grid.wraps)


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
