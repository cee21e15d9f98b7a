"""A request is one class: however it is written, the job and what is stored of it are the same."""

import json
import pickle

import numpy as np
import pytest

from rattle_kernels import CellGrid, Oscillator, OutsideDomain
from worker.errors import InvalidFields, InvalidJob
from worker.jobs.basin_job import BasinJob, SweepJob, basin_job
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.jobs.manifold_job import Itinerary, ManifoldJob
from worker.jobs.orbits_job import Continuation, OrbitSeed, OrbitsJob
from worker.jobs.oscillator_request import ImpactingOscillator, PiecewiseLinearOscillator
from worker.jobs.region import Departure, Interval, Region
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import Spacing, SweptParameter

DAMPING = SweptParameter("damping", (0.5, 0.6))
STIFF = Oscillator(stiffness=100.0, permanent_after=1.0)
JOBS = [
    BasinJob(),
    BasinJob(oscillator=STIFF, grid=CellGrid(0.9, 1.1, 3, 0.0, 2.0, 4), iterations=7),
    BasinJob(oscillator=Oscillator(eccentricity=0.16, stiffness=100.0), sample=Sample(10, 3)),
    SweepJob(vary=(DAMPING, SweptParameter("eccentricity", (0.1, 0.05))), sample=Sample(10)),
    SweepJob(oscillator=STIFF, vary=(SweptParameter("stiffness", (100.0, 300.0)),)),
    BifurcationJob(vary=DAMPING, region=Region(Interval(0, 0.5)), transient=0),
    BifurcationJob(vary=DAMPING, seeds=(Departure(1.25, 3),), direction="both"),
    OrbitsJob(oscillator=STIFF, longest=2, continuation=Continuation("stiffness", 50, 200)),
    OrbitsJob(seeds=(OrbitSeed(0.786, 1.613, 2),)),
    ManifoldJob(saddles=(OrbitSeed(0.6, 3.77), Itinerary(1, 1, 0)), side="both"),
    ManifoldJob(saddles=(OrbitSeed(0.6, 3.77),)),
    GrazingCurveJob(order=4, velocity=Interval(0, 5)),
]


@pytest.mark.parametrize("job", JOBS, ids=lambda job: job.kind)
def test_a_job_is_read_back_from_its_request(job):
    request = json.loads(json.dumps(job.request()))
    again = type(job).from_request(request)
    assert again == job and again.digest == job.digest and again.request() == request
    assert pickle.loads(pickle.dumps(job)) == job


def test_digests_are_those_of_stores_that_are_there_already():
    assert BasinJob().digest.startswith("7045b7a6b885b2fb")
    assert BasinJob().request() == {
        "oscillator": {"model": "impacting", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6},
        "grid": {
            "time": {"start": 0.0, "stop": 1.0, "cells": 1000},
            "velocity": {"start": 0.0, "stop": 7.0, "cells": 1000},
        },
        "iterations": 1499,
    }


def test_what_is_not_used_is_no_part_of_a_request():
    seeded = ManifoldJob.from_request({"saddles": [{"time": 0.6, "velocity": 3.77}], "cells": 13})
    assert "cells" not in seeded.request() and seeded == ManifoldJob(saddles=(OrbitSeed(0.6, 3.77),))


def test_a_swept_stiffness_needs_no_other():
    vary = {"parameter": "stiffness", "values": [300, 100]}
    stiff = {"model": "piecewise_linear"}
    assert SweepJob.from_request({"oscillator": stiff, "vary": [vary]}).oscillator.stiffness == 300.0
    assert BifurcationJob.from_request({"oscillator": stiff, "vary": vary}).oscillator.stiffness == 100.0
    with pytest.raises(InvalidJob, match="stiffness: Field required"):
        SweepJob.from_request({"oscillator": stiff, "vary": [{"parameter": "damping", "values": [0.6]}]})


