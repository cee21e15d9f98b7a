"""The data with which a viewer draws one basin, except its cells, which come tile by tile."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from rattle_kernels import Attractor, ExpectedLoudness, Loudness, Oscillator, grazing_velocity, loudness
from rattle_kernels.basins.tiles import Tiling
from worker.additions import additions
from worker.errors import InvalidJob
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState
from worker.stores.pyramid import Level
from worker.stores.solution_table import SolutionTable
from worker.stores.summary import expected_in, representatives

_CURVE_POINTS = 512
# Most points of an attractor: enough to see its shape on a screen, few enough for a network.
_MOST_POINTS = 3000


@dataclass(frozen=True)
class PanelOutline:
    """A basin without its cells.

    ``solutions`` are those of the whole store, by number, with this basin's own points (none if it lacks the solution)
    and ``shares`` (NaN until the basin is complete), and their ``loudness`` here. ``expected`` is its mean over the
    window, None until the basin is complete. ``states`` are `TileState` codes of the basin's tiles, numbered from
    ``first_tile``. ``levels`` are the coarser ones that can be read. ``added`` has what packages say of the basin.
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
    store = BasinStore(location)
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
