"""The scaled-up oscillator of Secs. 5 and 6: delta = 0.6, beta = 0.6, epsilon = 0.1."""

import math

from rattle import BasinJob
from rattle_kernels import CellGrid, Oscillator

ITERATIONS = 1499


def papers_oscillator(stiffness: float = math.inf, damping: float = 0.6) -> Oscillator:
    """Oscillator of the paper's Secs. 5 and 6 with a given stiffness; by default, the impacting model."""
    return Oscillator(damping=damping, eccentricity=0.1, half_backlash=0.6, stiffness=stiffness)


def papers_basin(grid: CellGrid, stiffness: float = math.inf, damping: float = 0.6) -> BasinJob:
    """Job of that oscillator's basins under ``P_corr o P^1499``."""
    return BasinJob(oscillator=papers_oscillator(stiffness, damping), grid=grid, iterations=ITERATIONS)
