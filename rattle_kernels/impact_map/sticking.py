"""Capture by impacts that lose energy: ever lower bounces on +beta shrink geometrically, and contact is then permanent.

Let a(t) lie between a_- > 0 and a_+, and change at a rate of at most L. A bounce that leaves at speed v rises for v/a_-
at most and up to v^2/(2 a) at most, a the least acceleration on its way, since damping and forcing both hold it back.
It falls with at most the largest acceleration on its way, so it arrives with u <= v sqrt(a_max/a_min), and after

    T <= 3 v/a_-    if    delta v sqrt(a_+/a_-) <= 3/4 a_-,

for then its acceleration is a_-/4 at least. On the way a changes by L T at most. So the action ``2/3 v^3/a`` is
multiplied in a bounce and its impact by

    r^3 (u/v)^3 a(t)/a(t') <= r^3 (1 + 3 L v/a_-^2)^(5/2),

less than 1 while ``3 L v/a_-^2 < r^(-6/5) - 1``. It then falls geometrically, speeds and durations with it. Their sum
is finite, and at its end a(t) > 0 presses on for ever. On -beta nothing sticks: there the acceleration points away.
"""

import math

import numpy as np

from rattle_kernels.model.arcs import rest_acceleration_over_phases
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.trigonometric_minimum import least_value

# Kept from every bound, for rounding.
_MARGIN = 1.0 - 1e-9
_LEAST_RESTITUTION = 1e-3


def sticking_bound(oscillator: Oscillator) -> float:
    """Bound on ``1.5 J`` (`chatter`) below which impacts that lose energy capture a departure.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model, checked by the caller.

    Returns
    -------
    float
        0 where impacts are elastic.
    """
    felt = rest_acceleration_over_phases(oscillator)
    least, most = least_value(felt)[0] * _MARGIN - 1e-14 * felt.size, felt.size
    change = float((2.0 * math.pi * felt.order * np.hypot(felt.cosine, felt.sine)).sum())
    # What holds for an r holds for every smaller one, whose power might be too large for a float.
    slack = max(oscillator.restitution, _LEAST_RESTITUTION) ** -1.2 - 1.0
    if not (least > 0.0 and slack > 0.0):
        return 0.0
    slow = slack * least * least / (3.0 * change) if change > 0.0 else math.inf
    steep = 0.75 * least**1.5 / (oscillator.damping * math.sqrt(most))
    low = math.sqrt(4.0 * oscillator.half_backlash * least)
    return (_MARGIN * min(slow, steep, low)) ** 3 / most
