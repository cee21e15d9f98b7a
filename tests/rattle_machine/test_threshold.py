"""Where a share is reached, against shares counted anew on both sides, and against samples of other seeds."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from rattle_kernels import Oscillator, capture_velocity, shares_of
from rattle_machine.threshold import _narrowed
from tests.rattle_machine.machines import machine

BASE = Oscillator(damping=0.6)
ERRORS = 5.0


def test_the_share_is_crossed_within_the_bracket_and_the_error_covers_other_seeds():
    found = rattle.threshold(BASE, "eccentricity", 0.8, between=(0.06, 0.12), departures=1024, fastest=7.0)
    low, high = found.bracket
    assert low <= found.value <= high and high - low <= 2.1 * found.error
    assert (found.shares[0] - 0.8) * (found.shares[1] - 0.8) <= 0.0
    # Another sample, counted anew: its share there is the one asked for, within both samples' errors.
    rng = np.random.default_rng(77)
    t, v = rng.random(4000), 7.0 * (1.0 - rng.random(4000))
    share = shares_of(BASE.at(eccentricity=found.value), t, v).share[0]
    apart = math.hypot(found.error * abs(found.slope), math.sqrt(0.16 / 4000))
    assert abs(share - 0.8) < ERRORS * apart


def test_a_step_is_found_to_the_bracket_and_a_slope_to_its_error():
    def step(value):
        return 1.0 if value < 0.3 else 0.2

    left, right, slope = _narrowed(step, ((0.0, 1.0), (1.0, 0.2)), 0.5, 0.01)
    assert left[0] < 0.3 <= right[0] and right[0] - left[0] < 1e-9 and slope < -1e6
    left, right, slope = _narrowed(lambda value: 1.0 - value**2, ((0.0, 1.0), (1.0, 0.0)), 0.51, 1e-4)
    assert left[0] <= 0.7 <= right[0] and slope == pytest.approx(-1.4, rel=1e-2)
    assert right[0] - left[0] <= 0.2 * 1e-4 / 1.4 * 1.02


def test_several_crossings_are_said_and_the_first_is_bracketed(monkeypatch):
    from rattle_machine import threshold as module

    monkeypatch.setattr(module, "_share_at", lambda *_: lambda value: 0.5 + 0.4 * math.cos(2.0 * math.pi * value))
    found = rattle.threshold(BASE, "damping", 0.5, between=(0.1, 1.0), departures=100)
    assert found.value == pytest.approx(0.25, abs=found.error) and len(found.crossings) == 2
    assert found.crossings[0][0] < 0.25 < found.crossings[0][1] < found.crossings[1][0] < 0.75
    assert "the share crosses again within" in str(found)


def test_a_share_that_is_not_reached_is_told_with_those_at_both_ends():
    with pytest.raises(rattle.InvalidJob) as caught:
        rattle.threshold(BASE, "eccentricity", 0.01, between=(0.06, 0.1), departures=256, scan=2)
    told = str(caught.value)
    assert "a share 0.01 of permanent contact is not reached between 0.06 and 0.1" in told
    assert "at 0.06, " in told and "at 0.1, and" in told


def test_the_size_of_a_pulse_moves_the_backlash_at_which_it_is_harmless():
    """A fixed pulse too weak to be let go by capture is harmless whatever the backlash; a stronger one is not."""
    pair = machine()
    weak = 0.9 * float(capture_velocity(pair.oscillator, np.linspace(0, 1, 100)).min()) * pair.scales.impulse
    with pytest.raises(rattle.InvalidJob, match="it is 1 at 0.11, 1 at 0.13"):
        rattle.threshold(
            pair, "backlash", 0.8, between=(0.11, 0.13), size=weak, distribution="fixed", departures=100, scan=2
        )


def test_a_speed_keeps_the_drag_law_and_departures_in_m_s():
    pair = machine()
    ends = []
    from rattle_machine.departures import sample_of
    from rattle_machine.threshold import _varied

    base, at, low, high = _varied(pair, "speed", ("2800 rpm", 320.0))
    assert (low, high) == pytest.approx((2800 * 2 * math.pi / 60, 320.0))
    sample = sample_of(base, size=None, distribution=None, pressing="bounces", fastest=30.0, departures=100, seed=0)
    for speed in (low, high):
        other = at(speed)
        assert other.drag_torque == pair.drag_torque and other.speed == speed
        t, v = sample(other)
        ends.append((t, v * other.scales.speed))
    assert np.array_equal(ends[0][0], ends[1][0]) and ends[0][1] == pytest.approx(ends[1][1], rel=1e-14)
    assert 0.0 < ends[0][1].min() and ends[0][1].max() <= 30.0


def test_orders_of_the_transmission_error_are_parameters():
    from rattle_machine.threshold import _varied

    pair = machine(transmission_error={1: 0.008, 3: {"amplitude": 1e-4, "phase": 0.2}})
    _, at, low, high = _varied(pair, "transmission_error.3.phase", ("10 deg", 0.5))
    assert (low, high) == pytest.approx((10 / 360, 0.5))
    assert at(0.4).transmission_error[3].phase == 0.4 and at(0.4).transmission_error[1].amplitude == 0.008


@pytest.mark.parametrize(
    ("given", "place", "told"),
    [
        ({"share": 0.0}, "share", "between 0 and 1"),
        ({"share": 1.5}, "share", "between 0 and 1"),
        ({"parameter": "colour"}, "parameter", "must be one of"),
        ({"between": (0.1, 0.1)}, "between", "two different values"),
        ({"between": 0.1}, "between", "two values"),
        ({"between": (0.1, math.inf)}, "between", "two values"),
        ({"between": (-0.1, 0.1)}, "between", "eccentricity = -0.1: .* at least 0"),
        ({"size": 1.0}, "size", "GearPair"),
        ({"distribution": "normal"}, "distribution", "give a size"),
        ({"departures": 1}, "departures", "from 2 on"),
        ({"fastest": -1.0}, "fastest", "above 0"),
        ({"scan": 1}, "scan", "from 2 on"),
    ],
)
def test_bad_input_is_told_what_would_be_right(given, place, told):
    usual = {"parameter": "eccentricity", "share": 0.8, "between": (0.06, 0.1), "departures": 64}
    values = usual | given
    with pytest.raises(rattle.InvalidJob, match=told) as caught:
        rattle.threshold(BASE, values.pop("parameter"), values.pop("share"), **values)
    assert caught.value.place == (place,)


def test_parameters_of_a_machine_are_named():
    for parameter in ("colour", "transmission_error", "transmission_error.2.phase"):
        with pytest.raises(rattle.InvalidJob, match="there is no number"):
            rattle.threshold(machine(), parameter, 0.8, between=(0.1, 0.2))
    with pytest.raises(rattle.InvalidJob, match="backlash"):
        rattle.threshold(machine(), "backlash", 0.8, between=("1 s", "2 mm"))
    fast = {"between": (900.0, 1000.0), "departures": 16, "scan": 2}
    with pytest.raises(rattle.InvalidJob, match=r"speed = 900: Gamma is .* So it is never quiet"):
        rattle.threshold(machine(), "speed", 0.8, size=1.0, **fast)


def test_no_share_of_quiet_is_left_beyond_the_threshold_speed():
    pair = machine(restitution=0.8)
    ends = 0.7 * pair.threshold_speed, 1.1 * pair.threshold_speed
    found = rattle.threshold(pair, "speed", 0.5, between=ends, departures=32, scan=3)
    assert found.scanned[0][1] > 0.5 and found.scanned[-1] == (ends[1], 0.0)
    assert found.bracket[0] < pair.threshold_speed


@pytest.mark.slow
def test_the_command_says_what_the_function_does(tmp_path):
    pair = machine()
    file = tmp_path / "machine.toml"
    names = "speed", "inertia", "drag_torque", "base_radius", "backlash"
    file.write_text("".join(f"{name} = {getattr(pair, name)!r}\n" for name in names) + "transmission_error = 0.01\n")
    arguments = ["threshold", str(file), "backlash", "--share", "0.95", "--between", "80 mm", "0.2"]
    arguments += ["--departures", "128", "--scan", "3", "--size", "1.2 N m s"]
    expected = rattle.threshold(
        pair, "backlash", 0.95, between=("80 mm", 0.2), departures=128, scan=3, size="1.2 N m s"
    )
    answer = CliRunner().invoke(app, arguments)
    assert answer.exit_code == 0 and answer.stdout.strip() == str(expected)
    assert json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout) == json.loads(
        json.dumps(expected.to_dict())
    )
    refused = CliRunner().invoke(app, ["threshold", str(file), "colour", "--share", "0.8", "--between", "1", "2"])
    assert refused.exit_code == 2 and "there is no number" in " ".join(refused.output.split())
