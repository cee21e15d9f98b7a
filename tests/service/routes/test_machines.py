"""A machine in its own units over HTTP: what it is in the model, and jobs that take it in place of an oscillator."""

import io
import math

import pandas as pd
import pytest

import rattle
from rattle.arguments import job_of
from tests.service.routes.problems import assert_problem
from worker.precision_limits import fastest_of

PUMP = {
    "speed": "3000 rpm", "inertia": "0.01 kg m^2", "drag_torque": "94.2 mN m", "base_radius": "100 mm",
    "backlash": "120 um", "transmission_error": "10 um",
}  # fmt: skip
NOISY = {
    "speed": 305.0, "inertia": 0.0173, "drag_torque": 150.0, "base_radius": 0.0571, "backlash": 61e-6,
    "transmission_error": 500e-6,
}  # fmt: skip

# Nearly the paper's numbers, with impacts that lose energy.
SCALED = {
    "speed": 100.0, "inertia": 0.01, "drag_torque": 9.5493, "base_radius": 0.1, "backlash": 0.12,
    "transmission_error": 0.01, "restitution": 0.8,
}  # fmt: skip


def test_a_machine_is_converted_as_by_the_package(service):
    answer = service.request("POST", "/v1/machines", json=PUMP).json()
    pair = rattle.GearPair(**PUMP)
    oscillator = answer["oscillator"]
    assert oscillator["model"] == "impacting"
    for name in ("damping", "eccentricity", "half_backlash", "restitution"):
        assert oscillator[name] == getattr(pair.oscillator, name)
    assert answer["scales"] == pair.scales._asdict()
    assert (answer["gamma"], answer["threshold_speed"]) == (pair.gamma, pair.threshold_speed)
    assert answer["machine"]["speed"] == pair.speed and answer["can_be_quiet"] is True
    assert rattle.GearPair(**answer["machine"]).oscillator == pair.oscillator


@pytest.mark.parametrize("wider", [{}, {"mesh_stiffness": "200 N/um"}])
def test_a_machine_beyond_the_threshold_is_never_quiet(service, wider):
    fast = PUMP | {"speed": "9000 rpm"} | wider
    answer = service.request("POST", "/v1/machines", json=fast).json()
    pair = rattle.GearPair(**fast)
    assert answer["gamma"] == pair.gamma > 1.0 and answer["can_be_quiet"] is False
    assert answer["velocity_stop"] == fastest_of(pair.oscillator)
    asked = {"kind": "basin", "machine": answer["machine"], "sample": {"points": 32}}
    assert service.request("POST", "/v1/checks", json=asked).json()["errors"] == []


def test_a_sweep_over_speed_goes_through_the_threshold(service):
    pair = rattle.GearPair(**SCALED)
    speeds = [part * pair.threshold_speed for part in (0.75, 0.95, 1.1)]
    asked = job_of("sweep", {"machine": pair, "speed": speeds, "sample": 32}).request()
    job = service.wait(service.submit(asked, "sweeps")["id"])
    assert job["state"] == "succeeded", job
    answer = service.request("GET", f"/v1/jobs/{job['id']}/result.csv?table=speed&units=si")
    table = pd.read_csv(io.StringIO(answer.text))
    assert table.gamma.tolist() == pytest.approx([pair.at_speed(speed).gamma for speed in speeds])
    assert (table.gamma >= 1.0).tolist() == [False, False, True]
    power = table.expected_impact_power_w
    assert power.notna().all() and power[2] > max(power[:2])


def test_without_a_transmission_error_no_speed_is_a_threshold(service):
    answer = service.request("POST", "/v1/machines", json=PUMP | {"transmission_error": 0}).json()
    assert answer["gamma"] == 0.0 and answer["threshold_speed"] is None
    assert math.isinf(rattle.GearPair(**PUMP | {"transmission_error": 0}).threshold_speed)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"speed": "3 kg"}, "speed: '3 kg' cannot be in rad/s"),
        ({"backlash": 0}, "backlash"),
        ({"foo": 1}, "foo"),
        ({"speed": 1e200}, "look at the units"),
        ({"inertia": 1e-300}, "look at the units"),
        ({"transmission_error": 1e300}, "look at the units"),
        ({"transmission_error": {str(order): 1e-6 for order in range(1, 34)}}, "at most 32"),
    ],
)
def test_an_absurd_machine_is_refused_with_what_is_wrong(service, change, words):
    assert_problem(service.request("POST", "/v1/machines", json=PUMP | change), 422, words)


