"""A chart of two parameters as an analysis: special points, curves, points of codimension two, and what machines do.

Lines are searched for special points. Curves are traced from them, points of codimension two are located on the curves,
and further curves leave these.

A curve crosses several lines, and is traced once. A special point lies on a curve of its kind and orbit if Newton's
method leads to it from the curve's points beside it. So those of one kind and orbit are traced one after another, and
each that lies on a curve that was traced before is left out. Curves that leave points of codimension two are kept once
by the same test, of their middle.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy import float64, int8, int32, int64
from pydantic import BaseModel, Field

from rattle_chart.job import FOLLOWED, GROWING, SETTLING, STARTS, ChartAxis, ChartJob
from rattle_kernels import (
    CellGrid,
    CodimensionTwo,
    CodimensionTwoPoint,
    Oscillator,
    OutsideDomain,
    SpecialCurve,
    SpecialKind,
    SpecialPoint,
    check_oscillator,
    codimension_two_points,
    continue_orbit,
    continue_special_point,
    curve_beside_graze,
    find_orbits,
)
from rattle_kernels.attractors.attractor import PERMANENT_CONTACT_ATTRACTOR, UNDECIDED_ATTRACTOR, AttractorKind
from rattle_kernels.attractors.chaotic_transient import REGULAR_GROWTH
from rattle_kernels.attractors.settled_orbit import attractor_of, settled_orbit
from rattle_kernels.lanes.lyapunov import tangent_growth
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.numerics.phase import wrap_all
from rattle_kernels.orbits.bifurcation_point import point_near
from rattle_kernels.orbits.closure import OrbitShape
from rattle_kernels.orbits.graze_kind import graze_response, touch_monodromy
from rattle_kernels.orbits.periodic_orbit import orbit_name
from worker.analyses.analysis import Analysis, AnalysisView, Parts, Piece, Plan, in_order, ready_of
from worker.analyses.orbit_tables import SPECIALS, distinct, flags_of_words, specials_of
from worker.jobs.region import Region
from worker.jobs.swept_parameter import Parameter
from worker.pictures.symbols import in_words, oscillator_text
from worker.progress import Stage
from worker.stores.layout import PERIODS, SPEED, Columns, Variable
from worker.stores.table import Column, Table

# A special point that Newton's method finds from a curve beside it lies on it. At a fold its departure is known to the
# root of rounding.
_SAME, _NEAR = 1e-8, 1e-5
# Next to a graze a curve that is seen from +beta stalls. A piece so short, as a part of the window, and so near to a
# longer one of its kind and orbit is a part of that.
_SHORT, _BESIDE = 0.1, 2e-3
# A point that lies further from the polyline of a curve, as a part of the window, is not on it.
_LINE_REACH = 0.05
# So near to a point of codimension two, as a part of the window, a curve ends in it.
_AT_END = 1e-3
# More points of a curve than that follow the corrector's errors.
_MOST_POINTS = 300
# Regular departures that are named.
_NAMED = 16
_NOTHING = np.empty((2, 0))
_QUIET, _CHAOTIC = PERMANENT_CONTACT_ATTRACTOR.name, AttractorKind.CHAOTIC.name.lower()
_KINDS, _POINTS = tuple(SpecialKind), tuple(CodimensionTwo)
_LEAVING = SpecialKind.SADDLE_NODE, SpecialKind.PERIOD_DOUBLING
_SAYS = {
    SpecialKind.SADDLE_NODE: "Two orbits {orbit} are born here, one of them a saddle.",
    SpecialKind.PERIOD_DOUBLING: "{orbit} gains or loses an orbit of twice its length here, and changes its stability.",
    SpecialKind.GRAZING: "{orbit} begins to touch the wall -beta here.",
    SpecialKind.CONTACT_LOSS: "{orbit} loses a contact with +beta here: its impact has no speed.",
    SpecialKind.UPPER_GRAZING: "{orbit} begins to touch +beta between two contacts here.",
    SpecialKind.RELEASE: "{orbit} begins or ceases to rest here.",
}
_PERSISTS = " It goes on with one impact more."
_FOLDS = " It meets an orbit that hits, and both vanish."
_BOTH = (
    " On one part of the curve it goes on with one impact more. On the dashed part it meets an orbit that hits, and "
    "both vanish."
)
_EXPLAINS = {
    CodimensionTwo.CUSP: "Two curves of saddle-nodes meet: on one side of it there are three orbits {orbit}, on the "
    "other side one.",
    CodimensionTwo.GENERALISED_DOUBLING: "The doubling of {orbit} changes here: on one side the longer orbit attracts "
    "and takes over, on the other it is a saddle and the motion leaves.",
    CodimensionTwo.SADDLE_NODE_GRAZE: "{orbit} and its twin are born just as they touch -beta.",
    CodimensionTwo.DOUBLING_GRAZE: "{orbit} doubles just as it touches -beta.",
    CodimensionTwo.NEUTRAL_GRAZE: "Along this graze {orbit} goes on with one impact more on one side of this point. "
    "On the other side it meets an orbit that hits, and both vanish.",
    CodimensionTwo.RESONANT_GRAZE: "The multipliers of {orbit} have the angle {turns}/{order} pi as it touches -beta: "
    "a slow impact has no leading effect after {order} turns.",
    CodimensionTwo.DOUBLE_GRAZE: "Two flights of {orbit} touch -beta at once.",
}
_COLOURS = {
    SpecialKind.SADDLE_NODE: "#1f4fd8", SpecialKind.PERIOD_DOUBLING: "#b3261e", SpecialKind.GRAZING: "#111111",
    SpecialKind.CONTACT_LOSS: "#7a5c00", SpecialKind.UPPER_GRAZING: "#6b3fa0", SpecialKind.RELEASE: "#00695c",
}  # fmt: skip
_MARKERS = {
    CodimensionTwo.CUSP: "v", CodimensionTwo.GENERALISED_DOUBLING: "D", CodimensionTwo.SADDLE_NODE_GRAZE: "o",
    CodimensionTwo.DOUBLING_GRAZE: "s", CodimensionTwo.NEUTRAL_GRAZE: "*", CodimensionTwo.RESONANT_GRAZE: "P",
    CodimensionTwo.DOUBLE_GRAZE: "X",
}  # fmt: skip


class ChartCurve(NamedTuple):
    """A curve of a chart: of one kind of special point, of one orbit."""

    kind: SpecialKind
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    first: np.ndarray
    second: np.ndarray
    t: np.ndarray
    v: np.ndarray
    residual: np.ndarray
    response: np.ndarray
    ends: tuple[str, str]

    @property
    def orbit(self) -> str:
        """Itinerary of its orbit; a flight that grazes is not counted."""
        return orbit_name(self.forcing_periods, self.upper_contacts, self.lower_contacts)

    @property
    def drawn(self) -> list[tuple[str, np.ndarray]]:
        """Its parts, each with what it is in words and a mask of its points; neighbours share one."""
        what = f"{self.kind.value} of {self.orbit}"
        folds = self.response < 0.0
        beside = folds.copy()
        beside[:-1] |= folds[1:]
        beside[1:] |= folds[:-1]
        return [(label, mask) for label, mask in ((what, ~folds), (f"folding {what}", beside)) if mask.any()]

    @property
    def says(self) -> str:
        """What happens along it, in a sentence or two."""
        folds = self.response < 0.0
        grazes = _FOLDS if folds.all() else _BOTH if folds.any() else _PERSISTS
        after = grazes if self.kind == SpecialKind.GRAZING else ""
        return _SAYS[self.kind].format(orbit=self.orbit) + after


_LINE, _SIZE = "curve_point", {"sample_dimension": "curve_point"}


@cache
def curve_table(first: str, second: str) -> Table:
    """Table of the curves in two parameters."""
    return Table("curve", (
        Column(
            "curve_kind", int8, "what happens along it", lambda curve: _KINDS.index(curve.kind) + 1,
            flags_of_words(_KINDS), fill=0,
        ),
        Column("curve_forcing_periods", int32, "m of its orbit P(m, n+, n-)"),
        Column("curve_upper_contacts", int32, "n+ of its orbit"),
        Column("curve_lower_contacts", int32, "n- of its orbit; a flight that grazes is not counted"),
        Column("curve_size", int64, "points of a curve, which follow those of the one before", "t.size", _SIZE),
        Column("curve_end", str, "why it ends at its first and at its last point", "ends", dims={"curve_side": 2}),
        Column(f"curve_{first}", float64, "value of the first parameter", "first", along=_LINE),
        Column(f"curve_{second}", float64, "value of the second parameter", "second", along=_LINE),
        Column("curve_time", float64, "phase of the first departure", "t", PERIODS, along=_LINE),
        Column("curve_velocity", float64, "its speed, 0 for contact loss", "v", SPEED, along=_LINE),
        Column("curve_residual", float64, "what is left of the equations", along=_LINE),
        Column(
            "curve_response", float64, "N_12/det(I - N) of a graze: above 0 its orbit persists, below it folds",
            along=_LINE,
        ),
    ), prefix="curve_")  # fmt: skip


@cache
def point_table(first: str, second: str) -> Table:
    """Table of the points of codimension two in two parameters."""
    return Table("point", (
        Column(
            "point_kind", int8, "what happens there", lambda point: _POINTS.index(point.kind) + 1,
            flags_of_words(_POINTS), fill=0,
        ),
        Column("point_order", int32, "p of a resonant graze, else 1"),
        Column("point_turns", int32, "k of a resonant graze, whose multipliers have the angle k pi/p; else 0"),
        Column(f"point_{first}", float64, "value of the first parameter", lambda point: point.values[0]),
        Column(f"point_{second}", float64, "value of the second parameter", lambda point: point.values[1]),
        Column("point_forcing_periods", int32, "m of its orbit P(m, n+, n-)"),
        Column("point_upper_contacts", int32, "n+ of its orbit"),
        Column("point_lower_contacts", int32, "n- of its orbit; a flight that grazes is not counted"),
        Column("point_residual", float64, "what is left of the equations"),
        Column("point_error", float64, "how far it may be off along its curve, in scaled unknowns"),
        Column("point_time", float64, "phases of departures, NaN-padded", "t", PERIODS, {"point_departure": 0}),
        Column("point_velocity", float64, "speeds of departures, NaN-padded", "v", SPEED, {"point_departure": 0}),
        Column(
            "point_multiplier_real", float64, "eigenvalues of DP^p, real part", "multipliers.real",
            dims={"multiplier": 2}, fill=np.nan,
        ),
        Column(
            "point_multiplier_imaginary", float64, "eigenvalues of DP^p, imaginary part", "multipliers.imag",
            dims={"multiplier": 2}, fill=np.nan,
        ),
    ), prefix="point_", length="point_upper_contacts")  # fmt: skip


class ChartCurveView(BaseModel):
    """A curve of a chart."""

    kind: str = Field(description="What happens along it", examples=["grazing"])
    orbit: str = Field(description="Itinerary of its orbit; a flight that grazes is not counted")
    points: int
    first: tuple[float, float] = Field(description="Least and greatest value of the first parameter")
    second: tuple[float, float]
    ends: tuple[str, str] = Field(description="Why it ends, in words")
    residual: float = Field(description="Largest of what is left of its equations")
    says: str = Field(description="What happens along it, in a sentence")


class ChartPointView(BaseModel):
    """A point of codimension two."""

    kind: str = Field(examples=["neutral graze"])
    order: int = Field(description="p of a resonant graze; else 1")
    turns: int = Field(description="k of a resonant graze, whose multipliers have the angle k pi/p; else 0")
    values: tuple[float, float] = Field(description="Of the two parameters")
    orbit: str
    residual: float
    error: float
    says: str = Field(description="What happens there, in a sentence or two")


class RegionView(BaseModel):
    """Machines of which most departures that do not fall quiet end in the same motion."""

    motion: str = Field(description="Its name; permanent contact where all fall quiet", examples=["P(1,1,0)"])
    share: float = Field(description="Of the machines of the chart")


class ChartView(AnalysisView):
    """Summary of a chart; the points of curves, and what machines do, are in the store."""

    kind: Literal["chart"]
    parameters: tuple[Parameter, Parameter]
    curves: list[ChartCurveView]
    points: list[ChartPointView]
    regions: list[RegionView] = Field(description="The largest first; of machines that are followed")
    lines_without_orbits: int = Field(description="Lines along which no orbit was found, so that they tell nothing")


def search_line(
    oscillator: Oscillator, along: ChartAxis, longest: int, region: Region, cells: int, *, pause: Pause
) -> Columns:
    """Special points of the orbits that are found at some machines of a line."""
    found: list[tuple[SpecialPoint, int]] = []
    orbits = 0
    for value in along.middles(STARTS).tolist():
        try:
            here = check_oscillator(oscillator.at(**{along.parameter: value}))
        except OutsideDomain:
            continue
        for each in find_orbits(here, longest, region.time.ends, region.velocity.ends, cells, pause=pause):
            orbits += 1
            branch = continue_orbit(here, each.orbit, along.parameter, along.ends, pause=pause)
            found += [(point, 0) for point in branch.special_points if not point.oscillator.is_loose]
    points, _ = distinct(found)
    return SPECIALS.of(points) | {"line_orbits": np.array([orbits], np.int64)}


def trace(point: SpecialPoint, along: ChartAxis, across: ChartAxis, turned: bool, *, pause: Pause) -> Columns:
    """Curve of a special point, the points of codimension two on it, and the curves that leave these.

    `turned` says that the point was found along the second parameter of the chart.
    """
    curve = continue_special_point(point, across.parameter, along.ends, across.ends, _MOST_POINTS, pause=pause)
    points = codimension_two_points(point, curve, pause)
    orbit = point.forcing_periods, point.upper_contacts, point.lower_contacts
    widths = np.array([along.stop - along.start, across.stop - across.start])
    curves = [_chart_curve(_ended(curve, points, widths), orbit, point.oscillator, turned)]
    for each in points:
        if (
            each.kind in (CodimensionTwo.NEUTRAL_GRAZE, CodimensionTwo.RESONANT_GRAZE)
            and each.oscillator.stiffness == np.inf
        ):
            turns = each.order
            orbit = turns * each.forcing_periods, turns * each.upper_contacts, turns * each.lower_contacts + 1
            leaving = (curve_beside_graze(each, kind, along.ends, across.ends, pause=pause) for kind in _LEAVING)
            curves += [_chart_curve(one, orbit, each.oscillator, turned) for one in leaving if one is not None]
    names = (across.parameter, along.parameter) if turned else (along.parameter, across.parameter)
    inside = [each for each in points if _inside(each, along, across)]
    straight = [each._replace(values=each.values[::-1]) if turned else each for each in inside]
    return curve_table(*names).of(curves) | point_table(*names).of(straight)


def _ended(curve: SpecialCurve, points: Sequence[CodimensionTwoPoint], widths: np.ndarray) -> SpecialCurve:
    """A curve that stalls beside a point of codimension two, up to that point.

    The map is not smooth there, and the last points that were found before it are known less well than it is.
    """
    for last in (False, True):
        for point in points:
            away = np.abs((curve.values - point.values) / widths).max(axis=1)
            if away[-1 if last else 0] > _AT_END:
                continue
            kept, why = away > _AT_END, f"the {point.kind} that it leads to"
            ends = (curve.ends[0], why) if last else (why, curve.ends[1])
            values, t, v, residual = (
                np.concatenate([field[kept], [end]] if last else [[end], field[kept]])
                for field, end in (
                    (curve.values, np.array(point.values)), (curve.t, point.t[0]), (curve.v, point.v[0]),
                    (curve.residual, point.residual),
                )
            )  # fmt: skip
            curve = curve._replace(values=values, t=t, v=v, residual=residual, ends=ends)
            break
    return curve


def _inside(point: CodimensionTwoPoint, along: ChartAxis, across: ChartAxis) -> bool:
    return along.start <= point.values[0] <= along.stop and across.start <= point.values[1] <= across.stop


def _chart_curve(curve: SpecialCurve, orbit: tuple[int, int, int], oscillator: Oscillator, turned: bool) -> ChartCurve:
    first, second = curve.values.T[::-1] if turned else curve.values.T
    response = _responses(curve, orbit, oscillator)
    return ChartCurve(curve.kind, *orbit, first, second, curve.t, curve.v, curve.residual, response, curve.ends)


def _responses(curve: SpecialCurve, orbit: tuple[int, int, int], oscillator: Oscillator) -> np.ndarray:
    """What decides at each point of a graze whether its orbit persists; NaN for others."""
    found = np.full(curve.t.size, np.nan)
    if curve.kind != SpecialKind.GRAZING:
        return found
    for i, (values, t, v) in enumerate(zip(curve.values.tolist(), curve.t.tolist(), curve.v.tolist(), strict=True)):
        here = oscillator.at(**dict(zip(curve.parameters, values, strict=True)))
        if math.isinf(here.stiffness) and not here.is_loose:
            turn = touch_monodromy(here, OrbitShape(orbit[0], orbit[1], 1), t, v)
            found[i] = np.nan if turn is None else graze_response(turn)
    return found


def map_row(
    oscillator: Oscillator, along: ChartAxis, pixels: int, departures: int, region: Region, *, pause: Pause
) -> Columns:
    """What the machines along a row do."""

    def machine(value: float) -> Oscillator | None:
        try:
            return check_oscillator(oscillator.at(**{along.parameter: value}))
        except OutsideDomain:
            return None

    return machines_of_row(list(map(machine, along.middles(pixels).tolist())), departures, region, pause=pause)


def machines_of_row(
    oscillators: Sequence[Oscillator | None], departures: int, region: Region, *, pause: Pause
) -> Columns:
    """Quiet share, largest exponent and usual motion of the machines of a row; none where one is not followed.

    Motions that few departures meet are followed along the row, both ways, from machine to machine.
    """
    count = len(oscillators)
    quiet, exponent, motion = np.full(count, np.nan), np.full(count, np.nan), [""] * count
    lasting = [_NOTHING] * count
    grid = CellGrid(*region.time.ends, departures, *region.velocity.ends, departures)
    centres = np.stack(np.meshgrid(grid.time_centres(), grid.velocity_centres())).reshape(2, -1)
    for order, own in ((range(count), centres), (range(count - 1, -1, -1), _NOTHING)):
        before = _NOTHING
        for i in order:
            pause()
            here = oscillators[i]
            if here is not None:
                seen = _follow(here, np.concatenate([own, lasting[i], before], axis=1), own.shape[1])
                exponent[i], lasting[i] = seen.exponent, seen.lasting
                quiet[i] = quiet[i] if np.isnan(seen.quiet) else seen.quiet
                motion[i] = seen.motion if motion[i] in ("", _QUIET) else motion[i]
            before = lasting[i]
    return {"quiet_share": quiet, "exponent": exponent, "motion": np.array(motion, str)}


class _Seen(NamedTuple):
    """What departures of a machine end in: arrays of lasting departures have the shape (2, n), phases and speeds."""

    quiet: float
    exponent: float
    motion: str
    lasting: np.ndarray


def _follow(oscillator: Oscillator, starts: np.ndarray, own: int) -> _Seen:
    """Follow departures, of which the first `own` count as a sample of the plane."""
    ends = next_impacts(oscillator, starts[0], starts[1], SETTLING, shortcuts=True)
    going = ends.outcome == Outcome.RETURNED
    t, v = wrap_all(ends.t[going]), ends.v[going]
    grown = tangent_growth(oscillator, t, v, GROWING)
    lasts, chaotic = np.isfinite(grown.growth), grown.growth > math.log(REGULAR_GROWTH * GROWING)
    regular = lasts & ~chaotic
    # Each regular motion once, and some departures of chaos.
    _, once, counts = np.unique(np.round([t[regular], v[regular]], 6), axis=1, return_index=True, return_counts=True)
    found = np.flatnonzero(regular)[once]
    exponents = [grown.of(chaotic).exponent] if chaotic.any() else []
    names = Counter({_CHAOTIC: int(chaotic.sum())} if chaotic.any() else {})
    for place, count in zip(found[:_NAMED].tolist(), counts.tolist(), strict=False):
        orbit = settled_orbit(oscillator, float(t[place]), float(v[place]))
        names[UNDECIDED_ATTRACTOR.name if orbit is None else attractor_of(orbit).name] += count
        exponents += [] if orbit is None else [orbit.lyapunov_exponent]
    motion = max(names, key=lambda name: names[name], default=_QUIET)
    kept = np.concatenate([found, np.flatnonzero(chaotic)])[:FOLLOWED]
    fell_quiet = ends.outcome == Outcome.PERMANENT_CONTACT
    fell_quiet[np.flatnonzero(going)[~lasts]] = True
    quiet = float(fell_quiet[:own].mean()) if own else np.nan
    return _Seen(quiet, max(exponents, default=np.nan), motion, np.stack([t[kept], v[kept]]))


def _lines(job: ChartJob) -> Iterator[tuple[str, Piece]]:
    """A search along each line: those of the first parameter, then those of the second."""
    for turned, (along, across) in enumerate(((job.first, job.second), (job.second, job.first))):
        for n, value in enumerate(across.middles(job.lines).tolist()):
            oscillator = job.oscillator.at(**{across.parameter: value})
            arguments = (oscillator, along, job.longest, job.region, job.cells)
            yield along.parameter, Piece(f"line-{turned}-{n:05d}", search_line, arguments)


def _specials(job: ChartJob, parts: Parts) -> list[tuple[SpecialPoint, bool]]:
    """Special points of all lines, and whether each was found along the second parameter."""
    points: list[tuple[SpecialPoint, bool]] = []
    for parameter, (name, _, (oscillator, *_)) in _lines(job):
        if name in parts:
            turned = parameter == job.second.parameter
            points += [(point, turned) for point in specials_of(parts[name], oscillator, parameter)]
    return points


def plan(job: ChartJob, parts: Parts) -> Plan:
    """Search all lines. Then trace every special point's curve, and compute the machines row by row."""
    searching = ready_of(Stage.SEARCHING, [piece for _, piece in _lines(job)], parts)
    if searching.done < searching.total:
        return searching
    tracing = _tracing(job, parts)
    if tracing.done < tracing.total:
        return tracing
    rows = [
        Piece(
            f"row-{n:05d}", map_row,
            (job.oscillator.at(**{job.second.parameter: second}), job.first, job.pixels, job.departures, job.region),
        )
        for n, second in enumerate(job.second.middles(job.pixels).tolist())
    ]  # fmt: skip
    return ready_of(Stage.MAPPING, rows, parts)


