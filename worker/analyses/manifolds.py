"""Manifolds as an analysis: first the saddles in parallel, then every branch separately."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import astuple
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy import float64, int8, int32, int64
from pydantic import BaseModel, Field

from rattle_kernels import (
    CurveResolution,
    FoundOrbit,
    ManifoldBranch,
    ManifoldEnd,
    ManifoldLimits,
    NotASaddle,
    Oscillator,
    PeriodicOrbit,
    find_orbit,
    find_orbits,
    find_saddle,
    stable_manifold,
    unstable_manifold,
)
from rattle_kernels.manifolds.saddle import is_saddle
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.orbits.orbit_search import merge_orbits
from worker.analyses.analysis import Analysis, AnalysisView, Parts, Piece, Plan, in_order, ready_of
from worker.analyses.curves import PIECES, THIN, PieceEnd, finish_plane, piece_columns, pieces_of
from worker.analyses.orbit_tables import ORBITS, OrbitView, orbits_of, summarise_orbits
from worker.errors import NotFound
from worker.jobs.manifold_job import Itinerary, ManifoldJob, Side
from worker.jobs.orbits_job import OrbitSeed
from worker.jobs.region import Region
from worker.pictures.overlay import Lines, grazing_line
from worker.pictures.symbols import oscillator_text
from worker.progress import Stage
from worker.stores.layout import Columns, Variable
from worker.stores.table import Column, Table, slices

_BANDS = 8
_SIDES = (Side.STABLE, Side.UNSTABLE)
# Colours of what is laid over a basin, by saddle.
_OVER = ("magenta", "lime", "darkorange", "cyan")
# Each manifold by the code of a branch's kind, with the style of its lines.
_MANIFOLDS = {1: ("stable", "-"), 2: ("unstable", ":")}
_KIND = {"flag_values": [1, 2], "flag_meanings": " ".join(_SIDES)}
_SIZE = {"sample_dimension": "piece"}
BRANCHES = Table("branch", (
    Column("branch_orbit", int32, "saddle that a branch belongs to", None),
    Column("branch_point", int32, "which of its departures the branch leaves"),
    Column("branch_side", int8, "1 where it leaves it towards later phases, else -1", fill=0),
    Column("branch_kind", int8, "of which manifold", None, _KIND, fill=0),
    Column("branch_arclength", float64, "length in the plane (t, v/velocity scale)"),
    Column("branch_end", str, "why it was grown no further", "end.value"),
    Column(
        "branch_size", int64, "pieces of a branch, which follow those of the one before",
        lambda branch: len(branch.pieces), _SIZE,
    ),
), prefix="branch_")  # fmt: skip


class ManifoldBranchView(BaseModel):
    """One branch of a manifold."""

    saddle: int = Field(description="Whose: index into `saddles`")
    manifold: Literal["stable", "unstable"]
    departure: int = Field(description="Which of the saddle's departures it leaves")
    side: Literal[1, -1] = Field(description="1 where it leaves it towards later phases")
    arclength: float
    end: str = Field(description="Why it was grown no further")
    vertices: int
    pieces: int
    pieces_by_end: dict[str, int] = Field(
        description="Pieces that end at a corner, leave the window, or end the branch"
    )


class ManifoldView(AnalysisView):
    """Summary of manifolds; their vertices are in the store."""

    kind: Literal["manifold"]
    saddles: list[OrbitView]
    branches: list[ManifoldBranchView]


def saddle_of_seed(oscillator: Oscillator, number: int, seed: OrbitSeed, *, pause: Pause) -> Columns:
    """Saddle near a seed.

    Raises
    ------
    NotFound
        If there is none, or Newton's method leads to another kind of orbit.
    """
    pause()
    try:
        saddle = find_saddle(oscillator, *astuple(seed))
    except NotASaddle as error:
        raise NotFound(f"saddle {number + 1}: {error}") from error
    found = find_orbit(oscillator, saddle.t[0], saddle.v[0], saddle.upper_contacts)
    assert found is not None  # Newton's method has just converged there
    return ORBITS.of([found])


def saddle_named(
    oscillator: Oscillator, number: int, itinerary: Itinerary, region: Region, cells: int, *, pause: Pause
) -> Columns:
    """The saddle of an itinerary that a search of a region finds.

    Raises
    ------
    NotFound
        If it finds none, or several: an itinerary does not select one of them.
    """
    found: list[FoundOrbit] = []
    edges = np.linspace(0, cells, min(_BANDS, cells) + 1).round().astype(int).tolist()
    for rows in zip(edges[:-1], edges[1:], strict=True):
        found += find_orbits(
            oscillator, itinerary.upper_contacts, region.time.ends, region.velocity.ends, cells, rows, pause=pause
        )  # fmt: skip
    orbits = merge_orbits(oscillator, found)
    saddles = [each for each in orbits if each.orbit.name == itinerary.name and is_saddle(each.orbit)]
    if not saddles:
        others = ", ".join(f"{o.orbit.name} {'saddle' if is_saddle(o.orbit) else 'that attracts'}" for o in orbits)
        raise NotFound(
            f"saddle {number + 1}: the search found no saddle {itinerary.name}; it found {others or 'no orbit'}: ask "
            "for one of these, search more cells or another region, or give a seed"
        )
    if len(saddles) > 1:
        impacts = itinerary.upper_contacts
        seeds = (f"{each.orbit.t[0]:.12g},{each.orbit.v[0]:.12g},{impacts}" for each in saddles)
        raise NotFound(
            f"saddle {number + 1}: the search found {len(saddles)} saddles {itinerary.name}: give the time, velocity "
            f"and impact period of the one you mean, {' or '.join(seeds)}, or a region that only one of them enters"
        )
    return ORBITS.of(saddles)


def grow_branch(
    oscillator: Oscillator, saddle: PeriodicOrbit, side: Side, only: tuple[int, int], limits: ManifoldLimits,
    resolution: CurveResolution, *, pause: Pause,
) -> Columns:  # fmt: skip
    """One branch of a manifold."""
    grow = stable_manifold if side == Side.STABLE else unstable_manifold
    (branch,) = grow(oscillator, saddle, limits, resolution, only=only, pause=pause)
    window = limits.lowest_velocity, limits.highest_velocity
    return (
        BRANCHES.of([branch])
        | piece_columns(branch.pieces, window)
        | {"branch_kind": np.array([_SIDES.index(side) + 1], np.int8)}
    )


def _saddle_pieces(job: ManifoldJob) -> list[Piece]:
    return [
        Piece(f"saddle-{n:05d}", saddle_of_seed, (job.oscillator, n, saddle))
        if isinstance(saddle, OrbitSeed)
        else Piece(f"saddle-{n:05d}", saddle_named, (job.oscillator, n, saddle, job.region, job.cells))
        for n, saddle in enumerate(job.saddles)
    ]


def _saddles(job: ManifoldJob, parts: Parts) -> tuple[FoundOrbit, ...]:
    return merge_orbits(job.oscillator, [each for part in in_order(parts, "saddle-") for each in orbits_of(part)])


def _branches(job: ManifoldJob, saddles: tuple[FoundOrbit, ...]) -> list[tuple[int, Piece]]:
    """Every branch of every saddle, with the number of the saddle."""
    branches = []
    for number, found in enumerate(saddles):
        for side in job.side.each:
            for point in range(found.orbit.upper_contacts):
                for way in (1, -1):
                    name = f"branch-{number:05d}-{side}-{point:03d}-{'later' if way > 0 else 'earlier'}"
                    arguments = job.oscillator, found.orbit, side, (point, way), job.limits, job.resolution
                    branches.append((number, Piece(name, grow_branch, arguments)))
    return branches


def plan(job: ManifoldJob, parts: Parts) -> Plan:
    """Find the saddles. Then grow every branch."""
    finding = ready_of(Stage.SEARCHING, _saddle_pieces(job), parts)
    if finding.done < finding.total:
        return finding
    return ready_of(Stage.GROWING, [piece for _, piece in _branches(job, _saddles(job, parts))], parts)


def assemble(job: ManifoldJob, parts: Parts) -> Columns:
    """Saddles, and the branches grown so far."""
    saddles = _saddles(job, parts)
    grown = [(number, parts[piece.name]) for number, piece in _branches(job, saddles) if piece.name in parts]
    branches = [part for _, part in grown]
    columns = ORBITS.of(saddles) | BRANCHES.join(branches) | PIECES.join(branches)
    return columns | {"branch_orbit": np.array([number for number, _ in grown], np.int32)}


def layout(job: ManifoldJob) -> tuple[Variable, ...]:
    """Variables of the store: saddles as orbits, branches, pieces, vertices."""
    return (*ORBITS.variables, *BRANCHES.variables, *PIECES.variables)


def branches_of(columns: Mapping[str, Any], side: Side, orbit: int | None = None) -> list[ManifoldBranch]:
    """Branches of the manifolds of one saddle, or of all, from a store's columns or an xarray dataset."""
    pieces = pieces_of(columns)
    rows = BRANCHES.rows(columns)
    return [
        ManifoldBranch(row.point, row.side, tuple(pieces[own]), row.arclength, ManifoldEnd(row.end))
        for row, own in zip(rows, slices(np.asarray(columns["branch_size"])), strict=True)
        if row.kind == _SIDES.index(side) + 1 and orbit in (None, row.orbit)
    ]


