"""How far departures are from grazing -beta: by the speed of leaving +beta, and by the speed of meeting -beta."""

import math

import numpy as np

from rattle_kernels.impact_map.arc_flights import next_loose_contact
from rattle_kernels.impact_map.flights import LOWER, UPPER, next_contact
from rattle_kernels.impact_map.grazing_velocity import grazing_velocity
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import chosen_by_field, inlined, kernel


@inlined
def _next_loose_contact(oscillator, phase, velocity):
    return next_loose_contact(oscillator, UPPER, phase, velocity)


@chosen_by_field("arcs", _next_loose_contact)
def _next_contact(oscillator, phase, velocity):
    return next_contact(oscillator, UPPER, phase, velocity, 1.0)


@kernel
def _fill_lower_speeds(oscillator, t, v, lower_speed):
    for i in range(t.size):
        end = _next_contact(oscillator, t[i], -v[i])
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
    lower_speed = np.empty(t.size)
    _fill_lower_speeds(oscillator, t, v, lower_speed)
    return v - grazing_velocity(oscillator, t), lower_speed
