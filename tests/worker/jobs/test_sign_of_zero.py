"""The sign of zero makes no other job, whichever values of Python it stands in."""

import json

import pytest

from rattle_kernels import CellGrid, Oscillator
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.manifold_job import ManifoldJob
from worker.jobs.orbits_job import Continuation, OrbitSeed, OrbitsJob
from worker.jobs.region import Departure, Interval, Region
from worker.jobs.swept_parameter import SweptParameter

JOBS = {
    "oscillator": lambda zero: BasinJob(oscillator=Oscillator(eccentricity=zero, harmonics=((2, zero, zero),))),
    "contact_damping": lambda zero: BasinJob(oscillator=Oscillator(stiffness=1000.0, contact_damping=zero)),
    "grid": lambda zero: BasinJob(grid=CellGrid(time_start=zero, velocity_start=zero)),
    "sweep": lambda zero: SweepJob(vary=[SweptParameter("eccentricity", (zero, 0.1))]),
    "diagram": lambda zero: BifurcationJob(
        vary=SweptParameter("eccentricity", (zero, 0.1)), seeds=[Departure(zero, 2.0)]
    ),
    "region": lambda zero: OrbitsJob(region=Region(Interval(zero, 1), Interval(zero, 4))),
    "continuation": lambda zero: OrbitsJob(continuation=Continuation("eccentricity", zero, 0.15)),
    "seed": lambda zero: OrbitsJob(seeds=[OrbitSeed(zero, 3.0)]),
    "manifold": lambda zero: ManifoldJob(saddles=[OrbitSeed(zero, 3.0)], velocity=Interval(zero, 5)),
}


@pytest.mark.parametrize("where", JOBS)
def test_the_sign_of_zero_makes_no_other_job(where):
    with_sign, without = JOBS[where](-0.0), JOBS[where](0.0)
    assert with_sign.digest == without.digest
    assert json.dumps(with_sign.request()) == json.dumps(without.request())
