"""Sweeps over a number of a machine, or over a list of machines: what the model gets, and units of what comes back."""

import json
import math

import matplotlib.pyplot as plt
import numpy as np
import pytest
from typer.testing import CliRunner

import rattle
from rattle.arguments import job_of
from rattle.cli import app
from rattle.cli.options import arguments_from, options_of
from worker import gear_pair
from worker.jobs.design import RESERVED, Design
from worker.machine_series import UNITS, MachineSeries, machine_of, settled_with_machine
from worker.results.figure import figure_of_store
from worker.results.shares import shares_figure

# The paper's scaled numbers at 100 rad/s: delta 0.6, eps 0.1, beta 0.6.
TORQUE = 0.6 * 0.01 * 100.0**2 / (2 * math.pi)
PAIR = rattle.GearPair(
    speed=100.0, inertia=0.01, drag_torque=TORQUE, base_radius=0.1, backlash=0.12, transmission_error=0.01
)
SPEEDS = [f"{value:g} rpm" for value in (900, 950, 1000)]


def swept(**given):
    return job_of("sweep", {"machine": PAIR, "cells": 12, "iterations": 101, **given})


@pytest.mark.parametrize("law", ["constant", "proportional"])
def test_all_numbers_of_the_model_move_with_the_speed(law):
    """delta = 2 pi T/(I Omega^2) and kappa goes as 1/Omega^2; the torque is constant or goes as Omega."""
    given = PAIR.model_dump() | {"mesh_stiffness": 3e5, "drag_law": law}
    pair = rattle.GearPair(**given)
    job = job_of("sweep", {"machine": pair, "speed": np.array([80.0, 90.0, 100.0]), "cells": 9})
    assert job.design.name == "speed" and job.design.units == "rad/s" and job.design.parameters.keys() == {
        "damping", "stiffness"
    }  # fmt: skip
    ratio = np.array([0.8, 0.9, 1.0])
    power = 2 if law == "constant" else 1
    np.testing.assert_allclose(job.design.parameters["damping"], 0.6 / ratio**power, rtol=1e-12)
    np.testing.assert_allclose(job.design.parameters["stiffness"], pair.oscillator.stiffness / ratio**2, rtol=1e-12)
    assert [job.oscillator_of(number) for number in range(3)] == [
        pair.at_speed(speed).oscillator for speed in (80.0, 90.0, 100.0)
    ]


@pytest.mark.parametrize("name", UNITS)
def test_every_number_of_a_machine_can_be_stepped_through(name):
    pair = rattle.GearPair(**PAIR.model_dump() | {"mesh_stiffness": 3e5, "inertia_ratio": 0.8})
    values = [value * getattr(pair, name) for value in (0.98, 1.0)]
    job = job_of("sweep", {"machine": pair, name: values, "cells": 9})
    assert job.design.name == name and job.design.values == tuple(values) and job.design.units == UNITS[name]
    assert job.oscillator_of(1).damping == pytest.approx(pair.oscillator.damping, rel=1e-12)
    assert job.oscillator_of(0) != job.oscillator_of(1)


def test_no_name_of_a_coordinate_or_of_a_unit_is_a_name_of_results():
    own = {name for name, _ in gear_pair.IN_SI.values()}
    for name in (*UNITS, "machine"):
        assert Design(name=name, values=[1.0], parameters={"damping": [0.6]}).name == name
    assert not own & {*UNITS, "machine"} and "gamma" in RESERVED


@pytest.mark.parametrize(
    ("given", "units", "values"),
    [
        (["900 rpm", "950rpm"], "rpm", (900.0, 950.0)),
        (("900 rpm", "1000 rpm", 3), "rpm", (900.0, 950.0, 1000.0)),
        (("500 rpm", "1000 rpm", 3, "geometric"), "rpm", (500.0, 707.106781186547, 1000.0)),
        ((90.0, 100.0, 3), "rad/s", (90.0, 95.0, 100.0)),
        (np.linspace(90.0, 100.0, 3), "rad/s", (90.0, 95.0, 100.0)),
        (["600 deg/s", 90.0], "rad/s", (math.radians(600.0), 90.0)),
    ],
)
def test_values_keep_the_unit_in_which_all_are_written(given, units, values):
    series = MachineSeries.over(PAIR, "speed", given)
    assert series.units == units and series.values == pytest.approx(values, rel=1e-14)
    turns = math.pi / 30 if units == "rpm" else 1.0
    assert [pair.speed for pair in series.pairs] == pytest.approx([value * turns for value in values], rel=1e-14)


