"""Share of quiet and least speed that ends in rattle, over the machine's damping and eccentricity, by sampling."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle.paper.figure import PaperFigure, Report, Sheet
from rattle.paper.machine import machine_oscillator
from rattle_kernels import AttractorKind, CellGrid, Oscillator
from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from rattle_kernels.impact_map.chatter import fastest_below
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter
from worker.views.reading import job_of, open_basin

_MACHINE = machine_oscillator(6e-4)
# Beyond eps/delta = 0.2 the capture region is so small that low bounces do not reach it within k applications.
_DAMPINGS = (5e-4, 6e-4, 7e-4, 8e-4, 1e-3)
_ECCENTRICITIES = (0.4e-4, 0.6e-4, 0.8e-4, 0.9e-4, 1e-4)
_POINTS = 512
# Highest speed of the machine's window, and of the part of it in which quiet ends, in units of its damping.
_WINDOWS = {"whole": 12.0, "low": 1.5}
_PHASES = np.arange(64) / 64


def _basins(grid: CellGrid) -> dict[str, BasinJob]:
    vary = SweptParameter("damping", _DAMPINGS), SweptParameter("eccentricity", _ECCENTRICITIES)
    return {
        name: SweepJob(
            oscillator=_MACHINE,
            grid=grid._replace(velocity_stop=fastest * _MACHINE.damping),
            vary=vary,
            sample=Sample(_POINTS),
        )
        for name, fastest in _WINDOWS.items()
    }


def _proven_quiet(oscillator: Oscillator) -> float:
    """Speed below which departures at all phases lie in the capture region. They provably end in quiet."""
    bound = capture_bound(oscillator)
    return float(min(fastest_below(oscillator, bound, phase) for phase in _PHASES))


def _summaries(whole: xr.Dataset, low: xr.Dataset) -> list[dict[str, Any]]:
    job = job_of(whole)
    kinds = whole.kind.values
    quiet, motions = kinds == AttractorKind.PERMANENT_CONTACT, whole.name.values
    quiet_low = low.kind.values == AttractorKind.PERMANENT_CONTACT
    speeds = low.velocity.values
    summaries: list[dict[str, Any]] = []
    for panel in range(job.basins):
        at = job.place_of(panel)
        share, solution = whole.share.values[at], low.solution.values[at]
        rattles = ~quiet_low[solution]
        largest = np.argsort(-np.where(np.isfinite(share) & ~quiet, share, -1.0))[:3]
        oscillator = job.oscillator_of(panel)
        values: dict[str, Any] = dict(job.values_of(panel))
        summaries.append(
            values
            | {
                "quiet": float(share[quiet][0]),
                "quiet_error": float(whole.share_error.values[at][quiet][0]),
                "undecided": float(np.nansum(share[kinds == AttractorKind.UNDECIDED])),
                "motions": int((np.nan_to_num(share) > 0.0).sum()),
                "largest": [[str(motions[i]), float(share[i])] for i in largest if share[i] > 0.0],
                "least_rattle": float(speeds[rattles].min()) if rattles.any() else None,
                "proven_quiet_below": _proven_quiet(oscillator),
            }
        )
    return summaries


def _draw_map(axes: Axes, summaries: list[dict[str, Any]], key: str, scale: float, title: str, label: str) -> None:
    """Draw one number per basin as a coloured table, damping upwards. Grey: none was seen in the window."""
    values = np.array([math.nan if each[key] is None else scale * each[key] for each in summaries])
    table = values.reshape(len(_DAMPINGS), len(_ECCENTRICITIES))
    image = axes.imshow(table, origin="lower", aspect="auto", cmap="viridis")
    axes.set_facecolor("lightgray")
    middle = 0.5 * (np.nanmin(table) + np.nanmax(table))
    for (row, column), value in np.ndenumerate(table):
        colour = "white" if value < middle else "black"
        text = f"> {scale * _WINDOWS['low'] * _MACHINE.damping:.3g}" if math.isnan(value) else f"{value:.3g}"
        axes.text(column, row, text, ha="center", va="center", color=colour, fontsize="small")
    axes.set_xticks(range(len(_ECCENTRICITIES)), [f"{1e4 * value:g}" for value in _ECCENTRICITIES])
    axes.set_yticks(range(len(_DAMPINGS)), [f"{1e4 * value:g}" for value in _DAMPINGS])
    axes.set_xlabel("eccentricity ε (1e-4)")
    axes.set_ylabel("damping δ (1e-4)")
    axes.set_title(title, fontsize="medium")
    axes.figure.colorbar(image, ax=axes, label=label)


def _make(stores: Mapping[str, str], report: Report) -> Sheet:
    report("drawing", 0, 1)
    summaries = _summaries(*(open_basin(stores[name]) for name in _WINDOWS))
    drawing = Figure(figsize=(13.0, 4.6), dpi=80, layout="constrained")
    left, right = drawing.subplots(1, 2)
    _draw_map(left, summaries, "quiet", 100.0, "(a) share of quiet", "per cent of v in [0, 7.2e-3)")
    _draw_map(right, summaries, "least_rattle", 1e4, "(b) least speed seen to end in rattle", "speed (1e-4)")
    numbers = {
        "half_backlash": _MACHINE.half_backlash,
        "points": _POINTS,
        "fastest": {name: fastest * _MACHINE.damping for name, fastest in _WINDOWS.items()},
        "panels": summaries,
    }
    return Sheet(drawing, numbers)


MACHINE_SWEEP = PaperFigure(
    "machine-sweep", "quiet of the machine over damping and eccentricity, by samples", _make, _basins
)
