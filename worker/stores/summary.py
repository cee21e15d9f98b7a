"""Summary of a job's basins, read from their store."""

import dataclasses
import math
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from cachetools import FIFOCache

from rattle_kernels import Attractor, AttractorKind, ExpectedLoudness, Loudness, expected_loudness, loudness
from rattle_kernels.attractors.attractor import ENSEMBLE
from worker.stores.basin_store import BasinStore
from worker.stores.changes import list_changes
from worker.stores.layout import ChangeKind, TileState
from worker.stores.solution_table import SolutionTable, share_error, shares_of_sets

_EXPECTATIONS_KEPT = 1 << 14
WITHOUT_POINTS = AttractorKind.PERMANENT_CONTACT, AttractorKind.UNDECIDED
_expectations: FIFOCache[tuple[str, int, bytes], ExpectedLoudness] = FIFOCache(_EXPECTATIONS_KEPT)
_lock = threading.Lock()


@dataclass(frozen=True)
class SweptBasinSummary:
    """One basin of a sweep: values of the swept parameters, and the share of each of its solutions, by number.

    ``shares`` is empty until the basin is complete. ``errors`` are standard errors, for samples only. ``expected`` is
    the mean loudness over its window, None until it is complete.
    """

    values: dict[str, float]
    complete: bool
    shares: dict[int, float]
    errors: dict[int, float]
    expected: ExpectedLoudness | None


@dataclass(frozen=True)
class Change:
    """Birth or death of a solution, between two neighbouring values of a swept parameter.

    ``beside`` is the value of the other swept parameter, None if there is none.
    """

    kind: ChangeKind
    solution: int
    parameter: str
    before: float
    after: float
    beside: float | None


