"""P against 28-digit values, an ODE integrator and what must hold of it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rattle_kernels import (
    Oscillator,
    Outcome,
    OutsideDomain,
    check_domain,
    eccentricity_bound_smooth_maxima,
    grazing_velocity,
    next_impacts,
    previous_impacts,
)
from tests.rattle_kernels.impact_map.scalar_map import departure
from tests.rattle_kernels.reference import condition, entries, oscillator_of, phase_error, speed_error
from tests.strategies import oscillators, phases, speeds

# Those beyond the bound of Eq. (8) are followed from arc to arc.
IMPACTING = entries("map_impacting.json") + entries("map_impacting.json", inside_domain=False)


def test_the_table_covers_every_category():
    categories = {entry["category"] for entry in entries("map_impacting.json")}
    assert categories == {"paper", "near_graze", "small_delta", "random", "tiny", "large"}


@pytest.mark.parametrize("path", [departure, next_impacts], ids=["scalar", "lanes"])
@pytest.mark.parametrize("entry", IMPACTING, ids=lambda entry: entry["category"])
def test_next_impact_agrees_with_the_reference(entry, path):
    impact = path(oscillator_of(entry), float(entry["t0"]), float(entry["v0"]))
    assert impact.outcome == Outcome.RETURNED
    assert impact.lower_impacts == entry["nminus"]
    assert phase_error(impact.t, entry["t1"]) <= 1e-12 * condition(entry)
    assert speed_error(impact.v, entry["v1"]) <= 1e-12 * condition(entry)


@pytest.mark.parametrize("entry", entries("map_impacting.json", inside_domain=False))
def test_what_needs_the_bound_refuses_machines_beyond_it_with_its_value(entry):
    oscillator = oscillator_of(entry)._replace(stiffness=1e4)
    with pytest.raises(OutsideDomain, match="epsilon_crit2 = 0.19012") as refusal:
        check_domain(oscillator)
    assert refusal.value.parameter == "eccentricity"
    assert refusal.value.limit == eccentricity_bound_smooth_maxima(oscillator)


@pytest.mark.parametrize(
    ("field", "value"),
    [("damping", 0.0), ("damping", -1.0), ("damping", math.nan), ("damping", math.inf), ("half_backlash", 0.0),
     ("eccentricity", -0.1), ("eccentricity", math.nan), ("stiffness", 0.0), ("stiffness", -1e3),
     ("stiffness", 0.04), ("stiffness", math.nan), ("permanent_after", 0.0), ("permanent_after", math.nan)],
)  # fmt: skip
def test_parameters_outside_the_domain_are_refused_by_name(field, value):
    with pytest.raises(OutsideDomain, match=field) as refusal:
        next_impacts(Oscillator()._replace(**{field: value}), 0.1, 1.0)
    assert refusal.value.parameter == field


@pytest.mark.parametrize("shape", [(), (0,), (1,), (3,), (2, 3), (65,), (1000,)])
def test_arrays_keep_their_shape_and_scalars_broadcast(shape):
    t = np.full(shape, 0.3)
    impacts = next_impacts(Oscillator(), t, 2.0)
    assert all(np.shape(field) == shape for field in impacts)
    assert all(np.shape(field) == shape for field in previous_impacts(Oscillator(), t, 2.0))


def test_integer_parameters_are_the_same_oscillator():
    assert next_impacts(Oscillator(damping=1), 0.1, 2.0) == next_impacts(Oscillator(damping=1.0), 0.1, 2.0)


def _departure(data, oscillator):
    return data.draw(phases), data.draw(speeds(oscillator))


@given(st.data())
@settings(max_examples=100)
def test_lanes_and_scalar_path_agree(data):
    oscillator = data.draw(oscillators())
    t, v = _departure(data, oscillator)
    scalar, lanes = departure(oscillator, t, v), next_impacts(oscillator, t, v)
    assert lanes.outcome == scalar.outcome == Outcome.RETURNED
    graze = abs(v / grazing_velocity(oscillator, t) - 1.0)
    assert lanes.lower_impacts == scalar.lower_impacts or graze < 1e-14
    allowed = 1e-12 / max(math.sqrt(graze), 1e-6)
    assert phase_error(lanes.t, repr(scalar.t)) <= allowed
    assert abs(lanes.v - scalar.v) <= allowed * max(scalar.v, v)


@given(st.data())
@settings(max_examples=100)
def test_a_lane_does_not_depend_on_its_neighbours(data):
    oscillator = data.draw(oscillators())
    t, v = np.array([_departure(data, oscillator) for _ in range(3)]).T
    together = next_impacts(oscillator, np.tile(t, 50), np.tile(v, 50), applications=7)
    for i in range(3):
        alone = next_impacts(oscillator, t[i], v[i], applications=7)
        for field, lonely in zip(together, alone, strict=True):
            np.testing.assert_array_equal(field[i::3], np.full(50, lonely))


@given(st.data())
@settings(max_examples=100)
def test_previous_impact_undoes_next_impact(data):
    oscillator = data.draw(oscillators(largest_part_of_bound=0.9))
    t, v = _departure(data, oscillator)
    graze = abs(v / grazing_velocity(oscillator, t) - 1.0)
    forwards = next_impacts(oscillator, t, v)
    back = previous_impacts(oscillator, forwards.t, forwards.v)
    assert back.outcome == Outcome.RETURNED
    # Next to a graze P^-1 multiplies rounding by the inverse square root of the distance, and may take the other side
    # of it.
    allowed = 1e-10 / max(math.sqrt(graze), 1e-7)
    assert phase_error(back.t, repr(t)) <= allowed * max(1.0, abs(float(forwards.v) / v))
    assert abs(back.v - v) <= allowed * max(v, float(forwards.v))


@given(st.data())
@settings(max_examples=50)
def test_the_map_commutes_with_a_shift_by_one_period(data):
    oscillator = data.draw(oscillators())
    t, v = _departure(data, oscillator)
    t = round(t * 2**20) / 2**20  # a phase that keeps all its digits when a period is added
    here, later = next_impacts(oscillator, t, v), next_impacts(oscillator, t + 1.0, v)
    assert (here.t, here.v, here.lower_impacts) == (later.t, later.v, later.lower_impacts)


@given(st.data())
@settings(max_examples=50)
def test_the_grazing_curve_separates_the_two_cases(data):
    oscillator = data.draw(oscillators())
    t = data.draw(phases)
    graze = float(grazing_velocity(oscillator, t))
    off = data.draw(st.floats(1e-9, 0.5))
    assert next_impacts(oscillator, t, graze * (1.0 - off)).lower_impacts == 0
    assert next_impacts(oscillator, t, graze * (1.0 + off)).lower_impacts == 1


@pytest.mark.parametrize("entry", entries("grazing.json"))
def test_grazing_velocity_agrees_with_the_reference(entry):
    speed = grazing_velocity(oscillator_of(entry), float(entry["t0"]))
    assert abs(float(speed) / float(entry["v"]) - 1.0) <= 1e-14


def test_several_applications_are_repeated_single_ones():
    rng = np.random.default_rng(1)
    t, v = rng.random(200), 7.0 * rng.random(200)
    at_once = next_impacts(Oscillator(), t, v, applications=5)
    lower = np.zeros(200, np.int64)
    for _ in range(5):
        t, v, contacts, _ = next_impacts(Oscillator(), t, v)
        lower += contacts
    np.testing.assert_array_equal(at_once.t, t)
    np.testing.assert_array_equal(at_once.v, v)
    np.testing.assert_array_equal(at_once.lower_impacts, lower)


def _integrated_impact(oscillator, t, v):
    """One application of P by an ODE integrator with events, an oracle that shares nothing with the kernels."""
    damping, eccentricity, beta = oscillator[:3]

    def motion(time, state):
        angle = 2.0 * math.pi * time
        forcing = 4.0 * math.pi**2 * math.cos(angle) + 2.0 * math.pi * damping * math.sin(angle)
        return [state[1], 4.0 * math.pi * damping - eccentricity * forcing - damping * state[1]]

    def upper(_, state):
        return state[0] - beta

    def lower(_, state):
        return state[0] + beta

    upper.terminal, upper.direction = True, 1.0
    lower.terminal, lower.direction = True, -1.0
    start, state, contacts = t, [beta, -v], 0
    while True:
        run = solve_ivp(motion, (start, start + 50.0), state, "DOP853", events=(upper, lower), rtol=1e-12, atol=1e-13)
        start = run.t[-1]
        if run.t_events[0].size:
            return start % 1.0, run.y[1, -1], contacts
        contacts += 1
        state = [-beta, -run.y[1, -1]]


@pytest.mark.parametrize("seed", range(12))
def test_next_impact_agrees_with_an_ode_integrator(seed):
    rng = np.random.default_rng(seed)
    oscillator = Oscillator(rng.uniform(0.05, 1.0), 0.0, rng.uniform(0.1, 1.0))
    bound = eccentricity_bound_smooth_maxima(oscillator)
    oscillator = oscillator._replace(eccentricity=rng.uniform(0.1, 0.9) * bound)
    t = rng.random()
    v = float(rng.uniform(0.2, 2.0) * grazing_velocity(oscillator, t))
    impact = next_impacts(oscillator, t, v)
    time, speed, contacts = _integrated_impact(oscillator, t, v)
    assert impact.lower_impacts == contacts
    assert phase_error(impact.t, repr(float(time))) < 1e-8
    assert abs(impact.v - speed) < 1e-8
