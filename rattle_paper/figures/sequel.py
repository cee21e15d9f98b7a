"""The sequel of the paper (Mason and Piiroinen, 2009): two points, robust chaos between them, basins on both sides.

Only the abstract of the sequel could be read. What is drawn is what it speaks of; the numbers are this project's own,
beside those of docs/theory/grazing.md.
"""

from functools import cache
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle import BasinJob
from rattle.pictures import attractor_marks
from rattle_chart.analysis import plot_chart
from rattle_chart.job import ChartJob
from rattle_kernels import (
    AttractorBeyond,
    CellGrid,
    CodimensionTwo,
    GrazeKind,
    Oscillator,
    SpecialKind,
    SpecialPoint,
    Tangency,
    attractor_beyond,
    continue_orbit,
    find_attractors,
    follow_tangency,
    graze_kind,
)
from rattle_paper.figure import Job, PaperFigure, Report, Results, Sheet
from rattle_paper.figures.crises import homoclinic_crisis
from rattle_paper.numbers.orbits import the_orbit, the_point
from rattle_paper.panels.basin_panel import draw_panel

_WINDOW = {
    "first": {"parameter": "damping", "start": 0.75, "stop": 0.78},
    "second": {"parameter": "eccentricity", "start": 0.094, "stop": 0.0995},
}
_PIXELS = 60
# Between the two points, where P(1,1,0) is born at a damping of 0.7655 and grazes at 0.7647.
_BETWEEN = Oscillator(damping=0.765, eccentricity=0.096608)
_DISTANCES = tuple(10.0 ** (-8.0 + 0.25 * n) for n in range(21))
_SIDES = {"above": 3e-5, "below": -3e-5}
# Dampings at which the end of chaos is followed, both ways from where it is located.
_DOWN, _UP = 0.762 - 5e-4 * np.arange(1, 11), 0.762 + 5e-4 * np.arange(1, 8)


@cache
def _graze() -> tuple[SpecialPoint, GrazeKind]:
    """Where P(1,1,0) grazes as damping falls, and what that does."""
    orbit = the_orbit(_BETWEEN, "P(1,1,0)", attracts=True)
    point = the_point(continue_orbit(_BETWEEN, orbit, "damping", (0.764, 0.766)).special_points, SpecialKind.GRAZING)
    kind = graze_kind(point)
    assert kind is not None, "it lies within Eq. (8)"
    return point, kind


def _jobs(grid: CellGrid) -> dict[str, Job]:
    point, _ = _graze()
    t, v = float(point.t[0]), float(point.v[0])
    window = CellGrid(t - 0.1, t + 0.1, grid.time_cells, v - 0.4, v + 0.4, grid.velocity_cells)
    sides = {
        name: BasinJob(oscillator=point.oscillator.at(damping=point.value + side), grid=window)
        for name, side in _SIDES.items()
    }
    return {"chart": ChartJob(**_WINDOW, pixels=_PIXELS), **sides}


def _followed(distance: float) -> dict[str, float]:
    """Exponent a turn of the motion beyond the graze, with its error, and the range of its phases."""
    point, _ = _graze()
    oscillator = point.oscillator.at(damping=point.value - distance)
    (found,) = (each for each in find_attractors(oscillator, point.t[:1], point.v[:1]) if each.time.size)
    phases = found.time - point.t[0]
    phases -= np.rint(phases)
    return {
        "exponent": found.lyapunov_exponent, "exponent_error": found.lyapunov_error,
        "range_of_phases": float(np.ptp(phases)),
    }  # fmt: skip


def _beyond(distance: float) -> AttractorBeyond:
    _, kind = _graze()
    there = attractor_beyond(kind, distance)
    assert there is not None, "both multipliers are real, positive and below 1"
    return there


def _chaos() -> list[dict[str, float]]:
    rows = []
    for distance in _DISTANCES:
        leading, own = _beyond(distance), _followed(distance)
        rows.append({"distance": distance, "leading_exponent": leading.exponent, "leading_size": leading.size} | own)
    return rows


def _slope(rows: list[dict[str, float]], name: str) -> float:
    """Power of the distance with which a size grows."""
    distances, sizes = np.log([[row["distance"], row[name]] for row in rows]).T
    return float(np.polyfit(distances, sizes, 1)[0])


