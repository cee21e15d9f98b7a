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
from rattle_kernels.impact_map import RETURNED
from rattle_kernels.jit import kernel
from rattle_kernels.lane_tables import lane_tables
from rattle_kernels.oscillator import Oscillator

BLOCKS = 64
_STANDARD_ERRORS = 5.0
# A motion that bounces ever lower needs less and less time for an impact; one on an attractor does not.
_LEAST_PACE = 0.5


class LyapunovRun(NamedTuple):
    """Exponent per forcing period and its standard error, whether the trajectory was captured, and its last points.

    ``pace`` is the time that the last quarter of the run took, as a part of what the first quarter took.
    """

    exponent: float
    error: float
    captured: bool
    pace: float
    t: np.ndarray
    v: np.ndarray

    @property
    def chaotic(self) -> bool:
        """Whether this is chaos on an attractor: an exponent five standard errors above zero, and a steady pace.

        The second matters for low bounces, thousands of which fit into a period: close to the bound of Eq. (8) their
        tangent vectors grow while they decay, and the exponent alone would take the decay for an attractor.
        """
        return self.exponent > _STANDARD_ERRORS * self.error and self.pace > _LEAST_PACE


@kernel
def _grow(oscillator, bound, speed_scale, t, v, block, growth, elapsed, last_t, last_v):
    dt, dv = 1.0, 0.0
    total = growth.size * block
    for n in range(total):
        if is_captured(oscillator, bound, t, v):
            return True
        impact, jacobian = next_impact_with_jacobian(oscillator, t, v)
        if impact.outcome != RETURNED:
            return True
        dt, dv = jacobian.tt * dt + jacobian.tv * dv * speed_scale, jacobian.vt * dt / speed_scale + jacobian.vv * dv
        norm = math.hypot(dt, dv)
        growth[n // block] += math.log(norm)
        elapsed[n // block] += impact.duration
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
        return LyapunovRun(math.nan, math.nan, True, math.nan, last_t[:0], last_v[:0])
    exponent = growth.sum() / elapsed.sum()
    scatter = (growth - exponent * elapsed) / elapsed.mean()
    error = scatter.std(ddof=1) / math.sqrt(BLOCKS)
    pace = elapsed[-BLOCKS // 4 :].sum() / elapsed[: BLOCKS // 4].sum()
    return LyapunovRun(float(exponent), float(error), False, float(pace), last_t, last_v)
