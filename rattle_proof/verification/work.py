"""One after the other or by several processes: each reads the store itself."""

import os
import signal
from collections.abc import Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from itertools import islice
from multiprocessing import get_context
from multiprocessing.connection import Connection
from threading import Thread
from types import TracebackType
from typing import NamedTuple

import numpy as np
from flint import ctx

from rattle_proof.stored_proof import StoredProof, read_proof
from rattle_proof.verification.claims import Claims, claims_of
from rattle_proof.verification.ends import Ends
from rattle_proof.verification.samples import (
    Plane,
    try_box,
    try_box_of_window,
    try_box_that_rattles,
    try_cell,
    try_cell_that_rattles,
    try_rattling_box,
)
from rattle_proof.verification.targets.discs import try_disc
from rattle_proof.verification.targets.quiet import acceleration_at_rest, try_column
from rattle_proof.verification.verdict import Failure
from worker.errors import StoreConflict

BITS = 64
"""Bits of a ball's middle."""
# Batches that wait, for each process.
_AHEAD = 4

Place = tuple[int, ...]


class Subject(NamedTuple):
    """What is verified."""

    proof: StoredProof
    claims: Claims
    ends: Ends
    ends_of_parts: tuple[Ends, ...]
    plane: Plane

    def try_one(self, what: str, place: Place) -> Failure | None:
        """Prove one thing again."""
        if what == "discs":
            return try_disc(self.claims, place[0])
        if what == "windows":
            return try_box_of_window(self.ends, int(self.proof.certificate["impacts"]["window"]), *place)
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


def _begin(location: str, leash: Connection) -> None:
    global _subject
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with, args=(leash,), daemon=True).start()
    _subject = subject_at(location)


def _end_with(leash: Connection) -> None:
    """End as soon as the other end of a pipe is closed, if only by the death of who holds it."""
    leash.poll(None)
    os._exit(1)


def _try(subject: Subject, what: str, batch: np.ndarray) -> list[Failure]:
    found = (subject.try_one(what, tuple(place)) for place in batch.tolist())
    return [failure for failure in found if failure is not None]


def _try_here(what: str, batch: np.ndarray) -> list[Failure]:
    assert _subject is not None
    return _try(_subject, what, batch)


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
        self.subject, self.processes = subject, processes
        self.pool = None
        if processes > 1:
            context = get_context("spawn")
            leash, self.holder = context.Pipe(duplex=False)
            self.pool = ProcessPoolExecutor(processes, context, initializer=_begin, initargs=(location, leash))

    def __enter__(self) -> "Crew":
        return self

    def __exit__(
        self, error: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.pool is None:
            return
        if error is not None:
            # What they are at is not waited for.
            self.holder.close()
        self.pool.shutdown(cancel_futures=True)
        self.holder.close()

    def try_all(self, what: str, batches: Mapping[int, np.ndarray]) -> Iterator[tuple[int, list[Failure]]]:
        """The number of each batch, and what failed in it, as they are done."""
        if self.pool is None:
            for number, batch in batches.items():
                yield number, _try(self.subject, what, batch)
            return
        waiting, running = iter(batches.items()), dict[Future[list[Failure]], int]()
        while True:
            for number, batch in islice(waiting, _AHEAD * self.processes - len(running)):
                running[self.pool.submit(_try_here, what, batch)] = number
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                yield running.pop(future), future.result()
