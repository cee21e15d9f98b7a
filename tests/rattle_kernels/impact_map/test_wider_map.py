"""P under several harmonics, with impacts or contacts that lose energy: against references and integrators."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rattle_kernels import Oscillator, Outcome, check_domain, grazing_velocity, previous_impacts
from tests.rattle_kernels.impact_map.integrator import integrated_departure
from tests.rattle_kernels.impact_map.scalar_map import departure, sensitivity
from tests.rattle_kernels.reference import phase_error, spare_compiling, speed_error
from tests.strategies import phases, speeds, wider_oscillators, wider_stiff_oscillators

_TABLE = json.loads((Path(__file__).parents[1] / "data" / "map_harmonics.json").read_text())["entries"]


def oscillator_of(entry):
    return check_domain(
        Oscillator(
            entry["damping"], entry["eccentricity"], entry["half_backlash"], restitution=entry["restitution"],
            harmonics=tuple(map(tuple, entry["harmonics"])),
        )
    )  # fmt: skip


@pytest.mark.parametrize(
    "entry", spare_compiling(_TABLE), ids=lambda entry: f"{len(entry['harmonics'])}-{entry['restitution']}"
)
def test_next_departure_agrees_with_the_reference_and_back_again(entry):
    oscillator, t, v = oscillator_of(entry), float.fromhex(entry["t"]), float.fromhex(entry["v"])
    impact = departure(oscillator, t, v)
    assert impact.lower_impacts == entry["lower_impacts"] and impact.outcome == Outcome.RETURNED
    assert phase_error(impact.t, entry["t_next"]) <= 1e-13
    assert speed_error(impact.v, entry["v_next"]) <= 1e-12
    before = previous_impacts(oscillator, impact.t, impact.v)
    assert abs((float(before.t) - t + 0.5) % 1.0 - 0.5) <= 1e-11 and float(before.v) == pytest.approx(v, rel=1e-11)


def _random_case(seed):
    rng = np.random.default_rng(seed)
    damping = 10.0 ** rng.uniform(-1.5, 0.0)
    bound = 2.0 * damping / math.hypot(2.0 * math.pi, damping)
    shares = rng.dirichlet(np.ones(seed % 3 + 2)) * rng.uniform(0.2, 0.95)
    # A harmonic of order n shakes n^2 times as hard.
    harmonics = tuple((n, share * bound / n**2, rng.random()) for n, share in enumerate(shares[1:], 2))
    oscillator = Oscillator(
        damping, shares[0] * bound, damping * rng.uniform(0.1, 3.0), 10.0 ** rng.uniform(1.0, 5.0),
        contact_damping=rng.choice([0.0, 0.02, 0.3, 0.7]), harmonics=harmonics,
    )  # fmt: skip
    t = rng.random()
    factor = 10.0 ** rng.uniform(-3.0, -1.0) if seed % 3 == 0 else rng.uniform(0.1, 2.0)
    oscillator = check_domain(oscillator)
    return oscillator, t, factor * float(grazing_velocity(oscillator, t))


_CASES = 45


def test_the_cases_for_the_integrator_end_in_every_way():
    impacts = [departure(*_random_case(seed)) for seed in range(_CASES)]
    assert min(sum(impact.lower_impacts == n for impact in impacts) for n in (0, 1)) >= 10
    assert sum(impact.outcome == Outcome.PERMANENT_CONTACT for impact in impacts) >= 3


@pytest.mark.parametrize("seed", range(_CASES))
def test_next_departure_of_the_stiff_model_agrees_with_an_ode_integrator(seed):
    oscillator, t, v = _random_case(seed)
    impact = departure(oscillator, t, v)
    integrated = integrated_departure(oscillator, t, v, 3.0 if impact.outcome == Outcome.PERMANENT_CONTACT else 1e3)
    if integrated is None:
        assert impact.outcome == Outcome.PERMANENT_CONTACT
        return
    time, speed, lower = integrated
    assert impact.outcome == Outcome.RETURNED and impact.lower_impacts == lower
    assert phase_error(impact.t, repr(float(time % 1.0))) < 1e-9
    assert abs(impact.v - speed) < 1e-8 * v


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_areas_shrink_by_damping_and_by_impacts(data):
    oscillator = data.draw(wider_oscillators())
    t, v = data.draw(phases), data.draw(speeds(oscillator, 0.05))
    assume(abs(v / grazing_velocity(oscillator, t) - 1) > 1e-3)
    impact, jacobian, _ = sensitivity(oscillator, 0, t, v, False)
    area = jacobian.tt * jacobian.vv - jacobian.tv * jacobian.vt
    # Of (time, energy): a flight shrinks it by e^{-delta tau}, an impact by r^2.
    expected = math.exp(-oscillator.damping * impact.duration) * oscillator.restitution ** (
        2 + 2 * impact.lower_impacts
    )
    size = abs(jacobian.tt * jacobian.vv) + abs(jacobian.tv * jacobian.vt)
    assert area * impact.v / v == pytest.approx(expected, rel=1e-9, abs=1e-12 * size * impact.v / v)


def _difference(function, x, step):
    far, near = function(x + 2 * step) - function(x - 2 * step), function(x + step) - function(x - step)
    return (8 * near - far) / (12 * step)


def _agree_with_differences(oscillator, name, t, v):
    value, number = oscillator.value_of(name), oscillator.parameters.index(name)

    def varied(changed):
        impact = departure(oscillator.at(**{name: changed}), t, v)
        return np.array([impact.duration, impact.v])

    step = 1e-4 * max(abs(value), 0.01)
    impact, _, change = sensitivity(oscillator, number, t, v, False)
    coarse, fine = _difference(varied, value, step), _difference(varied, value, step / 4)
    assume(np.isfinite(coarse).all() and np.abs(coarse - fine).max() < 1e-5 * (1 + np.abs(fine).max()))
    scale = np.abs(fine) + (abs(impact.duration) + impact.v) / max(abs(value), 1e-3)
    assert np.abs(np.array(change) - fine).max() <= 1e-5 * scale.max()


_NAMES = ["damping", "eccentricity", "half_backlash", "amplitude_2", "phase_2", "amplitude_3", "phase_3"]


@settings(max_examples=150, deadline=None)
@given(st.data(), st.sampled_from([*_NAMES, "restitution"]))
def test_the_impacting_models_sensitivity_agrees_with_differences(data, name):
    oscillator = data.draw(wider_oscillators())
    t, v = data.draw(phases), data.draw(speeds(oscillator, 0.05))
    assume(abs(v / grazing_velocity(oscillator, t) - 1) > 0.01)
    _agree_with_differences(oscillator, name, t, v)


@settings(max_examples=150, deadline=None)
@given(st.data(), st.sampled_from([*_NAMES, "stiffness", "contact_damping"]))
def test_the_stiff_models_sensitivity_agrees_with_differences(data, name):
    oscillator = data.draw(wider_stiff_oscillators())
    t, v = data.draw(phases), data.draw(speeds(oscillator, 0.05))
    assume(abs(v / grazing_velocity(oscillator, t) - 1) > 0.01)
    _agree_with_differences(oscillator, name, t, v)
