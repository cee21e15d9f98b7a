"""A production within tolerances: what is known of it, and which tolerance is to blame where that is known."""

import math

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binomtest, qmc

import rattle
from rattle_kernels import shares_of
from rattle_machine.tolerances import QUIET, Range, _indices, _size, _with_column, tolerances

# A machine of the paper's numbers, nearly: some of its departures end in rattle.
PAIR = rattle.GearPair(
    speed=100.0, inertia=0.01, drag_torque=9.5493, base_radius=0.1, backlash=0.12, transmission_error=0.01
)


def test_indices_are_those_of_ishigamis_function():
    """Its indices are known in closed form: Saltelli et al., Global sensitivity analysis, the primer (2008), 5.8."""
    ranges = tuple(Range(f"x{number}", "", -math.pi, math.pi) for number in range(3))
    first, second = np.hsplit(qmc.Sobol(6, rng=1).random_base2(12), 2)

    def ishigami(points):
        x, y, z = (each.at(part) for each, part in zip(ranges, points.T, strict=True))
        return np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)

    both = ishigami(np.concatenate([first, second]))
    mixed = np.array([ishigami(_with_column(first, second, column)) for column in range(3)])
    found = _indices(ranges, both, mixed, 0)
    variance = 49.0 / 8.0 + 0.1 * math.pi**4 / 5.0 + 0.01 * math.pi**8 / 18.0 + 0.5
    alone = np.array([0.5 * (1.0 + 0.1 * math.pi**4 / 5.0) ** 2, 49.0 / 8.0, 0.0]) / variance
    with_all = alone + np.array([1.0, 0.0, 1.0]) * 0.01 * math.pi**8 * 8.0 / 225.0 / variance
    for name, exact in (("first", alone), ("total", with_all)):
        # The bootstrap's interval at 95 %, half as wide again: three of three lie inside unless it is wrong.
        low, high = found[f"{name}_low"].to_numpy(), found[f"{name}_high"].to_numpy()
        half = 0.75 * (high - low)
        np.testing.assert_array_less(np.abs(found[name] - exact), half + 1e-3)


def test_a_law_has_its_limits_and_its_middle():
    part = np.linspace(0.0, 1.0, 1001)
    even, normal = Range("a", "", 2.0, 6.0), Range("a", "", 2.0, 6.0, normal=True)
    for each in (even, normal):
        values = each.at(part)
        assert values[[0, 500, -1]] == pytest.approx([2.0, 4.0, 6.0], abs=1e-12)
        assert (np.diff(values) > 0.0).all()
    np.testing.assert_allclose(even.at(part), 2.0 + 4.0 * part)
    # A third of the half width is the deviation: 68.27 of 99.73 % lie within it.
    inside = np.mean(np.abs(normal.at((np.arange(20_000) + 0.5) / 20_000) - 4.0) < 2.0 / 3.0)
    assert inside == pytest.approx(0.682689492 / 0.997300204, abs=1e-4)
    assert (even.tightened(0.25).low, even.tightened(0.25).high) == (3.5, 4.5)


@pytest.fixture(scope="module")
def study():
    return tolerances(
        PAIR,
        {"transmission_error.1.amplitude": "10 +- 2 mm", "transmission_error.1.phase": "any",
         "inertia": (0.0099, 0.0101)},
        machines=160, departures=128,
    )  # fmt: skip


def test_each_machine_of_the_table_does_what_it_does_alone(study):
    assert len(study.table) == 64 and study.table.columns.tolist() == [
        "transmission_error.1.amplitude", "transmission_error.1.phase", "inertia", QUIET, "impact_power_w", "gamma"
    ]  # fmt: skip
    random = np.random.default_rng(0)
    phase, part = random.random((2, 128))
    top = 7.2 * PAIR.scales.speed  # of the nominal machine: 12 damping
    for row in study.table.sample(5, random_state=0).to_dict("records"):
        machine = rattle.GearPair(
            **PAIR.model_dump()
            | {"inertia": row["inertia"],
               "transmission_error": {1: {"amplitude": row["transmission_error.1.amplitude"],
                                          "phase": row["transmission_error.1.phase"]}}}
        )  # fmt: skip
        found = shares_of(machine.oscillator, phase, top * (1.0 - part) / machine.scales.speed)
        assert row[QUIET] == pytest.approx(found.share[0], abs=1e-12)
        assert row["gamma"] == machine.gamma


def test_the_amplitude_is_to_blame_and_the_phase_of_the_only_order_is_not(study):
    """With uniform phases of departures the phase of a single order only says when time begins."""
    assert study.guilty == "transmission_error.1.amplitude"
    indices = study.indices.set_index("number")
    assert indices.total["transmission_error.1.amplitude"] > 0.5
    # The phase is no part of the model where there is one order, so exchanging it changes nothing at all.
    assert indices.total["transmission_error.1.phase"] == 0.0
    tight, then = study.tightened
    assert (tight.low, tight.high) == pytest.approx((0.009, 0.011))
    spread = study.production.quantiles[0.95] - study.production.quantiles[0.05]
    assert then.quantiles[0.95] - then.quantiles[0.05] < spread


