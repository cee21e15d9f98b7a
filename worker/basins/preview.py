"""A small basin at once, in memory: the solutions of its cells, without Hsu's numbers and without a store."""

import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rattle_kernels import (
    Attractor,
    CellGrid,
    CellImages,
    ExpectedLoudness,
    Loudness,
    Oscillator,
    expected_loudness,
    find_attractors,
    loudness,
    map_cells,
)
from rattle_kernels.attractors.neighbourhoods import locate, neighbourhoods
from rattle_kernels.attractors.seed_pass import traps_of_seeds
from rattle_kernels.attractors.seeds import choose_seeds
from rattle_kernels.numerics.phase import wrap_all
from worker.basins.first_names import few_seeds, first_names
from worker.basins.landings import name_landings, with_undecided
from worker.basins.preview_request import PreviewRequest

_CATALOGUES_KEPT = 8
_ROUNDS = 2
# A job carries points on long transients through 32 legs of some 4000 impacts; what is left here is undecided.
_LEGS = 2

Catalogue = tuple[Attractor, ...]


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


def preview_basin(request: PreviewRequest, pause: Callable[[], None] = lambda: None) -> Preview:
    """Compute the basin of a request at once.

    The solutions of its cells are those of a job with the same k, unless the request asks for quick names.

    Parameters
    ----------
    request : PreviewRequest
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Preview
        Its catalogue lists the motions that its cells end in, and what the chaotic transients among them end in.

    Raises
    ------
    OutsideDomain, InvalidJob
        Naming what is wrong with the request.
    """
    oscillator, grid, k = request.checked()
    traps = traps_of_seeds(oscillator, grid, k, grid.cells, pause)
    rows, columns = (0, grid.velocity_cells), (0, grid.time_cells)
    images = map_cells(oscillator, grid, k, rows, columns, traps=traps, pause=pause)
    if request.quick:
        solution, attractors = first_names(oscillator, images, _known.of(oscillator), pause)
    else:
        solution, attractors = _named(oscillator, images, pause)
        _known.keep(oscillator, attractors)
    there = np.unique(solution).tolist()
    there = sorted({*there, *(end for number in there for end, _ in attractors[number].ends)})
    solution = np.searchsorted(there, solution)
    shape = grid.velocity_cells, grid.time_cells
    listed = tuple(
        each._replace(ends=tuple((there.index(end), share) for end, share in each.ends))
        for each in (attractors[number] for number in there)
    )
    heard = tuple(loudness(oscillator, each) for each in listed)
    return Preview(grid, oscillator, solution.reshape(shape), listed, heard)


def _named(oscillator: Oscillator, images: CellImages, pause: Callable[[], None]) -> tuple[np.ndarray, Catalogue]:
    """Solution of each cell, and the catalogue: extended by landing points that reach none of its attractors."""
    unassigned = choose_seeds(oscillator, images.landing_time, images.landing_velocity)
    attractors = _known.of(oscillator)
    if attractors:
        solution, unassigned = name_landings(oscillator, attractors, images, pause, _name_at_once)
    for _ in range(_ROUNDS):
        if attractors and not unassigned.box.size:
            break
        seeds, known = few_seeds(unassigned), attractors
        attractors = find_attractors(oscillator, seeds.time, seeds.velocity, known=known, pause=pause)
        solution, unassigned = name_landings(oscillator, attractors, images, pause, _name_at_once)
    if (solution < 0).any():
        attractors = with_undecided(attractors)
        solution[solution < 0] = len(attractors) - 1
    return solution, attractors


def _name_at_once(
    oscillator: Oscillator, attractors: Catalogue, t: np.ndarray, v: np.ndarray, pause: Callable[[], None]
) -> np.ndarray:
    """Solution of each landing point, as `rattle_kernels.name_solutions` with fewer legs."""
    around = neighbourhoods(oscillator, attractors, pause)
    return locate(oscillator, around, wrap_all(t), v, _LEGS, pause).astype(np.int16)