def _tracing(job: ChartJob, parts: Parts) -> Plan:
    """Trace of each kind and orbit the first special point that lies on no curve traced so far."""
    axes, names = (job.first, job.second), _parameters(job)
    points = _specials(job, parts)
    traced: dict[tuple[Any, ...], list[ChartCurve]] = {}
    ready: dict[tuple[Any, ...], Piece] = {}
    done = 0
    for n, (point, turned) in enumerate(points):
        name, alone = f"curve-{n:05d}", _point_curve(point, names)
        before = traced.setdefault(alone[:4], [])
        if name in parts:
            before.append(_curves_in(job, parts[name])[0])
        elif alone[:4] in ready:
            continue
        elif not any(_is_on(job, alone, 0, curve) for curve in before):
            arguments = (point, *(axes[::-1] if turned else axes), turned)
            ready[alone[:4]] = Piece(name, trace, arguments)
            continue
        done += 1
    return Plan(Stage.TRACING, tuple(ready.values()), done, len(points))


def _point_curve(point: SpecialPoint, parameters: tuple[str, str]) -> ChartCurve:
    """A special point as a curve of one point."""
    first, second = (np.array([point.oscillator.value_of(name)]) for name in parameters)
    orbit = point.forcing_periods, point.upper_contacts, point.lower_contacts
    unknown = np.array([np.nan])
    return ChartCurve(point.kind, *orbit, first, second, point.t[:1], point.v[:1], unknown, unknown, ("", ""))


