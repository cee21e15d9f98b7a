"""The functions that workers run to prove a basin. Each takes a store and a part of it, and may safely be run again.

    targets -> follow parts of the boxes -> grow -> ... four levels ... -> prove tiles

What a level needs of the one before lies in the store.
"""

import time
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rattle_kernels import Attractor
from rattle_proof.arrays import BOXES_A_PART, proof_of
from rattle_proof.certificate import places_of, targets_of
from rattle_proof.enclosures.cells import prove_cells
from rattle_proof.enclosures.growth import empty_trails, follow_all, grow_all, never_quiet
from rattle_proof.enclosures.lattice import UNPROVEN, common_ends, refined
from rattle_proof.enclosures.machine import Machine, centre_of, parts_of
from rattle_proof.enclosures.targets import RATTLES, Certificate, Targets, prove_targets
from rattle_proof.layout import NEVER_QUIET, PROVEN, UNPROVEN_REASON, Unproven
from rattle_proof.request import LEVELS, asked_of, first_columns, machine_asked_of
from worker.cluster.calls import stop_if_cancelled
from worker.stores.basin_store import BasinStore


@dataclass(frozen=True)
class GrowthReceipt:
    """Boxes of the lattice after a level: all, those proven, and in how many rounds."""

    boxes: int
    proven: int
    rounds: int
    seconds: float


@dataclass(frozen=True)
class ProofReceipt:
    """What is proven of a tile: sixty-fourths of cells by solution, those that never fall quiet, cells by reason."""

    proven: np.ndarray
    never_quiet: int
    reasons: np.ndarray
    seconds: float


class _Known(NamedTuple):
    """What following needs: the machine, its parts, and targets at a level.

    Until the lattices have grown, that of the targets has those of all parts above each other.
    """

    machine: Machine
    parts: list[Machine]
    targets: Targets
    rounds: np.ndarray
    boxes: np.ndarray


def find_targets(location: str, digest: str, number: int, attractors: tuple[Attractor, ...]) -> Certificate:
    """Prove targets: the quiet core, discs around orbits, a set that rattles for ever."""
    job = BasinStore.open(location, digest).job
    machine = machine_asked_of(job)
    fastest, columns = job.grid.velocity_stop, first_columns(job.grid, len(parts_of(machine)))
    return prove_targets(machine, job.oscillator, attractors, stop_if_cancelled, fastest, columns)


@lru_cache(maxsize=1)
def _known(location: str, digest: str, level: int) -> _Known:
    """What is known once the lattice has grown at so many levels; its boxes are cut, if they are to be followed again.

    Kept once a process: the last lattice has 350 MB, and serves all tiles.
    """
    store = BasinStore.open(location, digest)
    ends, rounds = proof_of(store).read_lattice(level, level == LEVELS)
    stop_if_cancelled()
    certificate = proof_of(store).certificate
    assert certificate is not None
    machine = machine_asked_of(store.job)
    parts = parts_of(machine)
    rattling = np.zeros((1, 1), np.uint16)
    if level == LEVELS:
        ends = common_ends(ends, len(parts))
        stop_if_cancelled()
        rattling = common_ends(proof_of(store).read_never_quiet().astype(np.uint16), len(parts))
    # Each of these takes tenths of a second of a large lattice.
    stop_if_cancelled()
    proof = proof_of(store)
    windows = proof.read_windows(places_of(certificate))
    targets = targets_of(certificate, ends, proof.read_rattling(), windows, rattling)
    if 0 < level < LEVELS:
        targets = targets._replace(lattice=refined(targets.lattice))
        stop_if_cancelled()
        rounds = rounds.repeat(2, 0).repeat(2, 1)
    stop_if_cancelled()
    unproven = targets.lattice.ends == UNPROVEN if level < LEVELS else np.zeros((1, 1), np.bool_)
    return _Known(machine, parts, targets, rounds, np.argwhere(unproven).astype(np.int32))


