"""Where motions are proven to end: the quiet core, discs and windows around orbits, a set that rattles for ever."""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_proof.enclosures.interval import down, up
from rattle_proof.enclosures.lattice import UNPROVEN, Lattice, box_at, empty_lattice, end_of
from rattle_proof.enclosures.machine import Machine, acceleration, error_at
from rattle_proof.enclosures.orbit_disc import OrbitDisc, disc_rows, lies_in_disc, orbit_disc
from rattle_proof.enclosures.quiet_core import quiet_level
from rattle_proof.enclosures.rattling_set import Search, rattling_set, wandering
from rattle_proof.enclosures.windows import Windows, end_in_windows, grown_windows

COLUMNS = 1024
"""Columns of the first lattice."""
# How many times as many a set that rattles for ever may have, and windows have more than.
_FINER, _FINER_THAN = 32, 4

NO_QUIET = 2**16 - 1
"""End of no motion: none was found to fall quiet."""
RATTLES = 2**16 - 2
"""End of what rattles for ever, in whichever motions."""
NOTHING_KNOWN = Lattice(1.0, 0, np.zeros((1, 1), np.uint16))
"""A lattice without boxes."""


class Targets(NamedTuple):
    """Proven places. An *end* is 1 + the number of a motion, UNPROVEN where there is none.

    ``rattling`` carries the end of the chaotic motion that its boxes hold alone, or RATTLES. ``discs``, shape
    (discs, 8), is as `disc_rows` has it, and ``windows`` lie around them. ``quiet`` is the end of what falls quiet, and
    ``never_quiet`` has 1 in boxes of which nothing does, once the lattice has grown.
    """

    lattice: Lattice
    rattling: Lattice
    discs: np.ndarray
    windows: Windows
    quiet: int
    never_quiet: Lattice


class Certificate(NamedTuple):
    """What was proven of an oscillator's motions.

    ``level``: departures ``v^3 < level a(t)`` fall quiet. ``discs``: around orbits, by the number of the motion.
    ``rattling``: number of the chaotic motion that the set which is never left holds alone; None if it holds others, or
    there is none.
    """

    level: float
    discs: dict[int, OrbitDisc]
    rattling: int | None
    targets: Targets


@inlined_as_written
def proven_end(targets, moving, strip):
    """Where all departures of a set, held by a strip too, are proven to end, UNPROVEN where nothing is."""
    end = end_of(targets.lattice, strip)
    if end != UNPROVEN:
        return end
    end = end_of(targets.rattling, strip)
    if end != UNPROVEN and end != RATTLES:
        return end
    for i in range(targets.discs.shape[0]):
        if lies_in_disc(targets.discs[i], moving):
            return int(targets.discs[i, 0])
    return end_in_windows(targets.windows, strip)


@inlined_as_written
def rattles(targets, strip):
    """Whether no departure of a strip is known to fall quiet, be it that nothing is known of its end."""
    return end_of(targets.rattling, strip) != UNPROVEN or end_of(targets.never_quiet, strip) != UNPROVEN


@kernel_as_written
def _fill_core(machine, level, lattice, end):
    rows, columns = lattice.ends.shape
    for j in range(columns):
        felt = acceleration(machine, error_at(machine, box_at(lattice, 0, j).t)).low
        most = down(level * felt)
        for i in range(rows):
            high = box_at(lattice, i, j).w.high
            if not up(up(high * high) * high) < most:
                break
            lattice.ends[i, j] = end


