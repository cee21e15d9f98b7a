"""Numbers of a basin and its motions, as the figures' JSON files hold them."""

import math
from typing import Any

import numpy as np

from rattle.paper.numbers.transients import on_transient
from rattle.paper.panels.basin_view import BasinView
from rattle_kernels import Attractor, AttractorKind, Oscillator
from rattle_kernels.attractors.attractor import PERMANENT_CONTACT_ATTRACTOR


def told_oscillator(oscillator: Oscillator) -> dict[str, Any]:
    """Parameters of an oscillator."""
    damping, eccentricity, half_backlash, stiffness, _ = oscillator
    told: dict[str, Any] = {"model": "impacting" if math.isinf(stiffness) else "piecewise_linear"}
    told |= {"damping": damping, "eccentricity": eccentricity, "half_backlash": half_backlash}
    return told if math.isinf(stiffness) else told | {"stiffness": stiffness}


def told_motion(motion: Attractor) -> dict[str, Any]:
    """Name and exponent of a motion; where it is, by its points or, of a chaotic one, by their ranges."""
    told: dict[str, Any] = {"name": motion.name}
    if motion.kind == AttractorKind.PERIODIC or motion.is_chaotic:
        told["lyapunov_exponent"] = motion.lyapunov_exponent
    if motion.kind == AttractorKind.PERIODIC:
        told["points"] = list(zip(motion.time.tolist(), motion.velocity.tolist(), strict=True))
    if motion.is_chaotic:
        told["lyapunov_error"] = motion.lyapunov_error
        if not math.isnan(motion.mean_life):
            told["mean_life"] = motion.mean_life
        told["time_range"] = [float(motion.time.min()), float(motion.time.max())]
        told["velocity_range"] = [float(motion.velocity.min()), float(motion.velocity.max())]
    return told


def told_basin(view: BasinView) -> dict[str, Any]:
    """Request of a basin, and its motions with their shares of the cells, and of those not settled after k."""
    wandering = on_transient(view)
    solutions = []
    for index, (motion, share) in enumerate(zip(view.attractors, view.shares, strict=True)):
        if math.isnan(share):  # another basin of the sweep has it
            continue
        told = {"number": index} | told_motion(motion) | {"share": share}
        if motion.kind == AttractorKind.PERIODIC:
            told["share_not_settled"] = float(np.mean(wandering & (view.solution == index)))
        solutions.append(told)
    grid = view.job.grid
    return {
        "oscillator": told_oscillator(view.oscillator),
        "cells": [grid.time_cells, grid.velocity_cells],
        "iterations": view.job.iterations,
        "solutions": solutions,
        "image_counts": view.image_counts,
    }


def _wanders(view: BasinView) -> np.ndarray:
    return np.array([motion.is_chaotic for motion in view.attractors])[view.solution]


def told_differences(one: BasinView, other: BasinView) -> dict[str, float]:
    """Share of the cells that end differently in two basins over one grid.

    ``by_name``: in solutions of different names. ``after_k``: the same, but motions that have not settled after k
    applications count as chaotic, as the paper takes them. ``quiet_or_not``: in permanent contact in one only.
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