def _parameters(job: ChartJob) -> tuple[str, str]:
    return job.first.parameter, job.second.parameter


def _curves_in(job: ChartJob, columns: Columns) -> list[ChartCurve]:
    first, second = _parameters(job)
    return [
        ChartCurve(
            _KINDS[row.kind - 1], row.forcing_periods, row.upper_contacts, row.lower_contacts,
            getattr(row, first), getattr(row, second), row.time, row.velocity, row.residual, row.response,
            (str(row.end[0]), str(row.end[1])),
        )
        for row in curve_table(first, second).rows(columns)
    ]  # fmt: skip


def _points_in(job: ChartJob, columns: Columns) -> list[ChartPointView]:
    first, second = _parameters(job)
    found = []
    for row in point_table(first, second).rows(columns):
        orbit = orbit_name(row.forcing_periods, row.upper_contacts, row.lower_contacts)
        kind = _POINTS[row.kind - 1]
        says = _EXPLAINS[kind].format(orbit=orbit, turns=row.turns, order=row.order)
        found.append(
            ChartPointView(
                kind=kind.value, order=row.order, turns=row.turns, values=(getattr(row, first), getattr(row, second)),
                orbit=orbit, residual=row.residual, error=row.error, says=says,
            )
        )  # fmt: skip
    return found


