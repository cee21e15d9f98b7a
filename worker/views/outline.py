"""All that a viewer needs to draw one basin by itself, except its cells, which come tile by tile."""

from dataclasses import dataclass

import numpy as np

from rattle_kernels import Attractor, Oscillator, grazing_velocity
from worker.errors import InvalidJob
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState
from worker.stores.solution_table import SolutionTable
from worker.stores.summary import representatives
from worker.stores.tiles import Tiling

_CURVE_POINTS = 512
# Points of a chaotic attractor: enough to see its shape, on a screen and over a network.
_MOST_POINTS = 3000


@dataclass(frozen=True)
class PanelOutline:
    """A panel, but for its cells.

    ``solutions`` are those of the whole store, by number, with the panel's own points (none where it has no such
    solution) and ``shares`` (NaN until the panel is complete); ``states`` are `TileState` codes of the panel's tiles,
    the first of which has the number ``first_tile``. ``curve`` holds phases and speeds of the grazing curve.
    """

    values: dict[str, float]
    oscillator: Oscillator
    tiling: Tiling
    first_tile: int
    states: tuple[int, ...]
    complete: bool
    solutions: tuple[Attractor, ...]
    shares: tuple[float, ...]
    curve: tuple[np.ndarray, np.ndarray]


def open_cells(location: str, panel: int = 0) -> BasinStore:
    """Store of a grid of cells that has such a panel.

    Raises
    ------
    InvalidJob
        Where there is no such panel, or the store is of a sample.
    StoreConflict, StoreFailed
        Where there is no basin's store, or it cannot be read.
    """
    store = BasinStore(location)
    if store.job.sample is not None:
        raise InvalidJob("a sample has no cells, and so no tiles: picture.png draws its points")
    if not 0 <= panel < store.job.panels:
        raise InvalidJob(f"panel {panel} is none of the job's {store.job.panels}, which count from 0")
    return store


def catalogue_of(store: BasinStore, table: SolutionTable, panel: int) -> dict[int, Attractor]:
    """Solutions of a panel by number, with its own points; of the first panel as soon as they are known."""
    numbers = table.numbers_in(panel) or (list(range(len(table.motions))) if panel == 0 else [])
    return dict(zip(numbers, store.read_catalogue(panel, table, numbers), strict=True)) if numbers else {}


def outline_panel(location: str, panel: int) -> PanelOutline:
    """Outline of a panel of the store at a location, finished or not.

    Raises
    ------
    InvalidJob
        Where there is no such panel, or the store is of a sample.
    StoreConflict, StoreFailed
        Where there is no basin's store, or it cannot be read.
    """
    store = open_cells(location, panel)
    table = store.read_solutions()
    tiles = store.tiling.numbers_of(panel)
    states = store.read_ledger()[tiles]
    everywhere = representatives(store, table)
    there = catalogue_of(store, table, panel)
    grid, oscillator = store.job.grid, store.job.oscillator_of(panel)
    phases = np.linspace(grid.time_start, grid.time_stop, _CURVE_POINTS)
    return PanelOutline(
        values=store.job.values_of(panel),
        oscillator=oscillator,
        tiling=store.tiling,
        first_tile=tiles.start,
        states=tuple(states.tolist()),
        complete=bool((states == TileState.ASSEMBLED).all()),
        solutions=tuple(_thinned(there.get(i) or _without_points(each)) for i, each in enumerate(everywhere)),
        shares=tuple(table.share[panel].tolist()),
        curve=(phases, grazing_velocity(oscillator, phases)),
    )


def _thinned(attractor: Attractor) -> Attractor:
    every = -(-attractor.time.size // _MOST_POINTS) or 1
    return attractor._replace(time=attractor.time[::every], velocity=attractor.velocity[::every])


def _without_points(attractor: Attractor) -> Attractor:
    return attractor._replace(time=np.empty(0), velocity=np.empty(0))
