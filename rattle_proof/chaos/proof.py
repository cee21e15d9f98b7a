"""The proof for one machine: a set around its chaos, leaves across it, what crosses what, and cycles."""

import itertools
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.numerics.pausing import Pause
from rattle_proof.chaos.crossings import crossings, following
from rattle_proof.chaos.cycles import Cycles, repelling_cycles
from rattle_proof.chaos.entropy import Growth, growth_of
from rattle_proof.chaos.leaf_search import leaves_across, numbers_of
from rattle_proof.chaos.leaves import Leaves, NotSeparated, places_of
from rattle_proof.enclosures.lattice import Lattice
from rattle_proof.enclosures.machine import Machine, centre_of
from rattle_proof.enclosures.rattling_set import Search, closed_set

_MOST_COLUMNS = 8192
# Impacts after which strips are looked at, and windows that are tried.
_IMPACTS, _WINDOWS = 8, 8


class Chaos(NamedTuple):
    """A set that P maps into itself, the best leaves across it with the growth that they show, and its cycles.

    Without ``growth`` and ``leaves`` no window showed any.
    """

    lattice: Lattice
    leaves: Leaves | None
    growth: Growth | None
    cycles: Cycles


def chaos_of(
    machine: Machine, attractor: Attractor, columns: int, count: int, impacts: int, pause: Pause
) -> Chaos | None:
    """Prove of a chaotic motion what can be.

    Parameters
    ----------
    machine : Machine
    attractor : Attractor
        Of the machine in its middle.
    columns : int
        Of the first lattice that is tried.
    count : int
        Leaves that are tried in a window.
    impacts : int
        Of the longest cycles that are looked for; 0 for none.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Chaos or None
        None if no set was found.
    """
    oscillator = centre_of(machine)
    search = Search(machine, oscillator, 0.0, _MOST_COLUMNS, pause, columns)
    lattice = closed_set(search, attractor.time, attractor.velocity, 1)
    if lattice is None:
        return None
    rows, places = np.nonzero(lattice.ends)
    scale = np.ptp(rows) * lattice.height * lattice.ends.shape[1] / np.ptp(places)
    best: tuple[Leaves, Growth] | None = None
    for leaves in itertools.islice(leaves_across(lattice, numbers_of(oscillator, scale), count), _WINDOWS):
        pause()
        try:
            sides = places_of(leaves, lattice)
        except NotSeparated:
            continue
        growth = growth_of(crossings(leaves, lattice, sides, following(machine, oscillator), _IMPACTS))
        if growth is not None and (best is None or growth.numerator > best[1].numerator):
            best = leaves, growth
    cycles = repelling_cycles(machine, oscillator, lattice, impacts, pause)
    found, shown = best or (None, None)
    return Chaos(lattice, found, shown, cycles)