def _regions(columns: Columns) -> list[RegionView]:
    """Usual motions, with the part of the machines that is theirs."""
    counts = Counter(str(name) for name in columns["motion"].ravel() if name)
    return [RegionView(motion=name, share=count / counts.total()) for name, count in counts.most_common()]


def _places(job: ChartJob, curve: ChartCurve) -> np.ndarray:
    """Points of a curve in the window, shape (points, 2), which is 1 wide and 1 high."""
    low, high = np.array([job.first.ends, job.second.ends]).T
    placed: np.ndarray = (np.column_stack([curve.first, curve.second]) - low) / (high - low)
    return placed


def _reach(job: ChartJob, curve: ChartCurve) -> float:
    """How far a curve reaches, as a part of the window."""
    return float(np.ptp(_places(job, curve), axis=0).max())


def _lies_on(job: ChartJob, curve: ChartCurve, other: ChartCurve) -> bool:
    """Whether a curve is a part of another one of the same kind and orbit."""
    if curve[:4] != other[:4]:
        return False
    places, line = _places(job, curve), _places(job, other)
    if _reach(job, curve) < _SHORT:
        return bool(_from_line(places, line)[0].min(axis=1).max() < _BESIDE)
    middle = int(np.argmin(np.abs(places - 0.5 * (places.min(axis=0) + places.max(axis=0))).sum(axis=1)))
    return _is_on(job, curve, middle, other)


