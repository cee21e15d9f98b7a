"""The motions that cells end in, by name: a catalogue from their landing points, extended by those that it lacks."""

from collections.abc import Callable

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind, with_undecided
from rattle_kernels.attractors.attractor_search import find_attractors
from rattle_kernels.attractors.classify import UNASSIGNED, name_solutions
from rattle_kernels.attractors.seeds import Seeds, choose_seeds
from rattle_kernels.cell_mapping.cell_grid import SINK
from rattle_kernels.cell_mapping.cell_map import PERMANENT_CONTACT, CellImages
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause

Catalogue = tuple[Attractor, ...]

_ROUNDS = 3


def first_catalogue(oscillator: Oscillator, seeds: Seeds, lost: bool, pause: Pause) -> Catalogue:
    """Catalogue of the motions that seeds end in. If flights of some cells are lost, these are undecided in it."""
    attractors = find_attractors(oscillator, seeds.time, seeds.velocity, pause=pause)
    return with_undecided(attractors) if lost else attractors


def next_catalogue(
    oscillator: Oscillator, attractors: Catalogue, unassigned: Seeds, rounds: int, pause: Pause
) -> Catalogue:
    """Catalogue for another round of naming.

    Parameters
    ----------
    oscillator : Oscillator
    attractors : tuple of Attractor
        Catalogue by which all cells have been named.
    unassigned : Seeds
        Some of the landing points that reached none of it.
    rounds : int
        How often the cells have been named. After the third time what is left is undecided.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    tuple of Attractor
        Longer than before, unless the names of the cells are final.
    """
    if not unassigned.box.size:
        return attractors
    if rounds < _ROUNDS:
        extended = find_attractors(oscillator, unassigned.time, unassigned.velocity, known=attractors, pause=pause)
        if len(extended) > len(attractors):
            return extended
    return with_undecided(attractors)


def name_landings(
    oscillator: Oscillator,
    attractors: Catalogue,
    images: CellImages,
    pause: Pause,
    name: Callable[..., np.ndarray] = name_solutions,
) -> tuple[np.ndarray, Seeds]:
    """Solution of each cell, and some of the landing points that reached no attractor.

    Parameters
    ----------
    oscillator : Oscillator
    attractors : tuple of Attractor
        Catalogue, permanent contact first.
    images : CellImages
    pause : callable
        Called several times a second; an exception raised there ends the work.
    name : callable
        As `name_solutions`.

    Returns
    -------
    solution : ndarray of int16, shape of the images
        Index into the catalogue; -1 where a cell is undecided and the catalogue does not say so.
    unassigned : Seeds
    """
    image, t, v = images.image_cell, images.landing_time, images.landing_velocity
    solution = np.full(image.shape, UNASSIGNED, np.int16)
    solution[image == PERMANENT_CONTACT] = 0
    landed = image >= SINK
    solution[landed] = name(oscillator, attractors, t[landed], v[landed], pause)
    unassigned = (solution == UNASSIGNED) & landed
    kinds = [attractor.kind for attractor in attractors]
    if AttractorKind.UNDECIDED in kinds:
        solution[solution == UNASSIGNED] = kinds.index(AttractorKind.UNDECIDED)
    return solution, choose_seeds(oscillator, t[unassigned], v[unassigned])
