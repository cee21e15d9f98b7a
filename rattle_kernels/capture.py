"""Capture by ever lower bounces: the impacting model's permanent contact.

A ball that bounces low on ground whose acceleration a(t) varies slowly keeps ``v^3/a`` nearly constant; expanding P to
second order in v gives

    ln(v1^3/a1) - ln(v0^3/a0) = -2 delta v0/a0 + O(v0^2),

so damping can only lower it once v is small enough. The region ``v^3 < bound * a(t)`` is safe when P lowers ``v^3/a``
at every point of it: then it is never left, v^3/a falls for ever and v tends to zero; such a motion never rattles
again.

The bound is not guessed. The *descent* q = (change of ln v^3/a) a/(2 delta v) is a smooth function on the region with q
-> -1 as v -> 0. `capture_bound` computes q with P itself on a mesh over the region and takes the largest bound, by
steps of 0.8, at which q <= -1/2 at all nodes while neighbouring nodes differ by less than 1/4: q stays below -1/4 in
between. A -beta contact shows as a jump of q and fails the test.
"""

import math

from rattle_kernels.flight import rest_acceleration
from rattle_kernels.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.impact_map import RETURNED, next_impact
from rattle_kernels.jit import kernel, step

_PHASES = 96
_SPEEDS = 12
_REQUIRED_DESCENT = -0.5
_LARGEST_DIFFERENCE = 0.25
_SHRINK = 0.8
_ROUNDS = 200


@step
def is_captured(oscillator, bound, t, v):
    """Whether the departure (t, v) lies in the safe region ``v^3 < bound a(t)`` of `capture_bound`."""
    return v * v * v < bound * rest_acceleration(oscillator, t)


@step
def descent(oscillator, t, v):
    """Change of ln(v^3/a) under P, in units of 2 delta v/a; -1 in the limit of low bounces, NaN where P fails."""
    before = rest_acceleration(oscillator, t)
    impact = next_impact(oscillator, t, v)
    if impact.outcome != RETURNED:
        return math.nan
    after = rest_acceleration(oscillator, impact.t)
    change = 3.0 * math.log(impact.v / v) - math.log(after / before)
    return change * before / (2.0 * oscillator.damping * v)


@step
def _is_safe(oscillator, bound, previous_row, row):
    for i in range(_PHASES + 1):
        phase = (i % _PHASES) / _PHASES
        edge = (bound * rest_acceleration(oscillator, phase)) ** (1.0 / 3.0)
        below = -1.0
        for j in range(_SPEEDS):
            row[j] = descent(oscillator, phase, edge * (j + 1) / _SPEEDS)
            steep = abs(row[j] - below) >= _LARGEST_DIFFERENCE
            steep = steep or (i > 0 and abs(row[j] - previous_row[j]) >= _LARGEST_DIFFERENCE)
            if steep or not row[j] <= _REQUIRED_DESCENT:
                return False
            below = row[j]
        previous_row[:] = row
    return True


@kernel
def capture_bound(oscillator, previous_row, row):
    """Largest bound on v^3/a found safe; 0 (nothing is ever captured) where none of the steps tried is.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    previous_row, row : ndarray of float64, shape (12,)
        Work space.

    Returns
    -------
    float
    """
    speed, _, _ = grazing_flight(oscillator, 0.0, LEAVING)
    bound = speed * speed * speed / rest_acceleration(oscillator, 0.0)
    for _ in range(_ROUNDS):
        if _is_safe(oscillator, bound, previous_row, row):
            return bound
        bound *= _SHRINK
    return 0.0
