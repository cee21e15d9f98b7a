"""A basin of attraction in memory: cells are mapped, Hsu's algorithm runs on their images, and ends get their names.

    map tiles -> survey them -> assemble: groups, and a catalogue -> label tiles -> name tiles -> ... -> done
                                                                                       ^       |
                                                                                       +-------+ a longer catalogue

Workers do the same with a store between the parts. Tiles are the same, and seeds are taken in their order. So both give
the same numbers and, to the bit, the same catalogue.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count

import numpy as np

from rattle_kernels.attractors.seed_pass import traps_of_seeds
from rattle_kernels.attractors.seeds import Seeds, choose_seeds, gather_seeds
from rattle_kernels.basins.naming import Catalogue, first_catalogue, name_landings, next_catalogue
from rattle_kernels.basins.tiles import Tile, bands, cut
from rattle_kernels.cell_mapping.cell_grid import SINK, CellGrid, check_grid
from rattle_kernels.cell_mapping.cell_groups import find_groups, label_cells
from rattle_kernels.cell_mapping.cell_map import NOT_CONVERGED, PERMANENT_CONTACT, CellImages, join_images, map_cells
from rattle_kernels.cell_mapping.image_set import MarkedWords, mark_images, place_images, unite
from rattle_kernels.cell_mapping.iterations import check_iterations, expected_applications, settled_iterations
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped


@dataclass(frozen=True, eq=False)
class Basin:
    """Basins of attraction of one oscillator: the image, Hsu's numbers and the motion of each cell of a grid.

    Arrays have the shape (velocity cells, time cells), from the lowest speed. ``solution`` (int16) is the motion that a
    cell ends in, an index into the catalogue ``attractors``. ``image_cell`` (int64), ``landing_time`` and
    ``landing_velocity`` (float64) are as in `CellImages`. ``group`` (int32) is 1, 2, ... in the order of each cycle's
    lowest cell, 0 for the sink, -1 for permanent contact, -2 for cells that were not followed; ``period`` (int32) is
    the length of the group's cycle, 0 where there is none; ``step`` (int32) is the number of applications to the cycle,
    0 on it.
    """

    oscillator: Oscillator
    grid: CellGrid
    iterations: int
    attractors: Catalogue
    image_cell: np.ndarray
    landing_time: np.ndarray
    landing_velocity: np.ndarray
    group: np.ndarray
    period: np.ndarray
    step: np.ndarray
    solution: np.ndarray

    @property
    def share(self) -> np.ndarray:
        """Share of each motion among the cells, shape (attractors,)."""
        return np.bincount(self.solution.ravel(), minlength=len(self.attractors)) / self.grid.cells


@dataclass(frozen=True)
class Survey:
    """What becomes of a basin's tile, as far as its other tiles need to know.

    ``reserved`` (shape (3,)) counts the images SINK, PERMANENT_CONTACT and NOT_CONVERGED. ``image_set`` holds the
    distinct image cells, ``seeds`` the seeds of the catalogue.
    """

    reserved: np.ndarray
    image_set: MarkedWords
    seeds: Seeds


def map_bands(oscillator: Oscillator, grid: CellGrid, iterations: int, tile: Tile, pause: Pause) -> CellImages:
    """Images of a tile, a band of rows at a time.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    grid : CellGrid
        The whole grid.
    iterations : int
        k, 1 or a prime.
    tile : Tile
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    CellImages
        Whatever the tile: each image depends on its cell alone.
    """
    traps = traps_of_seeds(oscillator, grid, iterations, grid.cells, pause)
    map_rows = partial(map_cells, oscillator, grid, iterations, columns=tile.columns, traps=traps, pause=pause)
    return join_images([map_rows(rows) for rows in bands(tile, _applications(oscillator, iterations))])


def _applications(oscillator: Oscillator, iterations: int) -> int:
    return round(expected_applications(oscillator.damping, iterations))


def survey_images(oscillator: Oscillator, grid: CellGrid, images: CellImages) -> Survey:
    """Survey the images of a tile.

    Parameters
    ----------
    oscillator : Oscillator
    grid : CellGrid
        The whole grid.
    images : CellImages

    Returns
    -------
    Survey
    """
    cells = images.image_cell
    return Survey(
        reserved=np.array([(cells == code).sum() for code in (SINK, PERMANENT_CONTACT, NOT_CONVERGED)]),
        image_set=mark_images(grid.cells, cells),
        seeds=choose_seeds(oscillator, images.landing_time, images.landing_velocity),
    )


def basin(
    oscillator: Oscillator, grid: CellGrid, iterations: int | None = None, *, pause: Pause = never_stopped
) -> Basin:
    """Compute the basins of attraction of an oscillator over a grid of departures, in memory.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    grid : CellGrid
        Window of the (t, v) plane, and its cells. A million cells take some 100 MB.
    iterations : int, optional
        k, 1 or a prime; `settled_iterations` of the damping if left out.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Basin
        As the service and `rattle.basin` store it for the same request.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If the grid or ``iterations`` is not valid.

    Examples
    --------
    The basins of Fig. 7, on a coarse grid:

    >>> found = basin(Oscillator(), CellGrid(time_cells=100, velocity_cells=100))
    >>> for motion, share in zip(found.attractors, found.share):
    ...     print(motion.name, round(share, 2))
    permanent contact 0.72
    P(1,1,0) 0.03
    chaotic 0.25

    The cell around P(1,1,0) is a group of its own, which other cells reach in some steps:

    >>> print(found.period[53, 89], found.step[53, 89], found.step[found.group == found.group[53, 89]].max() > 0)
    1 0 True
    """
    checked, grid = check_oscillator(oscillator), check_grid(grid)
    k = check_iterations(settled_iterations(checked.damping) if iterations is None else iterations)
    tiling = cut(grid, _applications(checked, k))
    tiles = [tiling.tile(number) for number in range(tiling.tiles)]
    images = [map_bands(checked, grid, k, tile, pause) for tile in tiles]
    surveys = [survey_images(checked, grid, each) for each in images]
    labels = _label(grid, tiles, images, [each.image_set for each in surveys])
    seeds = gather_seeds([each.seeds for each in surveys])
    attractors = first_catalogue(checked, seeds, any(each.reserved[2] for each in surveys), pause)
    attractors, solutions = _name(checked, attractors, images, pause)
    of_tiles = [(*each[:3], *own, one) for each, own, one in zip(images, labels, solutions, strict=True)]
    arrays = (_whole(grid, tiles, parts) for parts in zip(*of_tiles, strict=True))
    return Basin(checked, grid, k, attractors, *arrays)


def _label(
    grid: CellGrid, tiles: Sequence[Tile], images: Sequence[CellImages], image_sets: list[MarkedWords]
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Hsu's group, period and step of the cells of each tile."""
    members = unite(grid.cells, image_sets)
    place = np.empty(members.size, np.int32)
    for tile, each in zip(tiles, images, strict=True):
        place_images(members, (tile.rows[0], tile.columns[0]), grid.time_cells, each.image_cell, place)
    groups = find_groups(members, place)
    own_cells = (grid.cell_numbers(tile.rows, tile.columns) for tile in tiles)
    return [label_cells(groups, own, each.image_cell) for own, each in zip(own_cells, images, strict=True)]


def _name(
    oscillator: Oscillator, attractors: Catalogue, images: Sequence[CellImages], pause: Pause
) -> tuple[Catalogue, list[np.ndarray]]:
    """The catalogue once it lacks no motion, and the solution of each tile's cells."""
    for rounds in count(1):
        named = [name_landings(oscillator, attractors, each, pause) for each in images]
        unassigned = gather_seeds([left for _, left in named])
        extended = next_catalogue(oscillator, attractors, unassigned, rounds, pause)
        if len(extended) == len(attractors):
            break
        attractors = extended
    return attractors, [solution for solution, _ in named]


def _whole(grid: CellGrid, tiles: Sequence[Tile], parts: Sequence[np.ndarray]) -> np.ndarray:
    """Array of all cells, from those of tiles."""
    whole = np.empty(grid.shape, parts[0].dtype)
    for tile, part in zip(tiles, parts, strict=True):
        whole[slice(*tile.rows), slice(*tile.columns)] = part
    return whole
