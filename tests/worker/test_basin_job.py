import json

import pytest

from rattle_kernels import CellGrid, Oscillator, OutsideDomain
from worker.basin_job import BasinJob
from worker.errors import InvalidJob


def test_a_job_survives_the_way_through_its_request():
    job = BasinJob(Oscillator(0.5, 0.1, 0.4), CellGrid(0.9, 1.1, 30, 1.0, 2.0, 40), 7)
    assert BasinJob.from_request(json.loads(json.dumps(job.request()))) == job


def test_equal_jobs_have_equal_digests_however_they_were_written():
    assert BasinJob(Oscillator(damping=1)).digest == BasinJob(Oscillator(damping=1.0)).digest
    assert BasinJob().digest != BasinJob(iterations=1493).digest


@pytest.mark.parametrize(
    ("grid", "iterations", "told"),
    [
        (CellGrid(), 1500, "nearest: 1499 or 1511"),
        (CellGrid(), 0, "nearest: 2"),
        (CellGrid(velocity_start=3.0, velocity_stop=2.0), 1, "velocity_stop must be above velocity_start = 3.0"),
        (CellGrid(velocity_start=-1.0), 1, "not negative"),
        (CellGrid(time_start=1.0, time_stop=1.5), 1, "time_start must be a phase"),
        (CellGrid(time_stop=1.5), 1, "at most one period"),
        (CellGrid(time_cells=0), 1, "at least one cell"),
        (CellGrid(velocity_stop=float("inf")), 1, "finite"),
        (CellGrid(time_stop=float("nan")), 1, "time_stop"),
    ],
)
def test_a_job_that_cannot_be_computed_says_why(grid, iterations, told):
    with pytest.raises(InvalidJob, match=told):
        BasinJob(grid=grid, iterations=iterations)


def test_an_oscillator_outside_the_domain_is_refused():
    with pytest.raises(OutsideDomain, match="epsilon_crit2"):
        BasinJob(Oscillator(eccentricity=0.2))
