"""Which of many oscillators are within the bounds of Eqs. (3) and (8) for sure, decided for all of them at once.

Both say that a trigonometric polynomial is positive at every phase: the acceleration at rest, and the reaction in
contact without ringing. It is where its mean exceeds the amplitudes of its harmonics. With one harmonic that is the
bound itself, with several it is stricter.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle_kernels import Oscillator
from worker.jobs.budget import spend
from worker.jobs.swept_parameter import SweptParameter, as_array

_TWO_PI = 2.0 * math.pi
# What lies as close to a bound as rounding is decided one by one.
_ROUNDING = 1e-9


def pressed_for_sure(oscillator: Oscillator, vary: Sequence[SweptParameter], *, quiet: bool) -> np.ndarray:
    """Whether each combination of values is within Eq. (8) for sure, and with `quiet` within Eq. (3), too.

    Parameters
    ----------
    oscillator : Oscillator
    vary : sequence of SweptParameter
        Values that are each within their own bounds.
    quiet : bool

    Returns
    -------
    ndarray of bool
        One axis for each parameter. False says nothing.

    Examples
    --------
    >>> stiffness = SweptParameter("stiffness", (10.0, 20.0, 1e3))
    >>> pressed_for_sure(Oscillator(eccentricity=0.15, stiffness=10.0), [stiffness], quiet=True).tolist()
    [True, False, True]
    """
    shape = tuple(len(swept.values) for swept in vary)
    grid = np.meshgrid(*(as_array(swept.values) for swept in vary), indexing="ij", sparse=True)
    values = dict(zip((swept.parameter for swept in vary), grid, strict=True))

    def value(name: str) -> Any:
        return values[name] if name in values else oscillator.value_of(name)

    with np.errstate(all="ignore"):  # what cannot be computed is not for sure
        damping, square = value("damping"), 2.0 * value("stiffness")
        mean, felt, pressed = 2.0 * _TWO_PI * damping, 0.0, 0.0
        for order, _, _ in oscillator.all_harmonics:
            spend()
            rate = _TWO_PI * order
            amplitude = np.abs(value("eccentricity" if order == 1.0 else f"amplitude_{order:g}"))
            of_order = amplitude * rate * np.hypot(rate, damping)
            felt = felt + of_order
            if quiet:
                drag = damping / square + 2.0 * value("contact_damping") / np.sqrt(square)
                pressed = pressed + of_order / np.hypot(1.0 - rate * rate / square, rate * drag)
        most = np.maximum(felt, pressed)
        return np.broadcast_to(mean - most > _ROUNDING * (mean + most), shape)
