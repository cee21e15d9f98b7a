"""Periodic orbits of loose gears: what the search finds returns by an integrator, and holds what is in closed form."""

import math

import numpy as np
import pytest

from rattle_kernels import Oscillator, find_orbit, find_orbits, shares_of
from rattle_kernels.impact_map.loose_map import RELEASED
from tests.rattle_kernels.impact_map.integrator import integrated_loose_impact
from tests.rattle_kernels.reference import phase_error

_DAMPING, _RESTITUTION = 0.1, 0.7


def machine(gamma, restitution=_RESTITUTION, half_backlash=0.3):
    """Machine of one harmonic with this Gamma."""
    eccentricity = gamma * 2.0 * _DAMPING / math.hypot(2.0 * math.pi, _DAMPING)
    return Oscillator(_DAMPING, eccentricity, half_backlash, restitution=restitution)


@pytest.fixture(scope="module")
def found():
    return find_orbits(machine(1.5), 2, velocity=(0.0, 2.0), cells=12)


def test_what_is_found_returns_by_an_integrator(found):
    assert {each.orbit.name for each in found} >= {"P(1,1,0)", "P(1,1,1)", "P(1,2,0)"}
    for orbit, margin, lower_speed in found:
        lower = 0
        for i in range(orbit.upper_contacts):
            after = (i + 1) % orbit.upper_contacts
            time, speed, met = integrated_loose_impact(machine(1.5), orbit.t[i], orbit.v[i])
            assert phase_error(orbit.t[after], repr(float(time % 1.0))) < 1e-8
            assert abs(orbit.v[after] - speed) < 1e-8
            # A contact with -beta is met first by what is faster than the grazing flight alone.
            assert (met > 0) == (margin[i] > 0.0) == math.isfinite(lower_speed[i])
            lower += met
        assert lower == orbit.lower_contacts


def test_a_bouncing_gear_has_both_its_orbits_one_a_saddle_unless_it_has_doubled(found):
    """Where -beta is not met, with damping d: v0 = 4 pi d r/(1 + r) for small d (the bouncing ball)."""
    single = [orbit for orbit, _, _ in found if orbit.name == "P(1,1,0)"]
    assert len(single) == 2
    for orbit in single:
        assert orbit.v[0] == pytest.approx(4.0 * math.pi * _DAMPING * _RESTITUTION / (1.0 + _RESTITUTION), rel=1e-3)
        # Energy is lost at the impact and by damping: det DP = r^2 e^{-delta m}.
        product = np.prod(orbit.multipliers).real
        assert product == pytest.approx(_RESTITUTION**2 * math.exp(-_DAMPING), rel=1e-9)
    traces = sorted(float(np.trace(orbit.jacobians[0])) for orbit in single)
    determinant = _RESTITUTION**2 * math.exp(-_DAMPING)
    assert traces[0] < -1.0 - determinant and traces[1] > 1.0 + determinant


def test_every_attractor_is_among_the_orbits_and_a_resting_one_has_its_star():
    resting = machine(1.6, restitution=0.3)
    rng = np.random.default_rng(1)
    ends = shares_of(resting, rng.random(200), rng.uniform(0.01, 2.0, 200))
    attracting = {each.name for each in ends.attractors[1:]}
    assert any(name.endswith("*") for name in attracting)
    names = set()
    for each in ends.attractors[1:]:
        orbit = find_orbit(resting, each.time[0], each.velocity[0], each.upper_contacts).orbit
        names.add(orbit.name)
        if orbit.rests:
            assert not orbit.multipliers.any() and orbit.v[0] == RELEASED
    assert names == attracting
    # From anywhere near, too, and then at the release itself.
    resting_orbits = [each.orbit for each in find_orbits(resting, 1, velocity=(0.0, 2.0), cells=6) if each.orbit.rests]
    assert resting_orbits and all((orbit.v == RELEASED).any() for orbit in resting_orbits)
