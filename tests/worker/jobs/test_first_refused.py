"""The first refused of many oscillators is found with few checks, and is the one that checking all of them finds."""

import itertools
import math

import numpy as np
import pytest

from rattle_kernels import Oscillator, OutsideDomain, check_domain, check_oscillator, check_quiet
from worker.errors import SweptOutsideDomain
from worker.jobs.basin_job import SweepJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.first_refused import Axis, first_refused, pressed_for_sure
from worker.jobs.swept_parameter import SweptParameter

STIFF = Oscillator(0.6, 0.1, 0.6, 1e3)
RICH = STIFF._replace(harmonics=((3, 0.002, 0.1), (7, 0.0005, 0.6)))


def spaced(parameter, start, stop, count):
    return SweptParameter(parameter, tuple(np.linspace(start, stop, count).tolist()))


SWEEPS = {
    "stiffness": (STIFF, [spaced("stiffness", 5.0, 100.0, 50)]),
    "stiffness down": (STIFF, [spaced("stiffness", 100.0, 5.0, 50)]),
    "stiffness and eccentricity": (STIFF, [spaced("stiffness", 5.0, 200.0, 20), spaced("eccentricity", 0.0, 0.3, 15)]),
    "damping and stiffness": (STIFF, [spaced("damping", 0.1, 0.9, 15), spaced("stiffness", 5.0, 200.0, 20)]),
    "damping in contact": (STIFF, [spaced("contact_damping", 0.0, 0.9, 5), spaced("stiffness", 10.0, 40.0, 8)]),
    "phase and amplitude": (RICH, [spaced("phase_3", 0.0, 1.0, 15), spaced("amplitude_3", 0.0, 0.03, 15)]),
    "amplitude and stiffness": (RICH, [spaced("amplitude_7", 0.0, 0.01, 15), spaced("stiffness", 60.0, 2000.0, 20)]),
}


def refusal(check, oscillator, values):
    try:
        check(oscillator.at(**values))
    except OutsideDomain as error:
        return error
    return None


@pytest.mark.parametrize("quiet", [False, True])
@pytest.mark.parametrize("name", SWEEPS)
def test_what_is_accepted_for_sure_is_accepted_and_the_first_refused_is_the_first_of_all(name, quiet):
    oscillator, vary = SWEEPS[name]
    names = [each.parameter for each in vary]
    shape = [len(each.values) for each in vary]

    def refused(place):
        values = {each.parameter: each.values[at] for each, at in zip(vary, place, strict=True)}
        return refusal(check_quiet if quiet else check_domain, oscillator, values) is not None

    sure = pressed_for_sure(oscillator, vary, quiet=quiet)
    every = list(itertools.product(*map(range, shape)))
    truly = np.array([refused(place) for place in every]).reshape(shape)
    assert sure.shape == truly.shape and not (sure & truly).any()
    if "phase_3" not in names and oscillator is STIFF and "contact_damping" not in names:
        assert (sure | truly).all()  # with one harmonic it is the bound itself
    for turned in itertools.product((1, -1), repeat=len(vary)):
        way = tuple(slice(None, None, step) for step in turned)
        listed = [SweptParameter(each.parameter, each.values[::step]) for each, step in zip(vary, turned, strict=True)]
        seen = truly[way]
        sure = pressed_for_sure(oscillator, listed, quiet=quiet)
        found = first_refused([Axis(size, False) for size in shape], seen.__getitem__, sure.view)
        first = next((place for place in every if seen[place]), None)
        assert found == first


def test_a_million_values_are_decided_with_few_checks(monkeypatch):
    checked = []

    def counting(check):
        return lambda oscillator: (checked.append(1), check(oscillator))[1]

    monkeypatch.setattr("worker.jobs.job.check_quiet", counting(check_quiet))
    monkeypatch.setattr("worker.jobs.job.check_oscillator", counting(check_oscillator))
    seeds = [{"time": 0.553, "velocity": 4.703}]
    vary = {"parameter": "stiffness", "start": 1e3, "stop": 1e4, "count": 1_000_000}
    body = {"oscillator": {"model": "piecewise_linear", "eccentricity": 0.05}, "vary": vary, "seeds": seeds, "kept": 1}
    BifurcationJob.from_request(body)
    assert len(checked) < 20
    with pytest.raises(SweptOutsideDomain, match="beyond it there is no quiet solution") as caught:
        BifurcationJob.from_request(body | {"vary": vary | {"start": 10.0, "stop": 1e4}})
    # At resonance the bound is below the eccentricity in an interval of stiffnesses.
    place = caught.value.place[-1]
    values = np.linspace(10.0, 1e4, 1_000_000)
    square = (0.05 * math.hypot(2 * math.pi, 0.6) / 1.2) ** 2
    inside = (values - 2 * math.pi**2) ** 2 + (math.pi * 0.6) ** 2 <= square * values**2
    assert len(checked) < 100 and place == int(np.flatnonzero(inside)[0])


def test_a_square_with_harmonics_is_decided_with_few_checks(monkeypatch):
    checked = []
    monkeypatch.setattr("worker.jobs.job.check_quiet", lambda each: (checked.append(1), check_quiet(each))[1])
    harmonics = [{"order": 2 + k, "amplitude": 1e-9} for k in range(9)]
    square = [
        {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 100},
        {"parameter": "stiffness", "start": 1e3, "stop": 1e4, "count": 100},
    ]
    grid = {"time": {"cells": 10}, "velocity": {"cells": 10}}
    stiff = {"model": "piecewise_linear", "eccentricity": 0.01, "harmonics": harmonics}
    assert SweepJob.from_request({"oscillator": stiff, "vary": square, "grid": grid}).basins == 10_000
    assert len(checked) < 20
