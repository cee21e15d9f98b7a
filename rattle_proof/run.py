"""A proof in progress: it takes the receipts of its tasks and returns the tasks that come next.

    targets -> (follow parts of the boxes -> grow) of each level -> tiles

It begins when all tiles have their solutions. A level that is whole in the store is not done again.
"""

import time
from collections import defaultdict, deque
from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np

from rattle_kernels import Attractor
from rattle_proof.arrays import BOXES_A_PART, proof_of
from rattle_proof.certificate import certificate_of, most_impacts
from rattle_proof.enclosures.machine import parts_of
from rattle_proof.enclosures.targets import Certificate, quiet_end
from rattle_proof.layout import Unproven
from rattle_proof.request import LEVELS, asked_of, machine_asked_of
from rattle_proof.tasks import (
    GrowthReceipt,
    ProofReceipt,
    find_targets,
    follow_part,
    grow_lattice,
    prove_tile,
)
from worker.cluster.calls import Task
from worker.progress import Progress, Stage
from worker.storage.folder import synced_together
from worker.stores.basin_store import BasinStore
from worker.stores.provenance import versions

_ENCLOSING, _PROVING = Stage("enclosing"), Stage("proving")
# Sixty-fourths of a cell.
_WHOLE = 64


class ProofRun:
    """The tasks of a proof.

    Parameters
    ----------
    store : BasinStore
        With all solutions.
    attractors : tuple of Attractor
        By the numbers of the solutions.

    Attributes
    ----------
    seconds : dict of str to float
        Time spent in kernels.
    """

    def __init__(self, store: BasinStore, attractors: tuple[Attractor, ...]) -> None:
        self.address, self.within = (store.location, store.digest), partial(synced_together, store.location)
        self._store, self._proof, self._attractors = store, proof_of(store), attractors
        self.seconds: dict[str, float] = defaultdict(float)
        self._ready: deque[Task] = deque()
        self._stage, self._done, self._total, self._begun = _ENCLOSING, 0, 1, time.monotonic()
        self._boxes = self._proven_boxes = self._rounds = self._quiet_rounds = 0
        self._reasons = np.zeros(len(Unproven), np.int64)
        self._sixty_fourths, self._never_quiet = np.zeros(len(attractors), np.int64), 0
        self._proof.make_room()
        level = self._proof.levels_grown
        self._ready.extend(self._from(level) if level >= 0 else [Task(find_targets, 0, (attractors,), self._found)])

    def next_task(self) -> Task | None:
        """The next task; None if there is none yet."""
        return self._ready.popleft() if self._ready else None

    def take(self, task: Task, receipt: Any) -> None:
        """Take the receipt of a task, and queue the tasks that it makes possible."""
        self._done += 1
        self._ready.extend(task.then(task.number, receipt))

    def _found(self, _: int, proven: Certificate) -> Iterable[Task]:
        job = self._store.job
        machine, asked = machine_asked_of(job), asked_of(job)
        assert asked is not None
        certificate = certificate_of(machine, self._attractors, proven, asked.levels, LEVELS - 1)
        core = np.tile(proven.targets.lattice.ends, (len(parts_of(machine)), 1))
        self._proof.begin(certificate, proven.targets, core)
        return self._from(0)

    def _from(self, level: int) -> list[Task]:
        """Tasks once the lattice has grown at so many levels."""
        last = level + 1 == LEVELS
        ends, rounds = self._proof.read_lattice(level, level == LEVELS)
        self._boxes, self._proven_boxes, self._rounds = ends.size, int(np.count_nonzero(ends)), int(rounds.max())
        if level == LEVELS:
            self._quiet_rounds = int(rounds.max(where=ends == quiet_end(self._attractors), initial=0))
            tiles = self._store.tiling.numbers_of(0)
            self._enter(_PROVING, len(tiles))
            return [Task(prove_tile, tile, (), self._proven) for tile in tiles]
        cut = 2 if level else 1
        boxes = cut * cut * (self._boxes - self._proven_boxes)
        self._proof.create_lattice(level + 1, last, (cut * ends.shape[0], cut * ends.shape[1]))
        parts = -(-boxes // BOXES_A_PART)
        self._enter(_ENCLOSING, parts + 1)
        # Also where none is left: what was found at the level before would be taken for what is found at this one.
        self._proof.create_trails(boxes)
        if not parts:
            return [Task(grow_lattice, level, (), self._grown)]
        return [Task(follow_part, part, (level,), self._part_followed) for part in range(parts)]

    def _enter(self, stage: Stage, tasks: int) -> None:
        self._stage, self._done, self._total, self._begun = stage, 0, tasks, time.monotonic()

    def _part_followed(self, _: int, seconds: float) -> Iterable[Task]:
        self.seconds["follow_kernels"] += seconds
        if self._done < self._total - 1:
            return ()
        return [Task(grow_lattice, self._proof.levels_grown, (), self._grown)]

    def _grown(self, level: int, receipt: GrowthReceipt) -> Iterable[Task]:
        self.seconds["grow_kernels"] += receipt.seconds
        self._proof.level_has_grown(level + 1)
        return self._from(level + 1)

    def _proven(self, _: int, receipt: ProofReceipt) -> Iterable[Task]:
        self.seconds["prove_kernels"] += receipt.seconds
        self._reasons += receipt.reasons
        self._sixty_fourths[: len(receipt.proven)] += receipt.proven
        self._never_quiet += receipt.never_quiet
        return ()

    def leave(self) -> None:
        """Write nothing: each level is written when it has grown."""

    def finish(self) -> None:
        """Write the whole certificate."""
        cells = self._store.job.grid.cells
        certificate = self._proof.certificate
        assert certificate is not None
        certificate["counts"] = {
            "cells": cells,
            "whole": int(self._reasons[Unproven.PROVEN]),
            "reasons": self._reasons.tolist(),
            "boxes": self._boxes,
            "proven_boxes": self._proven_boxes,
            "rounds": self._rounds,
        }
        if certificate["quiet"] is not None:
            certificate["quiet"]["within"] = most_impacts(certificate["impacts"], self._quiet_rounds)
        certificate["shares"] = (self._sixty_fourths / (_WHOLE * cells)).tolist()
        certificate["never_quiet"] = self._never_quiet / (_WHOLE * cells)
        certificate["versions"] = versions()
        self._proof.end(certificate)

    def progress(self, stage: Stage | None = None) -> Progress:
        """Progress of the level, or of the tiles."""
        elapsed = time.monotonic() - self._begun
        left = elapsed / self._done * (self._total - self._done) if self._done else None
        cells = self._store.job.grid.cells if self._stage is _PROVING else 0
        done = round(cells * self._done / self._total)
        pace = done / elapsed if elapsed > 0.0 else 0.0
        return Progress(stage or self._stage, self._done, self._total, done, cells, pace, left, 0, 1)
