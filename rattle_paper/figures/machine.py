"""Basins as damping falls to the machine's own: delta = 0.06, 6e-3 and 6e-4 with beta = delta and eps = delta/6."""

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from rattle import BasinJob
from rattle_kernels import Attractor, AttractorKind, CellGrid, Oscillator
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import cells_that, is_quiet, oscillator_summary
from rattle_paper.panels.basin_panel import draw_panel, model_of

_DAMPINGS = {"delta 0.06": 0.06, "delta 6e-3": 6e-3, "delta 6e-4": 6e-4}
_STIFFNESS = 1000.0
# Highest speed of the window, in units of delta.
_FASTEST = 12.0
_LEGEND = 14


def machine_oscillator(damping: float, stiffness: float = math.inf) -> Oscillator:
    """The machine's oscillator at another damping. Backlash and eccentricity scale with it."""
    return Oscillator(damping=damping, eccentricity=damping / 6.0, half_backlash=damping, stiffness=stiffness)


def _basins_of(stiffness: float) -> Callable[[CellGrid], dict[str, BasinJob]]:
    def basins(grid: CellGrid) -> dict[str, BasinJob]:
        return {
            name: BasinJob(
                oscillator=machine_oscillator(damping, stiffness), grid=grid._replace(velocity_stop=_FASTEST * damping)
            )
            for name, damping in _DAMPINGS.items()
        }

    return basins


def _motion_summary(motion: Attractor, share: float, error: float) -> dict[str, Any]:
    summary: dict[str, Any] = {"name": motion.name, "share": share, "share_error": error}
    if motion.kind == AttractorKind.PERIODIC:
        slowest = int(np.argmin(motion.velocity))
        summary["slowest"] = [float(motion.time[slowest]), float(motion.velocity[slowest])]
    return summary


def _summary(basin: xr.Dataset) -> dict[str, Any]:
    job = basin.rattle.job
    grid = job.grid
    by_share = sorted(
        zip(basin.share.values.tolist(), basin.rattle.catalogue(), strict=True), key=lambda each: -each[0]
    )
    return {
        "oscillator": oscillator_summary(job.oscillator),
        "cells": [grid.time_cells, grid.velocity_cells],
        "fastest": grid.velocity_stop,
        "iterations": job.iterations,
        "image_counts": basin.rattle.image_counts(),
        "solutions": [
            _motion_summary(motion, share, math.sqrt(share * (1.0 - share) / grid.cells)) for share, motion in by_share
        ],
        "least_rattle": _least_rattle(basin),
        "seconds": {name: round(value, 1) for name, value in json.loads(basin.attrs["seconds"]).items()},
    }


def _least_rattle(basin: xr.Dataset) -> dict[str, Any]:
    """The slowest of the cells shown that does not end in permanent contact."""
    row, column = (int(at[0]) for at in np.nonzero(~cells_that(basin, is_quiet)))
    cell = basin.rattle.shown.isel(velocity=row, time=column)
    return {"time": float(cell.time), "velocity": float(cell.velocity), "ends_in": cell.rattle.cell_names().item()}


def _legend(basin: xr.Dataset) -> list[Patch]:
    """Legend entries of the motions with the largest shares, and one entry for all others."""
    names, shares, palette = basin.name.values, basin.share.values.tolist(), basin.rattle.colours
    order = sorted(range(len(shares)), key=lambda each: -shares[each])
    entries = [Patch(color=palette[i], label=f"{names[i]}  {100.0 * shares[i]:.2f} %") for i in order[:_LEGEND]]
    others = order[_LEGEND:]
    if others:
        share = 100.0 * sum(shares[i] for i in others)
        entries.append(Patch(color="none", label=f"{len(others)} others  {share:.2f} %"))
    return entries


def _make(results: Results, report: Report) -> Sheet:
    drawing = Figure(figsize=(17.0, 5.2), dpi=80, layout="constrained")
    summaries = {}
    for number, (axes, (name, basin)) in enumerate(
        zip(drawing.subplots(1, len(results)), results.items(), strict=True)
    ):
        report("drawing", number, len(results))
        draw_panel(axes, basin, ())
        axes.set_title(f"({'abc'[number]}) {model_of(basin.rattle.oscillator)}, {name}", fontsize="medium")
        axes.legend(handles=_legend(basin), loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="x-small")
        summaries[name] = _summary(basin)
    return Sheet(drawing, {"panels": summaries})


MACHINE = PaperFigure("machine", "basins of the machine as damping falls to its own", _make, _basins_of(math.inf))
MACHINE_SOFT = PaperFigure("machine-soft", "the same with its stiffness, kappa = 1000", _make, _basins_of(_STIFFNESS))
