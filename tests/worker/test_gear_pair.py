"""A machine in SI against the two shafts that it is, and against the paper's numbers."""

import itertools
import json
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from rattle_kernels import find_attractors, largest_grazing_speed, loudness, next_impacts
from tests.worker.two_shafts import shafts_of
from worker.gear_pair import in_si

GIVEN = {
    "speed": 305.0, "inertia": 0.0173, "drag_torque": 3.0, "base_radius": 0.0571, "backlash": 61e-6,
    "transmission_error": 30e-6,
}  # fmt: skip


def machine(**changes):
    return rattle.GearPair(**GIVEN | changes)


MACHINES = {
    "heavy driving shaft": (machine(inertia_ratio=0.0, transmission_error=15e-6), 1.0),
    "rho 0.3": (machine(inertia_ratio=0.3), 1.0),
    "equal gears": (machine(), 1.0),
    "rho 3": (machine(inertia_ratio=3.0, transmission_error=60e-6), 1.0),
    "another ratio": (machine(inertia_ratio=0.7), 1.8),
    "impacts lose energy": (machine(inertia_ratio=0.3, restitution=0.8), 1.0),
    "two orders": (machine(transmission_error={1: 25e-6, 3: {"amplitude": 0.5e-6, "phase": 0.2}}), 1.0),
    "two turns": (machine(turns=2, transmission_error={1: 25e-6, 2: {"amplitude": 5e-6, "phase": 0.4}}), 0.5),
    "stiff": (machine(mesh_stiffness=3.1e7, inertia_ratio=0.3), 1.0),
    "stiff and damped": (machine(mesh_stiffness=3.1e7, contact_damping=0.05, transmission_error=15e-6), 1.3),
}  # fmt: skip


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name.startswith("two") else name for name in MACHINES]
)
def test_departures_of_the_two_shafts_are_those_of_the_model(name):
    pair, ratio = MACHINES[name]
    assert pair.gamma < 1.0
    shafts, scales = shafts_of(pair, ratio), pair.scales
    assert shafts.period == pytest.approx(scales.time, rel=1e-15)
    # Some depart below the grazing curve, and some hit the lower wall.
    for phase, speed in itertools.product((0.1, 0.45, 0.8), (0.3, 0.9, 2.4)):
        speed *= 4 * math.pi * pair.oscillator.damping
        (time,), (after,) = next_impacts(pair.oscillator, [phase], [speed])[:2]
        reached, faster = shafts.next_departure(phase * scales.time, speed * scales.speed)
        late = (reached / scales.time - time) % 1.0
        # The integrator's relative tolerance of 1e-12 for angles of up to 40 rad, in shares of half the backlash.
        assert min(late, 1.0 - late) < 1e-6
        assert faster / scales.speed == pytest.approx(after, rel=1e-6)


def test_the_numbers_of_a_pair_of_equal_gears():
    pair = machine(speed="2913 rpm", drag_torque="0.41 N m", mesh_stiffness="3.1e7 N/m", transmission_error="5.2 um")
    omega = 2913 * 2 * math.pi / 60
    oscillator = pair.oscillator
    assert oscillator.damping == pytest.approx(2 * math.pi * 0.41 / (0.0173 * omega**2), rel=1e-14)
    assert oscillator.stiffness == pytest.approx(4 * math.pi**2 * 3.1e7 * 0.0571**2 / (0.0173 * omega**2), rel=1e-14)
    assert oscillator.half_backlash == pytest.approx(61e-6 / (2 * 0.0571), rel=1e-14)
    assert oscillator.eccentricity == pytest.approx(5.2e-6 / 0.0571, rel=1e-14)


def test_the_papers_pump_comes_back():
    """Sec. 1 of the paper: delta = beta = 6e-4, eps = 1e-4."""
    omega = 2 * math.pi * 50
    pair = rattle.GearPair(
        speed=omega, inertia=0.01, drag_torque=6e-4 * 0.01 * omega**2 / (2 * math.pi), base_radius=0.1,
        backlash=2 * 0.1 * 6e-4, transmission_error=0.1 * 1e-4,
    )  # fmt: skip
    assert (pair.oscillator.damping, pair.oscillator.half_backlash, pair.oscillator.eccentricity) == pytest.approx(
        (6e-4, 6e-4, 1e-4), rel=1e-14
    )


