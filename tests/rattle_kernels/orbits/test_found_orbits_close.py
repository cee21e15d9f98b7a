"""What a search finds are orbits: the map returns to every departure, whatever the oscillator and the window."""

import math

import numpy as np
import pytest

from rattle_kernels import Oscillator, find_orbit, find_orbits, largest_grazing_speed, next_impacts


def random_oscillator(random, stiff):
    """An oscillator of either model, anywhere within Eq. (8) that rattles."""
    damping = random.uniform(0.2, 0.9)
    eccentricity = random.uniform(0.3, 0.95) * 2 * damping / math.hypot(2 * math.pi, damping)
    stiffness = 10 ** random.uniform(2.5, 6.0) if stiff else math.inf
    return Oscillator(damping, eccentricity, random.uniform(0.25, 1.0), stiffness)


def assert_that_the_map_returns(oscillator, found):
    for one in found:
        orbit = one.orbit
        allowed = 1e-9 * max(1.0, np.abs(orbit.multipliers).max())
        after = next_impacts(oscillator, orbit.t, orbit.v, orbit.upper_contacts)
        later = after.t - orbit.t
        apart = np.hypot(later - np.rint(later), after.v - orbit.v)
        assert (apart <= allowed).all(), (oscillator, orbit.name, orbit.t, orbit.v, apart)


def search_and_check(random, count, longest, cells):
    found = 0
    for number in range(count):
        oscillator = random_oscillator(random, stiff=number % 2 == 1)
        fastest = random.uniform(1.0, 3.0) * largest_grazing_speed(oscillator)
        orbits = find_orbits(oscillator, longest, velocity=(0.0, fastest), cells=cells)
        assert_that_the_map_returns(oscillator, orbits)
        found += len(orbits)
    return found


def test_newtons_method_does_not_step_so_far_that_every_phase_returns():
    """A step led to t = 1.7e35, where P(t) - t is a whole number of periods, since no other is a double."""
    oscillator = Oscillator(0.6164126945972871, 0.1477379585012081, 0.5374427799162805, 3421.1338449353943)
    found = find_orbits(oscillator, longest=1, velocity=(0.0, 8.0))
    assert [one.orbit.name for one in found] == ["P(1,1,0)", "P(1,1,1)"]
    assert_that_the_map_returns(oscillator, found)


def test_a_seed_many_periods_away_is_the_same_seed():
    here, far = find_orbit(Oscillator(), 0.6, 3.77), find_orbit(Oscillator(), 0.6 + 2.0**20, 3.77)
    assert far.orbit.t == pytest.approx(here.orbit.t, abs=1e-12)
    assert 0.0 <= far.orbit.t[0] < 1.0


@pytest.mark.slow
def test_the_map_returns_to_all_orbits_of_some_random_oscillators():
    assert search_and_check(np.random.default_rng(41), 15, longest=2, cells=12) > 15


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_the_map_returns_to_all_orbits_of_200_random_oscillators():
    assert search_and_check(np.random.default_rng(200), 200, longest=4, cells=40) > 200


def test_two_orbits_whose_indices_cancel_are_both_found_next_to_a_graze():
    """Their multipliers are -609 and 5448: that their indices add up to nothing says nothing about them."""
    oscillator = Oscillator(0.2464276520768997, 0.056663244461376855, 0.6742417555621207)
    found = [one for one in find_orbits(oscillator, 3, velocity=(0.0, 8.5)) if one.orbit.name == "P(4,3,3)"]
    assert len(found) == 2
    assert_that_the_map_returns(oscillator, found)
    for one, (t, v) in zip(found, [(0.90352204, 3.13135663), (0.98026623, 3.02862054)], strict=True):
        assert np.hypot(one.orbit.t - t, one.orbit.v - v).min() < 2e-8
    assert [np.sign(np.linalg.det(one.orbit.jacobians[0] - np.eye(2))) for one in found] == [1.0, -1.0]
    assert found[1].grazing_distance == pytest.approx(1.3659e-4, rel=1e-4)