def _draw_exponents(axes: Axes, rows: list[dict[str, float]]) -> None:
    distances = [row["distance"] for row in rows]
    axes.semilogx(distances, [row["exponent"] for row in rows], "o", color="#b35806", label="of the map")
    axes.semilogx(distances, [row["leading_exponent"] for row in rows], color="black", label="of the leading terms")
    axes.axhline(0.0, color="gray", linewidth=0.7)
    axes.set(xlabel="distance of the damping below the graze", ylabel="largest exponent a turn")
    axes.set_title("(b) chaos at once", fontsize="medium")
    axes.legend(loc="lower right", frameon=False)


def _draw_sizes(axes: Axes, rows: list[dict[str, float]]) -> None:
    distances = np.array([row["distance"] for row in rows])
    ranges = np.array([row["range_of_phases"] for row in rows])
    axes.loglog(distances, ranges, "o", color="#b35806", label="of the map")
    axes.loglog(distances, ranges[0] * np.sqrt(distances / distances[0]), color="black", label="square root")
    axes.set(xlabel="distance of the damping below the graze", ylabel="range of its phases")
    axes.set_title("(c) its size", fontsize="medium")
    axes.legend(loc="lower right", frameon=False)


def _ends_of_chaos() -> list[Tangency]:
    """Where P(1,1,0) meets its own stable manifold, in order of damping."""
    crisis = homoclinic_crisis()
    down, up = (follow_tangency(crisis, "damping", values) for values in (_DOWN, _UP))
    return [*down[::-1], crisis, *up]


def _points(chart: xr.Dataset) -> dict[str, list[float]]:
    kinds = tuple(CodimensionTwo)
    return {
        kinds[kind - 1].value: [float(damping), float(eccentricity)]
        for kind, damping, eccentricity in zip(
            chart.point_kind.values, chart.point_damping.values, chart.point_eccentricity.values, strict=True
        )
    }


def _make(results: Results, report: Report) -> Sheet:
    report("following motions beyond the graze", 0, 2)
    rows = _chaos()
    report("drawing", 1, 2)
    point, kind = _graze()
    chart = results["chart"]
    drawing = Figure(figsize=(13.0, 11.0), dpi=80, layout="constrained")
    (whole, _), (exponents, sizes), (above, below) = panels = drawing.subplots(3, 2, height_ratios=(1.4, 1.0, 1.2))
    grid = panels[0, 0].get_gridspec()
    for axes in panels[0]:
        axes.remove()
    whole = drawing.add_subplot(grid[0, :])
    plot_chart(whole, chart.rattle.job, {str(name): chart[name].values for name in chart.variables})
    whole.axhline(point.oscillator.eccentricity, color="gray", linewidth=0.7, linestyle=":")
    ends = _ends_of_chaos()
    whole.plot(
        [end.oscillator.damping for end in ends], [end.value for end in ends], color="#00695c", linewidth=2.0,
        label="crisis: P(1,1,0) meets itself",
    )  # fmt: skip
    whole.set_title("(a) curves and points, and the largest exponent", fontsize="medium")
    whole.legend(loc="upper left", bbox_to_anchor=(0.0, 1.0), fontsize="small")
    _draw_exponents(exponents, rows)
    _draw_sizes(sizes, rows)
    for letter, (name, side), axes in zip("de", _SIDES.items(), (above, below), strict=True):
        basin = results[name]
        draw_panel(axes, basin, attractor_marks(basin.rattle.catalogue()))
        axes.set_title(f"({letter}) {abs(side):g} {name} the graze in damping", fontsize="medium")
    numbers: dict[str, Any] = {
        "points": _points(chart),
        "graze": {
            "damping": point.value, "eccentricity": point.oscillator.eccentricity, "scenario": kind.scenario.value,
            "response": kind.response, "multipliers": sorted(kind.multipliers.real.tolist()),
        },
        "chaos": rows,
        "chaos_ends": [[end.oscillator.damping, end.value] for end in ends],
        "size_grows_with_the_power": _slope(rows, "range_of_phases"),
        "sides": {name: _shares(results[name]) for name in _SIDES},
    }  # fmt: skip
    return Sheet(drawing, numbers)


def _shares(basin: xr.Dataset) -> dict[str, float]:
    return {
        str(name): float(share)
        for name, share in zip(basin.name.values, basin.share.values, strict=True)
        if np.isfinite(share)
    }


SEQUEL = PaperFigure("sequel", "two points of codimension two, chaos at once between them, basins beside", _make, _jobs)
