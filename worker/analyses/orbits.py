"""Periodic orbits as an analysis: a search in parallel bands, then every orbit's branch, then every curve.

Orbits joined by a fold or a closed loop lie on one branch. It is computed from each of them, and the first is kept.
"""

import math
from collections.abc import Sequence
from dataclasses import astuple
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import (
    Branch,
    BranchEnd,
    FoundOrbit,
    Oscillator,
    PeriodicOrbit,
    SpecialKind,
    SpecialPoint,
    continue_orbit,
    continue_special_point,
    find_orbit,
    find_orbits,
)
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.orbits.orbit_search import merge_orbits
from worker.analyses.analysis import Analysis, AnalysisView, Parts, Piece, Plan, in_order, ready_of
from worker.analyses.orbit_tables import (
    CURVES,
    ORBITS,
    SPECIALS,
    BranchView,
    CurveView,
    OrbitView,
    SpecialPointView,
    branch_table,
    distinct,
    folding,
    orbits_of,
    specials_of,
    summarise_branches,
    summarise_curves,
    summarise_orbits,
    summarise_specials,
)
from worker.errors import NotFound
from worker.jobs.orbits_job import Continuation, OrbitSeed, OrbitsJob
from worker.pictures.overlay import grazing_line
from worker.pictures.symbols import in_words, oscillator_text
from worker.progress import Stage
from worker.stores.layout import Columns, Variable
from worker.stores.table import slices

_BANDS = 8
# Largest number of cells in a band of a search, which takes some seconds.
_MOST_CELLS = 400
# Two orbits closer than this are the same, as in the search.
_SAME = 1e-6
_MARKERS = {
    SpecialKind.SADDLE_NODE: "o", SpecialKind.PERIOD_DOUBLING: "s", SpecialKind.GRAZING: "^",
    SpecialKind.CONTACT_LOSS: "v", SpecialKind.UPPER_GRAZING: "<", SpecialKind.RELEASE: "D",
}  # fmt: skip


class OrbitsView(AnalysisView):
    """Summary of orbits; the points of branches and curves are in the store."""

    kind: Literal["orbits"]
    orbits: list[OrbitView]
    branches: list[BranchView]
    special_points: list[SpecialPointView]
    curves: list[CurveView]


def search_band(oscillator: Oscillator, job: OrbitsJob, rows: tuple[int, int], *, pause: Pause) -> Columns:
    """Orbits that the search finds from some rows of cells."""
    region = job.region
    found = find_orbits(
        oscillator, job.longest, region.time.ends, region.velocity.ends, job.cells, rows, pause=pause
    )  # fmt: skip
    return ORBITS.of(found)


def search_seed(oscillator: Oscillator, number: int, seed: OrbitSeed, *, pause: Pause) -> Columns:
    """Orbit near a seed.

    Raises
    ------
    NotFound
        If there is none.
    """
    found = find_orbit(oscillator, *astuple(seed), pause=pause)
    if found is None:
        raise NotFound(
            f"Newton's method on P^{seed.period} found no periodic orbit from seed {number}, t = {seed.time:g}, "
            f"v = {seed.velocity:g}: start closer to one, with the impact period that it has, or search a region"
        )
    return ORBITS.of([found])


def follow_branch(oscillator: Oscillator, orbit: PeriodicOrbit, along: Continuation, *, pause: Pause) -> Columns:
    """Branch of an orbit, its special points, and the orbits of the same oscillator that it passes through."""
    bounds = along.start, along.stop
    branch = continue_orbit(oscillator, orbit, along.parameter, bounds, most_points=along.most_points, pause=pause)
    passed = _passed(oscillator, branch)
    columns = branch_table(along.parameter).of([branch]) | SPECIALS.of(branch.special_points)
    return columns | {"passed_time": passed[:, 0], "passed_velocity": passed[:, 1]}


def _passed(oscillator: Oscillator, branch: Branch) -> np.ndarray:
    """Slowest departure of each orbit of a branch at the oscillator's own value, shape (orbits, 2)."""
    beyond = branch.values - oscillator.value_of(branch.parameter)
    passed = []
    for i in np.flatnonzero(beyond[:-1] * beyond[1:] < 0.0).tolist():
        part = beyond[i] / (beyond[i] - beyond[i + 1])
        apart = branch.t[i + 1, 0] - branch.t[i, 0]
        t = branch.t[i, 0] + part * (apart - np.rint(apart))
        v = branch.v[i, 0] + part * (branch.v[i + 1, 0] - branch.v[i, 0])
        found = find_orbit(oscillator, t, v, branch.upper_contacts)
        if found is not None:
            passed.append((found.orbit.t[0], found.orbit.v[0]))
    return np.array(passed).reshape(-1, 2)


def trace_curve(point: SpecialPoint, along: Continuation, second: Continuation, *, pause: Pause) -> Columns:
    """Curve of a special point in the plane of two parameters."""
    bounds, others = (along.start, along.stop), (second.start, second.stop)
    return CURVES.of([continue_special_point(point, second.parameter, bounds, others, second.most_points, pause=pause)])