def summarise(job: ManifoldJob, columns: Columns) -> dict[str, Any]:
    """Saddles, and branches with their lengths and the reasons why they end."""
    branches = []
    for row, own in zip(BRANCHES.rows(columns), slices(columns["branch_size"]), strict=True):
        ends = columns["piece_end"][own]
        branches.append(
            ManifoldBranchView(
                saddle=row.orbit,
                manifold=_SIDES[row.kind - 1].value,
                departure=row.point,
                side=row.side,
                arclength=row.arclength,
                end=row.end,
                vertices=int(columns["piece_size"][own].sum()),
                pieces=row.size,
                pieces_by_end={end.name.lower(): int((ends == end).sum()) for end in PieceEnd},
            )
        )
    return {"saddles": summarise_orbits(columns), "branches": branches}


def _manifolds_of(columns: Mapping[str, Any], saddle: int, colour: str, width: float = 1.0) -> Iterator[Lines]:
    """The manifolds of a saddle that have been grown, from a store's columns or an xarray dataset."""
    pieces, branches = pieces_of(columns), slices(np.asarray(columns["branch_size"]))
    kinds, saddles = np.asarray(columns["branch_kind"]), np.asarray(columns["branch_orbit"])
    for kind, (manifold, style) in _MANIFOLDS.items():
        own = np.flatnonzero((kinds == kind) & (saddles == saddle))
        arcs = tuple(piece for branch in own for piece in pieces[branches[branch]])
        if arcs:
            name = np.asarray(columns["name"])[saddle]
            yield Lines(f"{manifold} manifold of {name}", colour, arcs, width, style)


