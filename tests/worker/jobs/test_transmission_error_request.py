"""A measured curve in a request: in canonical form it is what the harmonics of the same forcing are."""

import math

import pytest

from rattle_kernels import Oscillator, OutsideDomain
from worker.errors import InvalidFields, InvalidJob
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.trajectory_request import TrajectoryRequest

TWO_PI = 2.0 * math.pi
ANGLE = [k / 40 for k in range(40)]
ERROR = [5.0 + 10.0 * math.cos(TWO_PI * (t - 0.1)) + 2.0 * math.cos(TWO_PI * 2 * t) for t in ANGLE]
CURVE = {"angle": ANGLE, "error": ERROR, "scale": 0.01}
# Time begins at 0.1 turns, so the second order leads by 0.2 of its periods.
FORCING = {"eccentricity": 0.1, "harmonics": [{"order": 2, "amplitude": 0.02, "phase": 0.2}]}


def job(oscillator, **request):
    return BasinJob.from_request({"oscillator": oscillator, **request})


def test_equal_forcing_is_an_equal_request():
    measured = job({"transmission_error": CURVE, "damping": 0.8})
    assert measured.digest == job(FORCING | {"damping": 0.8}).digest
    assert measured.oscillator == Oscillator(0.8, 0.1, harmonics=((2.0, 0.02, 0.2),))
    in_degrees = CURVE | {"angle": [360.0 * t for t in ANGLE], "unit": "degrees"}
    assert job({"transmission_error": in_degrees, "damping": 0.8}).digest == measured.digest
    stiff = {"model": "piecewise_linear", "stiffness": 1000.0, "damping": 0.8}
    assert job(stiff | {"transmission_error": CURVE}).digest == job(stiff | FORCING).digest


def test_a_part_of_the_variance_keeps_fewer_orders():
    alone = job({"transmission_error": CURVE | {"explained": 0.9}})
    assert alone.digest == job({"eccentricity": 0.1}).digest


def test_no_curve_is_the_request_that_it_was():
    assert job({"transmission_error": None}).digest == BasinJob().digest


def test_amplitudes_and_phases_of_a_curve_can_be_swept():
    vary = [{"parameter": "phase_2", "values": [0.1, 0.2]}]
    swept = SweepJob.from_request({"oscillator": {"transmission_error": CURVE, "damping": 0.8}, "vary": vary})
    assert swept.oscillator.value_of("amplitude_2") == 0.02


def test_a_time_history_says_its_harmonics():
    request = TrajectoryRequest.model_validate({"oscillator": {"transmission_error": CURVE}, "start": {"velocity": 4}})
    sent = request.model_dump(mode="json", exclude_unset=True)
    assert sent == {"oscillator": FORCING, "start": {"velocity": 4.0}}
    assert request.oscillator.transmission_error is None


@pytest.mark.parametrize("other", [{"eccentricity": 0.1}, {"harmonics": []}, FORCING])
def test_two_kinds_of_forcing_at_once_are_refused(other):
    with pytest.raises(InvalidJob, match="the forcing is given twice") as refused:
        job({"transmission_error": CURVE} | other)
    assert refused.value.place == ("oscillator", "transmission_error")


@pytest.mark.parametrize(
    ("change", "told", "place"),
    [
        ({"angle": [0.0, 0.0, *ANGLE[2:]]}, "angle must increase: 0 follows 0", ("angle", 1)),
        ({"error": ERROR[1:]}, "as long as each other, not 40 and 39", ()),
        ({"angle": [], "error": []}, "at least three samples, not 0", ()),
        ({"scale": 0.0}, "scale must be finite and not 0", ()),
        ({"unit": "degrees"}, "read as degrees", ()),
    ],
)
def test_what_is_wrong_with_a_curve_is_named_with_its_place(change, told, place):
    with pytest.raises(InvalidJob, match=told) as refused:
        job({"transmission_error": CURVE | change})
    assert refused.value.place == ("oscillator", "transmission_error", *place)


@pytest.mark.parametrize(
    "change", [{"unit": "gon"}, {"explained": 0.0}, {"explained": 1.5}, {"angle": "0"}, {"colour": 1}, {"scale": "1"}]
)
def test_fields_of_wrong_types_are_named(change):
    with pytest.raises(InvalidFields) as refused:
        job({"transmission_error": CURVE | change})
    assert refused.value.faults[0][0][:3] == ("oscillator", "transmission_error", next(iter(change)))


def test_more_orders_than_a_request_may_have_and_more_samples_are_refused():
    """The orders of one tooth of 200 samples are equal, so each explains as much as any other."""
    angle = [k / 200 for k in range(200)]
    tooth = {"angle": angle, "error": [1.0, *[0.0] * 199]}
    with pytest.raises(InvalidJob, match=r"9\d orders explain 0.9, which is more than 32: lower explained"):
        job({"transmission_error": tooth | {"explained": 0.9}})
    with pytest.raises(InvalidFields, match="at most 10000 items"):
        job({"transmission_error": {"angle": [k / 10_001 for k in range(10_001)], "error": [0.0]}})


def test_a_curve_beyond_the_bound_is_refused_with_the_least_reaction_and_its_phase():
    with pytest.raises(OutsideDomain, match=r"Eq. 3.*falls to -\d.* at t = 0.\d{4}"):
        job({"model": "piecewise_linear", "stiffness": 1e4, "transmission_error": CURVE | {"scale": 0.03}})
