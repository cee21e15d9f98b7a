"""The piecewise linear model beyond one scalar application: lanes, derivative, capture, images."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rattle_kernels import Oscillator, Outcome, OutsideDomain, grazing_velocity, next_impacts, previous_impacts
from rattle_kernels.impact_map.chatter import bounce_level, ringing_radian
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.flight import rest_acceleration
from rattle_kernels.numerics.jit import kernel
from tests.rattle_kernels.impact_map.scalar_map import departure, derivative
from tests.rattle_kernels.reference import entries, oscillator_of, phase_error, speed_error
from tests.strategies import phases, speeds, stiff_oscillators

RULES = [(math.inf, "plc_rigorous"), (1.0, "plc_one_rotation")]


@kernel
def invariant(oscillator, t, v):
    acceleration = rest_acceleration(oscillator, t)
    return bounce_level(ringing_radian(oscillator), acceleration, v) / acceleration


@pytest.mark.parametrize(("permanent_after", "rule"), RULES, ids=["exact", "paper"])
@pytest.mark.parametrize("entry", entries("map_pwl.json"), ids=lambda entry: entry["category"])
def test_lanes_agree_with_the_reference(entry, permanent_after, rule):
    oscillator = oscillator_of(entry)._replace(permanent_after=permanent_after)
    impact = next_impacts(oscillator, float(entry["t0"]), float(entry["v0"]))
    assert impact.lower_impacts == entry["nminus"]
    assert impact.outcome == (Outcome.PERMANENT_CONTACT if entry[rule] else Outcome.RETURNED)
    if not entry[rule]:
        assert phase_error(impact.t, entry["t1"]) <= 1e-12
        assert speed_error(impact.v, entry["v1"]) <= 1e-11


@given(st.data())
@settings(max_examples=100)
def test_lanes_and_scalar_path_agree(data):
    oscillator = data.draw(stiff_oscillators())
    t, v = data.draw(phases), data.draw(speeds(oscillator))
    scalar, lanes = departure(oscillator, t, v), next_impacts(oscillator, t, v)
    graze = abs(v / grazing_velocity(oscillator, t) - 1.0)
    assert lanes.outcome == scalar.outcome
    assert lanes.lower_impacts == scalar.lower_impacts or graze < 1e-14
    if scalar.outcome != Outcome.RETURNED:
        assert math.isnan(lanes.t) and math.isnan(lanes.v)
        return
    # Next to a graze of either kind (v* below, or from inside contact) the end moves with the inverse speed there.
    jacobian = np.abs(np.array(derivative(oscillator, t, v)[1])) * np.array([1.0, v, 1.0, v])
    assert phase_error(lanes.t, repr(scalar.t)) <= 1e-12 * max(1.0, jacobian[:2].max())
    assert abs(lanes.v - scalar.v) <= 1e-12 * max(scalar.v, v, jacobian[2:].max())


@given(st.data())
@settings(max_examples=50)
def test_a_lane_does_not_depend_on_its_neighbours(data):
    oscillator = data.draw(stiff_oscillators())
    t, v = np.array([(data.draw(phases), data.draw(speeds(oscillator))) for _ in range(3)]).T
    together = next_impacts(oscillator, np.tile(t, 50), np.tile(v, 50), applications=7)
    for i in range(3):
        alone = next_impacts(oscillator, t[i], v[i], applications=7)
        for field, lonely in zip(together, alone, strict=True):
            np.testing.assert_array_equal(field[i::3], np.full(50, lonely))


def differences(oscillator, t, v, impact, part):
    """DP by central differences of a part of a period and of the speed; None where one of them straddles a graze."""
    columns = []
    for dt, dv in ((part, 0.0), (0.0, part * v)):
        ends = [departure(oscillator, t + sign * dt, v + sign * dv) for sign in (1.0, -1.0)]
        if {(end.outcome, end.lower_impacts) for end in ends} != {(impact.outcome, impact.lower_impacts)}:
            return None
        apart = ends[0].t - ends[1].t
        columns.append(np.array([apart - round(apart), ends[0].v - ends[1].v]) / (2.0 * (dt + dv)))
    return np.array(columns).T


@given(st.data())
@settings(max_examples=100)
def test_every_entry_of_the_derivative_agrees_with_differences(data):
    """The step that suits best counts: curvature spoils long ones, most of all near grazes, and rounding short ones."""
    oscillator = data.draw(stiff_oscillators())
    t, v = data.draw(phases), data.draw(speeds(oscillator))
    impact, jacobian = derivative(oscillator, t, v)
    assume(impact.outcome == Outcome.RETURNED)
    by_step = [differences(oscillator, t, v, impact, 10.0**-n) for n in range(4, 9)]
    known = [each for each in by_step if each is not None]
    assume(len(known) > 1)
    exact = np.array(jacobian).reshape(2, 2)
    # In units of a period and of the speeds before and after, entries compare; rounding is that of the largest.
    units = np.outer([1.0, impact.v], [1.0, 1.0 / v])
    errors = np.min([np.abs(each - exact) for each in known], axis=0) / units
    sizes = np.abs(exact) / units
    assert (errors <= 1e-4 * sizes + 1e-7 * max(1.0, sizes.max())).all(), (errors, sizes)


@pytest.mark.parametrize("stiffness", [1e5, 1e6, 1e7])
def test_captured_bounces_fall_for_ever_until_contact_is_permanent(stiffness):
    oscillator = Oscillator(stiffness=stiffness)
    bound = lane_tables(oscillator).capture_bound
    rng = np.random.default_rng(4)
    t, v = rng.random(400), 0.6 * rng.random(400)
    level = np.array([invariant(oscillator, *point) for point in zip(t, v, strict=True)])
    inside = level < bound
    assert inside.sum() > 100
    t, v, level = t[inside], v[inside], level[inside]
    for _ in range(12):
        landed, _ = run_lanes(oscillator, t, v, 50, shortcuts=False)
        left = landed.outcome == Outcome.RETURNED
        assert set(landed.outcome[~left].tolist()) <= {Outcome.PERMANENT_CONTACT}
        t, v = landed.t[left], landed.v[left]
        after = np.array([invariant(oscillator, *point) for point in zip(t, v, strict=True)])
        assert (after < level[left]).all()
        level = after
    # From the bottom of the region it is not far to contact that is never left.
    settled, _ = run_lanes(oscillator, t[:20], v[:20], 1_000_000, shortcuts=False)
    assert (settled.outcome == Outcome.PERMANENT_CONTACT).all()


def test_soft_contact_needs_no_capture():
    assert lane_tables(Oscillator(stiffness=100.0)).capture_bound == 0.0


def test_the_map_backwards_is_the_impacting_models():
    with pytest.raises(OutsideDomain, match="stiffness must be infinite, which is the impacting model"):
        previous_impacts(Oscillator(stiffness=1e4), 0.1, 1.0)


def test_one_rotation_differs_from_the_envelope_as_the_errata_say():
    """ERRATA of the paper: 2,153 of 400,000 uniform departures at kappa = 100; a hundredth of them here."""
    rng = np.random.default_rng(0)
    t, v = rng.random(40_000), 7.0 * rng.random(40_000)
    exact = next_impacts(Oscillator(stiffness=100.0), t, v).outcome
    paper = next_impacts(Oscillator(stiffness=100.0, permanent_after=1.0), t, v).outcome
    differs = exact != paper
    assert (paper[differs] == Outcome.PERMANENT_CONTACT).all()
    expected = 40_000 * 2153 / 400_000
    assert abs(differs.sum() - expected) < 4.0 * math.sqrt(expected)
