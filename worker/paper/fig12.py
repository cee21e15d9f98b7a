"""Fig. 12: basins at A of Fig. 11, damping 0.527, where P(3,3,2) and chaos coexist, and histories of both."""

from collections.abc import Mapping
from typing import Any

from matplotlib.figure import Figure

from rattle_kernels import CellGrid
from worker.jobs.basin_job import BasinJob
from worker.paper.basin_view import view_basin
from worker.paper.figure import PaperFigure, Sheet, Tell
from worker.paper.history_panel import draw_history_panel
from worker.paper.marked_basin import draw_marked, history_of
from worker.paper.orbits_told import the_orbit, told_orbit, told_window
from worker.paper.papers_oscillator import papers_basin, papers_oscillator
from worker.paper.solutions_told import told_basin
from worker.pictures.overlay import attractor_marks

_DAMPING = 0.527
_NAME = "P(3,3,2)"
_BASIN = "basin"
_PERIODS = 30.0


def _basins(grid: CellGrid) -> dict[str, BasinJob]:
    return {_BASIN: papers_basin(grid, damping=_DAMPING)}


def _make(stores: Mapping[str, str], tell: Tell) -> Sheet:
    view = view_basin(stores[_BASIN])
    shown = tuple(each for each in view.attractors if each.name == _NAME or each.wanders)
    drawing = Figure(figsize=(12.0, 6.8), dpi=90, layout="constrained")
    places: Any = drawing.subplot_mosaic([["a", "b"], ["a", "c"]], width_ratios=(1.1, 1.0))
    draw_marked(places["a"], "a", view, attractor_marks(shown))
    for label, motion in zip("bc", shown, strict=False):
        draw_history_panel(
            places[label], view.oscillator, history_of(view.oscillator, motion, _PERIODS), f"({label}) {motion.name}"
        )
    places["c"].set_xlabel("time since the departure (forcing periods)")
    orbit = the_orbit(papers_oscillator(damping=_DAMPING), _NAME, attracts=True)
    windows = {each.name: told_window(view.oscillator, each) for each in view.attractors if each.upper_contacts > 2}
    return Sheet(drawing, told_basin(view) | {"orbit": told_orbit(orbit), "windows": windows})


FIG12 = PaperFigure("fig12", "basins at damping 0.527, with P(3,3,2) and the chaos beside it", _make, _basins)
