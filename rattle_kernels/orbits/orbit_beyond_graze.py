"""The orbit on the other side of a graze (impacting model): one flight meets -beta instead of missing it.

Seen from +beta, the orbits that meet the wall begin at a graze with an infinite DP, where Newton's method fails. Seen
from the touch they begin smoothly. Let -beta be met at phase t with speed u. The flight up from there, then n+ - 1
applications of P, lead to the departure before the next contact. The flight backwards in time from that contact leads
to the same departure:

    (departure reached forwards from (t, r u)) = (departure reached backwards from (t + m, u)).

These are two equations in (t, u, p), smooth through u = 0, where the graze is. Solved at a small given u, they give the
other orbit and the side of the graze on which it exists. If the orbit that misses is on the opposite side, a motion
merely changes its name. If it is on the same side, the two meet and vanish (a nonsmooth fold).
"""

import numpy as np

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.flights import LOWER, next_contact
from rattle_kernels.model.domain import check_impacting
from rattle_kernels.model.flight import fall_speed
from rattle_kernels.model.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pseudo_arclength import solve
from rattle_kernels.orbits.bifurcation_point import SpecialPoint
from rattle_kernels.orbits.closure import OrbitShape
from rattle_kernels.orbits.orbit_equations import SpecialKind, unknowns, with_differences
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit


@kernel
def _meeting(oscillator, shape, t, u):
    """Gap in time and speed between the forward and the backward departure, then the backward one."""
    up = next_contact(oscillator, LOWER, t, oscillator.restitution * u, 1.0)
    back = next_contact(oscillator, LOWER, t, -u, -1.0)
    here, speed, elapsed = up.phase, oscillator.restitution * up.velocity, up.duration
    for _ in range(shape.upper_contacts - 1):
        impact = next_impact(oscillator, here, speed)
        if impact.outcome != OUTCOME_RETURNED:
            return np.nan, np.nan, np.nan, np.nan
        here, speed = impact.t, impact.v
        elapsed += impact.duration
    before = abs(back.velocity)
    return elapsed - back.duration - shape.forcing_periods, speed - before, t + back.duration, before


@kernel
def _touch_phase(oscillator, t):
    return t + grazing_flight(oscillator, t, LEAVING)[1]


def orbit_beyond_graze(point: SpecialPoint, lower_speed: float = 0.01) -> tuple[Oscillator, PeriodicOrbit] | None:
    """Orbit that meets -beta where the orbit of a graze just touches it.

    Parameters
    ----------
    point : SpecialPoint
        A graze of the impacting model.
    lower_speed : float
        Small speed at which to meet -beta, relative to a fall through the backlash.

    Returns
    -------
    (Oscillator, PeriodicOrbit) or None
        The oscillator that has this orbit, and the orbit. None if Newton's method does not find it.

    Raises
    ------
    OutsideDomain
        If the stiffness is finite: there `continue_orbit` passes the graze by itself.
    ValueError
        If the point is not a graze.
    """
    if point.kind != SpecialKind.GRAZING:
        raise ValueError(f"the point must be a graze, not a {point.kind}")
    oscillator = check_impacting(point.oscillator)
    scale = float(fall_speed(oscillator))
    space = unknowns(oscillator, (point.parameter,))
    shape = OrbitShape(point.forcing_periods, point.upper_contacts)

    def gap(z: np.ndarray) -> np.ndarray | None:
        read = space.read(z)
        if read is None:
            return None
        time, speed, _, _ = _meeting(read[0], shape, read[1], read[2])
        return np.array([time, speed / scale]) if np.isfinite(time) else None

    touch = _touch_phase(oscillator, float(point.t[0]))
    guess = space.write(oscillator, touch, lower_speed * scale)
    solution = solve(with_differences(gap, space), guess, np.array([0.0, 1.0, 0.0]))
    read = None if solution is None else space.read(solution.z)
    if read is None:
        return None
    _, _, t, v = _meeting(read[0], shape, read[1], read[2])
    orbit = find_periodic_orbit(read[0], t, v, shape.upper_contacts, scale)
    return None if orbit is None or orbit.lower_contacts != point.lower_contacts + 1 else (read[0], orbit)
