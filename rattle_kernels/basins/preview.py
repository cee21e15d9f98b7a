"""A small basin at once, in memory: the solutions of its cells, without Hsu's numbers.

Quick labels are what some thousand impacts show, for a picture at once. A job follows a whole ensemble beside each
motion that does not settle, and carries slow motions through their transients. That can take a hundred times as long as
all cells of a preview. Here a motion that has not settled is called chaotic if tangent vectors grow along it, and
undecided if they do not. It may settle later.
"""

import math
import threading
from collections import OrderedDict
from functools import partial
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import (
    PERMANENT_CONTACT_ATTRACTOR,
    UNDECIDED_ATTRACTOR,
    Attractor,
    AttractorKind,
    with_undecided,
)
from rattle_kernels.attractors.attractor_search import find_attractors
from rattle_kernels.attractors.chaotic_transient import REGULAR_GROWTH
from rattle_kernels.attractors.classify import UNASSIGNED, name_solutions
from rattle_kernels.attractors.loudness import Loudness, loudness
from rattle_kernels.attractors.neighbourhoods import locate, neighbourhoods
from rattle_kernels.attractors.seeds import Seeds, choose_seeds, gather_seeds
from rattle_kernels.attractors.settled_orbit import attractor_of, settled_orbit
from rattle_kernels.basin_measures.expected_loudness import ExpectedLoudness, expected_loudness
from rattle_kernels.basins.basin import map_bands
from rattle_kernels.basins.naming import Catalogue, name_landings
from rattle_kernels.basins.tiles import Tiling
from rattle_kernels.cell_mapping.cell_grid import CellGrid
from rattle_kernels.cell_mapping.cell_map import CellImages
from rattle_kernels.lanes.arrival import follow
from rattle_kernels.lanes.lyapunov import tangent_growth
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.phase import wrap_all

_CATALOGUES_KEPT = 8
_ROUNDS = 2
# A job carries points on long transients through 32 legs of some 4000 impacts; what is left here is undecided.
_name_at_once = partial(name_solutions, legs=2)
# A job follows thousands of seeds for thousands of impacts each, which takes longer than all cells of a preview.
# Attractors that these seeds miss show up as unassigned landing points.
_MOST_SEEDS = 24
_SETTLING = 4096
# Motions settle in a time like 1/damping. Chaos never does, and most cells lie in its basin where there is any.
_NAMING, _NAMING_BESIDE_CHAOS, _MOST_NAMING = 60.0, 20.0, 600
_GROWING = 512

_CHAOS = UNDECIDED_ATTRACTOR._replace(kind=AttractorKind.CHAOTIC)


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
    images = map_bands(oscillator, grid, iterations, Tiling(grid, *grid.shape).tile(0), pause)
    if quick:
        solution, attractors = _quick_labels(oscillator, images, pause)
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
        seeds = _few(unassigned)
        attractors = find_attractors(oscillator, seeds.time, seeds.velocity, known=attractors, pause=pause)
        solution, unassigned = name_landings(oscillator, attractors, images, pause, _name_at_once)
    if (solution < 0).any():
        attractors = with_undecided(attractors)
        solution[solution < 0] = len(attractors) - 1
    return solution, attractors


def _few(seeds: Seeds) -> Seeds:
    return gather_seeds([seeds], _MOST_SEEDS)


def _quick_labels(oscillator: Oscillator, images: CellImages, pause: Pause) -> tuple[np.ndarray, Catalogue]:
    """As `_named`, by the orbit that each cell settles on within some thousand impacts, if there is one.

    Chaos is without points in the catalogue if it was not known before.
    """
    known = _known.of(oscillator)
    seeds = _few(choose_seeds(oscillator, images.landing_time, images.landing_velocity))
    attractors, chaotic = (known, False) if known else _settled(oscillator, seeds, pause)
    name = partial(_name_soon, within=_NAMING_BESIDE_CHAOS if chaotic else _NAMING)
    solution, unnamed = name_landings(oscillator, attractors, images, pause, name)
    if (solution < 0).any():
        rest = _CHAOS if _mostly_grow(oscillator, _few(unnamed)) else UNDECIDED_ATTRACTOR
        alike = [number for number, each in enumerate(attractors) if each.is_chaotic and rest.is_chaotic]
        attractors = attractors if alike else (*attractors, rest)
        solution[solution < 0] = alike[0] if alike else len(attractors) - 1
    return solution, attractors


def _settled(oscillator: Oscillator, seeds: Seeds, pause: Pause) -> tuple[Catalogue, bool]:
    """Permanent contact and the orbits on which some of the seeds have settled; and whether others are chaotic."""
    ends = next_impacts(oscillator, seeds.time, seeds.velocity, _SETTLING, shortcuts=True)
    going = ends.outcome == Outcome.RETURNED
    orbits: list[Attractor] = []
    t, v = wrap_all(ends.t[going]), ends.v[going]
    # A search for orbits along chaos takes ten times as long as this.
    chaotic = _growths(oscillator, t, v) > 0.0
    t, v = t[~chaotic], v[~chaotic]
    while t.size:
        pause()
        orbit = settled_orbit(oscillator, float(t[0]), float(v[0]))
        t, v = t[1:], v[1:]
        if orbit is None:
            continue
        orbits.append(attractor_of(orbit))
        elsewhere = locate(oscillator, neighbourhoods(oscillator, orbits, pause), t, v) < 0
        t, v = t[elsewhere], v[elsewhere]
    by_length = sorted(orbits, key=lambda each: (each.upper_contacts, each.forcing_periods, each.lower_contacts))
    return (PERMANENT_CONTACT_ATTRACTOR, *by_length), bool(chaotic.any())


def _name_soon(
    oscillator: Oscillator, attractors: Catalogue, t: np.ndarray, v: np.ndarray, pause: Pause, *, within: float
) -> np.ndarray:
    """Solution of each landing point, as `name_solutions` after fewer impacts."""
    pause()
    arrived = np.full(t.size, UNASSIGNED, np.int64)
    impacts = min(round(within / oscillator.damping), _MOST_NAMING)
    around = neighbourhoods(oscillator, attractors, pause)
    follow(oscillator, lane_tables(oscillator), around, impacts, wrap_all(t), v.copy(), arrived)
    return arrived.astype(np.int16)


def _growths(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Logarithm of the growth of tangent vectors beyond that along regular motions; NaN of captured motions."""
    return tangent_growth(oscillator, t, v, _GROWING).growth - math.log(REGULAR_GROWTH * _GROWING)


def _mostly_grow(oscillator: Oscillator, seeds: Seeds) -> bool:
    growths = _growths(oscillator, seeds.time, seeds.velocity)
    return (growths > 0.0).sum() > (growths <= 0.0).sum()