@pytest.fixture(scope="module")
def speeds():
    return rattle.sweep(PAIR, speed=SPEEDS, cells=16, iterations=101, progress=False)


def test_each_machine_has_its_own_scales(speeds):
    machines = [PAIR.at_speed(speed) for speed in SPEEDS]
    assert speeds.rattle.machines == tuple(machines) and speeds.rattle.machine is None
    assert speeds.speed_m_s.dims == ("speed", "velocity") and speeds.time_s.dims == ("speed", "time")
    for number, pair in enumerate(machines):
        np.testing.assert_allclose(speeds.speed_m_s[number], speeds.velocity * pair.scales.speed)
        np.testing.assert_allclose(speeds.time_s[number], speeds.time * pair.scales.time)
        assert speeds.gamma.values[number] == pair.gamma
    loud = speeds.rattle.loudness()
    powers = [pair.scales.power for pair in machines]
    np.testing.assert_allclose(loud.expected_impact_power_w, loud.expected_impact_power * powers)
    assert loud.expected_impact_power_w.values.all()
    table = speeds.rattle.to_table("speed")
    np.testing.assert_allclose(table.expected_impact_power_w, table.expected_impact_power * powers)
    np.testing.assert_allclose(table.gamma, speeds.gamma)
    shares = speeds.rattle.to_table()
    of_rows = np.array(powers)[[[900.0, 950.0, 1000.0].index(speed) for speed in shares.speed]]
    np.testing.assert_allclose(shares.impact_power_w, shares.impact_power * of_rows)


def test_one_machine_of_a_sweep_is_that_machine_alone(speeds):
    pair = PAIR.at_speed("950 rpm")
    middle = speeds.rattle.basin(speed=950)
    velocity = (0.0, speeds.rattle.job.grid.velocity_stop)
    alone = rattle.basin(pair, velocity=velocity, cells=16, iterations=101, progress=False)
    assert middle.rattle.machine == pair and middle.rattle.machines == ()
    assert middle.rattle.job == alone.rattle.job
    np.testing.assert_array_equal(middle.group, alone.group)
    np.testing.assert_allclose(middle.speed_m_s, alone.speed_m_s)
    of_sweep, of_basin = (each.rattle.to_table().set_index("name").dropna() for each in (middle, alone))
    for name in of_basin.index:
        assert of_sweep.loc[name].impact_power_w == pytest.approx(of_basin.loc[name].impact_power_w, rel=1e-12)
    assert [basin.rattle.machine for basin in speeds.rattle.basins()] == list(speeds.rattle.machines)


def test_its_chart_is_over_rpm_with_watts_and_gamma(speeds):
    figure = speeds.rattle.plot_shares()
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["share", "impacts\na period", "largest\nspeed (m/s)", "power (W)", "Γ"]
    assert figure.axes[-1].get_xlabel() == "speed (rpm)"
    np.testing.assert_allclose(figure.axes[-1].get_lines()[0].get_ydata(), speeds.gamma)
    watts = speeds.rattle.loudness().expected_impact_power_w
    np.testing.assert_allclose(figure.axes[3].get_lines()[0].get_ydata(), watts)


def test_a_store_keeps_its_machines(speeds, tmp_path):
    store = tmp_path / "speeds.zarr"
    kept = rattle.sweep(PAIR, speed=SPEEDS, cells=16, iterations=101, store=store, progress=False)
    opened = rattle.open(store)
    assert opened.identical(kept) and opened.equals(speeds)
    assert opened.rattle.machines == speeds.rattle.machines
    assert opened.rattle.job.machine_["speed"] == [pair.speed for pair in speeds.rattle.machines]
    assert opened.rattle.job.machine_["inertia"] == PAIR.inertia  # what does not differ stands once
    figures = shares_figure(str(store)), speeds.rattle.plot_shares()
    watts, again = (figure.axes[3].get_lines()[0].get_ydata() for figure in figures)
    np.testing.assert_array_equal(watts, again)