def _is_on(job: ChartJob, curve: ChartCurve, number: int, other: ChartCurve) -> bool:
    """Whether a point of a curve lies on another one of the same kind and orbit."""
    if other.t.size < 2:
        return False
    away, parts = _from_line(_places(job, curve)[number : number + 1], _places(job, other))
    piece = int(np.argmin(away[0]))
    if away[0, piece] > _LINE_REACH:
        return False
    part = float(parts[0, piece])
    turn = float(other.t[piece + 1] - other.t[piece])
    t = float(other.t[piece]) + part * (turn - round(turn))
    v = float(other.v[piece] + part * (other.v[piece + 1] - other.v[piece]))
    shape = OrbitShape(curve.forcing_periods, curve.upper_contacts, int(curve.kind == SpecialKind.GRAZING))
    here = dict(zip(_parameters(job), (float(curve.first[number]), float(curve.second[number])), strict=True))
    for name in here:
        found = point_near(curve.kind, job.oscillator.at(**here), name, shape, t, v)
        if found is None or abs(found.value - here[name]) > _SAME:
            continue
        apart = found.t - curve.t[number]
        # Which departure of an orbit comes first may differ.
        if (np.abs(apart - np.rint(apart)) + np.abs(found.v - curve.v[number])).min() < _NEAR:
            return True
    return False


