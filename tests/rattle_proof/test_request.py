"""Requests for a proof: canonical form, what is refused, and where."""

import math

import pytest

from rattle_kernels import CellGrid
from worker.errors import InvalidFields, InvalidJob
from worker.jobs.basin_job import BasinJob, SweepJob

WIDE = {"damping": (0.59, 0.61)}


def test_a_request_without_a_proof_is_what_it_was():
    assert "prove" not in BasinJob().request()
    assert BasinJob(prove=False).digest == BasinJob(prove=None).digest == BasinJob().digest
    assert BasinJob(prove=True).digest != BasinJob().digest


def test_a_proof_is_written_out():
    job = BasinJob(prove=True)
    assert job.request()["prove"] == {"levels": 3, "tolerances": {}}
    assert job.digest == BasinJob(prove={}).digest == BasinJob(prove={"levels": 3}).digest
    assert BasinJob.from_request(job.request()) == job
    tolerances = {"eccentricity": (0.09, 0.11), **WIDE}
    job = BasinJob(prove={"levels": 1, "tolerances": tolerances})
    assert list(job.request()["prove"]["tolerances"]) == ["damping", "eccentricity"]
    assert job.digest == BasinJob(prove={"levels": 1, "tolerances": dict(reversed(tolerances.items()))}).digest


@pytest.mark.parametrize(
    ("prove", "told"),
    [
        ({"levels": 4}, "levels: Input should be less than or equal to 3"),
        ({"levels": -1}, "levels: Input should be greater than or equal to 0"),
        ({"levels": 1.5}, "levels: Input should be a valid integer"),
        ({"tolerance": {}}, "tolerance: Extra inputs are not permitted"),
        ({"tolerances": {"damping": [0.59]}}, "tolerances.damping"),
        ({"tolerances": {"damping": [0.59, math.nan]}}, "tolerances.damping"),
        ("yes", "prove"),
        ({"tolerances": {"stiffness": [1.0, 2.0]}}, "stiffness has no tolerance: use one of damping, eccentricity"),
        ({"tolerances": {"phase_2": [0.0, 0.1]}}, "phase_2 has no tolerance"),
        ({"tolerances": {"damping": [0.7, 0.8]}}, "damping = 0.6 does not lie between 0.7 and 0.8"),
        ({"tolerances": {"damping": [0.61, 0.59]}}, "tolerance of damping ends below its beginning: 0.61 to 0.59"),
        ({"tolerances": {"half_backlash": [0.0, 0.7]}}, "half_backlash must lie above 0 in all of its tolerance"),
        ({"tolerances": {"restitution": [0.0, 1.0]}}, "restitution must lie above 0 in all of its tolerance"),
        ({"tolerances": {"damping": [0.0, 0.7]}}, "damping must lie above 0 in all of its tolerance"),
        ({"tolerances": {"restitution": [0.9, 1.1]}}, "restitution lies between 0 and 1"),
        ({"tolerances": {"damping": [-0.1, 0.7]}}, "damping lies between 0 and inf"),
        ({"tolerances": {"eccentricity": [0.1, 0.3]}}, r"every phase \(Eq. 8\): .* within the tolerances"),
    ],
)
def test_what_cannot_be_proven_is_refused(prove, told):
    with pytest.raises((InvalidFields, InvalidJob, ValueError), match=told):
        BasinJob(prove=prove)


def test_only_cells_of_one_basin_of_the_impacting_model_are_proven():
    with pytest.raises(InvalidJob, match="only the impacting model is proven"):
        BasinJob(oscillator={"model": "piecewise_linear", "stiffness": 100.0}, prove=True)
    with pytest.raises(InvalidJob, match="points of a sample are not proven"):
        BasinJob(sample={"points": 10}, prove=True)
    with pytest.raises(InvalidJob, match="more than 4000 cells on a side are not proven"):
        BasinJob(grid=CellGrid(time_cells=4001, velocity_cells=10), prove=True)
    vary = [{"parameter": "damping", "values": [0.5, 0.6]}]
    with pytest.raises(InvalidJob, match="a sweep is not proven"):
        SweepJob(vary=vary, prove=True)
    # What asks for no proof is refused none.
    assert SweepJob(vary=vary, prove=False).digest == SweepJob(vary=vary).digest
