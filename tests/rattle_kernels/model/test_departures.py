"""A number that is no departure, or no parameter, is refused at every public function, by name and place."""

import math

import numpy as np
import pytest

from rattle_kernels import (
    ManifoldLimits,
    Oscillator,
    Outcome,
    OutsideDomain,
    bifurcation_diagram,
    capture_velocity,
    eccentricity_bound_convexity,
    eccentricity_bound_quiet,
    eccentricity_bound_single_contact,
    eccentricity_bound_smooth_maxima,
    find_attractors,
    find_orbit,
    find_orbits,
    find_saddle,
    grazing_preimages,
    next_impacts,
    previous_impacts,
    single_contact_orbits,
    stable_manifold,
    stiffness_bound,
    unstable_manifold,
)
from rattle_kernels.model.departures import check_departures, check_phases

OF_DEPARTURES = {
    "next_impacts": next_impacts,
    "previous_impacts": previous_impacts,
    "find_attractors": find_attractors,
    "bifurcation_diagram": lambda oscillator, t, v: bifurcation_diagram(
        oscillator, "damping", [0.6], t, v, transient=1, kept=1
    ),
}
NOT_DEPARTURES = [(0.1, -3.0), (0.1, 0.0), (0.1, math.nan), (0.1, math.inf), (math.nan, 3.0), (math.inf, 3.0)]


@pytest.mark.parametrize("name", OF_DEPARTURES)
@pytest.mark.parametrize(("t", "v"), NOT_DEPARTURES)
def test_points_that_are_no_departures_are_refused_by_name_and_place(name, t, v):
    at_fault = f"v[1] must be finite and above 0, the speed of leaving +beta, not {v}"
    if not math.isfinite(t):
        at_fault = f"t[1] must be finite, a time in forcing periods, not {t}"
    with pytest.raises(ValueError) as refusal:
        OF_DEPARTURES[name](Oscillator(), [0.5, t], [3.0, v])
    assert str(refusal.value) == at_fault


def test_motions_that_have_come_to_rest_are_arguments_again():
    for each in (next_impacts, previous_impacts):
        landed = each(Oscillator(), [0.5, math.nan], [3.0, math.nan])
        assert landed.outcome.tolist() == [Outcome.RETURNED, Outcome.OUTSIDE_SECTION]
        with pytest.raises(ValueError, match=r"^v\[1\] must be"):
            each(Oscillator(), [0.5, 0.5], [3.0, math.nan])


def test_a_single_number_has_no_place():
    with pytest.raises(ValueError, match=r"^v must be .* not -3\.0$"):
        next_impacts(Oscillator(), 0.1, -3.0)
    with pytest.raises(ValueError, match=r"^v\[1, 0\] must be .* not 0\.0$"):
        next_impacts(Oscillator(), 0.1, np.array([[1.0, 2.0], [0.0, 3.0]]))
    for find in (find_orbit, find_saddle):
        with pytest.raises(ValueError, match="-3"):
            find(Oscillator(), 0.1, -3.0)
    with pytest.raises(ValueError, match=r"t must be finite"):
        capture_velocity(Oscillator(), math.nan)


@pytest.mark.parametrize("region", [
    {"time": (0.5, 0.2)}, {"time": (0.0, 1.5)}, {"time": (math.nan, 1.0)}, {"velocity": (3.0, 1.0)},
    {"velocity": (-1.0, 7.0)}, {"velocity": (0.0, math.inf)}, {"velocity": (0.0, math.nan)},
])  # fmt: skip
def test_a_region_that_is_none_is_refused(region):
    (name,) = region
    with pytest.raises(ValueError, match=f"^{name} must be two"):
        find_orbits(Oscillator(), 1, cells=2, **region)


OF_OSCILLATORS = {
    "quiet": eccentricity_bound_quiet,
    "smooth maxima": eccentricity_bound_smooth_maxima,
    "convexity": eccentricity_bound_convexity,
    "single contact": eccentricity_bound_single_contact,
    "stiffness": stiffness_bound,
    "next_impacts": lambda oscillator: next_impacts(oscillator, 0.5, 3.0),
}


@pytest.mark.parametrize("name", OF_OSCILLATORS)
@pytest.mark.parametrize("damping", [-1.0, 0.0, math.nan, math.inf])
def test_every_function_of_an_oscillator_refuses_a_damping_that_is_none(name, damping):
    with pytest.raises(OutsideDomain) as refusal:
        OF_OSCILLATORS[name](Oscillator(damping=damping))
    assert refusal.value.parameter == "damping"


@pytest.mark.parametrize("name", OF_OSCILLATORS)
def test_what_is_no_oscillator_is_refused_with_an_example_of_one(name):
    with pytest.raises(TypeError, match=r"Oscillator\(damping=0\.6\), not 0\.6"):
        OF_OSCILLATORS[name](0.6)


def test_a_number_of_forcing_periods_is_whole():
    for periods in (0, -1, 1.5, math.nan):
        with pytest.raises(ValueError, match="^forcing_periods must be a whole number from 1 on"):
            eccentricity_bound_single_contact(Oscillator(), periods)
        with pytest.raises(ValueError, match="^forcing_periods must be a whole number from 1 on"):
            single_contact_orbits(Oscillator(), periods)


def test_what_needs_the_inverse_of_the_map_says_why_it_refuses_a_stiffness():
    stiff = Oscillator(stiffness=1e4)
    saddle = find_saddle(stiff, 0.6, 3.77)
    asked = (
        lambda: stable_manifold(stiff, saddle, ManifoldLimits(0.1, 0.0, 7.0)),
        lambda: unstable_manifold(stiff, saddle, ManifoldLimits(0.1, 0.0, 7.0)),
        lambda: grazing_preimages(stiff, 1),
        lambda: previous_impacts(stiff, 0.5, 3.0),
    )
    for each in asked:
        with pytest.raises(OutsideDomain, match="stiffness must be infinite.*the inverse of P is needed") as refusal:
            each()
        assert refusal.value.parameter == "stiffness"


def test_kernels_see_one_type_whatever_is_given():
    """A read-only array has another, for which each kernel would be compiled once more."""
    read_only = np.broadcast_to(0.5, 3)
    arrays = (check_phases(read_only), *check_departures(read_only, read_only))
    assert all(each.flags.writeable and each.dtype == np.float64 and each.shape == (3,) for each in arrays)
    own = np.array([0.5])
    assert check_phases(own) is own
