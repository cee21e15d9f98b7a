"""Bifurcation diagrams as an analysis: one chain of stretches per seed, all chains in parallel.

A stretch begins where the previous one ended, so the stretches of a chain run one after another. If no seed is given,
the attractors at the first value are found, and each becomes a seed.
"""

from dataclasses import astuple
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.path import Path
from pydantic import BaseModel, Field

from rattle_kernels import AttractorKind, Oscillator, Outcome, find_attractors
from rattle_kernels.attractors.seeds import choose_seeds
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.orbits.bifurcation_diagram import Motions, follow_values
from worker.analyses.analysis import Analysis, AnalysisView, Parts, Piece, Plan
from worker.errors import NotFound
from worker.jobs.bifurcation_job import SETTLING, STARTS, BifurcationJob, Direction
from worker.jobs.region import Region
from worker.jobs.swept_parameter import Parameter
from worker.pictures.colours import paints_of_names
from worker.pictures.symbols import in_words, oscillator_text
from worker.progress import Stage
from worker.results.motion_names import MOST_NAMED, NO_PERIOD, motion_names
from worker.stores.layout import MISSING, PERIODS, SPEED, Columns, Variable, flags

# Applications of P in a stretch, about two seconds.
_APPLICATIONS = 1_000_000
# Most stretches per seed in the summary. A diagram through chaos has thousands.
_MOST_STRETCHES = 200
# Motions in the legend of a picture.
_LISTED = 12
# Dots, and where colours come again, strokes up, strokes down and dashes: as in the page's diagrams.
_MARKS = (".", Path([(-1, -1), (1, 1)]), Path([(-1, 1), (1, -1)]), Path([(-1, 0), (1, 0)]))
_SIZES = (1.2, 2.0, 2.0, 2.0)


class StretchView(BaseModel):
    """Neighbouring values at which a motion stays of one kind."""

    what: str = Field(examples=["impact period 2"])
    way: Literal["up", "down"]
    start: float
    stop: float
    values: int


class MotionView(BaseModel):
    """One motion along the parameter."""

    name: str = Field(description="Attractor at the first value visited, or given", examples=["P(1,2,0)"])
    time: float = Field(description="Phase of the departure that it began with")
    velocity: float
    stretches: list[StretchView] = Field(description="In the order of visits; the first 200")
    stretches_total: int


class BifurcationView(AnalysisView):
    """Summary of a bifurcation diagram."""

    kind: Literal["bifurcation"]
    parameter: Parameter
    values_visited: int
    motions: list[MotionView]


def find_seeds(oscillator: Oscillator, region: Region, *, pause: Pause) -> Columns:
    """One departure of each attractor, except permanent contact, that motions from a region end in.

    Raises
    ------
    NotFound
        If all motions become quiet.
    """
    middles = (np.arange(STARTS) + 0.5) / STARTS
    t, v = np.meshgrid(
        *(axis.start + (axis.stop - axis.start) * middles for axis in (region.time, region.velocity)),
    )
    landed, _ = run_lanes(oscillator, t.ravel(), v.ravel(), SETTLING, shortcuts=False, pause=pause)
    seeds = choose_seeds(oscillator, landed.t, landed.v)
    found = find_attractors(oscillator, seeds.time, seeds.velocity, pause=pause)
    moving = [each for each in found if each.kind == AttractorKind.PERIODIC or each.is_chaotic]
    if not moving:
        raise NotFound(
            f"all motions from v = {region.velocity.start:g} to {region.velocity.stop:g} end in permanent contact at "
            f"the first value visited, {_written(oscillator)}: give seeds, another region, or another direction"
        )
    return {
        "seed_time": np.array([each.time[0] for each in moving]),
        "seed_velocity": np.array([each.velocity[0] for each in moving]),
        "seed_name": np.array([each.name for each in moving]),
    }


def _written(oscillator: Oscillator) -> str:
    """Parameters of an oscillator in a sentence; those that are infinite say nothing."""
    values = {name: oscillator.value_of(name) for name in oscillator.parameters}
    return ", ".join(f"{name.replace('_', ' ')} {value:g}" for name, value in values.items() if np.isfinite(value))


def follow_stretch(
    oscillator: Oscillator, parameter: str, values: np.ndarray, motions: Motions, transient: int, kept: int,
    *, pause: Pause,
) -> Columns:  # fmt: skip
    """One stretch of one chain, and the state of the motion at its end."""
    run, motions = follow_values(oscillator, parameter, values, motions, transient, kept, pause=pause)
    columns = {
        name: getattr(run, field)[:, 0]
        for name, field in (("time", "t"), ("velocity", "v"), ("outcome", "outcome"), ("impact_period", "period"))
    }
    return columns | {f"left_{name}": values for name, values in motions._asdict().items()}


