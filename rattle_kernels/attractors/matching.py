"""The same attractor at neighbouring parameters: continuation by Newton's method, and a distance of attractors."""

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.attractors.settled_orbit import attractor_of
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.flight import fall_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit

# Points of an orbit from which Newton's method starts, and points of a chaotic attractor that are compared.
_STARTS = 8
_COMPARED = 256


def continue_attractor(oscillator: Oscillator, attractor: Attractor) -> Attractor | None:
    """Continue a periodic attractor to a neighbouring oscillator.

    Newton's method starts from one point of the old orbit after another, until it finds an attracting orbit of the same
    itinerary.

    Parameters
    ----------
    oscillator : Oscillator
        The oscillator at the new parameters.
    attractor : Attractor
        The attractor at the old parameters, close by.

    Returns
    -------
    Attractor or None
        None if it has vanished or lost its stability, or is not periodic.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    """
    if attractor.kind != AttractorKind.PERIODIC:
        return None
    checked = check_oscillator(oscillator)
    scale = fall_speed(checked)
    for t, v in zip(attractor.time[:_STARTS].tolist(), attractor.velocity[:_STARTS].tolist(), strict=True):
        orbit = find_periodic_orbit(checked, t, v, attractor.upper_contacts, scale)
        if orbit is not None and orbit.attracts:
            continued = attractor_of(orbit)
            if continued[:4] == attractor[:4]:
                return continued
    return None


def attractor_distance(oscillator: Oscillator, one: Attractor, other: Attractor) -> float:
    """Distance of two attractors of the same kind and itinerary, in forcing periods and natural speeds.

    Parameters
    ----------
    oscillator : Oscillator
        Oscillator of one of them; its natural speed counts as much as a period.
    one, other : Attractor
        Attractors of the same kind and itinerary.

    Returns
    -------
    float
        For periodic orbits, the largest distance between corresponding points of a turn, for the best shift. For
        chaotic attractors, the mean distance from a point of either to the nearest of the other. Otherwise 0.

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