def _search(job: OrbitsJob) -> list[Piece]:
    if job.seeds:
        return [Piece(f"search-{n:05d}", search_seed, (job.oscillator, n, seed)) for n, seed in enumerate(job.seeds)]
    rows = max(1, min(-(-job.cells // _BANDS), _MOST_CELLS // job.cells))
    bands = [(start, min(start + rows, job.cells)) for start in range(0, job.cells, rows)]
    return [Piece(f"search-{n:05d}", search_band, (job.oscillator, job, band)) for n, band in enumerate(bands)]


def _found(job: OrbitsJob, parts: Parts) -> tuple[FoundOrbit, ...]:
    found = [each for part in in_order(parts, "search-") for each in orbits_of(part)]
    return merge_orbits(job.oscillator, found)


def _branch_name(number: int) -> str:
    return f"branch-{number:05d}"


def _lines_of(found: Sequence[FoundOrbit], parts: Parts) -> tuple[list[int], list[int]]:
    """Orbits whose branches are kept, and the branch that each orbit lies on, -1 if that is not known yet."""
    kept: list[int] = []
    lines = []
    for number, each in enumerate(found):
        here = next((i for i, other in enumerate(kept) if _passes(parts[_branch_name(other)], each.orbit)), -1)
        if here < 0 and _branch_name(number) in parts:
            kept.append(number)
            here = len(kept) - 1
        lines.append(here)
    return kept, lines


def _passes(branch: Columns, orbit: PeriodicOrbit) -> bool:
    apart = branch["passed_time"] - orbit.t[0]
    distance = np.hypot(apart - np.rint(apart), (branch["passed_velocity"] - orbit.v[0]) / orbit.v[0])
    return bool((distance < _SAME).any())


def _specials(job: OrbitsJob, parts: Parts, kept: list[int]) -> tuple[list[SpecialPoint], list[int]]:
    """Special points of the kept branches, each once, and the branch of each."""
    assert job.continuation is not None
    points = [
        (point, number)
        for number, orbit in enumerate(kept)
        for point in specials_of(parts[_branch_name(orbit)], job.oscillator, job.continuation.parameter)
    ]
    return distinct(points)


def plan(job: OrbitsJob, parts: Parts) -> Plan:
    """Search for orbits. Then follow every orbit's branch, and then every special point's curve."""
    search = ready_of(Stage.SEARCHING, _search(job), parts)
    if search.done < search.total or job.continuation is None:
        return search
    found = _found(job, parts)
    branches = [
        Piece(_branch_name(n), follow_branch, (job.oscillator, each.orbit, job.continuation))
        for n, each in enumerate(found)
    ]
    continuing = ready_of(Stage.CONTINUING, branches, parts)
    if continuing.done < continuing.total or job.curves is None:
        return continuing
    points, _ = _specials(job, parts, _lines_of(found, parts)[0])
    curves = [
        Piece(f"curve-{n:05d}", trace_curve, (point, job.continuation, job.curves)) for n, point in enumerate(points)
    ]
    return ready_of(Stage.TRACING, curves, parts)


def assemble(job: OrbitsJob, parts: Parts) -> Columns:
    """Orbits by (n+, m, n-) and lowest speed, their branches, special points and curves."""
    found = _found(job, parts)
    columns = ORBITS.of(found)
    if job.continuation is None:
        return columns
    kept, lines = _lines_of(found, parts)
    columns |= branch_table(job.continuation.parameter).join([parts[_branch_name(n)] for n in kept])
    points, branch = _specials(job, parts, kept)
    columns |= SPECIALS.of(points)
    columns |= {
        "orbit_branch": np.array(lines, np.int32),
        "branch_orbit": np.array(kept, np.int32),
        "special_branch": np.array(branch, np.int32),
    }
    if job.curves is not None:
        began = sorted(int(name.removeprefix("curve-")) for name in parts if name.startswith("curve-"))
        columns |= CURVES.join(in_order(parts, "curve-")) | {"curve_special": np.array(began, np.int32)}
    return columns


def layout(job: OrbitsJob) -> tuple[Variable, ...]:
    """Variables of the store."""
    if job.continuation is None:
        return ORBITS.variables
    branches = branch_table(job.continuation.parameter)
    tables = (*ORBITS.variables, *branches.variables, *SPECIALS.variables)
    return tables if job.curves is None else (*tables, *CURVES.variables)


def summarise(job: OrbitsJob, columns: Columns) -> dict[str, Any]:
    """Orbits, branches with the reasons for their ends, special points and curves."""
    summary: dict[str, Any] = {"orbits": summarise_orbits(columns), "branches": [], "special_points": [], "curves": []}
    if job.continuation is not None:
        parameter = job.continuation.parameter
        for orbit, branch in zip(summary["orbits"], columns["orbit_branch"].tolist(), strict=True):
            orbit.branch = branch if branch >= 0 else None
        summary["branches"] = summarise_branches(columns, parameter)
        summary["special_points"] = summarise_specials(columns, parameter)
        if job.curves is not None:
            summary["curves"] = summarise_curves(columns, (parameter, job.curves.parameter))
    return summary


def plot_orbits(axes: Axes, job: OrbitsJob, columns: Columns) -> None:
    """Mark the departures of attracting orbits by x and of others by +, and draw v*(t)."""
    grazing_line(job.oscillator)._replace(colour="gray", width=1.0).draw(axes)
    for i, name in enumerate(columns["name"]):
        marker, stability = ("x", "attracts") if columns["attracts"][i] else ("+", "unstable")
        axes.plot(
            columns["orbit_time"][i], columns["orbit_velocity"][i], marker, label=f"{name} {stability}", markersize=8
        )
    axes.set_xlabel("time t of departure (forcing periods)")
    axes.set_ylabel("velocity v of departure")


def _mark_lost_ends(axes: Axes, job: OrbitsJob, columns: Columns) -> None:
    """Mark by x where a branch goes on, or may, but is not followed; in the impacting model a graze ends it."""
    assert job.continuation is not None
    lost = [BranchEnd.STALLED, BranchEnd.POINTS]
    if not math.isinf(job.oscillator.stiffness):
        lost.append(BranchEnd.GRAZING)
    names, label = [reason.name.lower() for reason in lost], "not followed further"
    for number, points in enumerate(slices(columns["branch_size"])):
        for end, place in ((0, points.start), (1, points.stop - 1)):
            if columns["branch_end_reason"][number][end] in names:
                speeds = columns["branch_velocity"][place]
                at = np.full(speeds.size, columns[job.continuation.parameter][place])
                axes.plot(at, speeds, "x", color="black", markersize=6, label=label)
                label = "_nolegend_"


def plot_branches(axes: Axes, job: OrbitsJob, columns: Columns) -> None:
    """Draw the speeds of departure along branches, thick where they attract, with special points and lost ends."""
    assert job.continuation is not None
    parameter = job.continuation.parameter
    for number, points in enumerate(slices(columns["branch_size"])):
        values, speeds = columns[parameter][points], columns["branch_velocity"][points]
        attracts = columns["branch_attracts"][points, None] == 1
        name, colour = columns["name"][columns["branch_orbit"][number]], f"C{number % 10}"
        axes.plot(values, speeds, color=colour, linewidth=0.6)
        axes.plot(values, np.where(attracts, speeds, np.nan), color=colour, linewidth=2.0)
        axes.plot([], [], color=colour, label=f"branch of {name}")
    _mark_lost_ends(axes, job, columns)
    for code, (kind, marker) in enumerate(_MARKERS.items(), 1):
        there = columns["special_kind"] == code
        folds = folding(columns)
        for chosen, label, fill in ((there & ~folds, kind.value, "none"), (there & folds, "grazing, a fold", "full")):
            speeds = columns["special_velocity"][chosen]
            if speeds.size:
                at = np.repeat(columns["special_value"][chosen], speeds.shape[1])
                axes.plot(at, speeds.ravel(), marker, color="black", markersize=4, fillstyle=fill, label=label)
    axes.set_xlabel(in_words(parameter))
    axes.set_ylabel("velocity v of departure")


def plot_curves(axes: Axes, job: OrbitsJob, columns: Columns) -> None:
    """Draw curves of special points in the plane of their two parameters; a cross where one is not followed."""
    assert job.continuation is not None and job.curves is not None
    for special, points in zip(columns["curve_special"].tolist(), slices(columns["curve_size"]), strict=True):
        kind = tuple(_MARKERS)[int(columns["special_kind"][special]) - 1]
        value = columns["special_value"][special]
        first, second = columns["curve_first"][points], columns["curve_second"][points]
        axes.plot(first, second, marker="x" if first.size == 1 else "", label=f"{kind.value} at {value:.5g}")
    for set_label, parameter in (
        (axes.set_xlabel, job.continuation.parameter),
        (axes.set_ylabel, job.curves.parameter),
    ):
        set_label(in_words(parameter))


def draw_orbits(job: OrbitsJob, columns: Columns, figure: Figure) -> None:
    """Draw orbits, or branches if there are any, with curves below them."""
    if job.continuation is None:
        drawn = [(figure.subplots(), plot_orbits)]
    elif job.curves is None:
        drawn = [(figure.subplots(), plot_branches)]
    else:
        figure.set_size_inches(10.0, 10.0)
        drawn = list(zip(figure.subplots(2), (plot_branches, plot_curves), strict=True))
    without = () if job.continuation is None else (job.continuation.parameter,)
    drawn[0][0].set_title(oscillator_text(job.oscillator, without))
    for axes, plot in drawn:
        plot(axes, job, columns)
        if axes.get_legend_handles_labels()[1]:
            axes.legend(
                loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, borderaxespad=0.0, fontsize="small"
            )


ORBITS_ANALYSIS = Analysis(
    "Periodic orbits of a rattling gear pair", OrbitsJob, plan, assemble, layout, summarise, OrbitsView, draw_orbits
)