def test_gamma_is_the_ratio_of_eq_8_and_reaches_one_at_the_threshold():
    pair = machine()
    oscillator = pair.oscillator
    exact = oscillator.eccentricity * math.hypot(2 * math.pi, oscillator.damping) / (2 * oscillator.damping)
    assert pair.gamma == pytest.approx(exact, rel=1e-12)
    for law in ("constant", "proportional"):
        at = machine(drag_law=law)
        assert at.at_speed(at.threshold_speed).gamma == pytest.approx(1.0, abs=1e-9)
    # Constant torque: delta goes with 1/speed^2; torque in proportion to the speed: with 1/speed.
    assert machine().at_speed(610.0).oscillator.damping == pytest.approx(oscillator.damping / 4)
    assert machine(drag_law="proportional").at_speed(610.0).oscillator.damping == pytest.approx(oscillator.damping / 2)


def test_restitution_and_damping_ratio_are_two_words_for_one_loss():
    lossy = machine(restitution=0.8, mesh_stiffness=3.1e7).oscillator
    zeta = lossy.contact_damping
    assert lossy.restitution == 1.0
    assert math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2)) == pytest.approx(0.8, rel=1e-14)
    assert machine(contact_damping=zeta).oscillator.restitution == pytest.approx(0.8, rel=1e-14)


def test_a_phase_of_the_first_order_moves_the_others():
    """Time begins where the first order is largest."""
    orders = {1: {"amplitude": 20e-6, "phase": 0.3}, 3: {"amplitude": 2e-6, "phase": 0.1}}
    pair = machine(transmission_error=orders)
    time = np.linspace(0, 1, 7)
    moved = time - 0.3

    def error(oscillator, at):
        return sum(a * np.cos(2 * np.pi * (n * at + phase)) for n, a, phase in oscillator.all_harmonics)

    given = 20e-6 * np.cos(2 * np.pi * (moved + 0.3)) + 2e-6 * np.cos(2 * np.pi * (3 * moved + 0.1))
    np.testing.assert_allclose(error(pair.oscillator, time) * pair.scales.length, given, atol=1e-20)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("3000 rpm", "rad/s", 100 * math.pi),
        ("1000 deg/s", "rad/s", 1000 * math.pi / 180),
        ("35 um", "m", 35e-6),
        ("35 \u00b5m", "m", 35e-6),
        ("0.02 kg\u00b7m^2", "kg m^2", 0.02),
        ("0.4 Nm", "N m", 0.4),
        ("400 mN m", "N m", 0.4),
        ("200 N/um", "N/m", 2e8),
        ("90 deg", "turn", 0.25),
        (0.5, "m", 0.5),
    ],
)
def test_quantities_with_units(text, unit, value):
    assert in_si(text, unit) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"speed": "3 m"}, "speed: '3 m' cannot be in rad/s: write it as in \"3000 rpm\""),
        ({"speed": "50 Hz"}, "speed: '50 Hz' does not say which angle is meant"),
        ({"speed": "3000 1/min"}, "does not say which angle is meant"),
        ({"speed": "3000"}, "has no unit"),
        ({"speed": "9**9**9**9 rpm"}, "is no number with a unit"),
        ({"backlash": "3,5 um"}, "backlash: '3,5 um' is no number with a unit: write it as in \"50 um\""),
        ({"backlash": "3 bananas"}, "'bananas' is not defined"),
        ({"backlash": "20 degC"}, "backlash: '20 degC' is"),
        ({"backlash": 0.0}, "backlash: Input should be greater than 0"),
        ({"drag_torque": "0 N m"}, "drag_torque: Input should be greater than 0"),
        ({"speed": "0 rpm"}, "speed: Input should be greater than 0"),
        ({"speed": True}, "speed: Input should be a valid number"),
        ({"backlash": "1e400 m"}, "backlash: Input should be a finite number"),
        ({"inertia_ratio": -1.0}, "inertia_ratio: Input should be greater than or equal to 0"),
        ({"transmission_error": {0: "1 um"}}, "transmission_error.0"),
        ({"transmission_error": {2: {"amplitude": "1 um", "phases": 0.1}}}, "did you mean phase"),
        ({"restitution": 0.9, "contact_damping": 0.1}, "not both"),
        ({"drag_law": "cubic"}, "drag_law: Input should be 'constant' or 'proportional'"),
    ],
)
def test_what_is_wrong_is_said_with_what_would_be_right(changes, words):
    with pytest.raises(rattle.InvalidJob) as refused:
        machine(**changes)
    assert words in str(refused.value)


