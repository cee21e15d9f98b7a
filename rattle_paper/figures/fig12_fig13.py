"""Figs. 12 and 13: basins with only the motions of the caption marked, and time histories of these motions.

Fig. 12 is point A of Fig. 11, at damping 0.527, where P(3,3,2) lies beside a long chaotic transient. Fig. 13 shows
basins before the graze of P(4,4,2) and at it.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle import BasinJob
from rattle.pictures import Marks, attractor_marks, draw_history_panel
from rattle_kernels import Attractor, CellGrid, FoundOrbit, Oscillator, PeriodicOrbit, TimeHistory, time_history
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.orbits import orbit_summary, orbits_named, the_orbit, window_summary
from rattle_paper.numbers.solutions import basin_summary
from rattle_paper.panels.basin_panel import draw_panel, legend_of
from rattle_paper.papers_oscillator import papers_basin, papers_oscillator


def draw_marked(axes: Axes, label: str, basin: xr.Dataset, marks: Sequence[Marks]) -> None:
    """Draw basins with marks on them, and a legend of the shares below."""
    draw_panel(axes, basin, marks)
    axes.set_title(f"({label}) δ = {basin.rattle.oscillator.damping:g}", fontsize="medium")
    axes.legend(handles=legend_of(basin), loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2, fontsize="small")


def history_of(oscillator: Oscillator, motion: Attractor | PeriodicOrbit, periods: float) -> TimeHistory:
    """Time history from the fastest departure of a motion. Of a chaotic one, this is the fastest point stored."""
    t, v = (motion.t, motion.v) if isinstance(motion, PeriodicOrbit) else (motion.time, motion.velocity)
    fastest = int(np.argmax(v))
    return time_history(oscillator, float(t[fastest]), oscillator.half_backlash, -float(v[fastest]), periods=periods)


def windows_of(basin: xr.Dataset) -> dict[str, Any]:
    """Windows of damping in which the longer periodic attractors of a basin persist, by name."""
    longer = [each for each in basin.rattle.catalogue() if each.upper_contacts > 2]
    return {each.name: window_summary(basin.rattle.oscillator, each) for each in longer}


_DAMPING = 0.527
_NAME = "P(3,3,2)"
_BASIN = "basin"
_PERIODS_OF_FIG12 = 30.0


def _basins_of_fig12(grid: CellGrid) -> dict[str, BasinJob]:
    return {_BASIN: papers_basin(grid, damping=_DAMPING)}


def _make_fig12(results: Results, report: Report) -> Sheet:
    basin, oscillator = results[_BASIN], papers_oscillator(damping=_DAMPING)
    shown = tuple(each for each in basin.rattle.catalogue() if each.name == _NAME or each.is_chaotic)
    drawing = Figure(figsize=(12.0, 6.8), dpi=90, layout="constrained")
    places: Any = drawing.subplot_mosaic([["a", "b"], ["a", "c"]], width_ratios=(1.1, 1.0))
    draw_marked(places["a"], "a", basin, attractor_marks(shown))
    for label, motion in zip("bc", shown, strict=False):
        history = history_of(oscillator, motion, _PERIODS_OF_FIG12)
        draw_history_panel(places[label], oscillator, history, f"({label}) {motion.name}")
    places["c"].set_xlabel("time since the departure (forcing periods)")
    orbit = orbit_summary(the_orbit(oscillator, _NAME, attracts=True))
    return Sheet(drawing, basin_summary(basin) | {"orbit": orbit, "windows": windows_of(basin)})


FIG12 = PaperFigure(
    "fig12", "basins at damping 0.527, with P(3,3,2) and the chaos beside it", _make_fig12, _basins_of_fig12
)


_PERIODS_OF_FIG13 = 12.0


class _Panel(NamedTuple):
    """A panel of basins: its damping, the attracting orbit marked on it, and the label of that orbit's history."""

    damping: float
    name: str
    history: str


_PANELS = {"a": _Panel(0.575, "P(2,2,1)", "c"), "b": _Panel(0.5922, "P(4,4,2)", "d")}


def _basins_of_fig13(grid: CellGrid) -> dict[str, BasinJob]:
    return {label: papers_basin(grid, damping=panel.damping) for label, panel in _PANELS.items()}


def _orbit(oscillator: Oscillator, name: str) -> FoundOrbit:
    (found,) = (each for each in orbits_named(oscillator, name) if each.orbit.attracts)
    return found


def _summary(basin: xr.Dataset, found: FoundOrbit) -> dict[str, Any]:
    orbit = orbit_summary(found.orbit) | {"grazing_distance": found.grazing_distance}
    return basin_summary(basin) | {"orbit": orbit, "windows": windows_of(basin)}


def _make_fig13(results: Results, report: Report) -> Sheet:
    drawing = Figure(figsize=(12.0, 9.4), dpi=90, layout="constrained")
    places: Any = drawing.subplot_mosaic([["a", "b"], ["c", "d"]], height_ratios=(2.2, 1.0))
    panels = {}
    for number, (label, panel) in enumerate(_PANELS.items()):
        report("drawing", number, len(_PANELS))
        basin = results[label]
        oscillator = basin.rattle.oscillator
        found = _orbit(oscillator, panel.name)
        draw_marked(places[label], label, basin, [Marks(panel.name, "black", found.orbit.t, found.orbit.v, "x")])
        history = history_of(oscillator, found.orbit, _PERIODS_OF_FIG13)
        draw_history_panel(places[panel.history], oscillator, history, f"({panel.history}) {panel.name}")
        places[panel.history].set_xlabel("time since the departure (forcing periods)")
        panels[label] = _summary(basin, found)
    return Sheet(drawing, {"panels": panels})


FIG13 = PaperFigure(
    "fig13", "basins before the graze of P(4,4,2) and at it, with histories", _make_fig13, _basins_of_fig13
)
