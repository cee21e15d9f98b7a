"""Summaries of basins and their motions for the figures' JSON files."""

import math
from typing import Any

import numpy as np

from rattle.paper.numbers.transients import on_transient
from rattle.paper.panels.basin_view import BasinView
from rattle_kernels import Attractor, AttractorKind, Oscillator
from rattle_kernels.attractors.attractor import PERMANENT_CONTACT_ATTRACTOR


def oscillator_summary(oscillator: Oscillator) -> dict[str, Any]:
    """Model and parameters of an oscillator."""
    damping, eccentricity, half_backlash, stiffness, _ = oscillator
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


def basin_summary(view: BasinView) -> dict[str, Any]:
    """Request of a basin, and its motions with their shares and the shares not settled after k applications."""
    wandering = on_transient(view)
    solutions = []
    for index, (motion, share) in enumerate(zip(view.attractors, view.shares, strict=True)):
        if math.isnan(share):  # only another basin of the sweep has it
            continue
        summary = {"number": index} | motion_summary(motion) | {"share": share}
        if motion.kind == AttractorKind.PERIODIC:
            summary["share_not_settled"] = float(np.mean(wandering & (view.solution == index)))
        solutions.append(summary)
    grid = view.job.grid
    return {
        "oscillator": oscillator_summary(view.oscillator),
        "cells": [grid.time_cells, grid.velocity_cells],
        "iterations": view.job.iterations,
        "solutions": solutions,
        "image_counts": view.image_counts,
    }


def _wanders(view: BasinView) -> np.ndarray:
    return np.array([motion.is_chaotic for motion in view.attractors])[view.solution]


def differences_summary(one: BasinView, other: BasinView) -> dict[str, float]:
    """Share of the cells that end differently in two basins on the same grid.

    ``by_name``: in solutions of different names. ``after_k``: the same, but motions that have not settled after k
    applications count as chaotic, as in the paper. ``quiet_or_not``: in permanent contact in only one of the basins.
    """
    by_name = one.names != other.names
    quiet = [view.names == PERMANENT_CONTACT_ATTRACTOR.name for view in (one, other)]
    chaotic = [on_transient(view) | _wanders(view) for view in (one, other)]
    after_k = np.where(chaotic[0] | chaotic[1], chaotic[0] != chaotic[1], by_name)
    return {
        "by_name": float(by_name.mean()),
        "after_k": float(after_k.mean()),
        "quiet_or_not": float((quiet[0] != quiet[1]).mean()),
    }
