"""Lanes under several harmonics and with losses land where the careful path lands; their capture is what it claims."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rattle_kernels import Oscillator, Outcome, check_domain, next_impacts, tangent_growth
from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from rattle_kernels.impact_map.chatter import bounce_level, is_captured
from rattle_kernels.impact_map.sticking import sticking_bound
from rattle_kernels.model.flight import rest_acceleration
from rattle_kernels.numerics.jit import kernel
from tests.rattle_kernels.impact_map.scalar_map import departure, departures
from tests.strategies import wider_oscillators

# Kernels are compiled for none, one, two, and more harmonics: two in the fast tests, as in `tests.strategies`.
TWO = ((2, 0.008, 0.3), (3, 0.002, 0.1))
OSCILLATORS = [
    Oscillator(restitution=0.9),
    Oscillator(harmonics=TWO),
    Oscillator(harmonics=((2, 0.001, 0.3), (17, 1e-4, 0.2)), restitution=0.7),
    Oscillator(stiffness=1e4, harmonics=TWO, contact_damping=0.05),
    Oscillator(stiffness=300.0, harmonics=TWO, contact_damping=0.2),
    pytest.param(Oscillator(harmonics=(*TWO, (5, 0.0005, 0.7)), restitution=0.9), marks=pytest.mark.slow),
]


@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_lanes_land_where_the_careful_path_does(oscillator):
    oscillator = check_domain(oscillator)
    rng = np.random.default_rng(22)
    t, v = rng.random(4000), rng.uniform(0.01, 12.0, 4000)
    landed = next_impacts(oscillator, t, v)
    t, v, lower, outcome = departures(oscillator, t, v)
    np.testing.assert_array_equal(landed.outcome, outcome)
    np.testing.assert_array_equal(landed.lower_impacts, lower)
    there = outcome == Outcome.RETURNED
    # A graze amplifies rounding; elsewhere both err by some units in the last place.
    apart = np.abs((landed.t - t + 0.5) % 1.0 - 0.5)[there]
    assert np.quantile(apart, 0.99) < 1e-14 and apart.max() < 1e-11
    assert np.quantile(np.abs(landed.v - v)[there], 0.99) < 1e-13


@kernel
def level(oscillator, t, v):
    acceleration = rest_acceleration(oscillator, t)
    return bounce_level(0.0, acceleration, v) / acceleration


@kernel
def captured(oscillator, bound, t, v):
    return is_captured(oscillator, bound, t, v)


@settings(max_examples=150, deadline=None)
@given(wider_oscillators(), st.floats(0.0, 1.0), st.floats(0.01, 0.999))
def test_impacts_that_lose_energy_capture_for_good(oscillator, t, part):
    """In the region of `sticking` every bounce is low, and its action falls."""
    oscillator = check_domain(oscillator._replace(restitution=min(oscillator.restitution, 0.999)))
    bound = sticking_bound(oscillator)
    assert bound > 0.0
    v = (part * bound * rest_acceleration(oscillator, t)) ** (1.0 / 3.0)
    for _ in range(20):
        assert captured(oscillator, bound, t, v)
        impact = departure(oscillator, t, v)
        assert impact.outcome == Outcome.RETURNED and impact.lower_impacts == 0
        assert level(oscillator, impact.t, impact.v) < level(oscillator, t, v)
        t, v = impact.t, impact.v


def test_elastic_impacts_do_not_stick():
    assert sticking_bound(Oscillator()) == 0.0
    assert capture_bound(Oscillator(restitution=0.5)) >= capture_bound(Oscillator()) > 0.0


def test_an_orbits_tangents_shrink_by_damping_and_by_impacts():
    """P(1,1,0) with r = 0.9: its multipliers are complex, of modulus r e^{-delta/2}."""
    t, v = 0.8583, 4 * math.pi * 0.6 * 0.9 / 1.9
    settled = next_impacts(Oscillator(restitution=0.9), t, v, 2000)
    grown = tangent_growth(Oscillator(restitution=0.9), [float(settled.t)] * 4, [float(settled.v)] * 4, 1024)
    assert grown.exponent == pytest.approx(math.log(0.9) - 0.3, abs=2e-3)
