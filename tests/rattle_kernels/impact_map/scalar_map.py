"""P and its inverse, many times, by the careful scalar path: to rounding, where lanes are good to 5e-11."""

import numpy as np

from rattle_kernels.impact_map.apply import _apply_to_all


def apply(oscillator, t, v, applications):
    """Points after so many applications of P, of its inverse where negative."""
    phase, speed = np.array(t, np.float64), np.array(v, np.float64)
    lower_impacts, outcome = np.zeros(phase.shape, np.int64), np.zeros(phase.shape, np.int8)
    for _ in range(abs(applications)):
        _apply_to_all(oscillator, float(np.sign(applications)), phase, speed, lower_impacts, outcome)
    return phase, speed
