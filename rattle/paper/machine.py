"""Basins as damping falls to the machine's own: delta = 0.06, 6e-3 and 6e-4 with beta = delta and eps = delta/6."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from rattle.paper.figure import PaperFigure, Report, Sheet
from rattle.paper.numbers.solutions import oscillator_summary
from rattle.paper.panels.basin_panel import draw_panel, model_of
from rattle.paper.panels.basin_view import BasinView, view_basin
from rattle_kernels import Attractor, AttractorKind, CellGrid, Oscillator
from worker.jobs.basin_job import BasinJob
from worker.pictures.colours import colours_of
from worker.views.reading import open_basin

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


def _summary(location: str, view: BasinView) -> dict[str, Any]:
    grid = view.job.grid
    by_share = sorted(zip(view.shares, view.attractors, strict=True), key=lambda each: -each[0])
    seconds = open_basin(location).attrs["seconds"]
    return {
        "oscillator": oscillator_summary(view.oscillator),
        "cells": [grid.time_cells, grid.velocity_cells],
        "fastest": grid.velocity_stop,
        "iterations": view.job.iterations,
        "image_counts": view.image_counts,
        "solutions": [
            _motion_summary(motion, share, math.sqrt(share * (1.0 - share) / grid.cells)) for share, motion in by_share
        ],
        "least_rattle": _least_rattle(view),
        "seconds": {name: round(value, 1) for name, value in seconds.items()},
    }


def _least_rattle(view: BasinView) -> dict[str, Any]:
    """The slowest of the cells shown that does not end in permanent contact."""
    rattles = np.array([motion.kind != AttractorKind.PERMANENT_CONTACT for motion in view.attractors])[view.solution]
    row, column = (int(at[0]) for at in np.nonzero(rattles))
    grid = view.job.grid
    motion = view.attractors[view.solution[row, column]]
    return {
        "time": float(grid.time_centres()[column]), "velocity": float(grid.velocity_centres()[row]),
        "ends_in": motion.name,
    }  # fmt: skip


def _legend(view: BasinView) -> list[Patch]:
    """Legend entries of the motions with the largest shares, and one entry for all others."""
    order = sorted(range(len(view.shares)), key=lambda each: -view.shares[each])
    palette = colours_of(view.attractors)
    entries = [
        Patch(color=palette[i], label=f"{view.attractors[i].name}  {100.0 * view.shares[i]:.2f} %")
        for i in order[:_LEGEND]
    ]
    others = order[_LEGEND:]
    if others:
        share = 100.0 * sum(view.shares[i] for i in others)
        entries.append(Patch(color="none", label=f"{len(others)} others  {share:.2f} %"))
    return entries


def _make(stores: Mapping[str, str], report: Report) -> Sheet:
    drawing = Figure(figsize=(17.0, 5.2), dpi=80, layout="constrained")
    summaries = {}
    for number, (axes, name) in enumerate(zip(drawing.subplots(1, len(stores)), stores, strict=True)):
        report("drawing", number, len(stores))
        view = view_basin(stores[name])
        draw_panel(axes, view, ())
        axes.set_title(f"({'abc'[number]}) {model_of(view.oscillator)}, {name}", fontsize="medium")
        axes.legend(handles=_legend(view), loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="x-small")
        summaries[name] = _summary(stores[name], view)
    return Sheet(drawing, {"panels": summaries})


MACHINE = PaperFigure("machine", "basins of the machine as damping falls to its own", _make, _basins_of(math.inf))
MACHINE_SOFT = PaperFigure("machine-soft", "the same with its stiffness, kappa = 1000", _make, _basins_of(_STIFFNESS))
