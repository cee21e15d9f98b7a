"""Fig. 13: basins before the graze of P(4,4,2) and at it, and histories of P(2,2,1) and of the orbit that grazes."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from rattle_kernels import CellGrid, FoundOrbit
from worker.jobs.basin_job import BasinJob
from worker.paper.basin_view import BasinView, view_basin
from worker.paper.figure import PaperFigure, Sheet, Tell
from worker.paper.history_panel import draw_history_panel
from worker.paper.marked_basin import draw_marked, history_of
from worker.paper.orbits_told import orbits_named, told_orbit, told_window
from worker.paper.papers_oscillator import papers_basin
from worker.paper.solutions_told import told_basin
from worker.pictures.overlay import Marks

_PERIODS = 12.0


class _Panel(NamedTuple):
    """A basin: where damping is, and the attracting orbit that is shown on it, with its history's label."""

    damping: float
    name: str
    history: str


_PANELS = {"a": _Panel(0.575, "P(2,2,1)", "c"), "b": _Panel(0.5922, "P(4,4,2)", "d")}


def _basins(grid: CellGrid) -> dict[str, BasinJob]:
    return {label: papers_basin(grid, damping=panel.damping) for label, panel in _PANELS.items()}


def _orbit(view: BasinView, name: str) -> FoundOrbit:
    (found,) = (each for each in orbits_named(view.oscillator, name) if each.orbit.attracts)
    return found


def _told(view: BasinView, found: FoundOrbit) -> dict[str, Any]:
    windows = {each.name: told_window(view.oscillator, each) for each in view.attractors if each.upper_contacts > 2}
    orbit = told_orbit(found.orbit) | {"grazing_distance": found.grazing_distance}
    return told_basin(view) | {"orbit": orbit, "windows": windows}


def _make(stores: Mapping[str, str], tell: Tell) -> Sheet:
    drawing = Figure(figsize=(12.0, 9.4), dpi=90, layout="constrained")
    places: Any = drawing.subplot_mosaic([["a", "b"], ["c", "d"]], height_ratios=(2.2, 1.0))
    panels = {}
    for number, (label, panel) in enumerate(_PANELS.items()):
        tell("drawing", number, len(_PANELS))
        view = view_basin(stores[label])
        found = _orbit(view, panel.name)
        draw_marked(places[label], label, view, [Marks(panel.name, "black", found.orbit.t, found.orbit.v, "x")])
        history = history_of(view.oscillator, found.orbit, _PERIODS)
        draw_history_panel(places[panel.history], view.oscillator, history, f"({panel.history}) {panel.name}")
        places[panel.history].set_xlabel("time since the departure (forcing periods)")
        panels[label] = _told(view, found)
    return Sheet(drawing, {"panels": panels})


FIG13 = PaperFigure("fig13", "basins before the graze of P(4,4,2) and at it, with histories", _make, _basins)
