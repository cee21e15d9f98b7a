"""Flights, impact maps and cell mapping of a backlash oscillator: NumPy and Numba, nothing else."""

from rattle_kernels.grazing_curve import grazing_velocity
from rattle_kernels.impact_lanes import next_impacts
from rattle_kernels.impact_map import Impacts, previous_impacts
from rattle_kernels.oscillator import (
    Oscillator,
    OutsideDomain,
    check_domain,
    eccentricity_bound_convexity,
    eccentricity_bound_quiet,
    eccentricity_bound_smooth_maxima,
)
from rattle_kernels.outcome import Outcome

__all__ = [
    "Impacts",
    "Oscillator",
    "Outcome",
    "OutsideDomain",
    "check_domain",
    "eccentricity_bound_convexity",
    "eccentricity_bound_quiet",
    "eccentricity_bound_smooth_maxima",
    "grazing_velocity",
    "next_impacts",
    "previous_impacts",
]
