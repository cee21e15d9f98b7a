"""The box of parameters: it holds every machine within limits, and no machine is missing at its ends."""

import itertools
import math

import numpy as np
import pytest

from rattle_machine.numbers import with_number
from rattle_machine.parameter_box import parameter_box
from tests.rattle_machine.machines import machine

ERROR = {1: {"amplitude": 0.01, "phase": 0.3}, 2: {"amplitude": 0.002, "phase": 0.9}, 5: 1e-4}
PRODUCTIONS = {
    "every number": (
        machine(inertia_ratio=0.5, restitution=0.9, transmission_error=ERROR, turns=3),
        {
            "speed": (290.0, 310.0), "inertia": (0.0099, 0.0102), "drag_torque": (80.0, 90.0),
            "base_radius": (0.099, 0.1005), "backlash": (0.1, 0.13), "inertia_ratio": (0.0, 0.6),
            "restitution": (0.8, 1.0), "transmission_error.1.amplitude": (0.0, 0.012),
        },
    ),
    "phases": (
        machine(transmission_error=ERROR),
        {"transmission_error.1.phase": (0.28, 0.31), "transmission_error.2.phase": (-0.2, 0.1)},
    ),
    "any phase of the first order": (machine(transmission_error=ERROR), {"transmission_error.1.phase": (0.0, 1.0)}),
    "losses by damping": (machine(contact_damping=0.1), {"contact_damping": (0.0, 0.7)}),
    "drag that follows speed": (
        machine(drag_law="proportional"),
        {"drag_torque": (80.0, 90.0), "speed": (250.0, 350.0)},
    ),
    "drag as it is given after speed": (
        machine(drag_law="proportional"),
        {"speed": (250.0, 350.0), "drag_torque": (80.0, 90.0)},
    ),
}  # fmt: skip
DRAWS = 2000


def parameters(pair):
    """Parameters of the model by their names, and the unit of speed."""
    model = pair.oscillator
    names = [name for name in model.parameters if name not in ("stiffness", "contact_damping")]
    return {name: model.value_of(name) for name in names} | {"unit": pair.scales.speed}


def within(pair, values):
    for name, value in values.items():
        pair = with_number(pair, name, value)
    return parameters(pair)


def intervals(pair, limits):
    box = parameter_box(pair, limits)
    return box.within | {"unit": box.speed}


def near(value, interval, name):
    """A phase as it is nearest to the middle of an interval."""
    return value + round(0.5 * sum(interval) - value) if name.startswith("phase") else value


@pytest.mark.parametrize("production", PRODUCTIONS)
def test_it_holds_the_oscillator_of_every_machine_within(production):
    pair, limits = PRODUCTIONS[production]
    box, random = intervals(pair, limits), np.random.default_rng(0)
    for _ in range(DRAWS):
        # At its ends as often as not.
        part = {name: random.choice([0.0, 1.0, random.random(), random.random()]) for name in limits}
        values = {name: min(max(low + part[name] * (high - low), low), high) for name, (low, high) in limits.items()}
        for name, value in within(pair, values).items():
            low, high = box[name]
            assert low <= near(value, box[name], name) <= high, (name, values)


@pytest.mark.parametrize("production", PRODUCTIONS)
def test_each_of_its_ends_is_that_of_a_machine(production):
    pair, limits = PRODUCTIONS[production]
    box = intervals(pair, limits)
    corners = [within(pair, dict(zip(limits, ends, strict=True))) for ends in itertools.product(*limits.values())]
    for name, (low, high) in box.items():
        if (low, high) == (0.0, 1.0) and name.startswith("phase"):
            continue  # any
        found = [near(corner[name], (low, high), name) for corner in corners]
        # An end moves outwards by 2^-45 of itself, and floats are rounded by much less: 2^-44, or a part of 6e-14.
        assert (min(found), max(found)) == pytest.approx((low, high), rel=1e-13, abs=2e-13), name


def test_any_phase_of_the_first_order_leaves_no_phase_out():
    pair, limits = PRODUCTIONS["any phase of the first order"]
    box = intervals(pair, limits)
    assert box["phase_2"] == box["phase_5"] == (0.0, 1.0)


def test_phases_lie_where_a_proof_takes_them():
    for turn in np.linspace(-3.0, 3.0, 61):
        limits = {"transmission_error.2.phase": (turn, turn + 0.9)}
        low, high = parameter_box(machine(transmission_error=ERROR), limits).within["phase_2"]
        assert -1.0 <= low < high <= 2.0 and high - low == pytest.approx(0.9)


@pytest.mark.parametrize("production", PRODUCTIONS)
def test_without_limits_it_is_the_machine_itself(production):
    pair, _ = PRODUCTIONS[production]
    box = parameter_box(pair, {})
    for name, value in parameters(pair).items():
        low, high = {**box.within, "unit": box.speed}[name]
        value = near(value, (low, high), name)
        assert low <= value <= high and high - low <= 2e-12 * max(1.0, abs(value)), name
    assert box.oscillator.restitution == pytest.approx(pair.oscillator.restitution, rel=1e-12)
    for name in set(box.within) - {"restitution"}:
        value = box.oscillator.value_of(name)
        assert near(pair.oscillator.value_of(name), (value, value), name) == pytest.approx(value, rel=1e-12)


def test_its_middle_lies_in_it():
    pair, limits = PRODUCTIONS["every number"]
    box = parameter_box(pair, limits)
    for name, (low, high) in box.within.items():
        assert low <= box.oscillator.value_of(name) <= high
        assert box.oscillator.value_of(name) == pytest.approx(0.5 * (low + high))


def test_what_an_impact_keeps_is_that_of_the_damping_ratio():
    pair, _ = PRODUCTIONS["losses by damping"]
    for zeta in (1e-9, 0.1, 0.5, 0.9):
        low, high = parameter_box(pair, {"contact_damping": (zeta, zeta)}).within["restitution"]
        exact = math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2))
        assert low < exact < high and high - low < 1e-13