def test_a_machine_in_a_file(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(
        'speed = "2913 rpm"\ninertia = "0.0173 kg m^2"\ndrag_torque = 0.41\nbase_radius = "57.1 mm"\n'
        'backlash = "61 um"\n[transmission_error.1]\namplitude = "5.2 um"\n[transmission_error.24]\n'
        'amplitude = "0.1 um"\nphase = "90 deg"\n'
    )
    orders = {1: "5.2 um", 24: {"amplitude": "0.1 um", "phase": 0.25}}
    assert rattle.GearPair.read(path) == machine(speed="2913 rpm", drag_torque=0.41, transmission_error=orders)
    path.write_text('speed = "2913 rpm"\n')
    with pytest.raises(rattle.InvalidJob, match=r"machine\.toml\.inertia: Field required"):
        rattle.GearPair.read(path)
    path.write_text("speed = \n")
    with pytest.raises(rattle.InvalidJob, match=r"machine\.toml: Invalid value"):
        rattle.GearPair.read(path)
    with pytest.raises(rattle.InvalidJob, match="No such file"):
        rattle.GearPair.read(tmp_path / "none.toml")


LIGHT = {**GIVEN, "drag_torque": 300.0, "backlash": 6e-3, "transmission_error": 3e-3}


def test_a_verb_takes_a_machine_and_its_result_has_si_units(tmp_path):
    pair = rattle.GearPair(**LIGHT)
    basin = rattle.basin(pair, cells=8, iterations=101, progress=False)
    assert basin.rattle.oscillator == pair.oscillator
    np.testing.assert_allclose(basin.speed_m_s, basin.velocity * pair.scales.speed)
    np.testing.assert_allclose(basin.time_s, basin.time * pair.scales.time)
    assert basin.speed_m_s.dims == ("velocity",) and basin.speed_m_s.attrs["units"] == "m/s"
    assert rattle.GearPair(**json.loads(basin.attrs["machine"])) == pair
    path = tmp_path / "machine.toml"
    path.write_text("\n".join(f"{name} = {value}" for name, value in LIGHT.items()))
    assert rattle.basin(path, cells=8, iterations=101, progress=False).equals(basin)
    store = tmp_path / "basin.zarr"
    command = ["basin", "--machine", str(path), "--cells", "8", "8", "--iterations", "101", "--out", str(store)]
    assert CliRunner().invoke(app, command).exit_code == 0
    assert rattle.open(store).rattle.job == basin.rattle.job


def test_loudness_of_a_machine_is_in_watts():
    """P(1, 1, 0) of the model has one impact a period: its energy, m v^2/2, over the period is the power."""
    torque = 0.6 * 0.01 * 100.0**2 / (2 * math.pi)
    pair = rattle.GearPair(
        speed=100.0, inertia=0.01, drag_torque=torque, base_radius=0.1, backlash=0.12, transmission_error=0.01
    )  # the paper's scaled numbers
    basin = rattle.basin(pair, cells=24, progress=False)
    table = basin.rattle.to_table().set_index("name").loc["P(1,1,0)"]
    mass = 1 / (2 * pair.base_radius**2 / pair.inertia)
    energy = mass * table.largest_impact_speed_m_s**2 / 2
    assert table.impact_power_w == pytest.approx(energy * pair.speed / (2 * math.pi), rel=1e-12)
    assert table.largest_impact_speed_m_s == pytest.approx(table.largest_impact_speed * pair.scales.speed, rel=1e-15)
    loud = basin.rattle.loudness()
    assert loud.expected_impact_power_w.item() == pytest.approx(loud.expected_impact_power.item() * pair.scales.power)
    assert basin.rattle.machine == pair and rattle.basin(cells=8, progress=False).rattle.machine is None


def test_the_window_of_a_machine_follows_it():
    """As fast as 12 delta, and as the fastest graze and a third more: with the paper's numbers some 7."""
    pair = rattle.GearPair(**LIGHT)
    fastest = max(12 * pair.oscillator.damping, 1.3 * largest_grazing_speed(pair.oscillator))
    grid = rattle.basin(pair, cells=8, iterations=101, progress=False).rattle.job.grid
    assert grid.velocity_stop == pytest.approx(fastest, rel=5e-3)
    given = rattle.basin(pair, velocity=(0, 1), cells=8, iterations=101, progress=False).rattle.job.grid
    assert given.velocity_stop == 1.0


def test_a_motion_of_a_machine_has_si_units():
    pair = rattle.GearPair(**LIGHT)
    motion = rattle.trajectory(pair, velocity=0.3 * pair.oscillator.damping, periods=2.0)
    np.testing.assert_allclose(motion.displacement_m, motion.displacement * pair.scales.length)
    np.testing.assert_allclose(motion.contact_speed_m_s, motion.contact_speed * pair.scales.speed)


@pytest.mark.slow
def test_a_machine_with_a_mesh_stiffness_is_followed_beyond_the_threshold():
    pair = rattle.GearPair(**LIGHT, mesh_stiffness=3.1e9)
    fast = pair.at_speed(2 * pair.threshold_speed)
    basin = rattle.basin(fast, cells=6, iterations=101, progress=False)
    assert basin.rattle.machine == fast and basin.share.values[0] == 0.0
    assert not fast.can_be_quiet and pair.at_speed(0.5 * pair.threshold_speed).can_be_quiet
    with pytest.raises(rattle.InvalidJob, match=r"Gamma is 4.* So it is never quiet; below .* rpm it can be"):
        fast.check_pulses()


def test_a_soft_mesh_keeps_teeth_together_beyond_the_threshold():
    """Eq. (3): springs whose own frequency is below that of meshing pass little of the force on."""
    pair = rattle.GearPair(**LIGHT, mesh_stiffness=3.1e9)
    fast = pair.at_speed(1.2 * pair.threshold_speed)
    # kappa = 2 is a frequency of 2/(2 pi) of that of meshing.
    soft = rattle.GearPair(**fast.model_dump() | {"mesh_stiffness": 3.1e9 * 2.0 / fast.oscillator.stiffness})
    assert soft.oscillator.stiffness == pytest.approx(2.0) and soft.gamma >= 1.0
    assert soft.can_be_quiet and not fast.can_be_quiet
    assert rattle.basin(soft, cells=6, iterations=101, progress=False).share.values[0] > 0.0
    with pytest.raises(rattle.InvalidJob, match="Pulses are followed below .* rpm alone"):
        soft.check_pulses()


def test_a_machine_of_impacts_beyond_the_threshold_is_followed_and_never_quiet():
    pair = rattle.GearPair(**LIGHT, restitution=0.8)
    fast = pair.at_speed(2 * pair.threshold_speed)
    basin = rattle.basin(fast, cells=8, iterations=101, progress=False)
    assert basin.rattle.machine == fast and basin.share.values[0] == 0.0
    assert basin.rattle.loudness().expected_impact_power_w.item() > 0.0
    with pytest.raises(rattle.InvalidJob, match=r"Gamma is 4.* So it is never quiet; below .* rpm it can be"):
        fast.check_pulses()
    pair.check_pulses()


@pytest.mark.parametrize(
    ("given", "words"),
    [({"damping": 0.5}, "damping is given twice"), ({"harmonics": [(2, 0.01)]}, "harmonics is given twice")],
)
def test_a_number_that_the_machine_has_is_not_given_beside_it(given, words):
    with pytest.raises(rattle.InvalidJob, match=words):
        rattle.basin(rattle.GearPair(**LIGHT), **given)


@pytest.mark.parametrize("given", [0.6, {"speed": 3.0}])
def test_what_is_no_machine_is_refused(given):
    with pytest.raises(rattle.InvalidJob, match=r"machine is a rattle\.GearPair"):
        rattle.basin(given)


@pytest.mark.parametrize("part", [0.82, 1.02], ids=["below the threshold", "beyond the threshold"])
def test_energy_is_balanced_in_watts_over_a_periodic_motion(part):
    """What the motor gives is what drag and impacts take, less what the transmission error gives.

    The two shafts are integrated in SI between two impacts of the model's P(1,1,0), with the work of the motor and of
    drag beside them. An impact takes (1 - r^2) m v^2/2, and moves against a tooth that moves with e'.
    """
    pair = machine(drag_torque=150.0, transmission_error=5e-3, backlash=0.06, inertia_ratio=0.4, restitution=0.95)
    pair = pair.at_speed(part * pair.threshold_speed)
    assert (pair.gamma > 1.0) == (part > 1.0)
    motion = next(each for each in find_attractors_of(pair) if each.name == "P(1,1,0)")
    t, v, scales = float(motion.time[0]), float(motion.velocity[0]), pair.scales
    first = pair.base_radius * math.sqrt(pair.inertia_ratio)  # another radius than the driven gear's
    i1 = pair.inertia * (first / pair.base_radius) ** 2 / pair.inertia_ratio
    c1, c2 = (pair.drag_torque / pair.speed * inertia / pair.inertia for inertia in (i1, pair.inertia))
    torque = pair.drag_torque * first / pair.base_radius + c1 * pair.speed * pair.base_radius / first
    error, turn = pair.transmission_error[1].amplitude, pair.speed / pair.turns

    def rate(time):
        return -error * turn * math.sin(turn * time)

    def fall(_, state):
        _, one, two, _, _ = state
        slip = first * one - pair.base_radius * two
        return slip, (torque - c1 * one) / i1, -c2 * two / pair.inertia, torque * one, c1 * one**2 + c2 * two**2

    def touches(time, state):
        return state[0] + error * math.cos(turn * time) - 0.5 * pair.backlash

    touches.terminal, touches.direction = True, 1.0
    begin = t * scales.time
    # The mean of both shafts is steady; their difference is the model's.
    reduced = 1.0 / (first**2 / i1 + pair.base_radius**2 / pair.inertia)
    slip = -v * scales.speed - rate(begin)
    one = pair.speed * pair.base_radius / first + slip * reduced * first / i1
    two = pair.speed - slip * reduced * pair.base_radius / pair.inertia
    place = 0.5 * pair.backlash - error * math.cos(turn * begin)
    flight = solve_ivp(
        fall, (begin, begin + 1.5 * scales.time), [place, one, two, 0.0, 0.0], "DOP853", events=touches, rtol=1e-13,
        atol=1e-14, first_step=1e-3 * scales.time,
    )  # fmt: skip
    (end,), (state,) = flight.t_events[0], flight.y_events[0]
    arrival = first * state[1] - pair.base_radius * state[2] + rate(end)
    assert end - begin == pytest.approx(scales.time, rel=1e-11)
    assert 0.95 * arrival == pytest.approx(v * scales.speed, rel=1e-10)
    lost = 0.5 * scales.mass * (1.0 - 0.95**2) * arrival**2
    given = scales.mass * 1.95 * arrival * rate(end)
    motor, drag = state[3], state[4]
    assert motor - drag - lost + given == pytest.approx(0.0, abs=1e-9 * motor)
    heard = loudness(pair.oscillator, motion)
    assert (1.0 - 0.95**2) * heard.impact_power * scales.power == pytest.approx(lost / scales.time, rel=1e-9)


def find_attractors_of(pair):
    """Attractors of a machine, from a grid of departures."""
    t, v = np.meshgrid(np.linspace(0.0, 1.0, 24, endpoint=False), np.linspace(0.3, 6.0, 24))
    return find_attractors(pair.oscillator, t.ravel(), v.ravel())
