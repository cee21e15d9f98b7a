"""How chaos ends: two crises, located by tangencies of manifolds, and a birth inside chaos, beside measured lives."""

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import (
    CurveResolution,
    ManifoldBranch,
    ManifoldLimits,
    Oscillator,
    Outcome,
    SpecialKind,
    Tangency,
    continue_orbit,
    find_saddle,
    find_tangency,
    follow_tangency,
    manifold_tips,
    next_impacts,
    stable_manifold,
    unstable_manifold,
)
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.orbits import the_orbit, the_point

_LARGE = Oscillator(damping=0.528, eccentricity=0.1, half_backlash=0.6)
_SMALL = Oscillator(damping=0.762, eccentricity=0.0972, half_backlash=0.6)
_BORN = Oscillator(damping=0.65, eccentricity=0.1, half_backlash=0.6)
_SIDES = {"before": 0.5285, "beyond": 0.527}
_LIMITS, _RESOLUTION = ManifoldLimits(arclength=1.5), CurveResolution(2e-3, 0.05, 1e-5)
# Of each transient so many motions are followed, at most so many impacts in all.
_MOTIONS, _IMPACTS = 400, 6e8
# Beside a motion of three impacts a motion stays so near for so many of its turns, or it is in chaos.
_BESIDE, _TURNS = 0.02, 20


class _Event(NamedTuple):
    """An end of chaos: a parameter's value, from which on the other way motions leave; where they start."""

    oscillator: Oscillator
    parameter: str
    value: float
    sign: float
    distances: tuple[float, ...]
    time: tuple[float, float]
    velocity: tuple[float, float]
    leaves: Callable[[Oscillator, np.ndarray, np.ndarray], np.ndarray]


