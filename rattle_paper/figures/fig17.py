"""Fig. 17: the stable manifolds of Fig. 15 up to v = 40."""

import numpy as np
from matplotlib.figure import Figure

from rattle.pictures import frame
from rattle_kernels import Oscillator, next_impacts
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import oscillator_summary
from rattle_paper.panels.anatomy import manifold_overlays, manifold_summary, manifolds, saddle_overlays
from rattle_paper.papers_oscillator import papers_oscillator

_HIGHEST = 40.0
# At this length A's manifold passes within a cell of every boundary in a picture of 1600 x 1600 cells (docs/theory).
_ARCLENGTH = 1600.0
_PHASES = 64


def _speed_lost(oscillator: Oscillator) -> list[float]:
    """Least and greatest loss of speed in one application of P, over departures at the highest speed."""
    lost = _HIGHEST - next_impacts(oscillator, np.linspace(0.0, 1.0, _PHASES, endpoint=False), _HIGHEST).v
    return [float(lost.min()), float(lost.max())]


def _make(results: Results, report: Report) -> Sheet:
    report("growing manifolds", 0, 1)
    oscillator = papers_oscillator()
    grown = manifolds(oscillator, _ARCLENGTH, _HIGHEST)
    drawing = Figure(figsize=(8.0, 10.0), dpi=90, layout="constrained")
    axes = drawing.subplots()
    lines = manifold_overlays(grown)
    for line in lines:
        line._replace(width=0.5 * line.width).draw(axes)
    for marks in saddle_overlays(grown):
        marks._replace(colour="black").draw(axes)
    frame(axes, (0.0, 1.0, 0.0, _HIGHEST))
    summaries = {label: manifold_summary(each) for label, each in grown.items()}
    numbers = {"oscillator": oscillator_summary(oscillator), "highest_velocity": _HIGHEST, "manifolds": summaries}
    return Sheet(drawing, numbers | {"speed_lost_there": _speed_lost(oscillator)})


FIG17 = PaperFigure("fig17", "the stable manifolds of Fig. 15 up to v = 40", _make)
