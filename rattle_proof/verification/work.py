"""One after the other or by several processes: each reads the store itself."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np
from flint import ctx

from rattle_proof.stored_proof import StoredProof, read_proof
from rattle_proof.verification.claims import Claims, claims_of
from rattle_proof.verification.ends import Ends
from rattle_proof.verification.samples import (
    Plane,
    try_box,
    try_box_that_rattles,
    try_cell,
    try_cell_that_rattles,
    try_rattling_box,
)
from rattle_proof.verification.targets.quiet import acceleration_at_rest, try_column
from rattle_proof.verification.verdict import Failure
from worker.errors import StoreConflict

BITS = 64
"""Bits of a ball's middle."""
_AT_A_TIME = 50

Place = tuple[int, int]


class Subject(NamedTuple):
    """What is verified."""

    proof: StoredProof
    claims: Claims
    ends: Ends
    ends_of_parts: tuple[Ends, ...]
    plane: Plane

    def try_one(self, what: str, place: Place) -> Failure | None:
        """Prove one thing again."""
        if what == "core" and self.claims.core is not None:
            return try_column(self.claims.parts[place[0]], self.claims.core, place[1])
        if what == "rattling" and self.claims.rattling is not None:
            return try_rattling_box(self.claims, self.claims.rattling, *place)
        if what in ("boxes", "rattling boxes"):
            part, row = divmod(place[0], self.claims.lattice.ends.shape[0])
            tried = try_box if what == "boxes" else try_box_that_rattles
            return tried(self.ends_of_parts[part], int(self.proof.certificate["impacts"]["trail"]), row, place[1])
        if what == "rattling cells":
            return try_cell_that_rattles(self.ends, self.plane, *place)
        return try_cell(self.ends, self.plane, *place)


def subject_at(location: str) -> Subject:
    """Read what is to be verified.

    Raises
    ------
    StoreConflict
        If there is no proof, or none that can be read.
    """
    ctx.prec = BITS
    proof = read_proof(location)
    try:
        claims = claims_of(proof.certificate, proof.arrays)
    except (KeyError, TypeError, ValueError) as error:
        raise StoreConflict(f"{location} has a certificate that cannot be read: {error!r}") from error
    for machine in (claims.machine, *claims.parts):
        acceleration_at_rest(machine)
    grid = proof.job.grid
    plane = Plane(
        (grid.time_start, grid.time_stop), (grid.velocity_start, grid.velocity_stop), proof.solution, proof.proven,
        proof.never_quiet,
    )  # fmt: skip
    ends_of_parts = tuple(Ends(claims.of_part(n)) for n in range(len(claims.parts)))
    return Subject(proof, claims, Ends(claims), ends_of_parts, plane)


_subject: Subject | None = None


def _begin(location: str) -> None:
    global _subject
    _subject = subject_at(location)


def _try(subject: Subject, what: str, places: Sequence[Place]) -> list[Failure]:
    found = (subject.try_one(what, place) for place in places)
    return [failure for failure in found if failure is not None]


def _try_here(what: str, places: Sequence[Place]) -> list[Failure]:
    assert _subject is not None
    return _try(_subject, what, places)


class Crew:
    """Those who work.

    Parameters
    ----------
    subject : Subject
    location : str
        Where processes read the same.
    processes : int
        1: everything is done here.
    """

    def __init__(self, subject: Subject, location: str, processes: int) -> None:
        self.subject = subject
        self.pool = None
        if processes > 1:
            self.pool = ProcessPoolExecutor(processes, get_context("spawn"), initializer=_begin, initargs=(location,))

    def __enter__(self) -> "Crew":
        return self

    def __exit__(self, *error: object) -> None:
        if self.pool is not None:
            self.pool.shutdown(cancel_futures=True)

    def try_all(
        self, what: str, places: np.ndarray, tick: Callable[[int, int], None]
    ) -> Iterator[tuple[int, list[Failure]]]:
        """How many were tried, and which failed, again and again."""
        each = [tuple(place) for place in places.tolist()]
        parts = [each[i : i + _AT_A_TIME] for i in range(0, len(each), _AT_A_TIME)]
        done = 0
        for tried, failures in self._tried(what, parts):
            done += tried
            tick(done, len(each))
            yield tried, failures

    def _tried(self, what: str, parts: list[list[Place]]) -> Iterator[tuple[int, list[Failure]]]:
        if self.pool is None:
            for part in parts:
                yield len(part), _try(self.subject, what, part)
            return
        running = {self.pool.submit(_try_here, what, part): len(part) for part in parts}
        for future in as_completed(running):
            yield running[future], future.result()
