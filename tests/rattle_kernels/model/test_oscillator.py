"""The bounds of Eqs. (3), (8), (22) against values computed elsewhere in high precision."""

import math

import pytest

from rattle_kernels import (
    Oscillator,
    OutsideDomain,
    check_domain,
    check_quiet,
    eccentricity_bound_convexity,
    eccentricity_bound_quiet,
    eccentricity_bound_smooth_maxima,
)


@pytest.mark.parametrize(
    ("stiffness", "printed"), [(100.0, 0.15263), (1e3, 0.18637), (1e4, 0.18975), (1e5, 0.19008), (1e6, 0.19012)]
)
def test_the_bound_of_the_quiet_solution(stiffness, printed):
    assert eccentricity_bound_quiet(Oscillator(stiffness=stiffness)) == pytest.approx(printed, abs=5e-6)


def test_the_bound_of_the_quiet_solution_of_the_machine():
    assert eccentricity_bound_quiet(Oscillator(6e-4, 1e-4, 6e-4, 1000.0)) == pytest.approx(1.87216e-4, abs=5e-10)


def test_the_other_bounds_at_the_papers_damping():
    assert eccentricity_bound_smooth_maxima(Oscillator()) == pytest.approx(0.19012, abs=5e-6)
    assert eccentricity_bound_convexity(Oscillator()) == pytest.approx(0.17434, abs=5e-6)


@pytest.mark.parametrize(("times", "quiet_is_lower"), [(1.01, True), (0.99, False)])
def test_the_quiet_bound_is_the_lower_one_above_a_stiffness(times, quiet_is_lower):
    stiff = Oscillator(stiffness=times * (math.pi**2 + 0.6**2 / 4.0))
    assert (eccentricity_bound_quiet(stiff) < eccentricity_bound_smooth_maxima(stiff)) == quiet_is_lower


def test_the_quiet_bound_tends_to_that_of_the_impacting_model():
    assert eccentricity_bound_quiet(Oscillator()) == eccentricity_bound_smooth_maxima(Oscillator())


@pytest.mark.parametrize("stiffness", [0.0, -100.0, -math.inf, math.nan, 0.6**2 / 8.0])
def test_a_stiffness_at_which_contacts_do_not_ring_is_refused(stiffness):
    with pytest.raises(OutsideDomain, match="stiffness must be above damping\\^2/8 = 0.045") as refusal:
        check_domain(Oscillator(stiffness=stiffness))
    assert refusal.value.parameter == "stiffness"


def test_a_soft_spring_is_in_the_domain():
    soft = Oscillator(stiffness=1, permanent_after=1)
    assert [type(value) for value in check_domain(soft)] == [float] * 5


def test_a_quiet_solution_is_demanded_with_its_bound():
    oscillator = Oscillator(eccentricity=0.16, stiffness=100.0)
    assert check_domain(oscillator) == oscillator and check_quiet(Oscillator(stiffness=100.0)).stiffness == 100.0
    with pytest.raises(OutsideDomain, match="epsilon_crit1 = 0.15263") as refusal:
        check_quiet(oscillator)
    assert (refusal.value.parameter, refusal.value.bound) == ("eccentricity", "epsilon_crit1")
