"""Manifolds as an analysis: saddles side by side, then every branch by itself."""

from collections.abc import Mapping
from typing import Any

import numpy as np

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
    merge_orbits,
    stable_manifold,
    unstable_manifold,
)
from rattle_kernels.numerics.pausing import Pause
from worker.analyses.analysis import Analysis, Parts, Piece, Plan, in_order, ready_of
from worker.analyses.branch_table import slices
from worker.analyses.curve_picture import draw_manifolds
from worker.analyses.curve_table import PIECES, PieceEnd, join_pieces, piece_columns, pieces_of
from worker.analyses.orbit_table import ORBITS, orbit_columns, orbits_of, tell_orbits
from worker.errors import NotFound
from worker.jobs.analysis_job import Region
from worker.jobs.manifold_job import Itinerary, ManifoldJob, Side
from worker.jobs.orbits_job import OrbitSeed
from worker.progress import Stage
from worker.stores.layout import MISSING, Columns, Variable

_BANDS = 8
_SIDES = (Side.STABLE, Side.UNSTABLE)
_BRANCH = ("branch",)
BRANCHES = (
    Variable("branch_orbit", _BRANCH, np.int32, MISSING, "saddle that a branch belongs to"),
    Variable("branch_point", _BRANCH, np.int32, MISSING, "which of its departures the branch leaves"),
    Variable("branch_side", _BRANCH, np.int8, 0, "1 where it leaves it towards later phases, else -1"),
    Variable(
        "branch_kind", _BRANCH, np.int8, 0, "of which manifold",
        {"flag_values": [1, 2], "flag_meanings": " ".join(_SIDES)},
    ),
    Variable("branch_arclength", _BRANCH, np.float64, np.inf, "length in the plane (t, v/velocity scale)"),
    Variable("branch_end", _BRANCH, str, "", "why it was grown no further"),
    Variable(
        "branch_size", _BRANCH, np.int64, MISSING, "pieces of a branch, which follow those of the one before",
        {"sample_dimension": "piece"},
    ),
)  # fmt: skip


def saddle_of_seed(oscillator: Oscillator, number: int, seed: OrbitSeed, *, pause: Pause) -> Columns:
    """Saddle near a seed.

    Raises
    ------
    NotFound
        Where there is none, or another orbit.
    """
    pause()
    try:
        saddle = find_saddle(oscillator, *seed)
    except NotASaddle as error:
        raise NotFound(f"saddles.{number}: {error}") from error
    found = find_orbit(oscillator, saddle.t[0], saddle.v[0], saddle.upper_contacts)
    assert found is not None  # Newton's method has just ended there
    return orbit_columns([found])


def saddles_named(
    oscillator: Oscillator, number: int, itinerary: Itinerary, region: Region, cells: int, *, pause: Pause
) -> Columns:
    """All saddles of an itinerary that a search of a region finds.

    Raises
    ------
    NotFound
        Where it finds none.
    """
    found: list[FoundOrbit] = []
    edges = np.linspace(0, cells, min(_BANDS, cells) + 1).round().astype(int).tolist()
    for rows in zip(edges[:-1], edges[1:], strict=True):
        pause()
        found += find_orbits(oscillator, itinerary.upper_contacts, region[:2], region[2:], cells, rows)
    orbits = merge_orbits(oscillator, found)
    saddles = [each for each in orbits if each.orbit.name == itinerary.name and _is_saddle(each.orbit)]
    if not saddles:
        others = ", ".join(f"{o.orbit.name} {'saddle' if _is_saddle(o.orbit) else 'that attracts'}" for o in orbits)
        raise NotFound(
            f"saddles.{number}: the search found no saddle {itinerary.name}; it found {others or 'no orbit'}: ask for "
            "one of these, search more cells or another region, or give a seed"
        )
    return orbit_columns(saddles)


def _is_saddle(orbit: PeriodicOrbit) -> bool:
    return not orbit.attracts and not np.abs(orbit.multipliers.imag).any()


def grow_branch(
    oscillator: Oscillator, saddle: PeriodicOrbit, side: Side, only: tuple[int, int], limits: ManifoldLimits,
    resolution: CurveResolution, *, pause: Pause,
) -> Columns:  # fmt: skip
    """One branch of a manifold."""
    grow = stable_manifold if side == Side.STABLE else unstable_manifold
    (branch,) = grow(oscillator, saddle, limits, resolution, only=only, pause=pause)
    return piece_columns(branch.pieces, (limits.lowest_velocity, limits.highest_velocity)) | {
        "branch_point": np.array([branch.point], np.int32),
        "branch_side": np.array([branch.side], np.int8),
        "branch_kind": np.array([_SIDES.index(side) + 1], np.int8),
        "branch_arclength": np.array([branch.arclength]),
        "branch_end": np.array([branch.end.value], object),
        "branch_size": np.array([len(branch.pieces)], np.int64),
    }


