"""How far departures are from grazing -beta: by the speed of leaving +beta, and by the speed of meeting -beta."""

import math

import numpy as np

from rattle_kernels.impact_map.flights import LOWER, UPPER, next_contact
from rattle_kernels.model.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel


@kernel
def _grazing_distances(oscillator, t, v, margin, lower_speed):
    for i in range(t.size):
        margin[i] = v[i] - grazing_flight(oscillator, t[i], LEAVING)[0]
        end = next_contact(oscillator, UPPER, t[i], -v[i], 1.0)
        lower_speed[i] = -end.velocity if end.wall == LOWER else math.nan


def grazing_distances(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Margin v - v*(t) of departures, and the speed with which each meets -beta.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : ndarray of float64, shape (n,)

    Returns
    -------
    (ndarray, ndarray), shape (n,)
        The margin, positive where -beta is met; the speed there, NaN where it is not met.
    """
    margin, lower_speed = np.empty(t.size), np.empty(t.size)
    _grazing_distances(oscillator, t, v, margin, lower_speed)
    return margin, lower_speed
