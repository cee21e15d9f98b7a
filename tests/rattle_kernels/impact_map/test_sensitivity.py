"""dP/dp and DP of both models against differences of P itself."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rattle_kernels import Oscillator, grazing_velocity
from rattle_kernels.model.oscillator import PARAMETERS
from tests.rattle_kernels.impact_map.scalar_map import departure, sensitivity
from tests.strategies import oscillators, phases, speeds, stiff_oscillators


def elapsed_and_speed(oscillator, t, v):
    impact = departure(oscillator, t, v)
    return np.array([impact.duration, impact.v])


def difference(function, x, step):
    """Fourth-order central difference: error of order step^4."""
    far, near = function(x + 2 * step) - function(x - 2 * step), function(x + step) - function(x - step)
    return (8 * near - far) / (12 * step)


def agree_with_differences(oscillator, parameter, t, v):
    value = oscillator.value_of(PARAMETERS[parameter])

    def varied(changed):
        return elapsed_and_speed(oscillator._replace(**{PARAMETERS[parameter]: changed}), t, v)

    step = 1e-4 * max(value, 0.1 * oscillator.damping)
    impact, _, change = sensitivity(oscillator, parameter, t, v, False)
    coarse, fine = difference(varied, value, step), difference(varied, value, step / 4)
    assume(np.isfinite(coarse).all() and np.abs(coarse - fine).max() < 1e-5 * (1 + np.abs(fine).max()))
    scale = np.abs(fine) + (abs(impact.duration) + impact.v) / max(value, 1e-3)
    assert np.abs(np.array(change) - fine).max() <= 1e-5 * scale.max()


@settings(max_examples=150, deadline=None)
@given(st.data(), st.sampled_from([0, 1, 2]))
def test_the_impacting_models_sensitivity_agrees_with_differences(data, parameter):
    oscillator = data.draw(oscillators(0.8))
    assume(oscillator.eccentricity > 1e-3 * oscillator.damping)
    t, v = data.draw(phases), data.draw(speeds(oscillator, 0.05))
    assume(abs(v / grazing_velocity(oscillator, t) - 1) > 0.01)
    agree_with_differences(oscillator, parameter, t, v)


@settings(max_examples=150, deadline=None)
@given(st.data(), st.sampled_from([0, 1, 2, 3]))
def test_the_stiff_models_sensitivity_agrees_with_differences(data, parameter):
    oscillator = data.draw(stiff_oscillators())._replace(permanent_after=math.inf)
    assume(oscillator.eccentricity > 1e-3 * oscillator.damping)
    t, v = data.draw(phases), data.draw(speeds(oscillator, 0.05))
    assume(abs(v / grazing_velocity(oscillator, t) - 1) > 0.01)
    agree_with_differences(oscillator, parameter, t, v)


@pytest.mark.parametrize("stiffness", [math.inf, 100.0])
def test_passing_over_the_wall_is_smooth_across_the_grazing_curve(stiffness):
    oscillator = Oscillator(stiffness=stiffness)
    t = 0.3
    v = float(grazing_velocity(oscillator, t))
    below, above = (sensitivity(oscillator, 0, t, v * part, True) for part in (1 - 1e-6, 1 + 1e-6))
    plain = sensitivity(oscillator, 0, t, v * (1 - 1e-6), False)
    assert plain == below
    assert above[0].lower_impacts == 0
    assert np.array(above[1]) == pytest.approx(np.array(below[1]), rel=1e-4)
    assert above[0].v == pytest.approx(below[0].v, rel=1e-5)