@pytest.mark.parametrize(
    ("path", "body", "window"),
    [
        ("basins", {"iterations": 5}, ("grid", "velocity", "stop")),
        (
            "sweeps",
            {"iterations": 5, "vary": [{"parameter": "damping", "values": [0.5, 0.6]}]},
            ("grid", "velocity", "stop"),
        ),
        ("orbits", {"longest": 1}, ("region", "velocity", "stop")),
        ("grazing-curves", {"order": 1}, ()),
    ],
)
def test_a_job_of_a_machine_has_its_oscillator_and_keeps_it(service, path, body, window):
    job = service.request("POST", f"/v1/{path}", json=body | {"machine": NOISY}).json()
    pair, request = rattle.GearPair(**NOISY), job["request"]
    assert rattle.GearPair(**request["machine"]) == pair
    if path != "sweeps":
        assert request["oscillator"]["damping"] == pair.oscillator.damping
    assert request["oscillator"]["eccentricity"] == pair.oscillator.eccentricity
    if window:
        value = request
        for name in window:
            value = value[name]
        assert value == fastest_of(pair.oscillator)
    again = service.request("POST", f"/v1/{path}", json=request).json()
    assert again["id"] == job["id"]


def test_a_preview_and_a_motion_take_a_machine(service):
    pair = rattle.GearPair(**NOISY)
    grid = {"time": {"cells": 8}, "velocity": {"cells": 8}}
    preview = service.request("POST", "/v1/previews", json={"machine": NOISY, "grid": grid, "iterations": 1}).json()
    assert preview["velocity"]["stop"] == fastest_of(pair.oscillator)
    start = {"start": {"velocity": 3.0}, "periods": 2}
    motion = service.request("POST", "/v1/trajectories", json=start | {"machine": NOISY}).json()
    oscillator = service.request("POST", "/v1/machines", json=NOISY).json()["oscillator"]
    assert motion == service.request("POST", "/v1/trajectories", json=start | {"oscillator": oscillator}).json()


@pytest.mark.parametrize("path", ["basins", "previews", "trajectories"])
def test_a_machine_at_fault_is_named_where_it_stands(service, path):
    def refused(words, **body):
        body = {"start": {"velocity": 3.0}} | body if path == "trajectories" else body
        assert_problem(service.request("POST", f"/v1/{path}", json=body), 422, words)

    if path != "basins":
        refused("machine or the oscillator, not both", machine=PUMP, oscillator={})
    refused("body.machine.speed: '3 kg'", machine=PUMP | {"speed": "3 kg"})
    refused("a machine is an object", machine=3)


def test_the_same_machine_is_the_same_job_in_whatever_units_it_was_written(service):
    """A page writes 1 where Python writes 1.0."""
    answer = service.request("POST", "/v1/machines", json=NOISY).json()
    oscillator, machine = answer["oscillator"], answer["machine"]
    grid = {"time": {"cells": 9}, "velocity": {"stop": 5.5, "cells": 9}}
    jobs = [
        service.request("POST", "/v1/basins", json=fields | {"grid": grid, "iterations": 5}).json()
        for fields in (
            {"machine": NOISY},
            {"machine": machine | {"inertia_ratio": 1}, "oscillator": oscillator},
            {"machine": NOISY, "oscillator": oscillator},
        )
    ]
    assert len({job["id"] for job in jobs}) == 1 and jobs[0]["request"]["machine"] == machine


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"damping": 0.1}, "the machine has another oscillator than the request"),
        ({"model": "round"}, "oscillator"),
    ],
)
def test_a_job_whose_machine_is_another_is_refused(service, change, words):
    answer = service.request("POST", "/v1/machines", json=NOISY).json()
    body = {"machine": answer["machine"], "oscillator": answer["oscillator"] | change}
    assert_problem(service.request("POST", "/v1/basins", json=body), 422, words)
