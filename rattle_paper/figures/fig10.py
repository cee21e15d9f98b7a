"""Fig. 10: the P(1,2,0) solution as damping grows up to its saddle-node, and the basins before, at and after it."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle import BasinJob
from rattle.pictures import attractor_marks, saddle_marks
from rattle_kernels import (
    BifurcationDiagram,
    Branch,
    CellGrid,
    PeriodicOrbit,
    SpecialKind,
    bifurcation_diagram,
    continue_orbit,
)
from rattle_paper.figure import PaperFigure, Printed, Report, Results, Sheet
from rattle_paper.numbers.orbits import orbit_summary, orbits_named, point_summary, the_orbit, the_point
from rattle_paper.numbers.solutions import basin_summary
from rattle_paper.panels.basin_panel import draw_panel, legend_of
from rattle_paper.papers_oscillator import papers_basin, papers_oscillator

_NAME = "P(1,2,0)"
_FIRST, _LAST = 0.575, 0.6
# Before, at (to the paper's four digits) and after the saddle-node.
_DAMPINGS = {"b": _FIRST, "c": 0.5997, "d": _LAST}
_VALUES = 251


class _Diagram(NamedTuple):
    """The attractor, followed by pseudo-continuation, and the branch that leads through the fold to the saddle."""

    attractor: PeriodicOrbit
    saddle: PeriodicOrbit
    settled: BifurcationDiagram
    branch: Branch


def _basins(grid: CellGrid) -> dict[str, BasinJob]:
    return {label: papers_basin(grid, damping=damping) for label, damping in _DAMPINGS.items()}


def _follow() -> _Diagram:
    oscillator = papers_oscillator(damping=_FIRST)
    attractor, saddle = (the_orbit(oscillator, _NAME, attracts=attracts) for attracts in (True, False))
    values = np.linspace(_FIRST, _LAST, _VALUES)
    settled = bifurcation_diagram(oscillator, "damping", values, attractor.t[0], attractor.v[0])
    branch = continue_orbit(oscillator, attractor, "damping", (_FIRST, _LAST), direction="up")
    return _Diagram(attractor, saddle, settled, branch)


def _alive(diagram: _Diagram) -> np.ndarray:
    """Values of damping at which the followed motion still has impact period 2."""
    return diagram.settled.values[diagram.settled.period[:, 0] == diagram.attractor.upper_contacts]


def _draw_diagram(axes: Axes, diagram: _Diagram) -> None:
    contacts = diagram.attractor.upper_contacts
    alive = diagram.settled.period[:, 0] == contacts
    last = np.sort(diagram.settled.v[alive, 0, -contacts:], axis=1)
    axes.plot(diagram.settled.values[alive], last, color="black", label=["attractor", "_", "_"][:contacts])
    unstable = ~diagram.branch.attracts
    axes.plot(
        diagram.branch.values[unstable], diagram.branch.v[unstable], "--", color="black",
        label=["saddle", "_", "_"][:contacts],
    )  # fmt: skip
    for orbit, marker in ((diagram.attractor, "x"), (diagram.saddle, "+")):
        axes.plot(np.full(contacts, _FIRST), orbit.v, marker, color="red", markersize=8, markeredgewidth=1.8)
    point = the_point(diagram.branch.special_points, SpecialKind.SADDLE_NODE)
    axes.axvline(point.value, color="gray", linestyle=":", label=f"saddle-node, δ = {point.value:.6f}")
    axes.set(xlabel="damping δ", ylabel="velocity v of departure", xlim=(_FIRST - 5e-4, _LAST))
    axes.set_title(f"(a) {_NAME}", fontsize="medium")
    axes.legend(loc="center left", fontsize="small")


def _draw_basin(axes: Axes, label: str, basin: xr.Dataset, orbits: list[PeriodicOrbit]) -> None:
    there = tuple(each for each in basin.rattle.catalogue() if each.name == _NAME)
    saddles = [orbit for orbit in orbits if not orbit.attracts]
    draw_panel(axes, basin, (*attractor_marks(there), *saddle_marks(saddles)))
    axes.set_title(f"({label}) δ = {basin.rattle.oscillator.damping:g}", fontsize="medium")
    axes.legend(handles=legend_of(basin), loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="x-small")


def _make(results: Results, report: Report) -> Sheet:
    report("following the orbit", 0, 1)
    diagram = _follow()
    drawing = Figure(figsize=(13.0, 9.0), dpi=90, layout="constrained")
    places = drawing.subplots(2, 2).flat
    _draw_diagram(places[0], diagram)
    panels = {}
    for number, (label, basin) in enumerate(results.items(), 1):
        report("drawing", number, len(results))
        orbits = [each.orbit for each in orbits_named(basin.rattle.oscillator, _NAME)]
        _draw_basin(places[number], label, basin, orbits)
        panels[label] = basin_summary(basin) | {"orbits": [orbit_summary(orbit) for orbit in orbits]}
    point = the_point(diagram.branch.special_points, SpecialKind.SADDLE_NODE)
    numbers = {
        "at_first_damping": {"attractor": orbit_summary(diagram.attractor), "saddle": orbit_summary(diagram.saddle)},
        "saddle_node": point_summary(point),
        "last_followed": float(_alive(diagram).max()),
        "panels": panels,
    }
    return Sheet(drawing, numbers)


FIG10 = PaperFigure(
    "fig10", "P(1,2,0) to its saddle-node, and basins before, at and after it", _make, _basins,
    (Printed("damping of the saddle-node of P(1,2,0)", 0.5997, ("saddle_node", "damping")),),
)  # fmt: skip
