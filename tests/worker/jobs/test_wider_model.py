"""Requests for the wider model: canonical form, what is refused, and where."""

import pytest

from rattle_kernels import Harmonic
from worker.errors import InvalidFields, InvalidJob
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.orbits_job import OrbitsJob

STIFF = {"model": "piecewise_linear", "stiffness": 1e4}
WIDER = {"harmonics": [{"order": 3, "amplitude": 0.001}, {"order": 2, "amplitude": 0.01, "phase": 0.25}]}


def test_what_the_paper_has_is_no_part_of_a_request():
    """So requests, and their digests, are what they were before there was a wider model."""
    usual = BasinJob(oscillator={"model": "impacting", "restitution": 1.0, "harmonics": []})
    assert usual.request()["oscillator"] == BasinJob().request()["oscillator"]
    assert usual.digest == BasinJob().digest
    stiff = {"model": "piecewise_linear", "stiffness": 100.0}
    assert BasinJob(oscillator={**stiff, "contact_damping": 0}).digest == BasinJob(oscillator=stiff).digest


def test_harmonics_are_in_the_order_of_their_orders():
    job = BasinJob(oscillator={**WIDER, "restitution": 0.9})
    assert job.oscillator.harmonics == (Harmonic(2.0, 0.01, 0.25), Harmonic(3.0, 0.001, 0.0))
    assert job.digest == BasinJob(oscillator=job.oscillator).digest
    assert BasinJob.from_request(job.request()) == job
    assert [each["order"] for each in job.request()["oscillator"]["harmonics"]] == [2, 3]


@pytest.mark.parametrize(
    ("oscillator", "told"),
    [
        ({"harmonics": [{"order": 2.5, "amplitude": 0.01}]}, "order: Input should be a valid integer"),
        ({"harmonics": [{"order": 1, "amplitude": 0.01}]}, "order: Input should be greater than or equal to 2"),
        ({"harmonics": [{"order": 2, "amplitude": -0.01}]}, "amplitude: Input should be greater than or equal to 0"),
        ({"harmonics": [{"order": 2}]}, "amplitude: Field required"),
        ({"harmonics": [{"order": 2, "amplitude": 0.01, "angle": 1}]}, "angle: Extra inputs are not permitted"),
        ({"restitution": 0}, "restitution: Input should be greater than 0"),
        ({"restitution": 1.5}, "restitution: Input should be less than or equal to 1"),
        ({"contact_damping": 0.1}, "contact_damping belongs to the piecewise linear model"),
        (
            {"model": "piecewise_linear", "stiffness": 100, "restitution": 0.9},
            "restitution belongs to the impacting model: give contact_damping",
        ),
        ({"model": "piecewise_linear", "stiffness": 100, "contact_damping": 1}, "less than 1"),
    ],
)
def test_what_cannot_be_is_refused_field_by_field(oscillator, told):
    with pytest.raises((InvalidFields, InvalidJob), match=told):
        BasinJob(oscillator=oscillator)


@pytest.mark.parametrize(
    ("oscillator", "told"),
    [
        (STIFF | {"harmonics": [{"order": 2, "amplitude": 0.06}]}, r"positive at every phase \(Eq. 3\)"),
        ({"harmonics": [{"order": 2, "amplitude": 0.01}, {"order": 2, "amplitude": 0.01}]}, "order 2 is there twice"),
    ],
)
def test_what_lies_outside_the_domain_is_refused_with_the_bound(oscillator, told):
    with pytest.raises(ValueError, match=told):
        BasinJob(oscillator=oscillator)


def test_numbers_of_harmonics_are_swept_and_followed():
    vary = {"parameter": "phase_2", "start": 0, "stop": 1, "count": 5}
    sweep = SweepJob(oscillator=WIDER, vary=[vary])
    assert [sweep.oscillator_of(i).value_of("phase_2") for i in range(5)] == [0.0, 0.25, 0.5, 0.75, 1.0]
    diagram = BifurcationJob(oscillator=WIDER, vary={"parameter": "amplitude_3", "values": [0.0, 0.001]})
    assert diagram.oscillator_at(0.001).value_of("amplitude_3") == 0.001
    followed = OrbitsJob(oscillator=WIDER, continuation={"parameter": "phase_2", "start": -0.5, "stop": 0.5})
    assert followed.continuation.start == -0.5


@pytest.mark.parametrize(
    ("oscillator", "parameter", "told"),
    [
        ({}, "phase_2", "phase_2 cannot be swept; these can: damping"),
        ({}, "speed", "speed is no parameter; these are: damping, .* phase_n of the harmonic of order n"),
        ({}, "contact_damping", "contact_damping cannot be swept in the impacting model"),
        (
            {"model": "piecewise_linear", "stiffness": 100},
            "restitution",
            "cannot be swept in the piecewise linear model",
        ),
    ],
)
def test_what_the_oscillator_does_not_have_cannot_be_swept(oscillator, parameter, told):
    with pytest.raises((InvalidFields, InvalidJob), match=told):
        SweepJob(oscillator=oscillator, vary=[{"parameter": parameter, "values": [0.5, 0.9]}])
    with pytest.raises(InvalidJob, match="amplitude_2 is none of its parameters"):
        OrbitsJob(continuation={"parameter": "amplitude_2", "start": 0.0, "stop": 0.1})


@pytest.mark.parametrize(
    ("parameter", "start", "stop", "told"),
    [
        ("restitution", 0.5, 1.2, "restitution ends at 1: it cannot be followed from 0.5 to 1.2"),
        ("amplitude_2", -0.01, 0.02, "amplitude_2 ends at 0: it cannot be followed from -0.01 to 0.02"),
        ("restitution", 0.5, 0.9, "bounds that hold its value 1"),
    ],
)
def test_bounds_of_a_continuation_where_there_is_nothing_are_named(parameter, start, stop, told):
    with pytest.raises(InvalidJob, match=told):
        OrbitsJob(oscillator=WIDER, continuation={"parameter": parameter, "start": start, "stop": stop})


def test_a_swept_value_beyond_the_bound_is_named():
    with pytest.raises(ValueError, match="value 1 of amplitude_2"):
        SweepJob(oscillator=STIFF | WIDER, vary=[{"parameter": "amplitude_2", "values": [0.001, 0.09]}])
