"""The proof in the store of a basin: what is proven of cells, the lattice that it follows from, and its certificate.

The group ``proof`` has the lattice and the certificate. The lattice grows level by level. Each level ends as a pair of
arrays of its own, and the group's attribute ``levels_grown`` counts those that are whole. What a level needs beside
them lies in the group ``proof/growing``, which is removed once the lattice has grown.
"""

from typing import Any

import numpy as np

from rattle_kernels.basins.tiles import Tile
from rattle_proof.enclosures.cells import ProvenCells
from rattle_proof.enclosures.growth import IMPACTS, NUMBERS
from rattle_proof.enclosures.lattice import UNPROVEN
from rattle_proof.enclosures.targets import Targets
from rattle_proof.enclosures.windows import ACROSS, Windows, empty_windows
from rattle_proof.layout import (
    FOLLOWED,
    LATTICE_ENDS,
    LATTICE_NEVER_QUIET,
    LATTICE_ROUNDS,
    NEVER_QUIET,
    PROOF,
    PROVEN,
    RATTLING,
    TRAILS,
    UNPROVEN_REASON,
    WINDOW_ENDS,
    WINDOW_ORDER,
    grown,
)
from rattle_proof.request import asked_of
from worker.errors import StoreFailed, as_store_failure
from worker.storage.folder import synced_together
from worker.stores.basin_store import BasinStore
from worker.stores.layout import Variable
from worker.stores.new_store import create_array
from worker.stores.open_arrays import OpenArrays
from worker.stores.tile_arrays import TileArrays

_GROWING = "growing"
_CHUNK, _WINDOWS_A_CHUNK = 1024, 64
BOXES_A_PART = 65536
"""Boxes that one task follows: a second's work. Their trails are 7 MB."""


