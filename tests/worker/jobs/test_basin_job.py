import json
import math

import pytest

from rattle_kernels import CellGrid, Oscillator, OutsideDomain
from worker.errors import InvalidJob, SweptOutsideDomain
from worker.jobs.basin_job import BasinJob, SweepJob, basin_job
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import Spacing, SweptParameter


def test_a_job_survives_the_way_through_its_request():
    job = BasinJob(oscillator=Oscillator(0.5, 0.1, 0.4), grid=CellGrid(0.9, 1.1, 30, 1.0, 2.0, 40), iterations=7)
    assert basin_job(json.loads(json.dumps(job.request()))) == job


def test_equal_jobs_have_equal_digests_however_they_were_written():
    assert BasinJob(oscillator=Oscillator(damping=1)).digest == BasinJob(oscillator=Oscillator(damping=1.0)).digest
    assert BasinJob().digest != BasinJob(iterations=1493).digest


@pytest.mark.parametrize(
    ("grid", "iterations", "told"),
    [
        (CellGrid(), 1500, "nearest: 1499 or 1511"),
        (CellGrid(), 0, "iterations: .*greater than or equal to 1"),
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


def test_a_sweep_survives_the_way_through_its_request():
    vary = SweptParameter("eccentricity", (0.05, 0.1)), SweptParameter.spaced("damping", 0.5, 0.7, 3, Spacing.LINEAR)
    for sample in (None, Sample(100, 7)):
        job = SweepJob(
            oscillator=Oscillator(0.9, 0.3),
            grid=CellGrid(time_cells=3, velocity_cells=4),
            iterations=7,
            vary=vary,
            sample=sample,
        )
        assert basin_job(json.loads(json.dumps(job.request()))) == job
        assert (job.basins, job.sweep_shape) == (6, (2, 3))
        assert [job.place_of(basin) for basin in range(6)] == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]
        assert job.oscillator_of(4) == Oscillator(0.6, 0.1)


def test_values_are_spaced_in_decimals_from_start_to_stop():
    assert SweptParameter.spaced("damping", 0.55, 0.65, 3, Spacing.LINEAR).values == (0.55, 0.6, 0.65)
    assert SweptParameter.spaced("damping", 1.0, 0.01, 3, Spacing.GEOMETRIC).values == (1.0, 0.1, 0.01)


def test_what_is_swept_counts_for_nothing_in_the_oscillator():
    vary = (SweptParameter("damping", (0.6, 0.7)),)
    assert SweepJob(oscillator=Oscillator(damping=0.01), vary=vary).digest == SweepJob(vary=vary).digest


def test_a_value_outside_the_domain_is_named_with_its_place():
    with pytest.raises(SweptOutsideDomain, match="value 1 of damping .*contacts ring only above it") as refused:
        SweepJob(oscillator=Oscillator(stiffness=1.0), vary=(SweptParameter("damping", (0.5, 5.0)),))
    assert refused.value.place == ("vary", 0, "values", 1)


def test_an_oscillator_outside_the_domain_is_refused():
    with pytest.raises(OutsideDomain, match="contacts ring only above it"):
        BasinJob(oscillator=Oscillator(stiffness=0.01))


@pytest.mark.parametrize("stiffness", [math.inf, 1e4])
def test_an_oscillator_of_either_model_may_be_loose(stiffness):
    assert BasinJob(oscillator=Oscillator(eccentricity=0.2, stiffness=stiffness)).oscillator.is_loose
    vary = (SweptParameter("eccentricity", (0.19, 0.2)),)
    swept = SweepJob(oscillator=Oscillator(stiffness=stiffness), vary=vary)
    assert [swept.oscillator_of(basin).is_loose for basin in range(2)] == [False, True]


WEAK = {"damping": 6e-4, "eccentricity": 1e-4, "half_backlash": 6e-4}


def test_a_window_that_is_not_asked_for_follows_a_machine_of_weak_damping():
    job = BasinJob(oscillator=WEAK)
    assert job.grid.velocity_stop == 12.0 * 6e-4 and job.grid.velocity_cells == 1000
    assert job.request()["grid"]["velocity"] == {"start": 0.0, "stop": 0.0072, "cells": 1000}
    assert BasinJob.from_request(job.request()).digest == job.digest
    assert BasinJob(oscillator=WEAK, grid={"velocity": {"cells": 20}}).grid.velocity_stop == 0.0072
    assert BasinJob().grid.velocity_stop == 7.0


def test_a_window_that_is_asked_for_is_refused_with_one_that_follows_the_machine():
    with pytest.raises(InvalidJob, match=r"at most 2\.34721, not 7: .* well below 0\.0072 \(12 damping"):
        BasinJob(oscillator=WEAK, grid={"velocity": {"stop": 7.0}})
