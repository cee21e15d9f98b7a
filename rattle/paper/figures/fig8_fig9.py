"""Figs. 8 and 9: basins at nine values of one parameter, and below them the share of each solution.

Fig. 8: rattle is born at an eccentricity of 0.0596 and becomes complex. Fig. 9: rattling solutions die one by one as
damping grows, until none remains.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from rattle.paper.figure import PaperFigure, Report, Sheet
from rattle.paper.numbers.solutions import basin_summary
from rattle.paper.numbers.transients import on_transient
from rattle.paper.panels.basin_panel import attractor_overlays, draw_panel
from rattle.paper.panels.sweep_view import SweepView, view_sweep
from rattle.paper.papers_oscillator import ITERATIONS, papers_oscillator
from rattle_kernels import CellGrid
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.swept_parameter import Spacing, SweptParameter
from worker.pictures.colours import CHAOTIC, colours_of
from worker.pictures.share_chart import draw_lines
from worker.pictures.symbols import SYMBOLS
from worker.stores.summary import Change

_PANELS, _COLUMNS = 9, 3
_SWEEP = "sweep"


def _sweep_figure(name: str, parameter: str, start: float, stop: float) -> PaperFigure:
    """Figure of basins at nine values of a parameter. All others are as in Fig. 7 (bottom)."""
    swept = SweptParameter.spaced(parameter, start, stop, _PANELS, Spacing.LINEAR)

    def basins(grid: CellGrid) -> dict[str, BasinJob]:
        return {_SWEEP: SweepJob(oscillator=papers_oscillator(), grid=grid, iterations=ITERATIONS, vary=(swept,))}

    return PaperFigure(name, f"basins at {_PANELS} values of {parameter} from {start:g} to {stop:g}", _make, basins)


def _make(stores: Mapping[str, str], report: Report) -> Sheet:
    sweep = view_sweep(stores[_SWEEP])
    drawing = Figure(figsize=(12.0, 12.5), dpi=80, layout="constrained")
    parts: Any = drawing.subfigures(2, 1, height_ratios=(3.0, 1.0))
    places = parts[0].subplots(_PANELS // _COLUMNS, _COLUMNS, sharex=True, sharey=True).flat
    (swept,) = sweep.job.vary
    for number, (axes, view) in enumerate(zip(places, sweep.basins, strict=True)):
        report("drawing", number, _PANELS)
        draw_panel(axes, view, attractor_overlays(view))
        axes.label_outer()
        value = f"{SYMBOLS[swept.parameter]} = {swept.values[number]:g}"
        axes.set_title(f"({'abcdefghi'[number]}) {value}", fontsize="medium")
    _draw_chart(parts[1].subplots(), sweep)
    return Sheet(drawing, _summary(sweep))


def _draw_chart(axes: Axes, sweep: SweepView) -> None:
    """Draw shares over the parameter. The dashed line is the share of cells on a transient after k applications."""
    solutions, values = sweep.basins[0].attractors, sweep.job.vary[0].values
    draw_lines(axes, sweep.job, np.array([view.shares for view in sweep.basins]), solutions)
    late = np.array([on_transient(view).mean() for view in sweep.basins])
    handles: list[Any] = [
        Patch(facecolor=colour, edgecolor="black", label=f"{number}: {name}")
        for number, (colour, name) in enumerate(zip(colours_of(solutions), sweep.names, strict=True))
    ]
    if late.any():
        handles += axes.plot(values, late, "--", color=CHAOTIC, label=f"still chaotic at k = {sweep.job.iterations}")
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize="small")


def _summary(sweep: SweepView) -> dict[str, Any]:
    (swept,) = sweep.job.vary
    return {
        "swept": swept.parameter,
        "values": list(swept.values),
        "solutions": list(sweep.names),
        "changes": [_change_summary(change, sweep.names) for change in sweep.changes],
        "panels": {
            f"{swept.parameter} {value:g}": basin_summary(view)
            for value, view in zip(swept.values, sweep.basins, strict=True)
        },
    }


def _change_summary(change: Change, names: tuple[str, ...]) -> dict[str, Any]:
    return {
        "what": change.kind.name.lower(),
        "number": change.solution,
        "name": names[change.solution],
        "between": [change.before, change.after],
    }


FIG8 = _sweep_figure("fig8", "eccentricity", 0.056, 0.1)
FIG9 = _sweep_figure("fig9", "damping", 0.5, 0.7)
