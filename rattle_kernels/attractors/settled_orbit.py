"""The periodic orbit on which a trajectory has settled, or nearly so.

If a trajectory returns close to itself after p impacts, Newton's method refines the orbit there, and its multipliers
decide. Slow convergence is not chaos.
"""

import math

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit

_LONGEST_PERIOD = 512
_LONGEST_DOUBLED = 4096
_CLOSE_RETURN = 1e-6


def attractor_of(orbit: PeriodicOrbit) -> Attractor:
    """An attracting periodic orbit as an attractor."""
    return Attractor(
        AttractorKind.PERIODIC, orbit.forcing_periods, orbit.upper_contacts, orbit.lower_contacts,
        orbit.lyapunov_exponent, 0.0, orbit.t, orbit.v,
    )  # fmt: skip


@kernel
def _distances_on_return(oscillator, t, v, scale, distances):
    """Distance from a departure after 1, 2, ... impacts, up to a close return; infinite once contact is permanent."""
    here_t, here_v = t, v
    distances[:] = math.inf
    for i in range(distances.size):
        impact = next_impact(oscillator, here_t, here_v)
        if impact.outcome != OUTCOME_RETURNED:
            return
        here_t, here_v = impact.t, impact.v
        apart = here_t - t
        distances[i] = math.hypot(apart - math.floor(apart + 0.5), (here_v - v) / scale)
        if distances[i] < _CLOSE_RETURN:
            return


def _closest_return(oscillator: Oscillator, t: float, v: float) -> tuple[int, float]:
    """Impact period after which a trajectory first returns within 1e-6, or else closest; and that distance."""
    distances = np.empty(_LONGEST_PERIOD)
    _distances_on_return(oscillator, t, v, largest_grazing_speed(oscillator), distances)
    close = np.flatnonzero(distances < _CLOSE_RETURN)
    period = int(close[0] if close.size else np.argmin(distances))
    return period + 1, float(distances[period])


def _down_the_cascade(
    oscillator: Oscillator, t: float, v: float, period: int, orbit: PeriodicOrbit
) -> PeriodicOrbit | None:
    """The orbit near a departure into which period doublings have turned a repelling one.

    In a cascade, orbits come to lie closer to each other than the distance of a close return.
    """
    scale = largest_grazing_speed(oscillator)
    while not orbit.attracts and orbit.multipliers.real.min() < -1.0 and 2 * period <= _LONGEST_DOUBLED:
        period *= 2
        doubled = find_periodic_orbit(oscillator, t, v, period, scale)
        if doubled is None or doubled.upper_contacts <= orbit.upper_contacts:
            return None  # the same orbit again: not a cascade
        orbit = doubled
    return orbit


def settled_orbit(oscillator: Oscillator, t: float, v: float) -> PeriodicOrbit | None:
    """The attracting periodic orbit that a settled trajectory approaches.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        Phase and speed of one of its departures.

    Returns
    -------
    PeriodicOrbit or None
    """
    scale = largest_grazing_speed(oscillator)
    period, distance = _closest_return(oscillator, t, v)
    if distance > 1e-3:
        return None
    orbit = find_periodic_orbit(oscillator, t, v, period, scale)
    if orbit is not None and not orbit.attracts:
        orbit = _down_the_cascade(oscillator, t, v, period, orbit)
    if orbit is None or not orbit.attracts:
        return None
    apart = orbit.t - t
    near = np.hypot(apart - np.rint(apart), (orbit.v - v) / scale).min()
    # Converging like lambda^n, a trajectory that moves by d in one turn is d/(1 - lambda) away.
    allowed = 10.0 * distance / (1.0 - np.abs(orbit.multipliers).max()) + 1e-9
    return orbit if near <= allowed else None
