"""Summaries of results: models that are made once, from a store, and are JSON for a service, the shell and Python."""

import math
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from cachetools import FIFOCache
from pydantic import BaseModel, BeforeValidator, Field

from rattle_kernels import Attractor, ExpectedLoudness, Loudness, loudness
from rattle_kernels.attractors.attractor import ENSEMBLE
from worker.additions import additions, with_fields
from worker.results.measures import heard_in
from worker.stores.basin_store import BasinStore
from worker.stores.changes import list_changes
from worker.stores.layout import ChangeKind, TileState
from worker.stores.solution_table import WITHOUT_POINTS, SolutionTable, share_error

_EXPECTATIONS_KEPT = 1 << 14
_expectations: FIFOCache[tuple[str, int, bytes], ExpectedLoudness] = FIFOCache(_EXPECTATIONS_KEPT)
_lock = threading.Lock()
# Points of a solution that a summary lists.
_MOST_POINTS = 100
_PROPERTIES = (
    "name", "forcing_periods", "upper_contacts", "lower_contacts", "lyapunov_exponent", "mean_life", "mean_life_error",
)  # fmt: skip


def _finite_or_none(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


FiniteOrNone = Annotated[float | None, BeforeValidator(_finite_or_none)]
"""A number, or None in place of NaN and infinity, which JSON cannot hold."""


class Loud(BaseModel):
    """Loudness of a motion: silent for permanent contact, null where it is not known."""

    impacts_per_period: FiniteOrNone = Field(description="Impacts on both walls in a forcing period")
    largest_impact_speed: FiniteOrNone = Field(description="Of arrival at a wall; of chaos the largest that was met")
    impact_power: FiniteOrNone = Field(description="Sum of v²/2 over the impacts of a forcing period")
    time_in_contact: FiniteOrNone = Field(description="Part of the time in which teeth touch: contacts and rests")
    impacts_per_period_error: FiniteOrNone = Field(description="Standard error; 0 if the motion is not chaotic")
    impact_power_error: FiniteOrNone = Field(description="Standard error; 0 if the motion is not chaotic")
    time_in_contact_error: FiniteOrNone = Field(description="Standard error; 0 if the motion is not chaotic")


class ExpectedView(BaseModel):
    """Mean loudness over the window of a basin: shares times loudness."""

    impacts_per_period: float
    largest_impact_speed: float
    impact_power: float
    time_in_contact: float
    impacts_per_period_error: float = Field(description="Standard error, from chaos and from shares of samples")
    largest_impact_speed_error: float = Field(description="Standard error, from shares of samples")
    impact_power_error: float = Field(description="Standard error, from chaos and from shares of samples")
    time_in_contact_error: float = Field(description="Standard error, from chaos and from shares of samples")
    undecided_share: float = Field(description="Share of the cells whose motion is not known; they count as silent")


class EndView(BaseModel):
    """What a part of the motions on a chaotic transient end in."""

    solution: int = Field(description="Which: index into `solutions`")
    share: float = Field(description="Part of an ensemble of motions that ended in it")
    standard_error: float


class SolutionView(Loud):
    """One motion and its share of the cells. In a sweep: the share of all basins, the points of the first with it."""

    name: str = Field(examples=["P(1,1,0)"])
    kind: Literal["periodic", "chaotic", "chaotic_transient", "permanent_contact", "undecided"]
    share: FiniteOrNone = Field(description="Part of the cells that end in it; null until every tile is labelled")
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    lyapunov_exponent: FiniteOrNone = Field(description="Per forcing period")
    mean_life: FiniteOrNone = Field(
        description="Mean number of impacts until a motion leaves a chaotic transient; null if none was seen to leave"
    )
    mean_life_error: FiniteOrNone = Field(description="Standard error of `mean_life`, at most")
    ends: list[EndView] = Field(
        description="What a chaotic transient ends in; the rest of its ensemble had not ended. Empty of other motions"
    )
    points: list[tuple[float, float]] = Field(
        description="(t, v) of its departures; the first hundred of a chaotic one"
    )


if not TYPE_CHECKING:
    for _addition in additions():
        SolutionView = with_fields(SolutionView, _addition.solution_fields())


class ShareView(BaseModel):
    """Share of a solution in one basin."""

    solution: int = Field(description="Which: index into `solutions`")
    share: float
    standard_error: FiniteOrNone = Field(description="Of samples, as of independent points; otherwise null")


class BasinView(BaseModel):
    """One basin of a sweep."""

    parameters: dict[str, float] = Field(description="Values of the swept parameters, or of the coordinate of a design")
    complete: bool
    shares: list[ShareView] = Field(description="Shares of its solutions; empty until it is complete")
    expected: ExpectedView | None = Field(description="Mean loudness over its window; null until it is complete")


class ChangeView(BaseModel):
    """Birth or death of a solution between two neighbouring values of a swept parameter, or machines of a design."""

    kind: Literal["birth", "death"]
    solution: int = Field(description="Which: index into `solutions`")
    parameter: str = Field(description="Along which parameter, or coordinate of a design")
    before: float
    after: float
    beside: FiniteOrNone = Field(description="Value of the other swept parameter")


class ResultView(BaseModel):
    """Summary of a basin or a sweep, complete or not."""

    complete: bool
    request: dict[str, Any]
    tiles: int
    tiles_computed: int
    tiles_assembled: int
    solutions: list[SolutionView]
    basins: list[BasinView] = Field(description="All basins, the last swept parameter fastest; one if nothing is swept")
    changes: list[ChangeView] = Field(description="Births and deaths of solutions along the swept parameters so far")
    image_counts: dict[str, int] = Field(description="Cells with each reserved image; empty until all cells are mapped")
    seconds: dict[str, float] = Field(
        description="Wall time of each stage, and the kernels' own time summed over tiles"
    )
    zarr: str


def summarise(location: str, zarr: str | None = None) -> ResultView:
    """Summary of the store at a location, finished or not.

    Parameters
    ----------
    location : str
    zarr : str, optional
        Where the reader of the summary finds the store; by default at its location.

    Returns
    -------
    ResultView

    Raises
    ------
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    store = BasinStore.open(location)
    states = store.read_ledger()
    table = store.solutions.read()
    return ResultView(
        complete=store.complete,
        request=store.job.request(),
        tiles=states.size,
        tiles_computed=int((states >= TileState.COMPUTED).sum()),
        tiles_assembled=int((states == TileState.ASSEMBLED).sum()),
        solutions=_solutions(store, table),
        basins=_basins(store, table),
        changes=_changes(store, table),
        image_counts=count_images(store),
        seconds=store.attributes.get("seconds", {}),
        zarr=location if zarr is None else zarr,
    )


def ends_of(attractor: Attractor) -> list[EndView]:
    """What a chaotic transient ends in: numbers of solutions, and the shares of its ensemble with their errors."""
    errors = share_error(ENSEMBLE * np.array([[share for _, share in attractor.ends]]), ENSEMBLE).tolist()
    return [
        EndView(solution=number, share=share, standard_error=error)
        for (number, share), error in zip(attractor.ends, errors, strict=True)
    ]


def _solutions(store: BasinStore, table: SolutionTable) -> list[SolutionView]:
    """Each motion, from the first basin that has it. Its share is known once all basins are complete."""
    whole = bool(table.complete.all())
    shares = np.nansum(table.share, axis=0) / store.job.basins if whole else np.full(len(table.motions), np.nan)
    added: list[dict[str, Any]] = [{} for _ in table.motions]
    for addition in additions():
        for own, more in zip(added, addition.of_solutions(store), strict=False):
            own |= more
    solutions = []
    for number, (attractor, basin) in enumerate(
        zip(representatives(store, table), _first_basins(table).tolist(), strict=True)
    ):
        heard: Loudness = loudness(store.job.oscillator_of(basin), attractor)
        points = zip(attractor.time[:_MOST_POINTS].tolist(), attractor.velocity[:_MOST_POINTS].tolist(), strict=True)
        solutions.append(
            SolutionView(
                **{name: getattr(attractor, name) for name in _PROPERTIES}, **heard._asdict(),
                kind=attractor.kind.name.lower(), share=float(shares[number]), **added[number],
                ends=ends_of(attractor), points=list(points),
            )
        )  # fmt: skip
    return solutions


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
        catalogue = store.solutions.read_catalogue(basin, table, numbers)
        if not all(each.time.size or each.kind in WITHOUT_POINTS for each in catalogue):
            return None  # points are still being written
        motions, shares = dict(zip(numbers, catalogue, strict=True)), table.share[basin, numbers]
        expected = heard_in(store.job, basin, motions, shares, partial(store.read_solution, basin))[1]
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


def _basins(store: BasinStore, table: SolutionTable) -> list[BasinView]:
    job = store.job
    with ThreadPoolExecutor() as threads:
        expected = list(threads.map(partial(expected_in, store, table), range(job.basins)))
    return [
        BasinView(
            parameters=job.values_of(basin), complete=complete,
            shares=[
                ShareView(
                    solution=number, share=float(table.share[basin, number]),
                    standard_error=float(table.share_error[basin, number]) if job.sample else None,
                )
                for number in table.numbers_in(basin)
            ],
            expected=ExpectedView(**heard._asdict()) if (heard := expected[basin]) else None,
        )
        for basin, complete in enumerate(table.complete.tolist())
    ]  # fmt: skip


def _changes(store: BasinStore, table: SolutionTable) -> list[ChangeView]:
    rows = zip(*(column.tolist() for column in list_changes(store.job, table)), strict=True)
    return [
        ChangeView(
            kind=ChangeKind(kind).name.lower(), solution=solution, parameter=str(parameter), before=before, after=after,
            beside=beside,
        )
        for kind, solution, parameter, before, after, beside in rows
    ]  # fmt: skip
