"""Share of quiet and least speed that ends in rattle, over the machine's damping and eccentricity, by sampling."""

import math
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle import BasinJob, Sample, SweepJob, SweptParameter
from rattle_kernels import AttractorKind, CellGrid, capture_velocity
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.figures.machine import machine_oscillator
from rattle_paper.numbers.solutions import cells_that, is_quiet

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


def _summary(whole: xr.Dataset, low: xr.Dataset) -> dict[str, Any]:
    """One basin, in both windows."""
    oscillator, share, kinds = whole.rattle.oscillator, whole.share.values, whole.kind.values
    quiet, rattles = kinds == AttractorKind.PERMANENT_CONTACT, ~cells_that(low, is_quiet)
    largest = np.argsort(-np.where(np.isfinite(share) & ~quiet, share, -1.0))[:3]
    return {
        "damping": oscillator.damping,
        "eccentricity": oscillator.eccentricity,
        "quiet": float(share[quiet][0]),
        "quiet_error": float(whole.share_error.values[quiet][0]),
        "undecided": float(np.nansum(share[kinds == AttractorKind.UNDECIDED])),
        "motions": int((np.nan_to_num(share) > 0.0).sum()),
        "largest": [[str(whole.name.values[i]), float(share[i])] for i in largest if share[i] > 0.0],
        "least_rattle": float(low.velocity.values[rattles].min()) if rattles.any() else None,
        # Departures at all phases lie in the region of capture.
        "proven_quiet_below": float(capture_velocity(oscillator, _PHASES).min()),
    }


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


def _make(results: Results, report: Report) -> Sheet:
    report("drawing", 0, 1)
    windows = [results[name].rattle.basins() for name in _WINDOWS]
    summaries = [_summary(whole, low) for whole, low in zip(*windows, strict=True)]
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
