"""Fig. 11: the motion that is P(3,3,2) at damping 0.5, followed to 0.6 and back, and the points A, B and C."""

from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import BifurcationDiagram, SpecialKind, SpecialPoint, bifurcation_diagram, continue_orbit
from rattle_paper.figure import PaperFigure, Printed, Report, Results, Sheet
from rattle_paper.numbers.orbits import orbit_summary, point_summary, the_orbit, the_point
from rattle_paper.papers_oscillator import papers_oscillator

_FIRST, _LAST, _VALUES = 0.5, 0.6, 1001
_AT_A = 0.527
# A shorter stretch of one period is a window within chaos.
_LEAST_VALUES = 15


def _special_points() -> dict[str, SpecialPoint]:
    """Special points of the orbits in the diagram, by their names in the text or in docs/paper/figures.md."""
    kinds = SpecialKind
    sought = {
        "B": (0.575, "P(2,2,1)", kinds.PERIOD_DOUBLING),
        "C": (0.585, "P(4,4,2)", kinds.GRAZING),
        "P(2,2,1) ends": (0.575, "P(2,2,1)", kinds.GRAZING),
        "P(3,3,2) of 0.5 doubles": (0.5, "P(3,3,2)", kinds.PERIOD_DOUBLING),
        "P(3,3,2) of A is born": (_AT_A, "P(3,3,2)", kinds.SADDLE_NODE),
        "P(3,3,2) of A doubles": (_AT_A, "P(3,3,2)", kinds.PERIOD_DOUBLING),
    }
    return {what: _special_point(*where) for what, where in sought.items()}


def _special_point(damping: float, name: str, kind: SpecialKind) -> SpecialPoint:
    oscillator = papers_oscillator(damping=damping)
    orbit = the_orbit(oscillator, name, attracts=True)
    return the_point(continue_orbit(oscillator, orbit, "damping", (0.49, 0.61)).special_points, kind)


def _diagram() -> BifurcationDiagram:
    oscillator = papers_oscillator(damping=_FIRST)
    orbit = the_orbit(oscillator, "P(3,3,2)", attracts=True)
    values = np.linspace(_FIRST, _LAST, _VALUES)
    return bifurcation_diagram(oscillator, "damping", values, orbit.t[0], orbit.v[0], direction="both")


def _ways(diagram: BifurcationDiagram) -> dict[str, slice]:
    return {"up": slice(0, _VALUES), "down": slice(_VALUES, None)}


def _stretches(diagram: BifurcationDiagram, way: slice) -> list[dict[str, Any]]:
    """Intervals of the parameter over which the motion keeps its impact period. 0 means that none was seen."""
    rows = zip(diagram.period[way, 0].tolist(), diagram.values[way].tolist(), strict=True)
    stretches = []
    for period, run in groupby(rows, key=lambda row: row[0]):
        values = [value for _, value in run]
        if len(values) >= _LEAST_VALUES:
            stretches.append({"impact_period": period, "from": values[0], "to": values[-1]})
    return stretches


def _draw(axes: Axes, diagram: BifurcationDiagram, points: dict[str, SpecialPoint]) -> None:
    colours = {"up": "limegreen", "down": "black"}
    for name, way in _ways(diagram).items():
        kept = diagram.v.shape[-1]
        values = np.repeat(diagram.values[way], kept)
        axes.plot(
            values, diagram.v[way, 0].ravel(), ".", color=colours[name], markersize=2.8 if name == "up" else 1.6,
            markeredgewidth=0.0, label="δ increasing" if name == "up" else "δ decreasing",
        )  # fmt: skip
    for label, value in {"A": _AT_A, "B": points["B"].value, "C": points["C"].value}.items():
        axes.axvline(value, color="tab:red", linewidth=0.7, linestyle=":")
        axes.annotate(label, (value, 1.0), (0, 3), xycoords=("data", "axes fraction"), textcoords="offset points",
                      ha="center", color="tab:red", weight="bold")  # fmt: skip
    axes.set(xlabel="damping δ", ylabel="velocity v of departure", xlim=(_FIRST, _LAST))
    axes.legend(loc="upper left", markerscale=6.0)


def _make(results: Results, report: Report) -> Sheet:
    report("following motions", 0, 2)
    diagram = _diagram()
    report("locating special points", 1, 2)
    points = _special_points()
    drawing = Figure(figsize=(12.0, 6.5), dpi=100, layout="constrained")
    _draw(drawing.subplots(), diagram, points)
    numbers = {
        "values": [_FIRST, _LAST, _VALUES],
        "stretches": {name: _stretches(diagram, way) for name, way in _ways(diagram).items()},
        "A": orbit_summary(the_orbit(papers_oscillator(damping=_AT_A), "P(3,3,2)", attracts=True)),
        "special_points": {what: point_summary(point) for what, point in points.items()},
    }
    return Sheet(drawing, numbers)


FIG11 = PaperFigure(
    "fig11", "impact velocity over damping, increasing and decreasing, with A, B and C", _make,
    printed=(
        Printed("B: damping at which P(2,2,1) doubles", 0.5819, ("special_points", "B", "damping")),
        Printed("C: damping at which P(4,4,2) grazes", 0.5922, ("special_points", "C", "damping")),
    ),
)  # fmt: skip