def test_a_request_has_machines_of_any_kind_and_gives_them_back():
    """Orders of the transmission error, losses and drag laws may differ; a loss may be missing."""
    numbers = PAIR.model_dump(exclude_none=True)
    rich = numbers | {"transmission_error": {1: 0.01, 3: {"amplitude": 1e-4, "phase": 0.2}}, "contact_damping": 0.01}
    lossy = numbers | {"restitution": 0.9, "drag_law": "proportional"}
    machines = [PAIR, rattle.GearPair(**rich), rattle.GearPair(**lossy)]
    request = json.loads(json.dumps(job_of("sweep", {"machines": machines, "cells": 9}).request()))
    assert machine_of(request).pairs == tuple(machines)
    alone = json.loads(json.dumps(job_of("basin", {"machine": machines[1], "cells": 9}).request()))
    assert machine_of(alone) == machines[1]
    oscillators = [PAIR.oscillator, PAIR.oscillator._replace(damping=0.7)]
    assert machine_of(job_of("sweep", {"machines": oscillators, "cells": 9}).request()) is None


@pytest.mark.parametrize(
    ("kind", "written"),
    [
        ("basin", {"speed": 100, "inertia_ratio": 1, "backlash": "120 mm"}),
        ("sweep", {"speed": [90, "100 rad/s", 110], "transmission_error": 0.01}),
    ],
)
def test_a_machine_has_one_digest_in_whatever_units_it_was_written(kind, written):
    job = job_of(kind, {"machine": PAIR, "cells": 9, **({"speed": (90.0, 110.0, 3)} if kind == "sweep" else {})})
    request = job.request()
    other = type(job).from_request(request | {"machine": dict(reversed((request["machine"] | written).items()))})
    assert other.digest != job.digest
    assert settled_with_machine(other).digest == job.digest
    assert settled_with_machine(job) is job


@pytest.mark.parametrize(
    ("kind", "change", "told"),
    [
        ("basin", {"machine": {"backlash": 0.11}}, "the machine has another oscillator than the request"),
        ("basin", {"machine": {"mesh_stiffness": 1e5}}, "the machine has another oscillator than the request"),
        ("basin", {"machine": {"transmission_error": {"1": 0.01, "2": 1e-4}}}, "another oscillator"),
        ("basin", {"machine": {"backlash": [0.12, 0.12]}}, "machine.backlash"),
        ("basin", {"machine": {"weight": 3.0}}, "machine.weight"),
        ("sweep", {"machine": {"inertia": 0.011}}, "the machine has another oscillator than the request"),
        ("sweep", {"machine": {"speed": [90.0]}}, "speed has 1 values for 3 machines"),
        ("sweep", {"machine": {"speed": [90.0, 95.0, 101.0]}}, "the machine has another oscillator than the request"),
    ],
)
def test_a_job_whose_machine_is_another_is_refused(kind, change, told):
    stepped = {"speed": (90.0, 100.0, 3)} if kind == "sweep" else {}
    job = job_of(kind, {"machine": PAIR, "cells": 9, **stepped})
    request = job.request()
    assert machine_of(request) is not None
    other = type(job).from_request(request | {"machine": request["machine"] | change["machine"]})
    with pytest.raises(rattle.InvalidJob, match=told):
        rattle.compute(other, progress=False)


def test_tables_have_the_units_that_are_asked_for(speeds, tmp_path):
    both = speeds.rattle.to_table("speed")
    model, si = (speeds.rattle.to_table("speed", units=units) for units in ("model", "si"))
    assert set(both.columns) == {*model.columns} | {*si.columns}
    assert set(both.columns) - {*si.columns} == {
        name.removesuffix(suffix)
        for name in set(both.columns) - {*model.columns}
        for suffix in ("_w", "_m_s")
        if name.endswith(suffix)
    }
    assert "expected_impact_power" in model and "expected_impact_power_w" in si and "gamma" in si
    store = tmp_path / "basin.zarr"
    rattle.basin(PAIR, cells=12, iterations=101, store=store, progress=False)
    done = CliRunner().invoke(app, ["table", str(store), "--units", "si"])
    assert done.exit_code == 0
    header = done.output.splitlines()[0].split(",")
    assert "impact_power_w" in header and "impact_power" not in header
    with pytest.raises(rattle.InvalidJob, match="units of a table are both, model, si, not 'inches'"):
        speeds.rattle.to_table(units="inches")
    plain = rattle.basin(cells=8, iterations=101, progress=False)
    assert plain.rattle.to_table(units="model").equals(plain.rattle.to_table())
    with pytest.raises(rattle.InvalidJob, match="this result has no SI units: its request names no machine"):
        plain.rattle.to_table(units="si")


