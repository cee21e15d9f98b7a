"""What a certificate claims, as written in a store; numbers are taken as the doubles that they are."""

from typing import Any, NamedTuple

import numpy as np

from rattle_proof.verification.machine import Machine

RATTLES = 2**16 - 2
"""End of what rattles for ever, in whichever motions."""


class Disc(NamedTuple):
    """Departures x with ``|frame (x - (t, v))| < radius``: all end in the orbit that returns after `impacts`."""

    motion: int
    impacts: int
    t: float
    v: float
    frame: tuple[tuple[float, float], tuple[float, float]]
    radius: float


class Core(NamedTuple):
    """Departures ``v^3 < level a(t)``: all fall quiet."""

    motion: int
    level: float


class Lattice(NamedTuple):
    """Boxes ``[left + j, left + j + 1]/columns`` by ``[first + i, first + i + 1] height``.

    Those of a window are some of the period's columns. ``ends`` carries 1 + the number of a motion, 0 where nothing is
    claimed, RATTLES where all that is claimed is that none of it falls quiet. ``rounds`` tells in which round, or which
    number a box of a window has in the order of their proofs.
    """

    height: float
    first: int
    columns: int
    left: int
    ends: np.ndarray
    rounds: np.ndarray


class Claims(NamedTuple):
    """All of it. ``motions`` are the names of the store's solutions, by number.

    ``parts`` are machines that together are the one, or the one alone. ``lattice`` says in which end boxes come for all
    of them, and ``never_quiet`` of which of its boxes nothing falls quiet; ``lattices`` and ``never_quiets`` say it for
    each part.
    """

    machine: Machine
    parts: tuple[Machine, ...]
    motions: tuple[str, ...]
    core: Core | None
    discs: tuple[Disc, ...]
    windows: tuple[Lattice, ...]
    rattling: Lattice | None
    lattice: Lattice
    lattices: tuple[Lattice, ...]
    never_quiet: Lattice
    never_quiets: tuple[Lattice, ...]

    @property
    def quiet(self) -> int | None:
        """The end of what falls quiet, if anything does."""
        return None if self.core is None else 1 + self.core.motion

    def of_part(self, n: int) -> "Claims":
        """What is claimed of one part."""
        return self._replace(machine=self.parts[n], lattice=self.lattices[n], never_quiet=self.never_quiets[n])


def claims_of(certificate: dict[str, Any], arrays: dict[str, np.ndarray]) -> Claims:
    """Read a certificate and arrays: ``ends``, ``rounds`` and, where there are, those of sets and windows.

    The lattices of parts stand above each other in their arrays.

    Raises
    ------
    KeyError, TypeError, ValueError
        If it is not such a certificate.
    """
    quiet, chaos, grid = certificate["quiet"], certificate["rattling"], certificate["lattice"]
    rattling = None
    if chaos is not None:
        end = RATTLES if chaos["motion"] is None else 1 + int(chaos["motion"])
        held = np.where(arrays["rattling"] > 0, end, 0).astype(np.uint16)
        place = float(chaos["height"]), int(chaos["first"]), held.shape[1], 0
        rattling = Lattice(*place, held, np.zeros_like(held))
    parts = tuple(Machine.of(each) for each in certificate.get("parts") or [certificate["machine"]])
    place = float(grid["height"]), int(grid["first"]), arrays["ends"].shape[1], 0
    ends, rounds = (np.split(arrays[name], len(parts)) for name in ("ends", "rounds"))
    never_quiet = np.split(arrays.get("never_quiet", np.zeros_like(arrays["ends"])), len(parts))
    same = np.logical_and.reduce([each == ends[0] for each in ends])
    return Claims(
        Machine.of(certificate["machine"]),
        parts,
        tuple(certificate["motions"]),
        None if quiet is None else Core(int(quiet["motion"]), float(quiet["level"])),
        tuple(_disc(each) for each in certificate["discs"]),
        tuple(
            _window(each, arrays["window_ends"][n], arrays["window_order"][n])
            for n, each in enumerate(certificate.get("windows", []))
        ),
        rattling,
        Lattice(*place, np.where(same, ends[0], 0), np.maximum.reduce(rounds)),
        tuple(Lattice(*place, *each) for each in zip(ends, rounds, strict=True)),
        Lattice(*place, np.minimum.reduce(never_quiet), np.zeros_like(rounds[0])),
        tuple(Lattice(*place, *each) for each in zip(never_quiet, rounds, strict=True)),
    )


def _window(told: dict[str, Any], ends: np.ndarray, order: np.ndarray) -> Lattice:
    return Lattice(float(told["height"]), int(told["first"]), int(told["columns"]), int(told["left"]), ends, order)


def _disc(told: dict[str, Any]) -> Disc:
    (a, b), (c, d) = told["frame"]
    frame = (float(a), float(b)), (float(c), float(d))
    return Disc(
        int(told["motion"]), int(told["impacts"]), float(told["t"]), float(told["v"]), frame, float(told["radius"])
    )
