"""Fig. 6: basins of the piecewise linear model from kappa = 100 to 1e5, and how much they differ from the limit."""

from matplotlib.figure import Figure

from rattle import BasinJob
from rattle_kernels import CellGrid
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import basin_summary, differences_summary
from rattle_paper.panels.basin_panel import draw_panel, legend_of, model_of
from rattle_paper.papers_oscillator import papers_basin

_STIFFNESSES = {"kappa 1e2": 1e2, "kappa 1e3": 1e3, "kappa 1e4": 1e4, "kappa 1e5": 1e5}
_LIMIT = "impacting"


def _basins(grid: CellGrid) -> dict[str, BasinJob]:
    return {name: papers_basin(grid, stiffness) for name, stiffness in _STIFFNESSES.items()} | {
        _LIMIT: papers_basin(grid)
    }


def _make(results: Results, report: Report) -> Sheet:
    drawing = Figure(figsize=(12.0, 9.0), dpi=90, layout="constrained")
    panels = drawing.subplots(2, 2).flat
    for number, (axes, name) in enumerate(zip(panels, _STIFFNESSES, strict=True)):
        report("drawing", number, len(_STIFFNESSES))
        draw_panel(axes, results[name], ())
        axes.set_title(f"({'abcd'[number]}) {model_of(results[name].rattle.oscillator)}", fontsize="medium")
        axes.legend(handles=legend_of(results[name]), loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="x-small")
    limit = results[_LIMIT]
    panel_summaries = {
        name: basin_summary(results[name]) | {"differs_from_impacting": differences_summary(results[name], limit)}
        for name in _STIFFNESSES
    }
    return Sheet(drawing, {"panels": panel_summaries})


FIG6 = PaperFigure("fig6", "basins of the piecewise linear model at kappa = 1e2, 1e3, 1e4 and 1e5", _make, _basins)
