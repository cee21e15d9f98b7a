"""Special points of periodic orbits: saddle-node, period doubling, grazing and contact loss, each by its own equations.

*Saddle-node*: a multiplier is +1, trace DP^p = 1 + e^{-delta m}. *Period doubling*: a multiplier is -1, trace
DP^p = -1 - e^{-delta m}. A Neimark-Sacker bifurcation is impossible: the multipliers' product is e^{-delta m} < 1
(`periodic_orbit`).

*Grazing*: a flight of the orbit touches -beta with zero speed, v = v*(t) at its departure. On orbits that miss the wall
the departure speed reaches v*. On orbits that meet it, the speed there falls to zero like the square root of v - v*,
and DP grows without bound (impacting model). The touching flight itself belongs to both. The equations use a flight
that passes -beta as if it were not there, and so stay smooth.

*Contact loss* (finite stiffness): a contact with +beta touches Phi = +beta from inside at phase t, x = x' = 0. Beyond
this point it splits in two, with one more departure, of speed 0, in between. The orbit is followed from rest on the
wall at t through its departures to its last contact. There x and x', a time m after t, are the equations in (t, p).

Newton's method solves the closing equations and the special one together, in (t, v, p). The gradient of the special
equation is not known in closed form and is taken by central differences. Their error slows the last step or two and
does not enter the result.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.flights import UPPER
from rattle_kernels.model.bounds import eccentricity_bound_smooth_maxima
from rattle_kernels.model.contact import enter_contact, state_in_contact
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.phase import wrap
from rattle_kernels.numerics.pseudo_arclength import solve
from rattle_kernels.orbits.closure import OrbitShape, closure, departures_from
from rattle_kernels.orbits.orbit_equations import (
    SpecialKind,
    entry_after,
    from_rest,
    special_system,
    unknowns,
)
from rattle_kernels.orbits.periodic_orbit import orbit_name

# A curve that runs into the bound of Eq. (8) stalls within this fraction of it.
_EDGE = 1e-5
# Samples of a contact among which its least depth is sought, as a first guess.
_SAMPLES = 400


class SpecialPoint(NamedTuple):
    """A located special point.

    ``oscillator`` has the parameter's value there. ``t``, ``v`` (shape (upper_contacts,)) are the orbit's departures.
    The first is the one that grazes, or the one of speed 0 at which contact is lost. ``multipliers`` are the
    eigenvalues of DP^p: for a graze on the orbits that miss the wall, NaN for contact loss. ``residual`` is the
    residual of the equations (phases in periods, speeds relative to a fall through the backlash). ``error`` is the last
    Newton step in the parameter.
    """

    kind: SpecialKind
    parameter: str
    value: float
    oscillator: Oscillator
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    t: np.ndarray
    v: np.ndarray
    multipliers: np.ndarray
    residual: float
    error: float

    @property
    def orbit_name(self) -> str:
        """``P(m, n+, n-)``, with a star if it comes to rest."""
        rests = not self.multipliers.any()
        return orbit_name(self.forcing_periods, self.upper_contacts, self.lower_contacts, rests=rests)


def nears_edge_of_domain(oscillator: Oscillator) -> bool:
    """Whether the eccentricity is just below the bound of Eq. (8), beyond which P is not defined."""
    bound = eccentricity_bound_smooth_maxima(oscillator)
    return bool(bound - oscillator.eccentricity < _EDGE * bound)


@kernel
def _shallowest(oscillator, t, v):
    """Phase of the least depth inside any contact with +beta after these departures; NaN if none has a minimum."""
    least, phase = math.inf, math.nan
    for i in range(t.size):
        elapsed, begins, velocity = entry_after(oscillator, t[i], v[i])
        length = next_impact(oscillator, t[i], v[i]).duration - elapsed
        stay = enter_contact(oscillator, UPPER, begins, 0.0, velocity)
        falling = False
        for n in range(1, _SAMPLES):
            motion = state_in_contact(stay, length * n / _SAMPLES)
            if falling and motion.rate >= 0.0 and motion.depth < least:
                least, phase = motion.depth, begins + length * n / _SAMPLES
            falling = motion.rate < 0.0
    return phase


def shallowest_in_contact(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> float:
    """Phase at which the contacts after these departures come closest to leaving +beta before their end.

    Parameters
    ----------
    oscillator : Oscillator
        With finite stiffness, checked by the caller.
    t, v : ndarray of float64, shape (n,)

    Returns
    -------
    float
        NaN if no contact has a minimum inside.
    """
    return float(_shallowest(oscillator, t, v))


def point_near(
    kind: SpecialKind, oscillator: Oscillator, parameter: str, shape: OrbitShape, t: float, v: float
) -> SpecialPoint | None:
    """Locate a special point from a guess.

    Parameters
    ----------
    kind : SpecialKind
    oscillator : Oscillator
        With a guess of the parameter's value.
    parameter : str
        Field of `Oscillator` to solve for.
    shape : OrbitShape
        As for `special_system`.
    t, v : float
        Guess of a departure of the orbit. For a graze the one that grazes, for contact loss the touch, with v = 0.

    Returns
    -------
    SpecialPoint or None
        None if Newton's method does not converge.
    """
    space = unknowns(oscillator, (parameter,), kind != SpecialKind.CONTACT_LOSS)
    system = special_system(kind, space, shape)
    solution = solve(system, space.write(oscillator, t, v))
    if solution is None:
        return None
    evaluated, read = system(solution.z), space.read(solution.z)
    if evaluated is None or read is None:
        return None
    error = solution.last_step * space.scales[-1]
    return describe_point(kind, parameter, shape, *read, residual=float(np.abs(evaluated[0]).max()), error=float(error))


def describe_point(
    kind: SpecialKind,
    parameter: str,
    shape: OrbitShape,
    oscillator: Oscillator,
    t: float,
    v: float,
    *,
    residual: float,
    error: float,
) -> SpecialPoint:
    """Special point from a solution of its equations, with all departures and the multipliers.

    Parameters
    ----------
    kind, parameter, shape
        As for `point_near`.
    oscillator : Oscillator
        With the parameter's value at the solution.
    t, v : float
        The first departure.
    residual, error : float
        As in `SpecialPoint`.

    Returns
    -------
    SpecialPoint
    """
    multipliers = np.full(2, np.nan, complex)
    if kind == SpecialKind.CONTACT_LOSS:
        here, speed, _ = from_rest(oscillator, t)
        rest = shape._replace(upper_contacts=shape.upper_contacts - 1)
        orbit = departures_from(oscillator, parameter, rest, here, speed)
        times, speeds = np.append(wrap(t), orbit.t), np.append(0.0, orbit.v)
    else:
        orbit = departures_from(oscillator, parameter, shape, t, v)
        times, speeds = orbit.t, orbit.v
        closed = closure(oscillator, parameter, shape, t, v)
        if closed is not None:
            multipliers = np.linalg.eigvals(closed.jacobian).astype(complex)
    return SpecialPoint(
        kind, parameter, oscillator.value_of(parameter), oscillator, shape.forcing_periods, shape.upper_contacts,
        orbit.lower_contacts, times, speeds, multipliers, residual, error,
    )  # fmt: skip
