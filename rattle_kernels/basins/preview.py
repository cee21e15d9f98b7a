"""A small basin at once, in memory: the solutions of its cells, without Hsu's numbers."""

import threading
from collections import OrderedDict
from functools import partial
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import with_undecided
from rattle_kernels.attractors.attractor_search import find_attractors
from rattle_kernels.attractors.classify import name_solutions
from rattle_kernels.attractors.loudness import Loudness, loudness
from rattle_kernels.attractors.seed_pass import traps_of_seeds
from rattle_kernels.attractors.seeds import choose_seeds, gather_seeds
from rattle_kernels.basin_measures.expected_loudness import ExpectedLoudness, expected_loudness
from rattle_kernels.basins.naming import Catalogue, name_landings
from rattle_kernels.basins.quick_labels import FEW_SEEDS, quick_labels
from rattle_kernels.cell_mapping.cell_grid import CellGrid
from rattle_kernels.cell_mapping.cell_map import CellImages, map_cells
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped

_CATALOGUES_KEPT = 8
_ROUNDS = 2
# A job carries points on long transients through 32 legs of some 4000 impacts; what is left here is undecided.
_name_at_once = partial(name_solutions, legs=2)


class Preview(NamedTuple):
    """Solution of each cell as an index into a catalogue of attractors, each with its loudness.

    ``solution`` has the shape (velocity cells, time cells), from the lowest speed.
    """

    grid: CellGrid
    oscillator: Oscillator
    solution: np.ndarray
    attractors: Catalogue
    loudness: tuple[Loudness, ...]

    @property
    def expected(self) -> ExpectedLoudness:
        """Mean loudness over the window."""
        return expected_loudness(self.shares, self.loudness)

    @property
    def shares(self) -> np.ndarray:
        """Share of each attractor among the cells."""
        return np.bincount(self.solution.ravel(), minlength=len(self.attractors)) / self.solution.size


class _Catalogues:
    """Catalogues of the oscillators seen last. A window that is zoomed ends in the same motions."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._of: OrderedDict[Oscillator, Catalogue] = OrderedDict()

    def of(self, oscillator: Oscillator) -> Catalogue:
        with self._lock:
            return self._of.get(oscillator, ())

    def keep(self, oscillator: Oscillator, catalogue: Catalogue) -> None:
        with self._lock:
            self._of[oscillator] = catalogue
            self._of.move_to_end(oscillator)
            while len(self._of) > _CATALOGUES_KEPT:
                self._of.popitem(last=False)


_known = _Catalogues()


def preview(
    oscillator: Oscillator, grid: CellGrid, iterations: int, *, quick: bool = False, pause: Pause = never_stopped
) -> Preview:
    """Compute a small basin at once.

    The solutions of its cells are those of `basin` with the same k, unless quick labels are asked for.

    Parameters
    ----------
    oscillator : Oscillator
    grid : CellGrid
    iterations : int
        k, 1 or a prime.
    quick : bool
        Whether to name motions by what a few thousand impacts show.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Preview
        Its catalogue lists the motions that its cells end in, and what the chaotic transients among them end in.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If the grid or ``iterations`` is not valid.
    """
    traps = traps_of_seeds(oscillator, grid, iterations, grid.cells, pause)
    rows, columns = (0, grid.velocity_cells), (0, grid.time_cells)
    images = map_cells(oscillator, grid, iterations, rows, columns, traps=traps, pause=pause)
    if quick:
        solution, attractors = quick_labels(oscillator, images, _known.of(oscillator), pause)
    else:
        solution, attractors = _named(oscillator, images, pause)
        _known.keep(oscillator, attractors)
    there = np.unique(solution).tolist()
    there = sorted({*there, *(end for number in there for end, _ in attractors[number].ends)})
    solution = np.searchsorted(there, solution)
    listed = tuple(
        each._replace(ends=tuple((there.index(end), share) for end, share in each.ends))
        for each in (attractors[number] for number in there)
    )
    heard = tuple(loudness(oscillator, each) for each in listed)
    return Preview(grid, oscillator, solution.reshape(grid.shape), listed, heard)


def _named(oscillator: Oscillator, images: CellImages, pause: Pause) -> tuple[np.ndarray, Catalogue]:
    """Solution of each cell, and the catalogue: extended by landing points that reach none of its attractors."""
    unassigned = choose_seeds(oscillator, images.landing_time, images.landing_velocity)
    attractors = _known.of(oscillator)
    if attractors:
        solution, unassigned = name_landings(oscillator, attractors, images, pause, _name_at_once)
    for _ in range(_ROUNDS):
        if attractors and not unassigned.box.size:
            break
        seeds, known = gather_seeds([unassigned], FEW_SEEDS), attractors
        attractors = find_attractors(oscillator, seeds.time, seeds.velocity, known=known, pause=pause)
        solution, unassigned = name_landings(oscillator, attractors, images, pause, _name_at_once)
    if (solution < 0).any():
        attractors = with_undecided(attractors)
        solution[solution < 0] = len(attractors) - 1
    return solution, attractors
