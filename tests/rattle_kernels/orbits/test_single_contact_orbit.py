"""P(m, 1, 0): the closed form against P itself, against Newton, and the exact bound behind Eq. (41)."""

import math

import numpy as np
import pytest

from rattle_kernels import (
    Oscillator,
    check_domain,
    eccentricity_bound_single_contact,
    next_impacts,
    single_contact_orbits,
)
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit


def test_the_exact_bound_behind_equation_41():
    assert eccentricity_bound_single_contact(Oscillator(0.6)) == pytest.approx(0.059643058193045, abs=1e-15)


@pytest.mark.parametrize("x", [1e-6, 0.01, 0.3])
def test_the_bound_has_the_printed_series(x):
    assert eccentricity_bound_single_contact(Oscillator(x)) == pytest.approx(x**2 / 6 - x**4 / 360, rel=x**4 + 1e-13)


@pytest.mark.parametrize(("damping", "eccentricity", "half_backlash", "m"), [(0.6, 0.1, 0.6, 1), (0.1, 0.02, 2.0, 2)])
def test_the_closed_form_is_an_orbit_and_newton_agrees(damping, eccentricity, half_backlash, m):
    oscillator = Oscillator(damping, eccentricity, half_backlash)
    for closed in single_contact_orbits(oscillator, m):
        assert closed.exists
        back = next_impacts(oscillator, closed.t, closed.v)
        assert (float(back.t), float(back.v)) == pytest.approx((closed.t, closed.v), abs=1e-12)
        orbit = find_periodic_orbit(oscillator, closed.t + 1e-3, closed.v * 1.001, 1, closed.v)
        assert (orbit.forcing_periods, orbit.upper_contacts, orbit.lower_contacts) == (m, 1, 0)
        assert (orbit.t[0], orbit.v[0]) == pytest.approx((closed.t, closed.v), abs=1e-11)
        assert orbit.multipliers.sum().real == pytest.approx(closed.trace, abs=1e-10)


def test_one_attracts_and_the_other_is_a_saddle():
    node, saddle = single_contact_orbits(Oscillator())
    assert abs(node.trace) < 1 + math.exp(-0.6) < saddle.trace
    assert node.v == saddle.v == pytest.approx(1.2 * math.pi)


def test_they_are_born_at_the_bound_and_not_before():
    bound = eccentricity_bound_single_contact(Oscillator(0.6))
    assert single_contact_orbits(Oscillator(eccentricity=bound * (1 - 1e-12))) == ()
    for orbit in single_contact_orbits(Oscillator(eccentricity=bound * (1 + 1e-12))):
        assert orbit.t == pytest.approx(0.75, abs=1e-6)
        assert orbit.trace == pytest.approx(1 + math.exp(-0.6), abs=1e-5)


def test_beyond_the_grazing_curve_they_do_not_exist():
    """With less backlash the flight would meet -beta."""
    margins = [single_contact_orbits(Oscillator(half_backlash=b))[0] for b in (0.6, 0.4)]
    assert [orbit.exists for orbit in margins] == [True, False]
    impact = next_impacts(Oscillator(half_backlash=0.4), margins[1].t, margins[1].v)
    assert np.all(impact.lower_impacts == 1)


def test_with_losses_they_are_slower_and_born_later():
    oscillator = Oscillator(restitution=0.9)
    node, saddle = single_contact_orbits(oscillator)
    assert node.v == pytest.approx(4 * math.pi * 0.6 * 0.9 / 1.9)
    for closed in (node, saddle):
        orbit = find_periodic_orbit(oscillator, closed.t + 1e-3, closed.v * 1.001, 1, closed.v)
        assert (orbit.t[0], orbit.v[0]) == pytest.approx((closed.t, closed.v), abs=1e-11)
        assert orbit.multipliers.sum().real == pytest.approx(closed.trace, abs=1e-10)
        assert orbit.multipliers.prod().real == pytest.approx(0.81 * math.exp(-0.6), abs=1e-10)
    bound = eccentricity_bound_single_contact(Oscillator(0.6, restitution=0.9))
    assert bound == pytest.approx(0.059643058193045 + 0.6 * 0.1 / 1.9)
    assert single_contact_orbits(oscillator.at(eccentricity=bound * (1 - 1e-12))) == ()
    assert len(single_contact_orbits(oscillator.at(eccentricity=bound * (1 + 1e-12)))) == 2


def test_several_harmonics_have_pairs_of_their_own():
    """Newton's method finds each of them, with its trace; a strong second order makes four of them."""
    oscillator = check_domain(
        Oscillator(eccentricity=0.005, harmonics=((2, 0.035, 0.1), (3, 0.0, 0.0)), half_backlash=2.0)
    )
    orbits = single_contact_orbits(oscillator)
    assert len(orbits) == 4
    for closed in orbits:
        assert closed.exists and closed.v == pytest.approx(1.2 * math.pi)
        orbit = find_periodic_orbit(oscillator, closed.t + 1e-4, closed.v * 1.0001, 1, closed.v)
        assert (orbit.t[0], orbit.v[0]) == pytest.approx((closed.t, closed.v), abs=1e-10)
        assert orbit.multipliers.sum().real == pytest.approx(closed.trace, abs=1e-9)


def test_under_several_harmonics_the_bound_is_where_the_first_orbits_are_born():
    harmonics = ((2, 0.01, 0.1), (3, 0.002, 0.4))
    bound = eccentricity_bound_single_contact(Oscillator(0.6, restitution=0.95, harmonics=harmonics))
    oscillator = Oscillator(restitution=0.95, harmonics=harmonics)
    assert single_contact_orbits(oscillator.at(eccentricity=bound * (1 - 1e-6))) == ()
    late = oscillator.at(eccentricity=bound + 0.002)
    assert len(single_contact_orbits(late)) == 2
    t = np.arange(100_000) / 100_000

    def largest_rate(eccentricity):
        waves = ((1, eccentricity, 0.0), *harmonics)
        return max(-sum(n * size * np.sin(2 * np.pi * (n * t + phase)) for n, size, phase in waves))

    # The rate's second derivative is 10 at most, and its top 5e-6 from the mesh at most.
    needed = eccentricity_bound_single_contact(Oscillator(0.6, restitution=0.95))
    assert needed - 10 / 2 * 5e-6**2 <= largest_rate(bound) <= needed + 1e-14


def test_harmonics_may_make_orbits_without_eccentricity():
    assert eccentricity_bound_single_contact(Oscillator(0.6, harmonics=((2, 0.035, 0.1),))) == 0.0
    of_none = eccentricity_bound_single_contact(Oscillator(0.6, harmonics=((2, 0.0),)))
    assert of_none == pytest.approx(eccentricity_bound_single_contact(Oscillator(0.6)), rel=1e-12)