def follow_part(location: str, digest: str, part: int, level: int) -> float:
    """Follow one part of the boxes that are not proven, and write where they come to. Return the seconds it took."""
    store, known = BasinStore.open(location, digest), _known(location, digest, level)
    stop_if_cancelled()
    begin = time.perf_counter()
    boxes = known.boxes[part * BOXES_A_PART : (part + 1) * BOXES_A_PART]
    ends, trails = np.zeros(len(boxes), np.uint16), empty_trails(len(boxes))
    lattice = known.targets.lattice
    rows = lattice.ends.shape[0] // len(known.parts)
    for n, machine in enumerate(known.parts):
        below, above = n * rows, (n + 1) * rows
        here = slice(*np.searchsorted(boxes[:, 0], (below, above)))
        targets = known.targets._replace(lattice=lattice._replace(ends=lattice.ends[below:above]))
        local = boxes[here] - np.array([below, 0], np.int32)
        follow_all(machine, centre_of(machine), targets, local, ends[here], trails[here], stop_if_cancelled)
    seconds = time.perf_counter() - begin
    proof_of(store).write_followed(part, ends, trails)
    return seconds


def grow_lattice(location: str, digest: str, level: int) -> GrowthReceipt:
    """Let the lattice grow from what is found of its boxes, and write it as it is after one more level."""
    store, known = BasinStore.open(location, digest), _known(location, digest, level)
    followed, trails = proof_of(store).read_followed()
    stop_if_cancelled()
    begin = time.perf_counter()
    ends, rounds = known.targets.lattice.ends.copy(), known.rounds.copy()
    rattles = followed == RATTLES
    followed[rattles] = UNPROVEN
    # What comes to a target at once, or to what the lattice knew before, is proven in a round of its own.
    rows, columns = known.boxes[followed != UNPROVEN].T
    ends[rows, columns] = followed[followed != UNPROVEN]
    rounds[rows, columns] = rounds.max() + 1
    grow_all(ends, rounds, known.boxes, trails, stop_if_cancelled, len(known.parts))
    seconds = time.perf_counter() - begin
    stop_if_cancelled()
    last = level + 1 == LEVELS
    proof_of(store).write_lattice(level + 1, last, ends, rounds)
    if last:
        begin = time.perf_counter()
        asked = known.boxes[~rattles], trails[~rattles]
        rattling = never_quiet(ends, known.targets.quiet, *asked, stop_if_cancelled, len(known.parts))
        seconds += time.perf_counter() - begin
        proof_of(store).write_never_quiet(rattling)
    return GrowthReceipt(ends.size, int(np.count_nonzero(ends)), int(rounds.max()), seconds)


def prove_tile(location: str, digest: str, number: int) -> ProofReceipt:
    """Prove the cells of one tile, unless that has been done, and count what is proven."""
    store = BasinStore.open(location, digest)
    tile = store.tiling.tile(number)
    (colours,) = store.tiles.read((store.places.solution,), tile)
    seconds = 0.0
    cells = proof_of(store).read_tile(tile)
    if cells is None:
        begin = time.perf_counter()
        job, known, asked = store.job, _known(location, digest, LEVELS), asked_of(store.job)
        assert asked is not None
        cells = prove_cells(
            known.machine, job.oscillator, known.targets, job.grid, tile.rows, tile.columns, colours,
            asked.levels, stop_if_cancelled,
        )  # fmt: skip
        seconds = time.perf_counter() - begin
        store.tiles.write((PROVEN, NEVER_QUIET, UNPROVEN_REASON), tile, cells)
    by_solution = np.bincount(colours.ravel(), cells.proven.ravel(), minlength=int(colours.max()) + 1)
    reasons = np.bincount(cells.reason.ravel(), minlength=len(Unproven))
    return ProofReceipt(by_solution.astype(np.int64), int(cells.never_quiet.sum(dtype=np.int64)), reasons, seconds)
