"""The grazing curve of any machine: from which speed on a departure meets -beta before it comes back to +beta.

Of two flights that leave +beta at one phase, the faster one is always lower: ``y(tau)`` falls by ``(1 - e^(-delta
tau))/delta`` for each unit of speed. So it comes back later, and reaches lower before it does. The speeds from which on
-beta is met first are those above v*(t), at any phase, also beyond Eq. (8).

Below Eq. (8) the flight at v*(t) touches -beta, and is known in closed form (`model.grazing_curve`). Beyond it a flight
may turn at +beta and set out once more. Where the one that just clears +beta reaches -beta, v*(t) is the speed of that
one, and jumps. Where a departure without any speed reaches -beta, v*(t) is 0. So it is found by halving.
"""

import math

import numpy as np

from rattle_kernels.impact_map.arc_flights import next_loose_contact
from rattle_kernels.impact_map.flights import LOWER, UPPER
from rattle_kernels.impact_map.loose_map import RELEASED
from rattle_kernels.model.arcs import is_pressed
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.grazing_curve import fill_grazing_velocities, largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.phase import wrap

# Down to neighbouring numbers, of speeds above 1e-3 of the scale; below it to 1e-19 of the scale.
_HALVINGS = 64


@inlined
def _meets_lower(oscillator, phase, speed):
    return next_loose_contact(oscillator, UPPER, phase, -speed).wall == LOWER


@kernel
def _fill_loose(oscillator, scale, phase, velocity):
    for i in range(phase.size):
        velocity[i] = math.nan
        if not math.isfinite(phase[i]):
            continue
        low, high = 0.0, scale
        while not _meets_lower(oscillator, phase[i], high):
            low, high = high, 2.0 * high
        if not is_pressed(oscillator.arcs, UPPER, wrap(phase[i])) and _meets_lower(oscillator, phase[i], RELEASED):
            high = 0.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if middle == 0.0 or _meets_lower(oscillator, phase[i], middle) else (middle, high)
        velocity[i] = high


def grazing_velocity(oscillator: Oscillator, t: np.typing.ArrayLike) -> np.ndarray:
    """Grazing curve v*(t): departures faster than v* reach -beta, slower ones fall back to +beta.

    Parameters
    ----------
    oscillator : Oscillator
        Either model: the curve depends on freeplay alone. Also beyond the bound of Eq. (8).
    t : array_like
        Phases of departure from +beta, forcing periods, any finite value.

    Returns
    -------
    ndarray of float64, shape of ``t``
        Positive; NaN where ``t`` is not finite. Beyond Eq. (8) it may jump, and is 0 where a gear that is released
        without speed reaches -beta.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.

    References
    ----------
    Sec. 2.1, Eqs. (9-13), solved for the time between departure and graze.
    """
    phase = np.asarray(t, dtype=np.float64)
    velocity = np.empty(phase.size)
    checked = check_oscillator(oscillator)
    if checked.is_loose:
        _fill_loose(checked, largest_grazing_speed(checked), phase.ravel(), velocity)
    else:
        fill_grazing_velocities(checked._replace(stiffness=math.inf), phase.ravel(), velocity)
    return velocity.reshape(phase.shape)
