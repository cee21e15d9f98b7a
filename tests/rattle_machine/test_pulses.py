"""What pulses do to a machine, against time histories, the two shafts in SI, closed formulas and one another."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from rattle_kernels import capture_velocity, time_history
from tests.rattle_machine.machines import machine
from tests.worker.two_shafts import shafts_of

RATE = 1.0 / 1200.0
# Errors allowed: of independent estimates 5 are exceeded by chance once in two million.
ERRORS = 5.0
# Followed for so many periods, a motion that is not captured rattles for good: the longest passing episode of the
# machine takes a tenth of it.
PERIODS = 400.0
# Of rattle in that time there are some 700; what is captured bounces ever faster, and is not followed on.
CONTACTS = 1000


def pulses(pair, deviation, **given):
    """Normal pulses, of a deviation in the model's unit of speed."""
    return rattle.pulses(pair, rate=RATE, size=deviation * pair.scales.impulse, **given)


@pytest.fixture(scope="module")
def found():
    return pulses(machine(), 2.5, departures=2000)


def followed(pair, phase, change):
    """Length of an episode, impacts and their energy, by the scalar path; infinite where it rattles for good."""
    oscillator = pair.oscillator
    speed = change if change > 0.0 else -oscillator.restitution * change
    history = time_history(
        oscillator,
        phase,
        oscillator.half_backlash,
        -speed,
        periods=PERIODS,
        samples_per_period=1,
        most_contacts=CONTACTS,
    )
    if not math.isfinite(history.permanent_from):
        return math.inf, math.nan, math.nan
    before = history.contacts.time <= history.permanent_from
    energy = 0.5 * float((history.contacts.speed[before] ** 2).sum())
    return history.permanent_from - phase, int(before.sum()), energy


def test_every_pulse_is_followed_as_by_time_histories(found):
    table, pair = found.table, found.machine
    change = table.size_n_m_s.to_numpy() / pair.scales.impulse
    lengths, impacts, energies = np.array([followed(pair, *one) for one in zip(table.phase, change, strict=True)]).T
    lasting = np.isinf(lengths)
    # Chaos doubles rounding some 1.5 times an impact: lanes are good to 5e-11, so after 24 impacts they agree to 1e-6.
    few = np.nan_to_num(impacts, nan=np.inf) <= 24
    assert few.sum() > 800 and (~few & ~lasting).sum() > 20 and lasting.sum() > 200
    assert np.array_equal(np.isinf(table.turns), lasting) or np.isinf(table.turns).mean() == pytest.approx(
        lasting.mean(), abs=0.005
    )
    assert np.array_equal(np.isinf(table.turns)[few], lasting[few])
    assert table.turns[few].to_numpy() == pytest.approx(lengths[few], abs=1e-6)
    assert table.impacts[few].to_numpy() == pytest.approx(impacts[few])
    assert table.impact_energy_j[few].to_numpy() == pytest.approx(energies[few] * pair.scales.energy, rel=1e-5)


@pytest.mark.slow
def test_ten_thousand_pulses_of_another_sample_have_the_same_shares(found):
    pair = found.machine
    rng = np.random.default_rng(99)
    drawn = zip(rng.random(10_000), rng.normal(0.0, 2.5, 10_000), strict=True)
    lengths, _, energies = np.array([followed(pair, *one) for one in drawn]).T
    ours = pulses(pair, 2.5)
    ended = np.isfinite(lengths) & (lengths > 0.0)
    for estimate, share in (
        (ours.lasting, np.isinf(lengths).mean()), (ours.passing, ended.mean()), (ours.quiet, (lengths == 0.0).mean()),
    ):  # fmt: skip
        error = math.hypot(estimate.error, math.sqrt(share * (1.0 - share) / lengths.size))
        assert abs(estimate.value - share) < ERRORS * error
    for estimate, sample in (
        (ours.passing_turns, lengths[ended]), (ours.passing_energy, energies[ended] * pair.scales.energy),
    ):  # fmt: skip
        error = math.hypot(estimate.error, sample.std() / math.sqrt(sample.size))
        assert abs(estimate.value - sample.mean()) < ERRORS * error