def _cycles(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> np.ndarray:
    stays = np.ones(t.size, np.bool_)
    for _ in range(_TURNS):
        after = next_impacts(oscillator, t, v, 3)
        turn = after.t - t
        stays &= (np.abs(after.v - v) < _BESIDE) & (np.abs(turn - np.rint(turn)) < _BESIDE)
        t, v = after.t, after.v
    return stays


def _stays(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.zeros(t.size, np.bool_)


@cache
def _crisis() -> Tangency:
    """Of the chaos of Fig. 12: the first tip of P(3,3,3) meets the stable manifold of the P(3,3,2) beside the sink."""
    touching = find_saddle(_LARGE, 0.7924564435, 4.1891587831, 3)
    bounding = find_saddle(_LARGE, 0.6882465292, 4.0243343365, 3)
    (tip,) = manifold_tips(_LARGE, touching, only=(0, 1))
    return find_tangency(_LARGE, touching, tip, bounding, "damping", (0.5275, 0.5285))


@cache
def homoclinic_crisis() -> Tangency:
    """Of the small chaos of the sequel: P(1,1,0) meets itself."""
    saddle = find_saddle(_SMALL, 0.7302, 4.7878)
    return find_tangency(_SMALL, saddle, manifold_tips(_SMALL, saddle)[0], saddle, "eccentricity", (0.0971, 0.0976))


@cache
def _birth() -> float:
    """Damping at which P(3,3,1) is born with a saddle at a graze."""
    orbit = the_orbit(_BORN, "P(3,3,1)", attracts=True)
    points = continue_orbit(_BORN, orbit, "damping", (0.64, 0.651)).special_points
    return the_point(points, SpecialKind.GRAZING).value


def _events() -> dict[str, _Event]:
    crisis, homoclinic = _crisis(), homoclinic_crisis()
    return {
        "tip of P(3,3,3) on P(3,3,2), at 0.52788": _Event(
            crisis.oscillator, "damping", crisis.value, -1.0, (1.5e-5, 3e-5, 5e-5, 1e-4, 2e-4),
            (0.0, 1.0), (3.9, 4.7), _cycles,
        ),
        "P(1,1,0) on itself, at 0.097422": _Event(
            homoclinic.oscillator, "eccentricity", homoclinic.value, 1.0, (3e-7, 1e-6, 3e-6, 1e-5, 3e-5, 1e-4),
            (0.715, 0.76), (4.75, 4.9), _stays,
        ),
        "birth of P(3,3,1), at 0.64984": _Event(
            _BORN, "damping", _birth(), 1.0, (1e-5, 2e-5, 5e-5, 1e-4, 2e-4), (0.0, 1.0), (4.0, 4.9), _cycles,
        ),
    }  # fmt: skip


def _mean_life(event: _Event, distance: float, impacts: float) -> tuple[float | None, int]:
    """Impacts a motion stays in chaos, on average, and how many left it of those that were followed."""
    oscillator = event.oscillator.at(**{event.parameter: event.value + event.sign * distance})
    n = np.arange(60 * _MOTIONS)
    # Scattered as Kronecker's sequence.
    t = event.time[0] + (event.time[1] - event.time[0]) * ((n * 0.7548776662466927) % 1.0)
    v = event.velocity[0] + (event.velocity[1] - event.velocity[0]) * ((n * 0.5698402909980532) % 1.0)

    def on(t: np.ndarray, v: np.ndarray, impacts: int) -> tuple[np.ndarray, np.ndarray]:
        landed = next_impacts(oscillator, t, v, impacts, shortcuts=True)
        going = landed.outcome == Outcome.RETURNED
        t, v = landed.t[going], landed.v[going]
        stays = ~event.leaves(oscillator, t, v)
        return t[stays], v[stays]

    t, v = on(t, v, 300)
    t, v = t[:_MOTIONS], v[:_MOTIONS]
    begun, followed, leg = t.size, 0.0, 16
    while t.size > begun // 4 and followed < impacts:
        before = t.size
        t, v = on(t, v, leg)
        followed += leg * 0.5 * (before + t.size)
        # Legs lengthen until a part of the motions leaves in each.
        leg = min(2 * leg, 16_000) if before - t.size < begun // 40 else leg
    left = begun - t.size
    return (followed / left if left else None), left


def _lives(impacts: float) -> dict[str, list[dict[str, float | None]]]:
    found = {}
    for name, event in _events().items():
        rows = []
        for distance in event.distances:
            life, left = _mean_life(event, distance, impacts)
            rows.append({"distance": distance, "mean_life": life, "left": left})
        found[name] = rows
    return found


def _draw_branches(axes: Axes, branches: Sequence[ManifoldBranch], colour: str, label: str) -> None:
    for branch in branches:
        for t, v in branch.pieces:
            for turns in range(math.floor(t.min()), math.floor(t.max()) + 1):
                axes.plot(t - turns, v, color=colour, linewidth=1.0, label=label)
                label = "_nolegend_"


def _draw_side(axes: Axes, letter: str, name: str, damping: float) -> None:
    crisis = _crisis()
    values = np.linspace(crisis.value, damping, 9)
    oscillator, orbits = crisis.oscillator, [crisis.unstable, crisis.stable]
    for value in values[1:].tolist():
        oscillator = crisis.oscillator.at(damping=value)
        orbits = [find_saddle(oscillator, float(orbit.t[0]), float(orbit.v[0]), 3) for orbit in orbits]
    assert [orbit.name for orbit in orbits] == ["P(3,3,3)", "P(3,3,2)"], "steps are short enough for Newton's method"
    _draw_branches(axes, stable_manifold(oscillator, orbits[1], _LIMITS, _RESOLUTION), "#1f4fd8", "stable, of P(3,3,2)")
    _draw_branches(
        axes, unstable_manifold(oscillator, orbits[0], _LIMITS, _RESOLUTION), "#b3261e", "unstable, of P(3,3,3)"
    )
    (tip,) = manifold_tips(oscillator, orbits[0], only=(crisis.tip.point, crisis.tip.side))
    axes.plot(tip.t % 1.0, tip.v, "ko", markersize=4, label="its first tip")
    axes.set(xlim=(tip.t % 1.0 - 0.012, tip.t % 1.0 + 0.006), ylim=(tip.v - 0.03, tip.v + 0.03))
    axes.set(xlabel="t", ylabel="v")
    axes.set_title(f"({letter}) {name}, damping {damping:g}", fontsize="medium")
    axes.legend(loc="lower left", frameon=False, fontsize="small")


def _draw_lives(axes: Axes, lives: dict[str, list[dict[str, float | None]]]) -> None:
    for (name, rows), mark in zip(lives.items(), "os^", strict=True):
        known = [row for row in rows if row["left"]]
        distances = np.array([row["distance"] for row in known])
        seen = [row["mean_life"] for row in known]
        (line,) = axes.loglog(distances, seen, mark, label=name)
        power = homoclinic_crisis().exponent if name.startswith("P(1,1,0)") else 1.0
        axes.loglog(distances, seen[0] * (distances[0] / distances) ** power, color=line.get_color(), linewidth=0.8)
    axes.set(xlabel="distance beyond, in the parameter", ylabel="mean life in impacts")
    axes.set_title(
        f"(c) how long chaos lasts; lines of power 1, and {homoclinic_crisis().exponent:.3f}", fontsize="medium"
    )
    axes.legend(loc="lower left", frameon=False, fontsize="small")


def _draw_curve(axes: Axes, curve: Sequence[Tangency]) -> None:
    axes.plot(
        [each.value for each in curve], [each.oscillator.eccentricity for each in curve], color="black", linewidth=1.2
    )
    axes.plot(_crisis().value, _crisis().oscillator.eccentricity, "ko", markersize=4)
    axes.set(xlabel="damping", ylabel="eccentricity")
    axes.set_title("(d) where the tip of P(3,3,3) touches", fontsize="medium")


def _make(results: Results, report: Report) -> Sheet:
    report("locating tangencies", 0, 3)
    crisis, homoclinic = _crisis(), homoclinic_crisis()
    curve = [
        *follow_tangency(crisis, "eccentricity", 0.1 - 2e-4 * np.arange(1, 11))[::-1],
        crisis,
        *follow_tangency(crisis, "eccentricity", 0.1 + 2e-4 * np.arange(1, 11)),
    ]
    report("following chaos to its end", 1, 3)
    lives = _lives(_IMPACTS)
    report("drawing", 2, 3)
    drawing = Figure(figsize=(11.0, 9.0), dpi=80, layout="constrained")
    (before, beyond), (lasting, followed) = drawing.subplots(2, 2)
    for letter, axes, (name, damping) in zip("ab", (before, beyond), _SIDES.items(), strict=True):
        _draw_side(axes, letter, name, damping)
    _draw_lives(lasting, lives)
    _draw_curve(followed, curve)
    numbers: dict[str, Any] = {
        "crisis": _numbers(crisis), "homoclinic": _numbers(homoclinic), "birth": {"damping": _birth()}, "lives": lives,
        "curve": [[each.value, each.oscillator.eccentricity] for each in curve],
    }  # fmt: skip
    return Sheet(drawing, numbers)


def _numbers(tangency: Tangency) -> dict[str, Any]:
    return {
        tangency.parameter: tangency.value, "unstable": tangency.unstable.name, "stable": tangency.stable.name,
        "tip": [tangency.tip.t % 1.0, tangency.tip.v], "distance": tangency.gap.distance, "slope": tangency.slope,
        "multipliers": sorted(tangency.unstable.multipliers.real.tolist()), "exponent": tangency.exponent,
    }  # fmt: skip


CRISES = PaperFigure(
    "crises", "how chaos ends: manifolds beside their tangency, and how long chaos lasts beyond", _make
)
