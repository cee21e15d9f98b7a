"""Largest Lyapunov exponent of a trajectory of P, with its error estimated.

A tangent vector is carried along by DP and rescaled after every impact; the exponent is the mean growth of its
logarithm per forcing period. The run is cut into blocks long enough to be nearly independent; the scatter of their
means gives the standard error (batch means). Benettin et al. (1980); Flegal and Jones (2010) for the batches.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.capture import is_captured
from rattle_kernels.impact_jacobian import next_impact_with_jacobian
from rattle_kernels.jit import kernel
from rattle_kernels.lane_tables import lane_tables
from rattle_kernels.oscillator import Oscillator

BLOCKS = 64


class LyapunovRun(NamedTuple):
    """Exponent per forcing period, its standard error, whether the trajectory was captured, and its last points."""

    exponent: float
    error: float
    captured: bool
    t: np.ndarray
    v: np.ndarray


@kernel
def _grow(oscillator, bound, speed_scale, t, v, block, growth, elapsed, last_t, last_v):
    dt, dv = 1.0, 0.0
    total = growth.size * block
    for n in range(total):
        if is_captured(oscillator, bound, t, v):
            return True
        impact, jacobian, duration = next_impact_with_jacobian(oscillator, t, v)
        dt, dv = jacobian.tt * dt + jacobian.tv * dv * speed_scale, jacobian.vt * dt / speed_scale + jacobian.vv * dv
        norm = math.hypot(dt, dv)
        growth[n // block] += math.log(norm)
        elapsed[n // block] += duration
        dt, dv = dt / norm, dv / norm
        t, v = impact.t, impact.v
        if n >= total - last_t.size:
            last_t[n - total + last_t.size], last_v[n - total + last_t.size] = t, v
    return False


def lyapunov_exponent(oscillator: Oscillator, t: float, v: float, impacts: int, points: int = 4096) -> LyapunovRun:
    """Largest Lyapunov exponent along the trajectory from a departure.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        Phase and speed of the departure, on or near the attractor.
    impacts : int
        Length of the run; the error falls with its square root.
    points : int
        How many of the last points to return.

    Returns
    -------
    LyapunovRun
        Exponent and error NaN where the trajectory was captured.
    """
    tables = lane_tables(oscillator)
    growth, elapsed = np.zeros(BLOCKS), np.zeros(BLOCKS)
    last_t, last_v = np.empty(points), np.empty(points)
    block = max(impacts // BLOCKS, points // BLOCKS + 1)
    if _grow(oscillator, tables.capture_bound, tables.speed_scale, t, v, block, growth, elapsed, last_t, last_v):
        return LyapunovRun(math.nan, math.nan, True, last_t[:0], last_v[:0])
    exponent = growth.sum() / elapsed.sum()
    scatter = (growth - exponent * elapsed) / elapsed.mean()
    return LyapunovRun(float(exponent), float(scatter.std(ddof=1) / math.sqrt(BLOCKS)), False, last_t, last_v)