def _saddle_pieces(job: ManifoldJob) -> list[Piece]:
    return [
        Piece(f"saddle-{n:05d}", saddle_of_seed, (job.oscillator, n, saddle))
        if isinstance(saddle, OrbitSeed)
        else Piece(f"saddle-{n:05d}", saddles_named, (job.oscillator, n, saddle, job.region, job.cells))
        for n, saddle in enumerate(job.saddles)
    ]


def _saddles(job: ManifoldJob, parts: Parts) -> tuple[FoundOrbit, ...]:
    return merge_orbits(job.oscillator, [each for part in in_order(parts, "saddle-") for each in orbits_of(part)])


def _branches(job: ManifoldJob, saddles: tuple[FoundOrbit, ...]) -> list[tuple[int, Piece]]:
    """Every branch of every saddle, with the saddle's number."""
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
    """Find the saddles; then grow every branch."""
    finding = ready_of(Stage.SEARCHING, _saddle_pieces(job), parts)
    if finding.done < finding.total:
        return finding
    return ready_of(Stage.GROWING, [piece for _, piece in _branches(job, _saddles(job, parts))], parts)


def assemble(job: ManifoldJob, parts: Parts) -> Columns:
    """Saddles, and the branches that are grown."""
    saddles = _saddles(job, parts)
    grown = [(number, parts[piece.name]) for number, piece in _branches(job, saddles) if piece.name in parts]
    columns = orbit_columns(saddles) | join_pieces([part for _, part in grown])
    columns["branch_orbit"] = np.array([number for number, _ in grown], np.int32)
    for variable in BRANCHES[1:]:
        empty = np.empty(0, object if variable.dtype is str else variable.dtype)
        columns[variable.name] = np.concatenate([part[variable.name] for _, part in grown] or [empty])
    return columns


def layout(job: ManifoldJob) -> tuple[Variable, ...]:
    """Variables of the store: saddles as orbits, branches, pieces, vertices."""
    return (*ORBITS, *BRANCHES, *PIECES)


def branches_of(columns: Mapping[str, Any], side: Side, orbit: int | None = None) -> list[ManifoldBranch]:
    """Branches of one manifold, or of those of all saddles: of a store's columns, or of an xarray dataset."""
    pieces = pieces_of(columns)
    named = {variable.name: np.asarray(columns[variable.name]) for variable in BRANCHES}
    branches = []
    for i, own in enumerate(slices(named["branch_size"])):
        if named["branch_kind"][i] == _SIDES.index(side) + 1 and orbit in (None, int(named["branch_orbit"][i])):
            point, way, length = (named[f"branch_{name}"][i] for name in ("point", "side", "arclength"))
            end = ManifoldEnd(str(named["branch_end"][i]))
            branches.append(ManifoldBranch(int(point), int(way), tuple(pieces[own]), float(length), end))
    return branches


def summarise(job: ManifoldJob, columns: Columns) -> dict[str, Any]:
    """Saddles and branches, with their lengths and why they end."""
    branches = []
    for i, own in enumerate(slices(columns["branch_size"])):
        ends = columns["piece_end"][own]
        branches.append(
            {
                "saddle": int(columns["branch_orbit"][i]),
                "manifold": _SIDES[int(columns["branch_kind"][i]) - 1].value,
                "departure": int(columns["branch_point"][i]),
                "side": int(columns["branch_side"][i]),
                "arclength": float(columns["branch_arclength"][i]),
                "end": str(columns["branch_end"][i]),
                "vertices": int(columns["piece_size"][own].sum()),
                "pieces": int(columns["branch_size"][i]),
                "pieces_by_end": {end.name.lower(): int((ends == end).sum()) for end in PieceEnd},
            }
        )
    return {"saddles": tell_orbits(columns), "branches": branches}


MANIFOLD = Analysis(
    "Manifolds of saddles of a rattling gear pair", ManifoldJob.from_request, plan, assemble, layout, summarise,
    draw_manifolds,
)  # fmt: skip
