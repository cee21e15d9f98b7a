"""P, its inverse and its derivatives by the careful scalar path: to rounding, where lanes are good to 5e-11.

These are kernels, kept on disk and shared by all tests. A piece that kernels inline can be called from Python as well,
but every test process would compile it anew.
"""

import numpy as np

from rattle_kernels.impact_map.apply import next_impact, previous_impact
from rattle_kernels.impact_map.jacobian import next_impact_with_jacobian
from rattle_kernels.impact_map.loose_map import _follow, contact_by_contact
from rattle_kernels.impact_map.sensitivity import next_impact_with_sensitivity
from rattle_kernels.impact_map.variations import by_speeds
from rattle_kernels.numerics.jit import kernel


@kernel
def departure(oscillator, t, v):
    return next_impact(oscillator, t, v)


@kernel
def bounce(oscillator, t, v):
    return contact_by_contact(oscillator, t, v)


@kernel
def bounce_with_derivative(oscillator, t, v):
    loose, jacobian = _follow(oscillator, t, v, 0.0)
    return loose.impact, by_speeds(jacobian)


@kernel
def derivative(oscillator, t, v):
    return next_impact_with_jacobian(oscillator, t, v)


@kernel
def sensitivity(oscillator, parameter, t, v, over):
    return next_impact_with_sensitivity(oscillator, parameter, t, v, over)


@kernel
def _apply_to_all(oscillator, backwards, t, v, lower_impacts, outcome):
    for i in range(t.size):
        impact = previous_impact(oscillator, t[i], v[i]) if backwards else next_impact(oscillator, t[i], v[i])
        t[i], v[i], lower_impacts[i], outcome[i] = impact.t, impact.v, impact.lower_impacts, impact.outcome


def departures(oscillator, t, v, applications=1):
    """Points after so many applications of P, of its inverse where negative; what the last one met."""
    phase, speed = np.array(t, np.float64), np.array(v, np.float64)
    lower_impacts, outcome = np.zeros(phase.shape, np.int64), np.zeros(phase.shape, np.int8)
    for _ in range(abs(applications)):
        _apply_to_all(oscillator, applications < 0, phase, speed, lower_impacts, outcome)
    return phase, speed, lower_impacts, outcome


def apply(oscillator, t, v, applications):
    """Points after so many applications of P, of its inverse where negative."""
    return departures(oscillator, t, v, applications)[:2]
