"""The machine's own parameters, and its attracting orbits."""

import numpy as np

from rattle_kernels import Attractor, AttractorKind, Oscillator
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit

MACHINE = Oscillator(6e-4, 1e-4, 6e-4)


def orbit_near(speed, period):
    """The attracting orbit of some impact period that has a departure of about this speed, in units of delta."""
    scale = lane_tables(MACHINE).largest_grazing_speed
    tried = (find_periodic_orbit(MACHINE, phase, speed * 6e-4, period, scale) for phase in np.linspace(0.0, 0.95, 20))
    return next(orbit for orbit in tried if orbit is not None and orbit.attracts)


def attractor_of(orbit):
    """Catalogue's entry of an orbit."""
    return Attractor(AttractorKind.PERIODIC, *orbit[2:5], orbit.lyapunov_exponent, 0.0, orbit.t, orbit.v)
