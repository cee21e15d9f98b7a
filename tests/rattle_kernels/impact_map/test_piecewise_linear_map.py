"""P of the piecewise linear model against 50-digit values, an ODE integrator, dense sampling and what must hold."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rattle_kernels import (
    Oscillator,
    Outcome,
    eccentricity_bound_quiet,
    eccentricity_bound_smooth_maxima,
    grazing_velocity,
)
from rattle_kernels.impact_map.apply import LOWER, UPPER
from rattle_kernels.model.contact_end import follow_contact
from rattle_kernels.numerics.jit import kernel
from tests.rattle_kernels.impact_map.integrator import integrated_departure
from tests.rattle_kernels.impact_map.scalar_map import departure
from tests.rattle_kernels.reference import entries, oscillator_of, phase_error, speed_error
from tests.strategies import oscillators, phases

ENVELOPE, ONE_ROTATION = math.inf, 1.0
_CASES = 45


@kernel
def contact_of(oscillator, side, phase, speed):
    return follow_contact(oscillator, side, phase, speed)


def graze_of(oscillator, t):
    """Grazing speed: freeplay's alone."""
    return float(grazing_velocity(oscillator._replace(stiffness=math.inf), t))


def test_the_table_covers_every_category_and_both_answers_of_both_rules():
    table = entries("map_pwl.json")
    categories = {entry["category"] for entry in table}
    assert categories == {
        "uniform", "low", "near_graze", "large", "plc_prone", "rule_differs", "random", "realistic"
    }  # fmt: skip
    answers = {(entry["plc_rigorous"], entry["plc_one_rotation"]) for entry in table}
    assert answers == {(False, False), (False, True), (True, True)}


@pytest.mark.parametrize(
    ("permanent_after", "rule"),
    [(ENVELOPE, "plc_rigorous"), (ONE_ROTATION, "plc_one_rotation")],
    ids=["exact", "paper"],
)
@pytest.mark.parametrize("entry", entries("map_pwl.json"), ids=lambda entry: entry["category"])
def test_next_departure_agrees_with_the_reference(entry, permanent_after, rule):
    oscillator = oscillator_of(entry)._replace(permanent_after=permanent_after)
    impact = departure(oscillator, float(entry["t0"]), float(entry["v0"]))
    assert impact.lower_impacts == entry["nminus"]
    if entry[rule]:
        assert impact.outcome == Outcome.PERMANENT_CONTACT
        assert math.isnan(impact.t) and math.isnan(impact.v)
    else:
        assert impact.outcome == Outcome.RETURNED
        assert phase_error(impact.t, entry["t1"]) <= 1e-13
        assert speed_error(impact.v, entry["v1"]) <= 1e-12


def _random_case(seed):
    rng = np.random.default_rng(seed)
    damping, stiffness = 10.0 ** rng.uniform(-2.0, 0.0), 10.0 ** rng.uniform(1.0, 5.0)
    oscillator = Oscillator(damping, 0.0, damping * rng.uniform(0.1, 3.0), stiffness)
    part = rng.uniform(0.0, 0.95)
    oscillator = oscillator._replace(eccentricity=part * eccentricity_bound_smooth_maxima(oscillator))
    t = rng.random()
    # Every third case is so slow that contact may never end.
    factor = 10.0 ** rng.uniform(-3.0, -1.0) if seed % 3 == 0 else rng.uniform(0.1, 2.0)
    return oscillator, t, factor * graze_of(oscillator, t)


def test_the_cases_for_the_integrator_end_in_every_way():
    cases = [_random_case(seed) for seed in range(_CASES)]
    impacts = [departure(*case) for case in cases]
    assert min(sum(impact.lower_impacts == n for impact in impacts) for n in (0, 1)) >= 10
    assert sum(impact.outcome == Outcome.PERMANENT_CONTACT for impact in impacts) >= 3


@pytest.mark.parametrize("seed", range(_CASES))
def test_next_departure_agrees_with_an_ode_integrator(seed):
    oscillator, t, v = _random_case(seed)
    impact = departure(oscillator, t, v)
    longest = 3.0 if impact.outcome == Outcome.PERMANENT_CONTACT else 1e3
    integrated = integrated_departure(oscillator, t, v, longest)
    if integrated is None:
        assert impact.outcome == Outcome.PERMANENT_CONTACT
        return
    time, speed, lower = integrated
    assert impact.outcome == Outcome.RETURNED
    assert impact.lower_impacts == lower
    assert phase_error(impact.t, repr(float(time % 1.0))) < 1e-9
    assert abs(impact.v - speed) < 1e-8 * v


@st.composite
def contacts(draw, side=None, largest_part_of_bound=0.999):
    """Oscillator of any stiffness (the resonance at kappa = 2 pi^2 among them), side, phase and speed of entering."""
    oscillator = draw(oscillators(largest_part_of_bound))
    oscillator = oscillator._replace(stiffness=10.0 ** draw(st.floats(1.0, 7.0)))
    gentle = 4.0 * math.pi * oscillator.damping / math.sqrt(2.0 * oscillator.stiffness)
    speed = gentle * 10.0 ** draw(st.floats(-3.0, 3.0))
    return oscillator, side or draw(st.sampled_from([UPPER, LOWER])), draw(phases), speed


