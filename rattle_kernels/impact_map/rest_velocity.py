"""The speed below which a loose gear comes to rest on +beta: the edge of all departures that are released as one.

Bounces of a departure accumulate on its arc where it is slow enough (`complete_chatter`). At the edge they accumulate
just as the arc ends. Bounce by bounce P leads along this curve to its end: the release, where it is 0.
"""

import numpy as np

from rattle_kernels.impact_map.complete_chatter import accumulates
from rattle_kernels.impact_map.flights import UPPER
from rattle_kernels.model.arcs import arcs_of
from rattle_kernels.model.bounds import eccentricity_bound_smooth_maxima
from rattle_kernels.model.departures import check_phases
from rattle_kernels.model.domain import check_invertible
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outside_domain import OutsideDomain
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.phase import wrap

# From the scale of speeds: to its last digits, next to a release to 1e-33 of the scale.
_HALVINGS = 110


@kernel
def _fill(oscillator, scale, phase, velocity):
    for i in range(phase.size):
        low, high, t = 0.0, scale, wrap(phase[i])
        while accumulates(oscillator, UPPER, t, high):
            low, high = high, 2.0 * high
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            if middle <= low or middle >= high:
                break
            low, high = (middle, high) if accumulates(oscillator, UPPER, t, middle) else (low, middle)
        velocity[i] = low


def rest_velocity(oscillator: Oscillator, t: np.typing.ArrayLike) -> np.ndarray:
    """Speed below which departures of a loose gear come to rest on +beta before their arc ends.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model, beyond the bound of Eq. (8).
    t : array_like
        Phases of departure from +beta, forcing periods, any finite value.

    Returns
    -------
    ndarray of float64, shape of ``t``
        Found by halving. 0 where a gear is not pressed to +beta, or impacts are elastic.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map, or up to the bound of Eq. (8).
    ValueError
        If a phase is not finite.

    Examples
    --------
    >>> speeds = rest_velocity(Oscillator(eccentricity=0.4, restitution=0.7), [0.1, 0.75])
    >>> bool(speeds[0] == 0.0), bool(speeds[1] > 0.0)
    (True, True)
    """
    checked, phase = check_release(oscillator), check_phases(t)
    velocity = np.zeros(phase.size)
    _fill(checked, largest_grazing_speed(checked), phase.ravel(), velocity)
    return velocity.reshape(phase.shape)


def check_release(oscillator: Oscillator) -> Oscillator:
    """Return an oscillator as `check_invertible` does, or raise if no gear at rest on +beta is released.

    Raises
    ------
    OutsideDomain
        Also up to the bound of Eq. (8): naming the eccentricity, the bound and its value.
    """
    checked = check_invertible(oscillator)
    arcs = arcs_of(checked)
    if arcs is not None and arcs.begin.size > 1:
        return checked
    limit = eccentricity_bound_smooth_maxima(checked)
    message = (
        f"eccentricity must be above epsilon_crit2 = {limit:.6g} (Eq. 8), not {checked.eccentricity:g}: up to it what "
        "rests on +beta is not released, and no flight touches +beta from below"
    )
    raise OutsideDomain("eccentricity", checked.eccentricity, "epsilon_crit2", limit, message)