@pytest.mark.parametrize("restitution", [0.7, 0.9])
def test_episodes_are_those_of_the_two_shafts(restitution):
    """From a pulse in N m s to capture, in seconds: nothing is scaled but the speed below which capture is certain.

    Without losses an episode has a hundred impacts; the time histories above follow those.
    """
    pair = machine(restitution=restitution, inertia_ratio=0.3)
    shafts, scales = shafts_of(pair), pair.scales
    ours = pulses(pair, 1.2, departures=400, seed=5)
    chosen = ours.table[(ours.table.impacts >= 2) & (ours.table.impacts <= 12)].head(12)
    assert len(chosen) == 12 and (chosen.size_n_m_s < 0).any() and (chosen.size_n_m_s > 0).any()
    for _, row in chosen.iterrows():
        time = row.phase * scales.time
        # The driven shaft is turned by T_imp/I2, so the teeth part by R2 T_imp/I2, or bounce.
        speed = row.size_n_m_s / pair.inertia * pair.base_radius
        speed = speed if speed > 0.0 else -restitution * speed
        returns = 0
        while speed >= scales.speed * capture_velocity(pair.oscillator, time / scales.time):
            time, speed = shafts.next_departure(time, speed)
            returns += 1
        lower = int(row.impacts) - returns
        assert 0 <= lower <= returns
        assert (time / scales.time - row.phase) * pair.turns == pytest.approx(row.turns, abs=2e-6)


def test_shares_add_up_and_times_follow_from_them(found):
    assert found.quiet.value + found.passing.value + found.lasting.value == pytest.approx(1.0, rel=1e-12)
    assert found.lasting.value == pytest.approx(sum(each.share.value for each in found.rattles), rel=1e-12)
    number = found.lasting.value * found.departures
    assert found.lasting.error == pytest.approx(math.sqrt(number * (1.0 - found.lasting.value)) / found.departures)
    assert found.time_between.value == pytest.approx(1200.0 / found.lasting.value)
    assert found.time_between.error / found.time_between.value == pytest.approx(
        found.lasting.error / found.lasting.value
    )
    low, high = found.lasting_interval
    assert low < found.lasting.value < high
    assert found.time_between_interval == pytest.approx((1200.0 / high, 1200.0 / low))
    names = {each.name for each in found.rattles}
    assert names == {"P(1,1,0)", "chaotic"} and found.table.motion.isin(names | {"permanent contact"}).all()


def test_the_power_of_p110_is_that_of_its_closed_formula(found):
    """It arrives at 2 pi delta once a period: 2 (pi delta)^2 in the model, 3.9 kW here."""
    orbit = next(each for each in found.rattles if each.name == "P(1,1,0)")
    scales = found.machine.scales
    assert orbit.impact_power.value == pytest.approx(2.0 * (math.pi * 0.6) ** 2 * scales.power, rel=1e-8)
    expected = sum(each.share.value * each.impact_power.value for each in found.rattles)
    assert found.impact_power.value == pytest.approx(expected, rel=1e-12) and found.impact_power.error > 0.0
    energy = np.where(np.isinf(found.table.turns), 0.0, found.table.impact_energy_j)
    assert found.passing_power.value == pytest.approx(RATE * energy.mean(), rel=1e-12)


def test_quiet_is_kept_no_longer_than_between_pulses_that_end_it(found):
    assert found.kept_at_least < found.time_between.value
    # Rare pulses do not meet: what is left of the difference is the sampling error of the share.
    assert found.kept_at_least == pytest.approx(found.time_between_interval[0], rel=1e-2)
    often = rattle.pulses(found.machine, rate=10.0, size=2.5 * found.machine.scales.impulse, departures=500)
    assert often.overlap > 0.1 and often.kept_at_least < 0.9 * often.time_between_interval[0]


