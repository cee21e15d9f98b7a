"""Orbits on the other side of a graze of finite stiffness, where a branch could not be followed through it.

Next to the graze an orbit that touches -beta is too steep to be followed, a little further off it is not. So Newton's
method looks for orbits of the same forcing and impact period, but of another number of contacts with -beta, at two
values of the parameter beside that of the graze. Those found exist. Whether they lie on the branch is not known.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.model.domain import OutsideDomain, check_domain
from rattle_kernels.orbits.near_graze import approach_above
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit
from rattle_kernels.orbits.station import BranchTask, Station

# Distance of the parameter from that of the graze, scaled. Touches have speeds of some 1e-3 there.
_ASIDE = 1e-6
# Roots of heights above v*(t) to begin with, and rounds of Newton's method.
_ROOTS, _ROUNDS = (1e-3, 1e-2, 1e-1), 20
# Departures of one orbit on both sides: they part like the root of the parameter's distance.
_NEAR = 0.05


class OrbitBeside(NamedTuple):
    """An orbit and the value of the parameter at which it exists."""

    value: float
    orbit: PeriodicOrbit


def values_beside(task: BranchTask, value: float) -> tuple[float, float]:
    """Values of the parameter on both sides of that of a graze.

    Parameters
    ----------
    task : BranchTask
    value : float
        That of the graze.

    Returns
    -------
    (float, float)
    """
    aside = _ASIDE * float(task.space.scales[2])
    return value - aside, value + aside


def orbits_beside(task: BranchTask, last: Station, value: float) -> list[OrbitBeside]:
    """Orbits of the same periods that meet -beta another number of times, next to a graze.

    Parameters
    ----------
    task : BranchTask
    last : Station
        The branch's last one before the graze.
    value : float
        The parameter at the graze.

    Returns
    -------
    list of OrbitBeside
        In order of the parameter; it may be empty.
    """
    scale, contacts = float(task.space.scales[1]), task.shape.upper_contacts
    found = list[OrbitBeside]()
    for there in values_beside(task, value):
        try:
            oscillator = check_domain(last.oscillator.at(**{task.parameter: there}))
        except OutsideDomain:
            continue
        roots = np.repeat(np.sqrt(scale) * np.array(_ROOTS), contacts)
        t, v, period = approach_above(oscillator, np.tile(last.t, len(_ROOTS)), roots, contacts, _ROUNDS, task.pause)
        own = period == contacts
        here = list[PeriodicOrbit]()
        for seed in zip(np.append(t[own], last.t), np.append(v[own], last.v), strict=True):
            orbit = find_periodic_orbit(oscillator, float(seed[0]), float(seed[1]), contacts, scale, pause=task.pause)
            if (
                orbit is not None
                and _is_beside(task, last, orbit)
                and not any(_are_one(orbit, other) for other in here)
            ):
                here.append(orbit)
        found.extend(OrbitBeside(there, orbit) for orbit in here)
    return found


def _is_beside(task: BranchTask, last: Station, orbit: PeriodicOrbit) -> bool:
    same = (orbit.forcing_periods, orbit.upper_contacts) == task.shape[:2]
    if not same or orbit.lower_contacts == int((last.margin > 0.0).sum()):
        return False
    apart = np.subtract.outer(orbit.t, last.t)
    faster = np.subtract.outer(orbit.v, last.v) / task.space.scales[1]
    return bool((np.hypot(apart - np.rint(apart), faster).min(axis=1) < _NEAR).all())


def _are_one(one: PeriodicOrbit, other: PeriodicOrbit) -> bool:
    return one.lower_contacts == other.lower_contacts and bool(np.abs(one.v - other.v).max() < 1e-9)