def _sampled(oscillator, side, phase, speed, tau):
    """Depth at times tau, from the complex form of Eqs. (33-37), and the largest of its terms."""
    damping, square = oscillator.damping, 2.0 * oscillator.stiffness
    drive = -oscillator.eccentricity * (4.0 * math.pi**2 - 2j * math.pi * damping)
    answer = side * drive / (square - 4.0 * math.pi**2 + 2j * math.pi * damping)
    level = side * 4.0 * math.pi * damping / square
    start = answer * np.exp(2j * math.pi * phase)
    root = -damping / 2.0 + 1j * math.sqrt(square - damping**2 / 4.0)
    # Real part of ring e^{root tau}, with x(0) = 0 and x'(0) = speed.
    cosine = -(level + start.real)
    sine = (speed - (2j * math.pi * start).real + damping / 2.0 * cosine) / root.imag
    depth = level + (start * np.exp(2j * math.pi * tau)).real + ((cosine - 1j * sine) * np.exp(root * tau)).real
    return depth, abs(level) + abs(answer) + math.hypot(cosine, sine)


@given(st.one_of(contacts(), contacts(largest_part_of_bound=8.0)))
@settings(max_examples=300)
def test_no_exit_before_the_one_found(case):
    oscillator, side, phase, speed = case
    contact = contact_of(oscillator, side, phase, speed)
    assert contact.outcome == Outcome.RETURNED or (contact.outcome == Outcome.PERMANENT_CONTACT and side == UPPER)
    radian = 1.0 / math.sqrt(2.0 * oscillator.stiffness)
    duration = 300.0 * radian if contact.outcome == Outcome.PERMANENT_CONTACT else contact.duration
    samples = int(min(10.0 * duration / radian, 100_000.0)) + 100
    depth, scale = _sampled(oscillator, side, phase, speed, duration * np.arange(1, samples) / samples)
    assert depth.min() > -1e-14 * scale
    if contact.outcome == Outcome.RETURNED:
        exit_depth, _ = _sampled(oscillator, side, phase, speed, contact.duration)
        assert abs(exit_depth) < (1e-14 + 1e-15 * contact.duration / radian) * scale
        assert contact.speed > 0.0


@given(contacts(side=UPPER))
@settings(max_examples=300)
def test_the_rule_of_one_rotation_calls_the_longer_contacts_permanent(case):
    exact, paper = contact_of(*case), contact_of(case[0]._replace(permanent_after=ONE_ROTATION), *case[1:])
    if exact.outcome == Outcome.RETURNED and exact.duration <= 1.0:
        assert paper == exact
    else:
        assert paper.outcome == Outcome.PERMANENT_CONTACT
        assert math.isnan(paper.duration) and math.isnan(paper.speed)


@given(contacts(side=UPPER))
@settings(max_examples=200)
def test_every_contact_ends_where_there_is_no_quiet_solution(case):
    oscillator, side, phase, speed = case
    quiet = eccentricity_bound_quiet(oscillator)
    between = 0.5 * (quiet + eccentricity_bound_smooth_maxima(oscillator))
    oscillator = oscillator._replace(eccentricity=between)
    outcome = contact_of(oscillator, side, phase, speed).outcome
    assert outcome == Outcome.RETURNED or between <= quiet


@given(contacts(side=UPPER))
@settings(max_examples=100)
def test_without_eccentricity_a_contact_begun_at_rest_never_ends(case):
    """It swings about the depth at rest, from 0 to a little less than twice that, and what is left of it decays."""
    oscillator, side, phase, _ = case
    contact = contact_of(oscillator._replace(eccentricity=0.0), side, phase, 0.0)
    assert contact.outcome == Outcome.PERMANENT_CONTACT


@pytest.mark.parametrize("side", [UPPER, LOWER])
@pytest.mark.parametrize("speed", [0.0, 5e-324, 1e-300, 1e-100, 1e-20, 1e-12])
def test_contacts_of_hardly_any_speed_end_or_are_permanent(side, speed):
    for phase in np.linspace(0.0, 1.0, 41):
        contact = contact_of(Oscillator(stiffness=1000.0), side, phase, speed)
        if side == LOWER:
            assert contact.outcome == Outcome.RETURNED
            assert 0.0 <= contact.duration < 10.0 * max(speed, 1e-17) and abs(contact.speed - speed) < 1e-15
        elif contact.outcome == Outcome.RETURNED:
            assert contact.duration > 0.1 and contact.speed > 1e-3
        else:
            assert contact.outcome == Outcome.PERMANENT_CONTACT


def test_the_stiff_limit_is_the_impacting_map():
    rng = np.random.default_rng(2)
    for t, v in zip(rng.random(100), rng.uniform(0.5, 7.0, 100), strict=True):
        elastic = departure(Oscillator(), t, v)
        errors = []
        for stiffness in (1e6, 1e8, 1e10):
            stiff = departure(Oscillator(stiffness=stiffness), t, v)
            assert stiff.lower_impacts == elastic.lower_impacts
            errors.append((phase_error(stiff.t, repr(elastic.t)) + abs(stiff.v - elastic.v)) * math.sqrt(stiffness))
        # The error falls as 1/sqrt(kappa): what multiplies it settles.
        assert abs(errors[2] - errors[1]) < 0.02 * max(errors[1], 1.0)


@given(st.data())
@settings(max_examples=100)
def test_the_map_commutes_with_a_shift_by_one_period(data):
    oscillator, _, t, _ = data.draw(contacts())
    v = data.draw(st.floats(0.01, 3.0)) * graze_of(oscillator, t)
    t = round(t * 2**20) / 2**20  # a phase that keeps all its digits when a period is added
    here, later = departure(oscillator, t, v), departure(oscillator, t + 1.0, v)
    np.testing.assert_array_equal(here, later)


@pytest.mark.parametrize(("t", "v"), [(math.nan, 1.0), (0.2, -1.0), (0.3, 0.0), (0.4, math.inf), (0.5, math.nan)])
def test_points_that_are_no_departures_are_coded_not_raised(t, v):
    impact = departure(Oscillator(stiffness=1000.0), t, v)
    assert impact.outcome == Outcome.OUTSIDE_SECTION
    assert math.isnan(impact.t) and math.isnan(impact.v)