@dataclass(frozen=True)
class BasinSummary:
    """Result of one job: its motions with their shares, and how complete it is.

    ``attractors`` are listed by number, each from the first basin that has it, with its ``loudness`` there. ``shares``
    are those of all basins' cells, NaN until every basin is complete. ``image_counts`` counts the cells or points with
    each reserved image, once all are mapped. ``seconds`` has the wall time of each stage and the kernels' own time.
    ``basins`` are in order. ``changes`` lists births and deaths so far. ``shares_proven`` are the parts of the plane
    proven to end in each attractor, empty where no proof has ended.
    """

    request: dict[str, Any]
    complete: bool
    tiles: int
    tiles_computed: int
    tiles_assembled: int
    attractors: tuple[Attractor, ...]
    loudness: tuple[Loudness, ...]
    shares: tuple[float, ...]
    image_counts: dict[str, int]
    seconds: dict[str, float]
    basins: tuple[SweptBasinSummary, ...]
    changes: tuple[Change, ...]
    shares_proven: tuple[float, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """The summary as JSON: None for NaN, and the first hundred points of a chaotic attractor."""
        solutions = [_solution(*each) for each in zip(self.attractors, self.loudness, self.shares, strict=True)]
        for solution, proven in zip(solutions, self.shares_proven, strict=False):
            solution["share_proven"] = proven
        names = ("complete", "request", "tiles", "tiles_computed", "tiles_assembled", "image_counts", "seconds")
        own = {name: getattr(self, name) for name in names} | {"solutions": solutions}
        own["basins"] = [
            {
                "parameters": each.values, "complete": each.complete, "shares": _shares(each),
                "expected": each.expected and each.expected._asdict(),
            }
            for each in self.basins
        ]  # fmt: skip
        own["changes"] = [dataclasses.asdict(each) | {"kind": each.kind.name.lower()} for each in self.changes]
        as_json: dict[str, Any] = without_nan(own)
        return as_json

    found = as_json


def _solution(attractor: Attractor, heard: Loudness, share: float) -> dict[str, Any]:
    names = (
        "name", "forcing_periods", "upper_contacts", "lower_contacts", "lyapunov_exponent", "mean_life",
        "mean_life_error",
    )  # fmt: skip
    points = zip(attractor.time[:100].tolist(), attractor.velocity[:100].tolist(), strict=True)
    own = {name: getattr(attractor, name) for name in names} | {"ends": ends_as_json(attractor)}
    return own | heard._asdict() | {"kind": attractor.kind.name.lower(), "share": share, "points": list(points)}


def ends_as_json(attractor: Attractor) -> list[dict[str, Any]]:
    """What a chaotic transient ends in: numbers of solutions, and the shares of its ensemble with their errors."""
    errors = share_error(ENSEMBLE * np.array([[share for _, share in attractor.ends]]), ENSEMBLE).tolist()
    return [
        {"solution": number, "share": share, "standard_error": error}
        for (number, share), error in zip(attractor.ends, errors, strict=True)
    ]


def _shares(basin: SweptBasinSummary) -> list[dict[str, Any]]:
    return [
        {"solution": number, "share": share, "standard_error": basin.errors.get(number)}
        for number, share in basin.shares.items()
    ]


def without_nan(value: Any) -> Any:
    """The same value for JSON, with None for NaN and infinity."""
    if isinstance(value, dict):
        return {name: without_nan(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def summarise(location: str) -> BasinSummary:
    """Summary of the store at a location, finished or not.

    Raises
    ------
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    store = BasinStore.open(location)
    states = store.read_ledger()
    table = store.solutions.read()
    whole = bool(table.complete.all())
    overall = np.nansum(table.share, axis=0) / store.job.basins if whole else np.full(len(table.motions), np.nan)
    attractors = representatives(store, table)
    oscillators = (store.job.oscillator_of(basin) for basin in _first_basins(table).tolist())
    return BasinSummary(
        request=store.job.request(),
        complete=store.complete,
        tiles=states.size,
        tiles_computed=int((states >= TileState.COMPUTED).sum()),
        tiles_assembled=int((states == TileState.ASSEMBLED).sum()),
        attractors=attractors,
        loudness=tuple(map(loudness, oscillators, attractors)),
        shares=tuple(overall.tolist()),
        image_counts=count_images(store),
        seconds=store.attributes.get("seconds", {}),
        basins=_basins(store, table),
        changes=_changes(store, table),
        shares_proven=tuple((store.proof.certificate or {}).get("shares", ())),
    )


def fingerprint(location: str) -> bytes:
    """Bytes that change whenever a picture of the store does: from its ledger and its solutions.

    Raises
    ------
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    store = BasinStore.open(location)
    table = store.solutions.read()
    return b"".join(
        (bytes([store.complete]), store.read_ledger().tobytes(), repr(table.motions).encode(), table.share.tobytes())
    )


def _first_basins(table: SolutionTable) -> np.ndarray:
    """The first basin that has each solution, 0 while none is known to."""
    there = np.isfinite(table.share)
    return np.where(there.any(axis=0), there.argmax(axis=0), 0)


def representatives(store: BasinStore, table: SolutionTable) -> tuple[Attractor, ...]:
    """Each solution, from the first basin that has it; from the first catalogue while no basin is complete."""
    first = _first_basins(table)
    found: dict[int, Attractor] = {}
    for basin in np.unique(first).tolist():
        numbers = np.flatnonzero(first == basin).tolist()
        found |= dict(zip(numbers, store.solutions.read_catalogue(basin, table, numbers), strict=True))
    return tuple(found[number] for number in range(len(table.motions)))


def expected_in(store: BasinStore, table: SolutionTable, basin: int) -> ExpectedLoudness | None:
    """Mean loudness over the window of a basin; None until it is complete. Kept, since it never changes again."""
    numbers = table.numbers_in(basin)
    if not numbers:
        return None
    key = store.digest, basin, table.share[basin].tobytes()
    with _lock:
        expected = _expectations.get(key)
    if expected is None:
        oscillator, catalogue = store.job.oscillator_of(basin), store.solutions.read_catalogue(basin, table, numbers)
        if not all(each.time.size or each.kind in WITHOUT_POINTS for each in catalogue):
            return None  # points are still being written
        heard = [loudness(oscillator, each) for each in catalogue]
        sample = store.job.sample
        points = None if sample is None else sample.points
        of_sets = None
        if sample is not None and sample.scramblings > 1:
            of_sets = shares_of_sets(store.read_solution(basin), numbers, sample)
        expected = expected_loudness(table.share[basin, numbers], heard, points, of_sets)
        with _lock:
            _expectations[key] = expected
    return expected


def count_images(store: BasinStore) -> dict[str, int]:
    """Number of cells with each reserved image. Empty until all of them are mapped."""
    counts = store.read_image_counts()
    if (counts < 0).any():
        return {}
    named = dict(zip(("sink", "permanent_contact", "undecided"), counts.sum(axis=0).tolist(), strict=True))
    if store.job.sample is not None:
        del named["sink"]  # a sample has no cells, and no outside
    return named


def _basins(store: BasinStore, table: SolutionTable) -> tuple[SweptBasinSummary, ...]:
    job = store.job
    with ThreadPoolExecutor() as threads:
        expected = list(threads.map(partial(expected_in, store, table), range(job.basins)))
    basins = []
    for basin, complete in enumerate(table.complete.tolist()):
        shares = {number: float(table.share[basin, number]) for number in table.numbers_in(basin)}
        errors = {number: float(table.share_error[basin, number]) for number in shares} if job.sample else {}
        basins.append(SweptBasinSummary(job.values_of(basin), complete, shares, errors, expected[basin]))
    return tuple(basins)


def _changes(store: BasinStore, table: SolutionTable) -> tuple[Change, ...]:
    rows = zip(*(column.tolist() for column in list_changes(store.job, table)), strict=True)
    return tuple(
        Change(ChangeKind(kind), solution, str(parameter), before, after, beside if beside == beside else None)
        for kind, solution, parameter, before, after, beside in rows
    )