def overlays_of(dataset: xr.Dataset, names: Collection[str] = ()) -> tuple[Lines, ...]:
    """Manifolds of each saddle, in a colour of its own. They have no other names to choose by."""
    saddles = range(dataset.sizes["orbit"])
    return tuple(lines for number in saddles for lines in _manifolds_of(dataset, number, _OVER[number % len(_OVER)]))


def draw_manifolds(job: ManifoldJob, columns: Columns, figure: Figure) -> None:
    """Draw saddles and their manifolds, stable ones solid and unstable ones dotted, with one colour per saddle."""
    axes = figure.subplots()
    grazing_line(job.oscillator)._replace(colour="gray", width=1.0).draw(axes)
    for number, name in enumerate(columns["name"]):
        for lines in _manifolds_of(columns, number, f"C{number % 10}", THIN):
            lines.draw(axes)
        marks = columns["orbit_time"][number], columns["orbit_velocity"][number]
        axes.plot(*marks, "+", color="black", markersize=9, label=f"saddle {name}")
    window = job.limits.lowest_velocity, job.limits.highest_velocity
    finish_plane(axes, oscillator_text(job.oscillator), window)


MANIFOLD = Analysis(
    "Manifolds of saddles of a rattling gear pair", ManifoldJob, plan, assemble, layout, summarise, ManifoldView,
    draw_manifolds,
)  # fmt: skip
