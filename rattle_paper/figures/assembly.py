"""Quiet over the assembly angle of two eccentric gears: the first turns once, the second twice a forcing period."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle import BasinJob, Sample, SweepJob, SweptParameter, eccentric_gears
from rattle_kernels import AttractorKind, CellGrid, Oscillator
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import basin_summary
from rattle_paper.panels.basin_panel import draw_panel, legend_of

# A tenth of the paper's eccentricity, mounted at any angle.
_SECOND = 0.01
_PHASES = tuple(round(0.025 * step, 3) for step in range(41))
_WORST, _BEST = 0.7, 0.375
_POINTS = 4096


def _oscillator(assembly: float) -> Oscillator:
    """The paper's oscillator, whose second gear is eccentric too."""
    return Oscillator(**eccentric_gears(1, 2, Oscillator().eccentricity, _SECOND, assembly))


def _basins(grid: CellGrid) -> dict[str, BasinJob]:
    vary = (SweptParameter("phase_2", _PHASES),)
    return {
        "sweep": SweepJob(oscillator=_oscillator(0.0), grid=grid, vary=vary, sample=Sample(_POINTS)),
        "one gear": BasinJob(grid=grid, sample=Sample(_POINTS)),
        "worst": BasinJob(oscillator=_oscillator(_WORST), grid=grid),
        "best": BasinJob(oscillator=_oscillator(_BEST), grid=grid),
    }


def _quiet(basin: xr.Dataset) -> tuple[float, float]:
    """Share of quiet, and its standard error."""
    (index,) = np.flatnonzero(basin.kind.values == AttractorKind.PERMANENT_CONTACT)
    return float(basin.share.values[index]), float(basin.share_error.values[index])


def _draw_shares(axes: Axes, quiet: np.ndarray, one_gear: float) -> None:
    """Draw the quiet share over the assembly angle, with twice its error."""
    share, error = quiet.T
    axes.fill_between(_PHASES, share - 2.0 * error, share + 2.0 * error, color="tab:blue", alpha=0.25, linewidth=0.0)
    axes.plot(_PHASES, share, ".-", color="tab:blue", label="both gears eccentric")
    axes.axhline(one_gear, color="gray", linestyle="--", label="the first gear alone")
    for phase, name, above in ((_WORST, "(b)", -18), (_BEST, "(c)", 10)):
        height = share[_PHASES.index(phase)]
        axes.annotate(name, (phase, height), (0, above), textcoords="offset points", ha="center")
    axes.set(xlim=(0.0, 1.0), ylim=(0.4, 1.05), xlabel="assembly angle (turns of the second gear)")
    axes.set_ylabel("share of quiet")
    axes.legend(loc="lower left", fontsize="small")


def _make(results: Results, report: Report) -> Sheet:
    drawing = Figure(figsize=(17.0, 5.2), dpi=80, layout="constrained")
    shares, *panels = drawing.subplots(1, 3)
    quiet = np.array([_quiet(basin) for basin in results["sweep"].rattle.basins()])
    one_gear = _quiet(results["one gear"])
    _draw_shares(shares, quiet, one_gear[0])
    shares.set_title("(a) quiet after a disturbance of any phase, v in (0, 7)", fontsize="medium")
    summaries: dict[str, Any] = {}
    for number, (axes, name, phase) in enumerate(zip(panels, ("worst", "best"), (_WORST, _BEST), strict=True)):
        report("drawing", number, 2)
        draw_panel(axes, results[name], ())
        axes.set_title(f"({'bc'[number]}) assembly angle {phase:g}", fontsize="medium")
        axes.legend(handles=legend_of(results[name]), loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="x-small")
        summaries[name] = {"assembly": phase} | basin_summary(results[name])
    numbers = {
        "second_eccentricity": _SECOND,
        "points": _POINTS,
        "phases": _PHASES,
        "quiet": quiet[:, 0].tolist(),
        "quiet_error": quiet[:, 1].tolist(),
        "one_gear": {"quiet": one_gear[0], "quiet_error": one_gear[1]},
        "panels": summaries,
    }
    return Sheet(drawing, numbers)


ASSEMBLY = PaperFigure("assembly", "quiet over the assembly angle of two eccentric gears", _make, _basins)