def test_every_field_at_fault_is_named():
    with pytest.raises(InvalidFields) as refused:
        basin_job({"oscillator": {"damping": True}, "grid": {"time": {"cells": 0}}, "colour": 1})
    assert {place for place, _ in refused.value.faults} == {
        ("oscillator", "damping"), ("grid", "time", "cells"), ("colour",),
    }  # fmt: skip
    assert pickle.loads(pickle.dumps(refused.value)).faults == refused.value.faults
    with pytest.raises(InvalidJob) as refused:
        OrbitsJob.from_request({"seeds": [{"time": 0, "velocity": -1}]})
    assert refused.value.place == ("seeds", 0, "velocity")


def test_a_size_is_checked_before_anything_that_takes_long():
    class TooLarge(Exception):
        pass

    def refuse(job):
        assert job.sizes()[3] == ("basins", 10**12, "max_basins")
        raise TooLarge

    vary = [{"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 10**12}]
    with pytest.raises(TooLarge):
        SweepJob.from_request({"vary": vary}, refuse)


def test_no_quiet_solution_is_allowed_or_refused():
    stiff = {"model": "piecewise_linear", "stiffness": 100, "eccentricity": 0.16}
    with pytest.raises(OutsideDomain, match="allow_no_quiet_solution"):
        BasinJob(oscillator=stiff)
    allowed = BasinJob(oscillator=stiff | {"allow_no_quiet_solution": True})
    assert allowed.request()["oscillator"]["allow_no_quiet_solution"]
    quiet = BasinJob(oscillator=stiff | {"eccentricity": 0.1, "allow_no_quiet_solution": True})
    assert "allow_no_quiet_solution" not in quiet.request()["oscillator"]


def test_the_oscillators_of_requests_have_the_fields_and_defaults_of_the_kernels():
    common = {"damping", "eccentricity", "half_backlash", "harmonics"}
    # A measured curve is another way to give eccentricity and harmonics.
    others = {"model", "transmission_error"}
    assert set(ImpactingOscillator.model_fields) - others == common | {"restitution"}
    others |= {"permanent_contact", "allow_no_quiet_solution"}
    assert set(PiecewiseLinearOscillator.model_fields) - others == common | {"stiffness", "contact_damping"}
    of_either = {"restitution", "stiffness", "contact_damping", "permanent_after"}
    assert common | of_either == set(Oscillator._fields)
    assert ImpactingOscillator().value == Oscillator()
    stiff = PiecewiseLinearOscillator(model="piecewise_linear", stiffness=100.0)
    assert stiff.value == Oscillator(stiffness=100.0)


def test_swept_values_are_of_one_class_however_they_are_given():
    listed = SweptParameter("damping", np.array([0.5, 0.55, 0.6]))
    spaced = SweptParameter("damping", start=0.5, stop=0.6, count=3)
    assert spaced.values == listed.values == (0.5, 0.55, 0.6) and spaced.settled() == listed
    assert SweptParameter.spaced("damping", 0.5, 0.6, 3, Spacing.LINEAR) == listed == pickle.loads(pickle.dumps(listed))
    assert repr(spaced) == str(listed) == "SweptParameter(parameter='damping', values=(0.5, 0.55, 0.6))"
    assert SweepJob(vary=[spaced]) == SweepJob(vary=[listed])
    with pytest.raises(InvalidJob, match="spaced geometrically from and to values above 0"):
        SweptParameter.spaced("damping", 0.0, 0.6, 3, Spacing.GEOMETRIC)


def test_the_value_of_a_part_of_a_request_is_made_once():
    job = BasinJob.from_request({"oscillator": {"harmonics": [{"order": 3, "amplitude": 1e-3}]}})
    assert job.oscillator_.value is job.oscillator_.value and job.grid_.value is job.grid_.value
    assert job.oscillator == job.oscillator_.value and job.grid == job.grid_.value


def test_harmonics_are_in_order_and_a_swept_one_has_its_first_value():
    harmonics = [{"order": 3, "amplitude": 1e-3}, {"order": 2, "amplitude": 1e-4, "phase": 0.5}]
    request = {"oscillator": {"harmonics": harmonics}, "vary": [{"parameter": "amplitude_3", "values": [2e-3, 3e-3]}]}
    assert SweepJob.from_request(request).request()["oscillator"]["harmonics"] == [
        {"order": 2, "amplitude": 1e-4, "phase": 0.5}, {"order": 3, "amplitude": 2e-3, "phase": 0.0},
    ]  # fmt: skip