def test_the_bound_holds_for_a_machine_that_is_followed_from_pulse_to_pulse():
    """Pulses every fifth period meet episodes that have not passed. Quiet is kept longer than the bound says."""
    pair = machine()
    oscillator, rate = pair.oscillator, 0.2
    size = 1.6
    bound = (
        rattle.pulses(
            pair, rate=rate / pair.scales.time, size=size * pair.scales.impulse, departures=2000
        ).kept_at_least
        / pair.scales.time
    )
    rng = np.random.default_rng(3)
    kept = []
    for _ in range(60):
        time, place, velocity = rng.random(), oscillator.half_backlash, 0.0
        for _ in range(400):
            velocity -= rng.normal(0.0, size)
            follows = time_history(
                oscillator, time, place, velocity, periods=PERIODS / 4, samples_per_period=1, most_contacts=CONTACTS
            )
            if not math.isfinite(follows.permanent_from):
                break
            wait = rng.exponential(1.0 / rate)
            follows = time_history(
                oscillator, time, place, velocity, periods=wait, samples_per_period=1, most_contacts=CONTACTS
            )
            time, place, velocity = time + wait, follows.displacement[-1], follows.velocity[-1]
            if follows.time[-1] > follows.permanent_from:  # captured: at rest on the wall, but for low bounces
                place, velocity = oscillator.half_backlash, 0.0
        kept.append(time)
    mean, error = np.mean(kept), np.std(kept) / math.sqrt(len(kept))
    assert bound < mean + ERRORS * error
    assert mean > 2.0 / rate  # more than one pulse


def test_nothing_ends_in_rattle_where_quiet_takes_all():
    ours = pulses(machine(drag_torque=2.5 * machine().drag_torque), 2.0, departures=500)
    assert ours.lasting.value == 0.0 and ours.rattles == () and ours.time_between.value == math.inf
    # Zero of 500: above this share it would be seen with 97.5 %.
    high = 1.0 - 0.025 ** (1.0 / 500)
    assert ours.lasting_interval == pytest.approx((0.0, high)) and 0.0 < ours.lasting.error < high
    assert ours.time_between_interval == pytest.approx((1200.0 / high, math.inf))
    assert "no pulse has ended in rattle: less often than once in" in str(ours)


def test_a_pulse_that_presses_bounces_or_is_held():
    pair = machine(restitution=0.8)
    pressed = rattle.pulses(pair, rate=RATE, size=-3.0 * pair.scales.impulse, distribution="fixed", departures=300)
    parted = rattle.pulses(pair, rate=RATE, size=2.4 * pair.scales.impulse, distribution="fixed", departures=300)
    assert np.allclose(pressed.table.turns, parted.table.turns, rtol=1e-9)
    held = rattle.pulses(
        pair, rate=RATE, size=-3.0 * pair.scales.impulse, distribution="fixed", departures=300, pressing="held"
    )
    assert held.quiet.value == 1.0 and held.table.impacts.max() == 0.0


def test_sizes_are_those_of_the_distribution(tmp_path):
    pair = machine(restitution=0.5)
    unit = pair.scales.impulse
    normal = pulses(pair, 1.0, departures=4000).table.size_n_m_s / unit
    assert abs(normal.mean()) < ERRORS / math.sqrt(4000) and normal.std() == pytest.approx(1.0, abs=ERRORS / 89.0)
    given = {"rate": RATE, "departures": 4000}
    exponential = rattle.pulses(pair, size=unit, distribution="exponential", **given).table.size_n_m_s / unit
    assert (exponential > 0).all() and exponential.mean() == pytest.approx(1.0, abs=ERRORS / math.sqrt(4000))
    path = tmp_path / "sizes.csv"
    path.write_text(f"# measured\nsize\n{unit}\n{-2 * unit}\n\n{3 * unit}\n")
    measured = rattle.pulses(pair, size=path, **given)
    values, counts = np.unique((measured.table.size_n_m_s / unit).round(9), return_counts=True)
    assert values.tolist() == [-2.0, 1.0, 3.0]
    assert np.abs(counts / 4000 - 1 / 3).max() < ERRORS * math.sqrt(2 / 9 / 4000)
    assert str(rattle.pulses(pair, size=[unit, -2 * unit, 3 * unit], **given)) == str(measured)