def prove_targets(
    machine: Machine,
    oscillator: Oscillator,
    attractors: Sequence[Attractor],
    pause: Pause = never_stopped,
    fastest: float = 0.0,
    columns: int = COLUMNS,
) -> Certificate:
    """Prove where the motions of a catalogue end, as far as that succeeds.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them, whose catalogue it is.
    attractors : sequence of Attractor
        Where each stands is its number.
    pause : callable
        Called now and then; an exception raised there ends the work.
    fastest : float
        Speed up to which the lattice reaches at least.
    columns : int
        Of the lattice: a power of two.

    Returns
    -------
    Certificate
        Its lattice holds the quiet core; `growth` lets it grow.
    """
    lattice, top = _lattice_for(oscillator, attractors, fastest, columns)
    level = quiet_level(machine, top, pause=pause)
    quiet = quiet_end(attractors)
    if quiet != NO_QUIET:
        _fill_core(machine, level, lattice, quiet)
    discs = {}
    for n, each in enumerate(attractors):
        disc = orbit_disc(machine, oscillator, each, pause) if each.kind == AttractorKind.PERIODIC else None
        if disc is not None:
            discs[n] = disc
    windows = grown_windows(machine, oscillator, discs, attractors, _FINER_THAN * columns, pause)
    rattling, chaos = NOTHING_KNOWN, None
    search = Search(machine, oscillator, _edge_of_core(machine, level), _FINER * columns, pause)
    for n, each in enumerate(attractors):
        found = rattling_set(search, each.time, each.velocity, 1 + n) if each.is_chaotic and chaos is None else None
        others = [other for other in attractors if other is not each]
        if found is not None and _holds_no_other(machine, found, level, discs.values(), others):
            rattling, chaos = found, n
    if chaos is None:
        rattling = _what_rattles(search, level, top)
    targets = Targets(lattice, rattling, disc_rows(discs), windows, quiet, NOTHING_KNOWN)
    return Certificate(level, discs, chaos, targets)


def _edge_of_core(machine: Machine, level: float) -> float:
    """The fastest that a departure of the quiet core may be."""
    return math.cbrt(level * machine.greatest_acceleration)


def _what_rattles(search: Search, level: float, top: float) -> Lattice:
    """A set that rattles for ever around trajectories that do so for long, whichever motions they come to."""
    for t, v in wandering(search.oscillator, top):
        search.pause()
        found = rattling_set(search, t, v, RATTLES)
        if found is not None and _lies_above_core(search.machine, found, level):
            return found
    return NOTHING_KNOWN


def _lies_above_core(machine: Machine, rattling: Lattice, level: float) -> bool:
    rows, _ = np.nonzero(rattling.ends)
    if rows.size == 0:
        return False
    lowest = (rattling.first + rows.min()) * rattling.height
    return bool(down(down(lowest * lowest) * lowest) > up(level * machine.greatest_acceleration))


def quiet_end(attractors: Sequence[Attractor]) -> int:
    """End of the motion that falls quiet, NO_QUIET where there is none."""
    ends = [1 + n for n, each in enumerate(attractors) if each.kind == AttractorKind.PERMANENT_CONTACT]
    return ends[0] if ends else NO_QUIET


def _lattice_for(
    oscillator: Oscillator, attractors: Sequence[Attractor], fastest: float, columns: int
) -> tuple[Lattice, float]:
    speeds = [float(each.velocity.max()) for each in attractors if each.velocity.size]
    usual = 1.05 * max([largest_grazing_speed(oscillator), *speeds])
    top = max(usual, fastest)
    return empty_lattice(0.0, top, columns, 2.0 ** math.floor(math.log2(usual / columns))), top


def _holds_no_other(
    machine: Machine, rattling: Lattice, level: float, discs: Iterable[OrbitDisc], others: Iterable[Attractor]
) -> bool:
    """Whether a set that rattles for ever lies above the quiet core, clear of all discs and of all other motions.

    A motion of the set that fell quiet would enter the core; one that came to an orbit would enter its disc. A motion
    without a disc is known by numbers only: were it inside, its departures would be said to end otherwise.
    """
    if not _lies_above_core(machine, rattling, level):
        return False
    rows, columns = np.nonzero(rattling.ends)
    for disc in discs:
        near_t, near_v = disc.half_sides
        distance = np.abs((columns + 0.5) / rattling.ends.shape[1] - disc.t)
        apart_t = np.minimum(distance, 1.0 - distance) - 1.0 / rattling.ends.shape[1] > near_t
        apart_v = np.abs((rattling.first + rows + 0.5) * rattling.height - disc.v) - rattling.height > near_v
        if not (apart_t | apart_v).all():
            return False
    return not any(_visits(each, rattling) for each in others)


def _visits(attractor: Attractor, lattice: Lattice) -> bool:
    """Whether a motion has a departure in a box of a set."""
    rows = np.floor(attractor.velocity / lattice.height).astype(np.int64) - lattice.first
    columns = np.floor(attractor.time * lattice.ends.shape[1]).astype(np.int64) % lattice.ends.shape[1]
    inside = (rows >= 0) & (rows < lattice.ends.shape[0])
    return bool(lattice.ends[rows[inside], columns[inside]].any())
