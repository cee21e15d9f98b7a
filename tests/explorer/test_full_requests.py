"""The requests that addresses are tried with have each field of a request, and none at its default."""

import json
from pathlib import Path

import pytest

from rattle_proof.request import ProofRequest
from worker.jobs.basin_job import BasinJob, GridRequest
from worker.jobs.oscillator_request import HarmonicRequest, ImpactingOscillator, PiecewiseLinearOscillator

IMPACTING, STIFF = json.loads((Path(__file__).parent / "full_requests.json").read_text())
WITHOUT_DEFAULT = {"model", "stiffness", "order", "amplitude"}
# A sample is no picture of the plane; a measured curve is sent as its harmonics; the kind follows from the rest; a
# machine is written with its units, beside the request.
NOT_WRITTEN = {"kind", "machine", "sample", "transmission_error"}


def names_of(model):
    return {field.alias or name for name, field in model.model_fields.items()}


@pytest.mark.parametrize(
    ("told", "model"),
    [
        (IMPACTING["oscillator"], ImpactingOscillator),
        (STIFF["oscillator"], PiecewiseLinearOscillator),
        (IMPACTING["oscillator"]["harmonics"][0], HarmonicRequest),
        (IMPACTING["prove"], ProofRequest),
        (IMPACTING["grid"]["time"], GridRequest.model_fields["time"].annotation),
        (IMPACTING["grid"]["velocity"], GridRequest.model_fields["velocity"].annotation),
    ],
    ids=["impacts", "springs", "harmonic", "proof", "time", "velocity"],
)
def test_no_field_is_left_out_or_at_its_default(told, model):
    assert set(told) == names_of(model) - NOT_WRITTEN
    for name in set(told) - WITHOUT_DEFAULT:
        assert told[name] != model.model_fields[name].get_default(call_default_factory=True), name


def test_the_requests_themselves_have_every_field():
    assert set(IMPACTING) | set(STIFF) == names_of(BasinJob) - NOT_WRITTEN | {"vary"}
