"""Solutions of cells, from the images of the cells and a catalogue of attractors."""

from collections.abc import Callable

import numpy as np

from rattle_kernels import PERMANENT_CONTACT, SINK, Attractor, AttractorKind, CellImages, Oscillator, name_solutions
from rattle_kernels.attractors.attractor import UNDECIDED_ATTRACTOR
from rattle_kernels.attractors.classify import UNASSIGNED
from rattle_kernels.attractors.seeds import Seeds, choose_seeds

CATALOGUE_ROUNDS = 3
"""After this many rounds, landing points that reach no attractor of the catalogue are called undecided."""


def name_landings(
    oscillator: Oscillator,
    attractors: tuple[Attractor, ...],
    images: CellImages,
    pause: Callable[[], None],
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
        As `rattle_kernels.name_solutions`.

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


def with_undecided(attractors: tuple[Attractor, ...]) -> tuple[Attractor, ...]:
    """Catalogue that holds undecided cells as its last solution."""
    known = any(attractor.kind == AttractorKind.UNDECIDED for attractor in attractors)
    return attractors if known else (*attractors, UNDECIDED_ATTRACTOR)