def test_a_contact_of_finite_stiffness_holds_weak_pulses_and_is_the_limit_of_impacts():
    stiff = machine(mesh_stiffness=1e4 * 2.0 * machine().scales.mass / machine().scales.time ** 2)
    assert stiff.oscillator.stiffness == pytest.approx(1e4)
    weak = rattle.pulses(stiff, rate=RATE, size=0.02 * stiff.scales.impulse, distribution="fixed", departures=50)
    assert weak.quiet.value == 1.0 and weak.table.impacts.max() == 0.0
    with pytest.raises(ValueError, match="pressing=held is for impacts"):
        rattle.pulses(stiff, rate=RATE, size=0.02, pressing="held")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"rate": 0.0}, "rate must be how often pulses come, above 0"),
        ({"rate": -1.0}, "above 0"),
        ({"rate": math.nan}, "above 0"),
        ({"rate": "3 m"}, "rate: '3 m' cannot be in 1/s"),
        ({"rate": "3 rpm"}, "speed of rotation"),
        ({"size": "3 N m"}, "'3 N m' cannot be in N m s"),
        ({"size": 0.0}, "size must not be 0"),
        ({"size": -1.0}, "its deviation"),
        ({"size": None}, "size must be a torque pulse"),
        ({"size": []}, "measured sizes are one or more finite numbers"),
        ({"size": [1.0, math.inf]}, "finite"),
        ({"size": ["a"]}, "list of numbers"),
        ({"size": "nowhere.csv"}, "nowhere.csv cannot be read"),
        ({"size": [1.0], "distribution": "normal"}, "leave it out"),
        ({"distribution": "cauchy"}, "normal, exponential or fixed"),
        ({"pressing": "sticks"}, "bounces or held"),
        ({"departures": 1}, "from 2 on"),
        ({"departures": 2.5}, "whole number"),
        ({"seed": -1}, "seed must be"),
    ],
)
def test_bad_input_is_told_what_would_be_right(given, told):
    with pytest.raises(rattle.InvalidJob, match=told.replace("(", r"\(")) as caught:
        rattle.pulses(machine(), **{"rate": RATE, "size": 1.0} | given)
    assert caught.value.place == (next(reversed(given)),)


@pytest.mark.parametrize(("text", "told"), [("", "no sizes"), ("size\n", "no sizes"), ("1\nx\n", "line 2: a size")])
def test_a_file_without_sizes_is_told_so(text, told, tmp_path):
    path = tmp_path / "sizes.csv"
    path.write_text(text)
    with pytest.raises(rattle.InvalidJob, match=told):
        rattle.pulses(machine(), rate=RATE, size=path)


def test_a_machine_that_cannot_be_quiet_is_refused_with_the_speed():
    with pytest.raises(rattle.InvalidJob, match=r"Gamma is .* never quiet; below .* rpm it can be"):
        rattle.pulses(machine(transmission_error=0.05), rate=RATE, size=1.0)
    with pytest.raises(rattle.InvalidJob, match="GearPair"):
        rattle.pulses(None, rate=RATE, size=1.0)


def test_the_command_says_what_the_function_does(tmp_path):
    file = tmp_path / "machine.toml"
    pair = machine(restitution=0.6)
    numbers = {name: getattr(pair, name) for name in ("speed", "inertia", "drag_torque", "base_radius", "backlash")}
    numbers |= {"restitution": 0.6, "transmission_error": 0.01}
    file.write_text("".join(f"{name} = {value!r}\n" for name, value in numbers.items()))
    arguments = ["pulses", str(file), "--rate", "3 / hour", "--size", "1 N m s", "--departures", "200"]
    expected = rattle.pulses(pair, rate="3 / hour", size="1 N m s", departures=200)
    answer = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path / "pulses.csv")])
    assert answer.exit_code == 0 and answer.stdout.strip() == str(expected)
    lines = (tmp_path / "pulses.csv").read_text().splitlines()
    assert lines[0] == "phase,size_n_m_s,motion,turns,impacts,impact_energy_j" and len(lines) == 201
    told = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout)
    assert told == json.loads(json.dumps(expected.to_dict()))
    refused = CliRunner().invoke(app, ["pulses", str(file), "--rate", "-3 / hour", "--size", "1"])
    assert refused.exit_code == 2 and "above 0" in " ".join(refused.output.split())
