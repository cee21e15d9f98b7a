"""A graze of P(1,1,0) between its two points of codimension two, and what follows it."""

import math

import numpy as np

from rattle_kernels import Oscillator, SpecialKind, next_impacts, single_contact_orbits
from rattle_kernels.orbits.bifurcation_point import point_near
from rattle_kernels.orbits.closure import OrbitShape, closure

BETWEEN = Oscillator(damping=0.764662, eccentricity=0.096608)
WIDE = (0.3, 1.2), (0.05, 0.15)
"""Bounds of damping and eccentricity."""


def graze_of_single_contact(oscillator):
    """Graze of a P(1,1,0) near an oscillator, in the damping."""
    orbit = single_contact_orbits(oscillator)[0]
    point = point_near(SpecialKind.GRAZING, oscillator, "damping", OrbitShape(1, 1, 1), orbit.t, orbit.v)
    assert point is not None
    return point


def graze_at(point, damping, eccentricity):
    """Damping at which the orbit of a point of codimension two grazes, at another eccentricity."""
    near = point.oscillator.at(damping=damping, eccentricity=eccentricity)
    shape = OrbitShape(point.forcing_periods, point.upper_contacts, 1)
    return point_near(SpecialKind.GRAZING, near, "damping", shape, float(point.t[0]), float(point.v[0])).value


def exponent_of_the_map(oscillator, t, v, applications):
    """Largest exponent per application, and impacts with -beta per application."""
    along, grown, lower = np.array([1.0, 0.3]), 0.0, 0
    for n in range(applications + 1000):
        closed = closure(oscillator, "damping", OrbitShape(1, 1), t, v)
        along = closed.jacobian @ along
        length = np.linalg.norm(along)
        along /= length
        landed = next_impacts(oscillator, t, v)
        t, v = float(landed.t), float(landed.v)
        if n >= 1000:
            grown, lower = grown + math.log(length), lower + int(landed.lower_impacts)
    return grown / applications, lower / applications
