"""Summaries of basins and their motions for the figures' JSON files."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from rattle_kernels import Attractor, AttractorKind, Oscillator
from rattle_paper.numbers.transients import on_transient


def oscillator_summary(oscillator: Oscillator) -> dict[str, Any]:
    """Model and parameters of an oscillator."""
    damping, eccentricity, half_backlash, stiffness, *_ = oscillator
    summary: dict[str, Any] = {"model": "impacting" if math.isinf(stiffness) else "piecewise_linear"}
    summary |= {"damping": damping, "eccentricity": eccentricity, "half_backlash": half_backlash}
    return summary if math.isinf(stiffness) else summary | {"stiffness": stiffness}


def motion_summary(motion: Attractor) -> dict[str, Any]:
    """Name and Lyapunov exponent of a motion, and its points; of a chaotic one, the ranges of its points."""
    summary: dict[str, Any] = {"name": motion.name}
    if motion.kind == AttractorKind.PERIODIC or motion.is_chaotic:
        summary["lyapunov_exponent"] = motion.lyapunov_exponent
    if motion.kind == AttractorKind.PERIODIC:
        summary["points"] = list(zip(motion.time.tolist(), motion.velocity.tolist(), strict=True))
    if motion.is_chaotic:
        summary["lyapunov_error"] = motion.lyapunov_error
        if not math.isnan(motion.mean_life):
            summary["mean_life"] = motion.mean_life
        summary["time_range"] = [float(motion.time.min()), float(motion.time.max())]
        summary["velocity_range"] = [float(motion.velocity.min()), float(motion.velocity.max())]
    return summary


def basin_summary(basin: xr.Dataset) -> dict[str, Any]:
    """Request of a basin, and its motions with their shares and the shares not settled after k applications."""
    wandering, solution = on_transient(basin), basin.rattle.shown.solution.values
    solutions = []
    for index, (motion, share) in enumerate(zip(basin.rattle.catalogue(), basin.share.values.tolist(), strict=True)):
        if math.isnan(share):  # only another basin of the sweep has it
            continue
        summary = {"number": index} | motion_summary(motion) | {"share": share}
        if motion.kind == AttractorKind.PERIODIC:
            summary["share_not_settled"] = float(np.mean(wandering & (solution == index)))
        solutions.append(summary)
    job = basin.rattle.job
    return {
        "oscillator": oscillator_summary(job.oscillator),
        "cells": [job.grid.time_cells, job.grid.velocity_cells],
        "iterations": job.iterations,
        "solutions": solutions,
        "image_counts": basin.rattle.image_counts(),
    }


def cells_that(basin: xr.Dataset, is_so: Callable[[Attractor], bool]) -> np.ndarray:
    """Cells shown that end in a motion of which something holds."""
    return np.array([is_so(motion) for motion in basin.rattle.catalogue()])[basin.rattle.shown.solution.values]


def is_quiet(motion: Attractor) -> bool:
    """Whether a motion is permanent contact."""
    return motion.kind == AttractorKind.PERMANENT_CONTACT


def differences_summary(one: xr.Dataset, other: xr.Dataset) -> dict[str, float]:
    """Share of the cells that end differently in two basins on the same grid.

    ``by_name``: in solutions of different names. ``after_k``: the same, but motions that have not settled after k
    applications count as chaotic, as in the paper. ``quiet_or_not``: in permanent contact in only one of the basins.
    """
    names = [basin.rattle.shown.rattle.cell_names().values for basin in (one, other)]
    by_name = names[0] != names[1]
    quiet = [cells_that(basin, is_quiet) for basin in (one, other)]
    chaotic = [on_transient(basin) | cells_that(basin, lambda motion: motion.is_chaotic) for basin in (one, other)]
    after_k = np.where(chaotic[0] | chaotic[1], chaotic[0] != chaotic[1], by_name)
    return {
        "by_name": float(by_name.mean()),
        "after_k": float(after_k.mean()),
        "quiet_or_not": float((quiet[0] != quiet[1]).mean()),
    }
