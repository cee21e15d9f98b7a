"""A range of many values stays a rule, is checked at few of them, and has the digest of its values."""

import hashlib
import json
import threading

import numpy as np
import pytest

from rattle_kernels import Oscillator, OutsideDomain, eccentricity_bound_quiet
from worker.errors import InvalidJob, SweptOutsideDomain
from worker.jobs import job
from worker.jobs.basin_job import SweepJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.budget import CheckTooLong, within
from worker.jobs.first_refused import Axis, first_refused
from worker.jobs.swept_parameter import MOST_LISTED

SEEDS = [{"time": 0.553, "velocity": 4.703}]


# Of finite stiffness, machines beyond the bound of Eq. (8) are refused.
QUIET = {"model": "piecewise_linear", "stiffness": 1e4}


def diagram(oscillator=None, **vary):
    request = {"vary": vary, "seeds": SEEDS, "kept": 1, "transient": 0}
    return BifurcationJob.from_request(request | ({"oscillator": oscillator} if oscillator else {}))


@pytest.fixture
def checks(monkeypatch):
    """Oscillators that were checked against the domain."""
    seen = []
    check = job.check_oscillator
    monkeypatch.setattr(job, "check_oscillator", lambda each: (seen.append(each), check(each))[1])
    return seen


def test_a_long_range_is_checked_at_its_ends(checks):
    diagram(parameter="damping", start=0.5, stop=0.6, count=200_000)
    assert {each.damping for each in checks} == {0.5, 0.6}


@pytest.mark.parametrize("spacing", ["linear", "geometric"])
@pytest.mark.parametrize("ends", [(0.5, 0.6), (0.6, 0.5)])
def test_a_long_range_stays_a_rule_with_the_digest_of_its_values(ends, spacing):
    count = MOST_LISTED + 5
    rule = {"parameter": "damping", "start": ends[0], "stop": ends[1], "count": count}
    found = diagram(**rule, **({"spacing": spacing} if spacing == "geometric" else {}))
    request = found.request()
    assert len(json.dumps(request)) < 400 and request["vary"]["count"] == count
    # Listed, the same values are the same job: this is the text that has always been hashed.
    listed = request | {"vary": {"parameter": "damping", "values": list(found.vary.values)}}
    text = json.dumps({"request": listed, "version": found.result_version}, sort_keys=True)
    assert found.digest == hashlib.sha256(text.encode()).hexdigest()
    assert found.digest == BifurcationJob.from_request(listed).digest == BifurcationJob.from_request(request).digest
    space = np.geomspace if spacing == "geometric" else np.linspace
    assert np.allclose(found.vary.values, np.sort(space(*ends, count)), rtol=1e-14, atol=0.0)


def test_a_short_range_is_listed():
    assert diagram(parameter="damping", start=0.5, stop=0.6, count=3).request()["vary"]["values"] == [0.5, 0.55, 0.6]


def test_the_first_value_outside_the_domain_is_named_as_if_all_were_checked():
    vary = {"parameter": "eccentricity", "start": 0.0, "stop": 0.4, "count": 3001}
    with pytest.raises(SweptOutsideDomain) as refused:
        diagram(QUIET, **vary)
    bound = eccentricity_bound_quiet(Oscillator(0.6, stiffness=1e4))
    values = np.linspace(0.0, 0.4, 3001)
    assert refused.value.place == ("vary", "values", int(np.flatnonzero(values >= bound)[0]))


def test_the_first_basin_outside_the_domain_is_named_as_if_all_were_checked():
    damping, eccentricity = np.linspace(0.3, 0.6, 31), np.linspace(0.05, 0.17, 13)
    vary = [
        {"parameter": "damping", "values": damping.tolist()},
        {"parameter": "eccentricity", "values": eccentricity.tolist()},
    ]
    with pytest.raises(SweptOutsideDomain) as refused:
        SweepJob.from_request({"oscillator": QUIET, "vary": vary})
    outside = eccentricity >= np.array(
        [[eccentricity_bound_quiet(Oscillator(each, stiffness=1e4))] for each in damping]
    )
    assert refused.value.place == ("vary", 1, "values", int(np.argwhere(outside)[0][1]))
    assert f"damping = {damping[np.argwhere(outside)[0][0]]:g}" in str(refused.value)


@pytest.mark.parametrize("convex", [(True, True), (True, False), (False, True)])
def test_the_first_refused_place_is_that_of_a_search_through_all(convex):
    chance = np.random.default_rng(7)
    for _ in range(200):
        shape = tuple(chance.integers(1, 9, 2))
        accepted = np.zeros(shape, bool)
        low, high = np.sort(chance.integers(0, shape[0] + 1, 2))
        across = np.sort(chance.integers(0, shape[1] + 1, 2))
        accepted[low:high, across[0] : across[1]] = True
        refused = np.argwhere(~accepted)
        expected = tuple(refused[0].tolist()) if refused.size else None
        axes = [Axis(count, each) for count, each in zip(shape, convex, strict=True)]
        assert first_refused(axes, lambda place, accepted=accepted: not accepted[place]) == expected


def test_a_resonance_between_two_quiet_ends_is_found():
    # Between the ends the stiffness meets 2 pi^2, where contact without ringing resonates.
    request = {
        "oscillator": {"model": "piecewise_linear", "eccentricity": 0.1},
        "vary": {"parameter": "stiffness", "values": [1.0, 2 * np.pi**2, 1e4]},
        "seeds": SEEDS,
    }
    with pytest.raises(SweptOutsideDomain, match="epsilon_crit1") as refused:
        BifurcationJob.from_request(request)
    assert refused.value.place == ("vary", "values", 1)


def test_checks_end_where_their_budget_does():
    with within(0.0, threading.Event()), pytest.raises(CheckTooLong):
        diagram(parameter="damping", start=0.5, stop=0.6, count=50_000)
    stopped = threading.Event()
    stopped.set()
    with within(100.0, stopped), pytest.raises(CheckTooLong):
        diagram(parameter="damping", start=0.5, stop=0.6, count=50_000)
    assert diagram(parameter="damping", start=0.5, stop=0.6, count=50_000).vary.values[-1] == 0.6


def test_sizes_come_before_values():
    class TooLarge(Exception):
        pass

    def refuse(asked):
        assert "vary" not in asked.__dict__
        raise TooLarge(dict((what, size) for what, size, _ in asked.sizes()))

    harmonics = [{"order": 969 + k, "amplitude": 1e-9} for k in range(32)]
    request = {
        "oscillator": {"eccentricity": 0.01, "harmonics": harmonics},
        "vary": {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 10**9},
        "seeds": SEEDS,
    }
    with pytest.raises(TooLarge) as refused:
        BifurcationJob.from_request(request, refuse)
    assert refused.value.args[0]["values"] == 10**9
    assert refused.value.args[0]["values times harmonics times their highest order"] == 32_000 * 10**9


def test_values_too_close_for_doubles_are_refused():
    with pytest.raises(InvalidJob, match="must ascend or descend"):
        diagram(parameter="damping", start=0.5, stop=0.5 + 1e-14, count=20_000)
    with pytest.raises(OutsideDomain):
        diagram(parameter="damping", start=-0.5, stop=0.5, count=20_000)


def test_values_between_which_the_step_overflows_are_refused_in_words():
    body = {"region": {}, "vary": {"parameter": "half_backlash", "values": [1.5e252, 0.5]}}
    with pytest.raises((InvalidJob, SweptOutsideDomain), match="half_backlash"):
        BifurcationJob.from_request(body)
