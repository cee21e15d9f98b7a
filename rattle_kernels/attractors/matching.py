"""The same attractor at neighbouring parameters: orbits continued by Newton, and how far apart attractors are."""

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.attractors.settled_orbit import attractor_of
from rattle_kernels.model.flight import fall_speed
from rattle_kernels.model.oscillator import Oscillator, check_domain
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit

# Points of an orbit that Newton's method is started from, and of a chaotic attractor that are compared.
_STARTS = 8
_COMPARED = 256


def continue_attractor(oscillator: Oscillator, attractor: Attractor) -> Attractor | None:
    """Continue a periodic attractor to a neighbouring oscillator.

    Newton's method starts from the points of the old orbit, one after the other, until it ends on an orbit of the same
    itinerary that attracts.

    Parameters
    ----------
    oscillator : Oscillator
        Where the attractor is looked for.
    attractor : Attractor
        What it was at other parameters, close by.

    Returns
    -------
    Attractor or None
        None if it has vanished, has lost its stability or was never periodic.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    """
    if attractor.kind != AttractorKind.PERIODIC:
        return None
    checked = check_domain(oscillator)
    scale = fall_speed(checked)
    for t, v in zip(attractor.time[:_STARTS].tolist(), attractor.velocity[:_STARTS].tolist(), strict=True):
        orbit = find_periodic_orbit(checked, t, v, attractor.upper_contacts, scale)
        if orbit is not None and orbit.attracts:
            continued = attractor_of(orbit)
            if continued[:4] == attractor[:4]:
                return continued
    return None


def attractor_distance(oscillator: Oscillator, one: Attractor, other: Attractor) -> float:
    """Distance between two attractors of one kind and itinerary, in forcing periods and natural speeds.

    Parameters
    ----------
    oscillator : Oscillator
        Of one of them; its natural speed weighs as much as a period.
    one, other : Attractor
        Of the same kind and itinerary.

    Returns
    -------
    float
        Periodic orbits: the largest distance between points of the same turn, for the best shift. Chaotic attractors:
        the mean distance from a point of either to the nearest of the other. Otherwise 0.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    """
    if not one.time.size or not other.time.size:
        return 0.0
    scale = fall_speed(oscillator)
    apart = one.time[:_COMPARED, None] - other.time[None, :_COMPARED]
    apart -= np.rint(apart)
    distance = np.hypot(apart, (one.velocity[:_COMPARED, None] - other.velocity[None, :_COMPARED]) / scale)
    if one.kind != AttractorKind.PERIODIC or distance.shape[0] != distance.shape[1]:
        return float(0.5 * (distance.min(axis=0).mean() + distance.min(axis=1).mean()))
    points = np.arange(distance.shape[0])
    return min(float(distance[points, np.roll(points, shift)].max()) for shift in points)
