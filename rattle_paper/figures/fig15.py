"""Fig. 15: the stable manifolds of the saddles A, P(1,1,0), and B, P(1,1,1), on the basins at damping 0.6."""

from matplotlib.figure import Figure

from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import oscillator_summary
from rattle_paper.panels.anatomy import (
    BASIN,
    manifold_overlays,
    manifold_summary,
    manifolds,
    saddle_overlays,
    share_of_boundaries,
    the_basin,
)
from rattle_paper.panels.basin_panel import draw_panel

# Per branch. The manifolds then cover every boundary cell of a picture of 2000 x 2000 (docs/theory/manifolds.md).
ARCLENGTH = 100.0


def _make(results: Results, report: Report) -> Sheet:
    basin = results[BASIN]
    oscillator, grid = basin.rattle.oscillator, basin.rattle.job.grid
    grown = manifolds(oscillator, ARCLENGTH, grid.velocity_stop)
    drawing = Figure(figsize=(8.0, 6.4), dpi=100, layout="constrained")
    axes = drawing.subplots()
    draw_panel(axes, basin, ())
    for line in manifold_overlays(grown):
        line.draw(axes, grid.time_start)
    for marks in saddle_overlays(grown):
        marks.draw(axes, grid.time_start)
    for label, each in grown.items():
        place = float(each.saddle.t[0]), float(each.saddle.v[0])
        axes.annotate(label, place, (6, 6), textcoords="offset points", color="white", weight="bold")
    entries = {
        label: manifold_summary(each) | {"share_of_boundaries": share_of_boundaries(basin, each.pieces)}
        for label, each in grown.items()
    }
    together = share_of_boundaries(basin, [piece for each in grown.values() for piece in each.pieces])
    numbers = {"oscillator": oscillator_summary(oscillator), "manifolds": entries, "share_of_boundaries": together}
    return Sheet(drawing, numbers)


FIG15 = PaperFigure("fig15", "stable manifolds of the saddles P(1,1,0) and P(1,1,1) on the basins", _make, the_basin)
