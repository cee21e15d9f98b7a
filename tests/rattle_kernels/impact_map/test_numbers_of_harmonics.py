"""Every number of harmonics that a request may have is computed, and more than two share their machine code."""

import math

import numpy as np
import pytest
from numba import types

from rattle_kernels import Oscillator, Outcome, check_domain, find_orbits, next_impacts
from rattle_kernels.lanes import short_run
from rattle_kernels.model.domain import eccentricity_bound_smooth_maxima
from rattle_kernels.orbits.closure import OrbitShape, closure
from tests.rattle_kernels.impact_map.integrator import integrated_departure, integrated_impact
from tests.rattle_kernels.impact_map.scalar_map import departures
from tests.rattle_kernels.reference import phase_error

# Most of it is compiling for each number. Applications with up to three harmonics are tested in test_wider_contacts.
pytestmark = pytest.mark.slow

LARGEST = 32
MODELS = [
    pytest.param({"restitution": 0.9}, id="impacting"),
    pytest.param({"stiffness": 1e4, "contact_damping": 0.05}, id="stiff"),
]
NUMBERS = range(LARGEST + 1)
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def oscillator_with(number, **fields):
    """An oscillator whose harmonics, of orders 2, 3, ..., take half of the acceleration at rest together."""
    bound = eccentricity_bound_smooth_maxima(Oscillator(harmonics=()))
    harmonics = tuple((n, 0.5 * bound / (number * n * n), n * GOLDEN % 1.0) for n in range(2, number + 2))
    return check_domain(Oscillator(eccentricity=0.3 * bound, harmonics=harmonics, **fields))


@pytest.mark.parametrize("fields", MODELS)
@pytest.mark.parametrize("number", NUMBERS)
def test_lanes_land_where_the_careful_path_does(number, fields):
    oscillator = oscillator_with(number, **fields)
    rng = np.random.default_rng(number)
    t, v = rng.random(2000), rng.uniform(0.01, 12.0, 2000)
    landed = next_impacts(oscillator, t, v)
    t, v, lower, outcome = departures(oscillator, t, v)
    np.testing.assert_array_equal(landed.outcome, outcome)
    np.testing.assert_array_equal(landed.lower_impacts, lower)
    there = outcome == Outcome.RETURNED
    assert there.sum() > 1000
    # As in `test_wider_lanes`: a graze amplifies rounding; elsewhere both err by some units in the last place.
    apart = np.abs((landed.t - t + 0.5) % 1.0 - 0.5)[there]
    assert np.quantile(apart, 0.99) < 1e-14 and apart.max() < 1e-11
    assert np.quantile(np.abs(landed.v - v)[there], 0.99) < 1e-13


@pytest.mark.parametrize("fields", MODELS)
@pytest.mark.parametrize("number", NUMBERS)
def test_the_next_impact_is_that_of_an_ode_integrator(number, fields):
    oscillator = oscillator_with(number, **fields)
    for t, v, below in ((0.37, 2.0, 0), (0.81, 9.0, 1)):
        landed = next_impacts(oscillator, t, v)
        if math.isinf(oscillator.stiffness):
            time, speed, lower = integrated_impact(oscillator, t, v)
        else:
            time, speed, lower = integrated_departure(oscillator, t, v, 1e3)
        assert landed.outcome == Outcome.RETURNED and landed.lower_impacts == lower == below
        assert phase_error(float(landed.t), repr(float(time % 1.0))) < 1e-9
        assert float(landed.v) == pytest.approx(speed, abs=1e-8)


@pytest.mark.parametrize("fields", MODELS)
def test_more_than_two_harmonics_share_their_machine_code(fields):
    for number in (3, 4, 17, LARGEST):
        next_impacts(oscillator_with(number, **fields), 0.3, 2.0)
    below = [oscillator for oscillator, *_ in short_run._fly_leg.signatures if "arcs" not in oscillator.fields]
    harmonics = [oscillator[-1] for oscillator in below]
    assert sum(isinstance(each, types.Array) for each in harmonics) == 1
    assert max((len(each) for each in harmonics if not isinstance(each, types.Array)), default=0) <= 2


@pytest.mark.parametrize("fields", MODELS)
@pytest.mark.parametrize("part", ["amplitude", "phase"])
@pytest.mark.parametrize("number", [2, 3, LARGEST])
def test_the_change_by_the_highest_order_is_that_of_finite_differences(number, part, fields):
    oscillator, shape = oscillator_with(number, **fields), OrbitShape(1, 1)
    parameter = f"{part}_{number + 1}"
    value = oscillator.value_of(parameter)
    step = 1e-4 * value

    def gap(value):
        return closure(oscillator.at(**{parameter: value}), parameter, shape, 0.37, 2.0).gap

    # Of fourth order: it errs by the fifth derivative times step^4, and by rounding over the step.
    near, far = gap(value + step) - gap(value - step), gap(value + 2.0 * step) - gap(value - 2.0 * step)
    found = closure(oscillator, parameter, shape, 0.37, 2.0).sensitivity
    size = np.abs(found).max()
    np.testing.assert_allclose(found, (8.0 * near - far) / (12.0 * step), rtol=1e-6, atol=1e-6 * size + 1e-15 / step)


@pytest.mark.parametrize("fields", [{}, {"stiffness": 1e4}])
@pytest.mark.parametrize("number", [3, LARGEST])
def test_orbits_close(number, fields):
    # Enough for P(1,1,0), which without losses begins at 0.051 with 3 harmonics, and at 0.059 with 32.
    oscillator = oscillator_with(number, **fields).at(eccentricity=0.08)
    found = find_orbits(oscillator, longest=1, cells=8)
    assert found
    for each in found:
        landed = next_impacts(oscillator, each.orbit.t[0], each.orbit.v[0])
        apart = abs((float(landed.t) - each.orbit.t[0] + 0.5) % 1.0 - 0.5)
        assert apart < 1e-10 and float(landed.v) == pytest.approx(each.orbit.v[0], abs=1e-10)
