"""The bounds of Eqs. (3), (8), (22) against values computed elsewhere in high precision."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle_kernels import (
    Oscillator,
    OutsideDomain,
    check_domain,
    check_quiet,
    damping_bound_quiet,
    eccentricity_bound_convexity,
    eccentricity_bound_quiet,
    eccentricity_bound_smooth_maxima,
    stiffness_gap_quiet,
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
    assert [type(value) for value in check_domain(soft)] == [float] * 7 + [tuple]


def test_a_quiet_solution_is_demanded_with_its_bound():
    oscillator = Oscillator(eccentricity=0.16, stiffness=100.0)
    assert check_domain(oscillator) == oscillator and check_quiet(Oscillator(stiffness=100.0)).stiffness == 100.0
    with pytest.raises(OutsideDomain, match="epsilon_crit1 = 0.15263") as refusal:
        check_quiet(oscillator)
    assert (refusal.value.parameter, refusal.value.bound) == ("eccentricity", "epsilon_crit1")


def test_a_harmonic_of_no_size_changes_no_bound():
    still = ((3.0, 0.0, 0.2),)
    for stiffness in (math.inf, 100.0):
        plain = Oscillator(stiffness=stiffness)
        wider = plain._replace(harmonics=still)
        assert eccentricity_bound_smooth_maxima(wider) == pytest.approx(eccentricity_bound_smooth_maxima(plain))
        assert eccentricity_bound_quiet(wider) == pytest.approx(eccentricity_bound_quiet(plain))


def test_harmonics_too_large_for_a_float_are_refused_in_words():
    beyond = Oscillator(damping=7e16, eccentricity=9e307, harmonics=((124, 1.7e308, 0.0), (269, 1.6e308, -1.2)))
    with pytest.raises(OutsideDomain, match="harmonics are too large"):
        check_domain(beyond)


def test_harmonics_beyond_equation_8_are_refused_with_the_least_acceleration_and_its_phase():
    beyond = Oscillator(eccentricity=0.0, harmonics=((2, 0.06, 0.25),))
    # 4 pi delta - (4 pi)^2 eps cos - 4 pi delta eps sin of the angle: the amplitude is eps 4 pi hypot(4 pi, delta).
    least = 4 * math.pi * 0.6 - 0.06 * 4 * math.pi * math.hypot(4 * math.pi, 0.6)
    with pytest.raises(
        OutsideDomain, match=r"positive at every phase \(Eq. 8\).* falls to -1.94579 at t = 0.8788"
    ) as told:
        check_domain(beyond)
    assert told.value.parameter == "harmonics" and told.value.value == pytest.approx(least, abs=1e-12)


def test_the_refusal_says_by_how_much_all_amplitudes_must_shrink():
    def shrunk(part):
        return Oscillator(eccentricity=0.15 * part, harmonics=((2, 0.02 * part, 0.1), (5, 0.003 * part, 0.7)))

    with pytest.raises(OutsideDomain, match="all of them times less than") as told:
        check_domain(shrunk(1.0))
    part = float(re.search(r"less than (\S+) are", str(told.value))[1])
    check_domain(shrunk(part * (1 - 1e-5)))  # it is written with six digits
    with pytest.raises(OutsideDomain):
        check_domain(shrunk(part * (1 + 1e-5)))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"harmonics": ((2.5, 0.01, 0.0),)}, "whole numbers from 2 on, not 2.5"),
        ({"harmonics": ((1, 0.01, 0.0),)}, "the first is the eccentricity"),
        ({"harmonics": ((2, 0.01, 0.0), (2, 0.002, 0.5))}, "order 2 is there twice"),
        ({"harmonics": ((2, -0.01, 0.0),)}, "amplitude of order 2 must be at least 0"),
        ({"harmonics": ((2, 0.01, math.inf),)}, "phase of order 2 must be finite"),
        ({"restitution": 0.0}, "restitution must be above 0 and at most 1"),
        ({"restitution": 1.01}, "restitution must be above 0 and at most 1"),
        ({"restitution": 0.9, "stiffness": 100.0}, "restitution belongs to the impacting model"),
        ({"contact_damping": 0.1}, "contact_damping belongs to the piecewise linear model"),
        ({"contact_damping": 1.0, "stiffness": 100.0}, "contacts do not ring"),
        ({"contact_damping": 0.99, "stiffness": 400.0}, r"above damping\^2/\(8 \(1 - contact_damping\)\^2\) = 450"),
    ],
)
def test_what_the_wider_model_cannot_be_is_refused(given, told):
    with pytest.raises(OutsideDomain, match=told):
        check_domain(Oscillator()._replace(**given))


@pytest.mark.parametrize("harmonics", [((2,),), (2, 0.01), ((2, 0.01, 0.0, 1.0),), 0.01])
def test_what_are_no_harmonics_is_refused(harmonics):
    with pytest.raises(ValueError, match="harmonics are a sequence of"):
        check_domain(Oscillator(harmonics=harmonics))


def test_parameters_of_harmonics_are_named_by_order():
    oscillator = check_domain(Oscillator(harmonics=[(3, 0.001, 0.5), [2, 0.01]]))
    assert oscillator.parameters[6:] == ("amplitude_2", "phase_2", "amplitude_3", "phase_3")
    assert oscillator.at(phase_3=0.25, damping=0.7).value_of("phase_3") == 0.25
    with pytest.raises(ValueError, match="phase_3, not 'phase_4'"):
        oscillator.value_of("phase_4")


@given(
    damping=st.floats(1e-3, 20.0), eccentricity=st.floats(1e-6, 1.9), stiffness=st.floats(1e-2, 1e8),
    near=st.sampled_from([0.3, 1.0 - 1e-9, 1.0 + 1e-9, 3.0]),
)  # fmt: skip
def test_the_bounds_of_the_quiet_solution_are_one_in_three_parameters(damping, eccentricity, stiffness, near):
    here = Oscillator(damping, eccentricity, stiffness=stiffness)
    for bound, name in ((damping_bound_quiet(here), "damping"), *_edges(here)):
        # What is left of the paper's formula for the eccentricity, once it is solved for another parameter.
        if 0.0 < bound < 1e100:
            assert eccentricity_bound_quiet(here._replace(**{name: bound})) == pytest.approx(eccentricity, rel=1e-9)
    bound = damping_bound_quiet(here)
    if 0.0 < near * bound < math.inf:
        assert (eccentricity < eccentricity_bound_quiet(here._replace(damping=near * bound))) == (near > 1.0)
    gap = stiffness_gap_quiet(here) or (math.inf, -math.inf)
    if all(not 1.0 - 1e-9 < stiffness / edge < 1.0 + 1e-9 for edge in gap):
        assert (eccentricity < eccentricity_bound_quiet(here)) != (gap[0] < stiffness < gap[1])


def _edges(oscillator):
    gap = stiffness_gap_quiet(oscillator)
    return [(edge, "stiffness") for edge in gap or ()]


@pytest.mark.parametrize("size", [1e-300, 1e-200, 1e-150, 1e150, 1e200, 1e299])
@pytest.mark.parametrize("name", ["damping", "eccentricity", "stiffness"])
def test_no_size_of_a_parameter_leaves_a_bound_without_a_number(name, size):
    extreme = Oscillator(stiffness=100.0)._replace(**{name: size})
    assert damping_bound_quiet(extreme) >= 0.0
    low, high = stiffness_gap_quiet(extreme) or (0.0, math.inf)
    assert 0.0 <= low <= high


def test_a_bound_that_is_no_formula_is_not_given():
    for bound in (damping_bound_quiet, stiffness_gap_quiet):
        for fields in ({"harmonics": ((2, 0.01, 0.25),)}, {"contact_damping": 0.1}):
            with pytest.raises(ValueError, match="search for the bound"):
                bound(Oscillator(stiffness=100.0, **fields))