def test_what_is_said_of_the_production_follows_from_the_table(study):
    quiet = study.table[QUIET]
    assert study.production.mean.value == pytest.approx(quiet.mean())
    assert study.production.bad.value == (quiet < 0.99).mean()
    assert study.production.power.value == pytest.approx(study.table["impact_power_w"].mean())
    text = str(study)
    assert "64 machines with 128 departures each" in text
    assert "transmission_error.1.amplitude = 0.01 +- 0.002 m" in text
    told = study.to_dict()
    assert told["guilty"] == study.guilty and told["machines"] == 64
    assert pd.DataFrame.from_dict(told["indices"], orient="index").shape == (3, 6)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_production_with_any_number_of_threads():
    def drawn(workers, seed=3):
        given = {"backlash": "0.12 +- 0.02 m"}
        return tolerances(PAIR, given, machines=32, departures=64, tighten=1.0, seed=seed, workers=workers).table

    pd.testing.assert_frame_equal(drawn(1), drawn(3))
    assert not drawn(1).equals(drawn(1, seed=4))


@pytest.mark.parametrize("contact", [{"restitution": 0.8}, {"mesh_stiffness": 1e7}], ids=["impacts", "springs"])
def test_machines_whose_teeth_part_in_every_turn_are_never_quiet_and_their_power_is_known(contact):
    lossy = rattle.GearPair(**PAIR.model_dump() | contact)
    found = tolerances(lossy, {"speed": (125.0, 150.0)}, machines=48, departures=32, tighten=1.0)
    beyond, power = found.table["gamma"] >= 1.0, found.table["impact_power_w"]
    assert beyond.any() and not beyond.all()
    assert (found.table[QUIET][beyond] == 0.0).all() and (power[beyond] > 0.0).all()
    assert found.production.power.value == pytest.approx(power.mean())
    assert found.tightened is None


def test_the_power_of_machines_that_are_never_quiet_is_not_known_after_pulses():
    found = tolerances(PAIR, {"speed": (90.0, 200.0)}, machines=48, departures=8, tighten=1.0, size=1.0)
    beyond = found.table["gamma"] >= 1.0
    assert beyond.any() and not beyond.all()
    assert (found.table[QUIET][beyond] == 0.0).all() and found.table["impact_power_w"][beyond].isna().all()


def test_episodes_a_year_follow_from_the_rate():
    found = tolerances(
        PAIR, {"backlash": "0.12 +- 0.02 m"}, machines=48, departures=64, size="20 N m s", rate="1 / hour"
    )
    hours = 365.25 * 24.0
    np.testing.assert_allclose(found.table["episodes_a_year"], hours * (1.0 - found.table[QUIET]))


def test_machines_that_all_do_the_same_blame_nobody():
    still = rattle.GearPair(**PAIR.model_dump() | {"transmission_error": 0.0})
    found = tolerances(still, {"backlash": "0.12 +- 0.001 m"}, machines=48, departures=32)
    assert found.guilty is None and found.tightened is None and found.indices["total"].isna().all()
    assert "no tolerance is to blame" in str(found)
    assert binomtest(int(found.table[QUIET].sum()), 32).k == 32  # every machine is quiet from everywhere


@pytest.mark.parametrize(("machines", "numbers", "sets"), [(1024, 2, 256), (1024, 5, 128), (64, 1, 32), (80, 3, 16)])
def test_sets_are_powers_of_two_within_the_machines_asked_for(machines, numbers, sets):
    assert _size(machines, numbers) == sets
    assert sets * (numbers + 2 if numbers > 1 else 2) <= machines


@pytest.mark.parametrize(
    ("numbers", "options", "words"),
    [
        ({}, {}, "one or more"),
        ({"foo": "1 +- 1 m"}, {}, "there is no number 'foo'"),
        ({"transmission_error.3.phase": "any"}, {}, "there are transmission_error.1.amplitude"),
        ({"backlash": "any"}, {}, "is no tolerance"),
        ({"backlash": "120 mm"}, {}, "is no tolerance"),
        ({"backlash": "120 +- 0 mm"}, {}, "enclose nothing"),
        ({"backlash": "120 +- 130 mm"}, {}, "cannot have backlash = -0.01"),
        ({"backlash": "120 +- 10 kg"}, {}, "cannot be in m: write it as in"),
        ({"restitution": (0.5, 1.0)}, {}, "the machine has no restitution"),
        ({"inertia_ratio": "1 +- 0.1 kg"}, {}, "has no unit"),
        ({"backlash": (0.1, 0.12, 0.13)}, {}, "is no tolerance"),
        ({"backlash": "120 +- 10 mm"}, {"machines": 31}, "at least 32"),
        ({"backlash": "120 +- 10 mm"}, {"limit": 0.0}, "limit must be"),
        ({"backlash": "120 +- 10 mm"}, {"rate": "3 / hour"}, "give their size as well"),
        ({"backlash": "120 +- 10 mm"}, {"departures": 1}, "departures must be"),
    ],
)
def test_what_is_wrong_is_said_with_what_would_be_right(numbers, options, words):
    with pytest.raises(rattle.InvalidJob, match=words):
        tolerances(PAIR, numbers, **options)