class ProofArrays:
    """The proof of a store of one basin.

    Parameters
    ----------
    arrays : OpenArrays
    tiles : TileArrays
        Of the same store.
    """

    def __init__(self, arrays: OpenArrays, tiles: TileArrays) -> None:
        self._arrays, self._tiles = arrays, tiles
        self._location, self._job, self._group, self._fence = arrays.location, arrays.job, arrays.group, arrays.fence

    @property
    def wanted(self) -> bool:
        """Whether a proof was asked for: what is proven of cells is there, or comes."""
        # By the request, too: the arrays' metadata may be damaged.
        return asked_of(self._job) is not None or PROVEN.path in self._group

    def read_tile(self, tile: Tile) -> ProvenCells | None:
        """Read what is proven of a tile's cells; None until all of it is written."""
        proven, reason = (self._tiles.read_one(each, tile) for each in (PROVEN, UNPROVEN_REASON))
        if proven is None or reason is None:
            return None
        # Stores of the first edition have none.
        there = NEVER_QUIET.path in self._group
        never_quiet = self._tiles.read_one(NEVER_QUIET, tile) if there else np.zeros_like(proven)
        return None if never_quiet is None else ProvenCells(proven, never_quiet, reason)

    @property
    def certificate(self) -> dict[str, Any] | None:
        """Certificate of the proof as far as it has come; None until its targets are there."""
        with as_store_failure(self._location):
            if PROOF not in self._group:
                return None
            certificate = self._group[PROOF].attrs.get("certificate")
        return None if certificate is None else dict(certificate)

    @property
    def levels_grown(self) -> int:
        """Levels of the lattice that have grown; -1 until the targets are there."""
        with as_store_failure(self._location):
            return int(self._group[PROOF].attrs.get("levels_grown", -1)) if PROOF in self._group else -1

    def begin(self, certificate: dict[str, Any], targets: Targets, core: np.ndarray) -> None:
        """Write the targets: what rattles for ever, windows, the core on lattices, the certificate (driver only)."""
        self._fence()
        with as_store_failure(self._location), synced_together(self._location):
            self._group.create_group(PROOF, overwrite=True)
            rattling, windows = targets.rattling.ends != UNPROVEN, targets.windows
            self._create(RATTLING, rattling.shape, (_CHUNK, _CHUNK))[...] = rattling
            if len(windows.places):
                for variable, values in ((WINDOW_ENDS, windows.ends), (WINDOW_ORDER, windows.order)):
                    self._create(variable, values.shape, (_WINDOWS_A_CHUNK, ACROSS, ACROSS))[...] = values
            self.create_lattice(0, False, core.shape)
            self._write_pair(0, False, core, np.zeros_like(core))
        self._count(0, certificate)

    def _create(self, variable: Variable, shape: tuple[int, ...], chunks: tuple[int, ...]) -> Any:
        if variable.path in self._group:
            del self._group[variable.path]
        within = tuple(min(max(1, length), chunk) for length, chunk in zip(shape, chunks, strict=True))
        return create_array(self._group, self._job, variable, shape, within)

    def _count(self, levels: int, certificate: dict[str, Any] | None = None) -> None:
        more = {} if certificate is None else {"certificate": certificate}
        with as_store_failure(self._location):
            self._group[PROOF].update_attributes({"levels_grown": levels} | more)

    def create_lattice(self, level: int, last: bool, shape: tuple[int, ...]) -> None:
        """Make room for the lattice that has grown at a level (driver only)."""
        self._fence()
        with as_store_failure(self._location):
            for variable in (*_lattice(level, last), *((LATTICE_NEVER_QUIET,) if last else ())):
                self._create(variable, shape, (_CHUNK, _CHUNK))

    def create_trails(self, boxes: int) -> None:
        """Make room for what is found of boxes that are followed (driver only)."""
        self._fence()
        with as_store_failure(self._location):
            self._create(FOLLOWED, (boxes,), (BOXES_A_PART,))
            self._create(TRAILS, (boxes, IMPACTS, NUMBERS), (BOXES_A_PART, IMPACTS, NUMBERS))

    def make_room(self) -> None:
        """Make room for what stores of the first edition lack, whose lattice then grows anew (driver only)."""
        with as_store_failure(self._location):
            if NEVER_QUIET.path in self._group:
                return
            self._fence()
            proven = self._group[PROVEN.path]
            create_array(self._group, self._job, NEVER_QUIET, proven.shape, proven.chunks)
            if PROOF in self._group:
                self.forget_lattice()

    def forget_lattice(self) -> None:
        """Let the lattice grow anew, from its targets on (driver only)."""
        self._fence()
        self._count(-1)

    def level_has_grown(self, level: int) -> None:
        """Record that a level is whole (driver only)."""
        self._fence()
        self._count(level)

    def end(self, certificate: dict[str, Any]) -> None:
        """Write the whole certificate, and remove what the lattice has grown from (driver only)."""
        self._fence()
        with as_store_failure(self._location):
            proof = self._group[PROOF]
            if _GROWING in proof:
                del proof[_GROWING]
            proof.update_attributes({"certificate": certificate})

    def write_lattice(self, level: int, last: bool, ends: np.ndarray, rounds: np.ndarray) -> None:
        """Write the lattice that has grown at a level."""
        with as_store_failure(self._location):
            self._write_pair(level, last, ends, rounds)

    def write_never_quiet(self, boxes: np.ndarray) -> None:
        """Write of which boxes of the last lattice nothing falls quiet."""
        with as_store_failure(self._location):
            self._arrays.fresh(LATTICE_NEVER_QUIET)[...] = boxes

    def _write_pair(self, level: int, last: bool, *values: np.ndarray) -> None:
        for variable, value in zip(_lattice(level, last), values, strict=True):
            self._arrays.fresh(variable)[...] = value

    def read_lattice(self, level: int, last: bool) -> tuple[np.ndarray, np.ndarray]:
        """Read ends and rounds of the lattice that has grown at a level."""
        ends, rounds = (self._whole(variable) for variable in _lattice(level, last))
        return ends, rounds

    def read_never_quiet(self) -> np.ndarray:
        """Read of which boxes of the last lattice nothing falls quiet."""
        return self._whole(LATTICE_NEVER_QUIET)

    def read_rattling(self) -> np.ndarray:
        """Read which boxes belong to the set that rattles for ever."""
        return self._whole(RATTLING)

    def read_windows(self, places: np.ndarray) -> Windows:
        """Read the windows at some places, with what is proven of their boxes."""
        if not len(places):
            return empty_windows(places)
        return Windows(places, self._whole(WINDOW_ENDS), self._whole(WINDOW_ORDER))

    def write_followed(self, part: int, ends: np.ndarray, trails: np.ndarray) -> None:
        """Write what is found of one part of the boxes."""
        here = slice(part * BOXES_A_PART, part * BOXES_A_PART + len(ends))
        with as_store_failure(self._location):
            self._arrays.fresh(FOLLOWED)[here] = ends
            self._arrays.fresh(TRAILS)[here] = trails

    def read_followed(self) -> tuple[np.ndarray, np.ndarray]:
        """Read what is found of all boxes."""
        ends = self._whole(FOLLOWED)
        with as_store_failure(self._location):
            # What is lost of a trail is not a number, which proves nothing.
            return ends, np.asarray(self._arrays.fresh(TRAILS)[...])

    def _whole(self, variable: Variable) -> np.ndarray:
        with as_store_failure(self._location):
            values = np.asarray(self._arrays.fresh(variable)[...])
        if (values == variable.fill).any():
            raise StoreFailed(f"the store {self._location} has lost a part of {variable.path}")
        return values


def proof_of(store: BasinStore) -> ProofArrays:
    """The proof in a store."""
    return ProofArrays(store.arrays, store.tiles)


def _lattice(level: int, last: bool) -> tuple[Variable, Variable]:
    both = LATTICE_ENDS, LATTICE_ROUNDS
    return both if last else (grown(both[0], level), grown(both[1], level))