def test_a_picture_of_a_store_has_the_axes_of_the_machine(tmp_path):
    store = tmp_path / "basin.zarr"
    basin = rattle.basin(PAIR, cells=12, iterations=101, store=store, progress=False)
    axes = figure_of_store(str(store)).axes[0], basin.rattle.plot()
    assert [[each.get_ylabel() for each in one.child_axes] for one in axes] == [["", "m/s"]] * 2
    plt.close("all")


def test_the_window_is_that_of_the_machine_that_needs_the_largest():
    slow = rattle.basin(PAIR.at_speed("900 rpm"), cells=12, iterations=101, progress=False).rattle.job.grid
    assert swept(speed=SPEEDS).grid.velocity_stop == slow.velocity_stop
    assert swept(speed=SPEEDS, velocity=(0, 3)).grid.velocity_stop == 3.0


def test_a_list_of_machines_is_numbered_and_has_all_orders_of_the_forcing():
    rich = rattle.GearPair(
        **PAIR.model_dump() | {"transmission_error": {1: 0.01, 3: {"amplitude": 1e-4, "phase": 0.2}}}
    )
    job = job_of("sweep", {"machines": [PAIR, rich], "cells": 9})
    assert (job.design.name, job.design.units, job.design.values) == ("machine", None, (0.0, 1.0))
    assert job.oscillator_of(1) == rich.oscillator
    assert job.oscillator_of(0).harmonics[0][1] == 0.0
    same = job_of("sweep", {"machines": [PAIR, PAIR], "cells": 9})
    assert same.design.parameters == {"damping": (PAIR.oscillator.damping,) * 2}
    oscillators = [rattle.Oscillator(0.6, 0.1, 0.6), rattle.Oscillator(0.7, 0.1, 0.5)]
    job = job_of("sweep", {"machines": oscillators, "cells": 9})
    assert [job.oscillator_of(number) for number in range(2)] == oscillators


FAST = PAIR.at_speed(2 * PAIR.threshold_speed)
STIFF = rattle.GearPair(**PAIR.model_dump() | {"mesh_stiffness": 3e5})


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"speed": "900 rpm"}, "values of speed are a list or an array, or"),
        ({"speed": ("900 rpm", "950 rpm")}, "values of speed are a list or an array, or"),
        ({"speed": ("900 rpm", "950 rpm", 1)}, "a count is 2 or more"),
        ({"speed": ("900 rpm", "950 rpm", 3, "cubic")}, "a spacing linear or geometric"),
        ({"speed": (0.0, 100.0, 3, "geometric")}, "only be spaced geometrically from and to values above 0"),
        ({"speed": []}, "speed needs at least one value"),
        ({"speed": [90.0, True]}, "number 1 of speed is True: a quantity is wanted"),
        ({"speed": [90.0, 0.0]}, "machine 1, speed = 0 rad/s: Input should be greater than 0"),
        ({"speed": ["900 um"]}, "speed: '900 um' cannot be in rad/s"),
        ({"speed": ["900"]}, "speed: '900' has no unit"),
        ({"speed": ["900 rpm", "900 rpm"]}, "values of speed must ascend or descend"),
        ({"inertia_ratio": ["1"]}, "number 0 of inertia_ratio is '1': a number is wanted"),
        ({"speed": [90.0], "backlash": [0.1]}, "one number of a machine, not speed and backlash"),
        ({"speed": [90.0], "damping": [0.6]}, "damping is given twice"),
        ({"machines": [PAIR]}, "machine is given beside machines"),
        ({"machine": None, "speed": [90.0]}, "speed is a number of a machine: give the machine as well"),
        ({"machine": None, "machines": []}, "machines are a list of rattle.GearPair"),
        ({"machine": None, "machines": [PAIR, PAIR.oscillator]}, "machines are a list of rattle.GearPair"),
        ({"machine": None, "machines": PAIR.oscillator}, "machines are a list of rattle.GearPair"),
        (
            {"machine": None, "machines": [PAIR.oscillator, PAIR.oscillator._replace(stiffness=1e3)]},
            "all of the impacting model or all of the piecewise linear",
        ),
    ],
)
def test_what_is_wrong_is_said_with_what_would_be_right(given, told):
    with pytest.raises(rattle.InvalidJob, match=told):
        swept(**given)