def _seeds(job: BifurcationJob, parts: Parts) -> Columns:
    if not job.seeds:
        return parts["seeds"] if "seeds" in parts else {name: np.empty(0) for name in _SEED_COLUMNS}
    t, v = np.array([astuple(seed) for seed in job.seeds]).T
    return {"seed_time": t, "seed_velocity": v, "seed_name": np.full(t.size, "given")}


def _starts(job: BifurcationJob) -> list[int]:
    """Index of the first visit of each stretch."""
    return list(range(0, job.visits.size, max(1, _APPLICATIONS // (job.transient + job.kept))))


def _name(seed: int, stretch: int) -> str:
    return f"seed-{seed:03d}-stretch-{stretch:05d}"


def plan(job: BifurcationJob, parts: Parts) -> Plan:
    """Find seeds if none are given. Then follow the next stretch of every chain."""
    seeds = _seeds(job, parts)
    if not seeds["seed_time"].size:
        return Plan(
            Stage.SEARCHING, (Piece("seeds", find_seeds, (job.oscillator_at(job.visits[0]), job.region)),), 0, 1
        )
    starts, ready, done = _starts(job), [], 0
    for seed in range(seeds["seed_time"].size):
        reached = next((n for n in range(len(starts)) if _name(seed, n) not in parts), len(starts))
        done += reached
        if reached < len(starts):
            ready.append(_stretch(job, parts, seeds, seed, reached, starts))
    return Plan(Stage.SETTLING, tuple(ready), done, len(starts) * seeds["seed_time"].size)


def _stretch(job: BifurcationJob, parts: Parts, seeds: Columns, seed: int, number: int, starts: list[int]) -> Piece:
    motions = Motions.from_seeds(seeds["seed_time"][seed], seeds["seed_velocity"][seed])
    if number:
        before = parts[_name(seed, number - 1)]
        motions = Motions(*(before[f"left_{name}"] for name in Motions._fields))
    values = job.visits[starts[number] : (starts + [job.visits.size])[number + 1]]
    arguments = job.oscillator, job.vary.parameter, values, motions, job.transient, job.kept
    return Piece(_name(seed, number), follow_stretch, arguments)


_SEED_COLUMNS = ("seed_time", "seed_velocity", "seed_name")


def assemble(job: BifurcationJob, parts: Parts) -> Columns:
    """The diagram. Values that are not computed yet have the outcome MISSING."""
    seeds = _seeds(job, parts)
    visits, starts, count = job.visits, _starts(job), seeds["seed_time"].size
    columns = {
        "time": np.full((visits.size, count, job.kept), np.nan),
        "velocity": np.full((visits.size, count, job.kept), np.nan),
        "outcome": np.full((visits.size, count), MISSING, np.int8),
        "impact_period": np.full((visits.size, count), MISSING, np.int16),
    }
    for seed in range(count):
        for number, start in enumerate(starts):
            if _name(seed, number) in parts:
                part = parts[_name(seed, number)]
                for name, column in columns.items():
                    column[start : start + part[name].shape[0], seed] = part[name]
    up = visits.size if job.direction == "up" else 0 if job.direction == "down" else visits.size // 2
    ways = np.where(np.arange(visits.size) < up, 1, -1)
    return columns | seeds | {job.vary.parameter: visits, "way": ways}


def layout(job: BifurcationJob) -> tuple[Variable, ...]:
    """Variables of the store: departures by visit and seed."""
    kept, each, seed = ("visit", "seed", "kept"), ("visit", "seed"), ("seed",)
    return (
        Variable(job.vary.parameter, ("visit",), np.float64, np.inf, "value of the parameter at each visit"),
        Variable(
            "way", ("visit",), np.int8, 0, "which way the parameter changes",
            {"flag_values": [1, -1], "flag_meanings": "up down"},
        ),
        Variable("time", kept, np.float64, np.nan, "phases of the last departures, NaN where none", PERIODS),
        Variable("velocity", kept, np.float64, np.nan, "speeds of the last departures, NaN where none", SPEED),
        Variable("outcome", each, np.int8, MISSING, f"how the motion goes on; {MISSING}: not computed", flags(Outcome)),
        Variable(
            "impact_period", each, np.int16, MISSING,
            f"impacts after which the motion repeats itself, 0 where that is not seen; {MISSING}: not computed",
        ),
        Variable("seed_time", seed, np.float64, np.inf, "phase of the departure that each motion began with", PERIODS),
        Variable("seed_velocity", seed, np.float64, np.inf, "its speed", SPEED),
        Variable("seed_name", seed, str, "", "attractor found there, or given"),
    )  # fmt: skip


def _describe(outcome: int, period: int) -> str:
    if outcome == MISSING:
        return "not computed"
    if outcome != Outcome.RETURNED:
        return Outcome(outcome).name.lower().replace("_", " ")
    return f"impact period {period}" if period else "no period seen"


def _stretches(values: np.ndarray, ways: np.ndarray, outcome: np.ndarray, period: np.ndarray) -> list[StretchView]:
    """Runs of values over which a motion keeps its kind."""
    changes = np.flatnonzero((np.diff(outcome) != 0) | (np.diff(period) != 0) | (np.diff(ways) != 0)) + 1
    bounds = [0, *changes.tolist(), values.size]
    return [
        StretchView(
            what=_describe(int(outcome[a]), int(period[a])), way="up" if ways[a] > 0 else "down",
            start=float(values[a]), stop=float(values[b - 1]), values=b - a,
        )
        for a, b in zip(bounds[:-1], bounds[1:], strict=True)
    ]  # fmt: skip


def summarise(job: BifurcationJob, columns: Columns) -> dict[str, Any]:
    """Kinds of each motion along the parameter."""
    motions = []
    for seed in range(columns["seed_time"].size):
        runs = _stretches(
            columns[job.vary.parameter], columns["way"], columns["outcome"][:, seed], columns["impact_period"][:, seed]
        )
        motions.append(
            MotionView(
                name=str(columns["seed_name"][seed]), time=float(columns["seed_time"][seed]),
                velocity=float(columns["seed_velocity"][seed]), stretches=runs[:_MOST_STRETCHES],
                stretches_total=len(runs),
            )
        )  # fmt: skip
    return {"parameter": job.vary.parameter, "values_visited": int(job.visits.size), "motions": motions}


def names_of(job: BifurcationJob, columns: Columns) -> np.ndarray:
    """Name of the motion at each visit of each seed; of very many motions only how many impacts they have.

    Parameters
    ----------
    job : BifurcationJob
    columns : mapping of str to ndarray
        Of its store.

    Returns
    -------
    ndarray of str, shape (visits, seeds)
        Empty where nothing is computed.
    """
    shape = columns["outcome"].shape
    if columns["outcome"].size <= MOST_NAMED:
        return np.array(motion_names(job, columns), dtype=object).reshape(shape)
    periods = columns["impact_period"].ravel().tolist()
    named = [f"repeats after {n} impact{'s' if n > 1 else ''}" if n > 0 else NO_PERIOD for n in periods]
    return np.array(named, dtype=object).reshape(shape)


def _in_key(job: BifurcationJob, name: str) -> str:
    return f"no period within {job.kept // 2} impacts: chaos, or longer" if name == NO_PERIOD else name


def plot_diagram(axes: Axes, job: BifurcationJob, columns: Columns) -> None:
    """Draw a diagram on axes, each departure in the colour of the motion that it belongs to."""
    parameter = job.vary.parameter
    values, speeds = columns[parameter], columns["velocity"]
    at = np.broadcast_to(values[:, None, None], speeds.shape)
    names = np.broadcast_to(names_of(job, columns)[..., None], speeds.shape)[np.isfinite(speeds)]
    at, speeds = at[np.isfinite(speeds)], speeds[np.isfinite(speeds)]
    there, counts = np.unique(names[names != ""].astype(str), return_counts=True)
    paints = paints_of_names(there.tolist())
    # What there is less of lies on top.
    for place, name in enumerate(there[np.argsort(-counts, kind="stable")].tolist()):
        colour, texture = paints[name]
        listed = _in_key(job, name) if place < _LISTED else None
        axes.plot(
            at[names == name], speeds[names == name], linestyle="none", marker=_MARKS[texture], color=colour,
            markersize=_SIZES[texture], label=listed,
        )  # fmt: skip
    if len(there) > _LISTED:
        axes.plot([], [], linestyle="none", label=f"and {len(there) - _LISTED} more")
    axes.set_xlabel(in_words(parameter))
    axes.set_ylabel("velocity v of departure")
    axes.set_xlim(values.min(), values.max() if values.max() > values.min() else values.min() + 1e-6)


def draw_diagram(job: BifurcationJob, columns: Columns, figure: Figure) -> None:
    """Draw a diagram with title and legend."""
    axes = figure.subplots()
    plot_diagram(axes, job, columns)
    title = oscillator_text(job.oscillator, without=(job.vary.parameter,))
    if (columns["outcome"] == MISSING).any() or not columns["seed_time"].size:
        title += "; incomplete"
    ways = {Direction.UP: "upwards", Direction.DOWN: "downwards", Direction.BOTH: "upwards, then downwards"}
    axes.set_title(f"{title}; {ways[job.direction]}")
    if axes.lines:
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, markerscale=6, borderaxespad=0.0)


BIFURCATION = Analysis(
    "Bifurcation diagram of a rattling gear pair",
    BifurcationJob,
    plan,
    assemble,
    layout,
    summarise,
    BifurcationView,
    draw_diagram,
)
