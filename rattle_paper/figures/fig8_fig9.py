"""Figs. 8 and 9: basins at nine values of one parameter, and below them the share of each solution.

Fig. 8: rattle is born at an eccentricity of 0.0596 and becomes complex. Fig. 9: rattling solutions die one by one as
damping grows, until none remains.
"""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from rattle import BasinJob, Spacing, SweepJob, SweptParameter
from rattle.pictures import SYMBOLS, Palette, colours_of
from rattle_kernels import CellGrid
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import basin_summary
from rattle_paper.numbers.transients import on_transient
from rattle_paper.panels.basin_panel import COLOUR_OF_TRANSIENTS, attractor_overlays, draw_panel
from rattle_paper.papers_oscillator import ITERATIONS, papers_oscillator

_PANELS, _COLUMNS = 9, 3
_SWEEP = "sweep"


def _sweep_figure(name: str, parameter: str, start: float, stop: float) -> PaperFigure:
    """Figure of basins at nine values of a parameter. All others are as in Fig. 7 (bottom)."""
    swept = SweptParameter.spaced(parameter, start, stop, _PANELS, Spacing.LINEAR)

    def basins(grid: CellGrid) -> dict[str, BasinJob]:
        return {_SWEEP: SweepJob(oscillator=papers_oscillator(), grid=grid, iterations=ITERATIONS, vary=(swept,))}

    return PaperFigure(name, f"basins at {_PANELS} values of {parameter} from {start:g} to {stop:g}", _make, basins)


def _make(results: Results, report: Report) -> Sheet:
    sweep = results[_SWEEP]
    basins = sweep.rattle.basins()
    drawing = Figure(figsize=(12.0, 12.5), dpi=80, layout="constrained")
    parts: Any = drawing.subfigures(2, 1, height_ratios=(3.0, 1.0))
    places = parts[0].subplots(_PANELS // _COLUMNS, _COLUMNS, sharex=True, sharey=True).flat
    (swept,) = sweep.rattle.job.vary
    for number, (axes, basin) in enumerate(zip(places, basins, strict=True)):
        report("drawing", number, _PANELS)
        draw_panel(axes, basin, attractor_overlays(basin))
        axes.label_outer()
        value = f"{SYMBOLS[swept.parameter]} = {swept.values[number]:g}"
        axes.set_title(f"({'abcdefghi'[number]}) {value}", fontsize="medium")
    _draw_chart(parts[1].subplots(), sweep, basins)
    return Sheet(drawing, _summary(sweep, basins))


def _draw_chart(axes: Axes, sweep: xr.Dataset, basins: tuple[xr.Dataset, ...]) -> None:
    """Draw shares over the parameter. The dashed line is the share of cells on a transient after k applications."""
    job = sweep.rattle.job
    sweep.rattle.plot_shares(axes)
    colours = colours_of(basins[0].rattle.catalogue(), Palette.PAPER)
    for line, colour in zip(axes.get_lines(), colours, strict=True):
        line.set_color(colour)
    late = np.array([on_transient(basin).mean() for basin in basins])
    handles: list[Any] = [
        Patch(facecolor=colour, edgecolor="black", label=f"{number}: {name}")
        for number, (colour, name) in enumerate(zip(colours, sweep.name.values, strict=True))
    ]
    if late.any():
        label = f"still chaotic at k = {job.iterations}"
        handles += axes.plot(job.vary[0].values, late, "--", color=COLOUR_OF_TRANSIENTS, label=label)
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize="small")


def _summary(sweep: xr.Dataset, basins: tuple[xr.Dataset, ...]) -> dict[str, Any]:
    (swept,), names = sweep.rattle.job.vary, sweep.name.values.tolist()
    return {
        "swept": swept.parameter,
        "values": list(swept.values),
        "solutions": names,
        "changes": [
            {
                "what": change.change_kind,
                "number": change.change_solution,
                "name": names[change.change_solution],
                "between": [change.change_from, change.change_to],
            }
            for change in sweep.rattle.to_table("change").itertuples()
        ],
        "panels": {
            f"{swept.parameter} {value:g}": basin_summary(basin)
            for value, basin in zip(swept.values, basins, strict=True)
        },
    }


FIG8 = _sweep_figure("fig8", "eccentricity", 0.056, 0.1)
FIG9 = _sweep_figure("fig9", "damping", 0.5, 0.7)