@pytest.mark.slow
def test_a_sweep_with_a_mesh_stiffness_goes_through_the_threshold():
    speeds = [part * STIFF.threshold_speed for part in (0.75, 1.1)]
    found = rattle.sweep(STIFF, speed=speeds, sample=32, progress=False)
    assert [pair.can_be_quiet for pair in found.rattle.machines] == [True, False]
    quiet = found.share.sel(attractor="permanent contact").values
    assert quiet[0] > 0.0 and quiet[1] == 0.0
    assert found.rattle.to_table("speed").expected_impact_power_w.values[1] > 0.0
    listed = job_of("sweep", {"machines": [STIFF, STIFF.at_speed(FAST.speed)], "sample": 32})
    assert [oscillator.is_loose for oscillator in map(listed.oscillator_of, range(2))] == [False, True]


@pytest.fixture(scope="module")
def crossing():
    """Speeds on both sides of the threshold, of a machine whose impacts lose energy."""
    lossy = rattle.GearPair(**PAIR.model_dump() | {"restitution": 0.8})
    speeds = [part * PAIR.threshold_speed for part in (0.75, 0.95, 1.1, 1.5)]
    return rattle.sweep(lossy, speed=speeds, sample=64, progress=False)


def test_a_sweep_over_speed_goes_through_the_threshold(crossing):
    table = crossing.rattle.to_table("speed")
    beyond = table.gamma.values >= 1.0
    assert beyond.tolist() == [False, False, True, True]
    np.testing.assert_array_equal(table.gamma, [pair.gamma for pair in crossing.rattle.machines])
    quiet, power = crossing.share.sel(attractor="permanent contact").values, table.expected_impact_power_w.values
    assert (quiet[~beyond] > 0.0).all() and (quiet[beyond] == 0.0).all()
    assert np.isfinite(power).all() and power[beyond].min() > power[~beyond].max()
    shares = crossing.rattle.to_table().groupby("speed").share.sum()
    np.testing.assert_allclose(shares, 1.0)


def test_its_chart_shows_gamma_beyond_1(crossing):
    axes = crossing.rattle.plot_shares().axes[-1]
    assert axes.get_ylim()[1] > crossing.gamma.values.max() > 1.0
    plt.close("all")


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("speed=900:1000rpm:3", {"speed": ("900.0 rpm", "1000rpm", 3)}),
        ("speed=900 rpm:1000 rpm:3:geometric", {"speed": ("900 rpm", "1000 rpm", 3, "geometric")}),
        ("base-radius=90,95,100mm", {"base_radius": ["90.0 mm", "95.0 mm", "100mm"]}),
        ("backlash=0.1,0.12", {"backlash": [0.1, 0.12]}),
    ],
)
def test_the_shell_writes_the_unit_behind_the_last_number(text, read):
    given = {each.name: each.default for each in options_of(rattle.sweep)} | {"vary": [text]}
    assert arguments_from(rattle.sweep, given) == read


@pytest.mark.parametrize(
    ("vary", "told"),
    [
        (["speed=900:1000:x"], "write speed=600,800,1000rpm or speed=600:6000rpm:200"),
        (["speed=900,1000rpm", "damping=0.5,0.6"], "speed is a number of a machine: step through it alone"),
        (["speed=900,1000rpm"], "give the machine as well"),
    ],
)  # fmt: skip
def test_a_wrong_line_of_the_shell_is_refused(vary, told, tmp_path):
    options = [part for each in vary for part in ("--vary", each)]
    done = CliRunner().invoke(app, ["sweep", *options, "--out", str(tmp_path / "none.zarr")])
    assert done.exit_code == 2 and told in " ".join(done.output.split())


def test_the_shell_computes_what_python_computes(speeds, tmp_path):
    path, store = tmp_path / "machine.toml", tmp_path / "speeds.zarr"
    numbers = PAIR.model_dump(exclude_none=True, exclude={"transmission_error"})
    lines = [f"{name} = {value!r}" for name, value in numbers.items()]
    path.write_text("\n".join([*lines, "transmission_error = 0.01"]).replace("'", '"'))
    command = [
        "sweep", "--machine", str(path), "--vary", "speed=900,950,1000rpm", "--cells", "16", "--iterations", "101",
        "--out", str(store),
    ]  # fmt: skip
    assert CliRunner().invoke(app, command).exit_code == 0
    assert rattle.open(store).rattle.job == speeds.rattle.job
