"""Quick labels of the cells of a preview: what some thousand impacts show, for a picture at once.

A job follows a whole ensemble beside each motion that does not settle, and carries slow motions through their
transients. That can take a hundred times as long as all cells of a preview. Here a motion that has not settled is
called chaotic if tangent vectors grow along it, and undecided if they do not. It may settle later.
"""

import math
from functools import partial

import numpy as np

from rattle_kernels.attractors.attractor import (
    PERMANENT_CONTACT_ATTRACTOR,
    UNDECIDED_ATTRACTOR,
    Attractor,
    AttractorKind,
)
from rattle_kernels.attractors.classify import UNASSIGNED
from rattle_kernels.attractors.neighbourhoods import locate, neighbourhoods
from rattle_kernels.attractors.seeds import Seeds, choose_seeds, gather_seeds
from rattle_kernels.attractors.settled_orbit import attractor_of, settled_orbit
from rattle_kernels.basins.naming import Catalogue, name_landings
from rattle_kernels.cell_mapping.cell_map import CellImages
from rattle_kernels.lanes.arrival import follow
from rattle_kernels.lanes.lyapunov import tangent_growth
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.numerics.phase import wrap_all

FEW_SEEDS = 24
"""A job follows thousands of seeds for thousands of impacts each, which takes longer than all cells of a preview.
Attractors that these seeds miss show up as unassigned landing points."""
_SETTLING = 4096
# Motions settle in a time like 1/damping. Chaos never does, and most cells lie in its basin where there is any.
_NAMING, _NAMING_BESIDE_CHAOS, _MOST_NAMING = 60.0, 20.0, 600
_GROWING = 512
# Regular motions separate too: by at most this factor times the impacts.
_REGULAR_GROWTH = 6.0

_CHAOS = UNDECIDED_ATTRACTOR._replace(kind=AttractorKind.CHAOTIC)


def quick_labels(
    oscillator: Oscillator, images: CellImages, known: Catalogue, pause: Pause
) -> tuple[np.ndarray, Catalogue]:
    """Name each cell by the orbit that it settles on within some thousand impacts, if there is one.

    Parameters
    ----------
    oscillator : Oscillator
    images : CellImages
    known : tuple of Attractor
        A catalogue of this oscillator; empty if there is none yet.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    solution : ndarray of int16, shape of the images
        Index into the catalogue.
    attractors : tuple of Attractor
        Chaos is without points if it was not in the catalogue before.
    """
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
    return tangent_growth(oscillator, t, v, _GROWING).growth - math.log(_REGULAR_GROWTH * _GROWING)


def _few(seeds: Seeds) -> Seeds:
    return gather_seeds([seeds], FEW_SEEDS)


def _mostly_grow(oscillator: Oscillator, seeds: Seeds) -> bool:
    growths = _growths(oscillator, seeds.time, seeds.velocity)
    return (growths > 0.0).sum() > (growths <= 0.0).sum()