def _from_line(places: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances of places from the pieces of a line through points, and at which part of each piece they are."""
    begin, along = line[:-1], np.diff(line, axis=0)
    length = np.maximum((along * along).sum(axis=1), np.finfo(float).tiny)
    part = np.clip(((places[:, None] - begin) * along).sum(axis=2) / length, 0.0, 1.0)
    return np.linalg.norm(places[:, None] - begin - part[..., None] * along, axis=2), part


def _distinct_points(points: Sequence[ChartPointView]) -> list[int]:
    """Places of points without repetitions."""
    kept: list[int] = []
    for place, point in enumerate(points):

        def same(other: ChartPointView, point: ChartPointView = point) -> bool:
            shapes = [(each.kind, each.order, each.turns, each.orbit) for each in (point, other)]
            apart = max(abs(one - two) for one, two in zip(point.values, other.values, strict=True))
            return shapes[0] == shapes[1] and apart < _SAME

        if not any(same(points[other]) for other in kept):
            kept.append(place)
    return kept


def assemble(job: ChartJob, parts: Parts) -> Columns:
    """Curves and points, each once, and the machines."""
    names = _parameters(job)
    traced = in_order(parts, "curve-")
    curves: list[ChartCurve] = []
    found = _curves_in(job, curve_table(*names).join(traced))
    for curve in sorted(found, key=lambda curve: _reach(job, curve), reverse=True):
        if not any(_lies_on(job, curve, other) for other in curves):
            curves.append(curve)
    points = point_table(*names).join(traced)
    kept = _distinct_points(_points_in(job, points))
    orbits = [int(part["line_orbits"][0]) for part in in_order(parts, "line-")]
    shape = job.pixels, job.pixels
    field = {name: np.full(shape, np.nan) for name in ("quiet_share", "exponent")} | {
        "motion": np.full(shape, "", object)
    }
    for n in range(job.pixels):
        name = f"row-{n:05d}"
        if name in parts:
            for array, values in field.items():
                values[n] = parts[name][array]
    return (
        curve_table(*names).of(curves)
        | {name: array[kept] for name, array in points.items()}
        | {"line_orbits": np.array(orbits, np.int64)}
        | {axis.parameter: axis.middles(job.pixels) for axis in (job.first, job.second)}
        | field
    )


def layout(job: ChartJob) -> tuple[Variable, ...]:
    """Variables of the store."""
    first, second = _parameters(job)
    plane = second, first
    return (
        *curve_table(first, second).variables,
        *point_table(first, second).variables,
        Variable("line_orbits", ("line",), int64, -1, "orbits found along a line, at all of its machines"),
        Variable(first, (first,), float64, np.nan, "value of the first parameter"),
        Variable(second, (second,), float64, np.nan, "value of the second parameter"),
        Variable(
            "quiet_share",
            plane,
            float64,
            np.nan,
            f"share of departures that fall quiet within {SETTLING + GROWING} impacts",
        ),
        Variable(
            "exponent",
            plane,
            float64,
            np.nan,
            "largest Lyapunov exponent per forcing period of what is met, also from neighbours",
        ),
        Variable("motion", plane, str, "", "motion that most departures end in which do not fall quiet"),
    )


def summarise(job: ChartJob, columns: Columns) -> dict[str, Any]:
    """Curves with how far they reach and why they end, and the points of codimension two."""
    first, second = _parameters(job)
    return {
        "parameters": (first, second),
        "curves": [
            ChartCurveView(
                kind=curve.kind.value, orbit=curve.orbit, points=curve.first.size, ends=curve.ends,
                first=(float(curve.first.min()), float(curve.first.max())),
                second=(float(curve.second.min()), float(curve.second.max())),
                residual=float(curve.residual.max()), says=curve.says,
            )
            for curve in _curves_in(job, columns)
        ],
        "points": _points_in(job, columns),
        "regions": _regions(columns),
        "lines_without_orbits": int((columns["line_orbits"] == 0).sum()),
    }  # fmt: skip


def plot_chart(axes: Axes, job: ChartJob, columns: Columns) -> None:
    """Draw curves and points over the largest exponent, or over the quiet share where no exponent is known."""
    first, second = _parameters(job)
    if job.pixels:
        finite = np.isfinite(columns["exponent"])
        known = bool(finite.any())
        shown = columns["exponent"] if known else columns["quiet_share"]
        limit = float(np.abs(columns["exponent"][finite]).max()) if known else 1.0
        image = axes.pcolormesh(
            columns[first], columns[second], shown, cmap="PuOr_r" if known else "viridis",
            vmin=-limit if known else 0.0, vmax=limit if known else 1.0, shading="nearest", rasterized=True,
        )  # fmt: skip
        label = "largest exponent per forcing period" if known else "quiet share"
        axes.figure.colorbar(image, ax=axes, label=label)
    listed = set()
    for curve in _curves_in(job, columns):
        for label, drawn in curve.drawn:
            axes.plot(
                np.where(drawn, curve.first, np.nan), np.where(drawn, curve.second, np.nan),
                color=_COLOURS[curve.kind], linewidth=1.2, linestyle="--" if label.startswith("folding") else "-",
                label="_nolegend_" if label in listed else label,
            )  # fmt: skip
            listed.add(label)
        _name_curve(axes, job, curve)
    for point in _points_in(job, columns):
        label = f"{point.kind}, {point.turns}/{point.order}" if point.order > 1 else point.kind
        axes.plot(
            *point.values, _MARKERS[CodimensionTwo(point.kind)], color="white", markeredgecolor="black", markersize=8,
            label="_nolegend_" if label in listed else label,
        )  # fmt: skip
        listed.add(label)
    axes.set_xlim(*job.first.ends)
    axes.set_ylim(*job.second.ends)
    axes.set_xlabel(in_words(first))
    axes.set_ylabel(in_words(second))


def _name_curve(axes: Axes, job: ChartJob, curve: ChartCurve) -> None:
    """Write the orbit beside a curve, nearer to its beginning the longer the orbit is, so that names lie apart."""
    places = _places(job, curve)
    height = places[:, 1] - places[:, 1].min()
    place = places[int(np.argmin(np.abs(height - np.ptp(height) / (1.0 + _length(curve)))))]
    axes.annotate(
        curve.orbit, tuple(place), (4, -2), xycoords="axes fraction", textcoords="offset points", va="top",
        fontsize="x-small", color=_COLOURS[curve.kind], path_effects=[withStroke(linewidth=2.0, foreground="white")],
    )  # fmt: skip


def _length(curve: ChartCurve) -> int:
    return curve.upper_contacts + curve.lower_contacts


def draw_chart(job: ChartJob, columns: Columns, figure: Figure) -> None:
    """Draw a chart with its key beside it."""
    figure.set_size_inches(10.0, 7.0)
    axes = figure.subplots()
    axes.set_title(oscillator_text(job.oscillator, _parameters(job)))
    plot_chart(axes, job, columns)
    if axes.get_legend_handles_labels()[1]:
        figure.legend(loc="outside lower left", ncols=3, frameon=False, fontsize="small")


CHART = Analysis(
    "Chart of two parameters of a rattling gear pair",
    ChartJob,
    plan,
    assemble,
    layout,
    summarise,
    ChartView,
    draw_chart,
)
