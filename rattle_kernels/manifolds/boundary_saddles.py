"""Saddles whose stable manifold is a basin boundary: departures close to them end in more than one motion.

A saddle in a chaotic attractor has stable and unstable manifolds too, but all that leaves it stays in that attractor.
"""

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.attractors.classify import name_solutions
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.manifolds.grazing_preimages import speed_of_no_return
from rattle_kernels.manifolds.saddle import directions, is_saddle
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.orbits.orbit_search import find_orbits
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit

# Largest impact period. Boundaries of longer saddles lie within those of short ones or are too fine for a picture.
_LONGEST = 2
# Two seconds. Saddles next to a graze, which bound basins, are found from any number of cells (`orbit_seeds`).
_SEARCH_CELLS = 64
# Departures on each side along the unstable direction, from one to its image: all that leaves the saddle passes here.
_LEAVING = 12
_NEAR = 1e-6
_IMPACTS = 1499


def boundary_saddles(oscillator: Oscillator, attractors: tuple[Attractor, ...]) -> tuple[PeriodicOrbit, ...]:
    """Saddles P(m, 1, .) and P(m, 2, .) whose stable manifolds separate basins.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    attractors : tuple of Attractor
        Catalogue of the oscillator's motions, permanent contact first. Other motions without points are ignored.

    Returns
    -------
    tuple of PeriodicOrbit
        Ordered by (n+, m, n-) and lowest speed. The search is systematic, not exhaustive.
    """
    velocity = 0.0, speed_of_no_return(oscillator)  # faster departures have no past at lower speeds
    found = [each.orbit for each in find_orbits(oscillator, _LONGEST, velocity=velocity, cells=_SEARCH_CELLS)]
    there = [each for each in attractors if each.kind == AttractorKind.PERMANENT_CONTACT or each.time.size]
    return tuple(orbit for orbit in found if is_saddle(orbit) and _parts_basins(oscillator, there, orbit))


def _parts_basins(oscillator: Oscillator, attractors: list[Attractor], saddle: PeriodicOrbit) -> bool:
    scale = largest_grazing_speed(oscillator)
    leaving = directions(saddle, 0, scale)
    steps = _NEAR * np.abs(leaving.unstable_multiplier) ** (np.arange(_LEAVING) / _LEAVING)
    away = np.concatenate([steps, -steps])[:, None] * leaving.unstable
    landed = next_impacts(oscillator, saddle.t[0] + away[:, 0], saddle.v[0] + away[:, 1], _IMPACTS)
    going = np.isfinite(landed.t)
    ends = set(name_solutions(oscillator, attractors, landed.t[going], landed.v[going]).tolist())
    return len(ends | ({0} if not going.all() else set())) > 1
