"""Branches of finite stiffness pass grazes, and list the same special points from whichever end they are followed.

Next to a graze the trace of P(m, n+, n-) passes its critical values within 1/kappa^2: at 1e7 within 1e-15.
"""

import math
import re

import numpy as np
import pytest

from rattle_kernels import (
    BranchEnd,
    Oscillator,
    SpecialKind,
    continue_orbit,
    continue_special_point,
    find_orbit,
    find_orbits,
)
from rattle_kernels.orbits import continuation
from rattle_kernels.orbits.touching_orbit import touches_of
from tests.rattle_kernels.orbits.contact_times import special_points

KINDS = {"fold": SpecialKind.SADDLE_NODE, "doubling": SpecialKind.PERIOD_DOUBLING}
QUIET, RATTLING, AMID_CHAOS = (0.6017, 3.77, 1), (0.8902, 3.99, 1), (0.6296, 4.57, 1)


def branch_of(oscillator, seed, parameter="damping", bounds=(0.55, 0.8)):
    return continue_orbit(oscillator, find_orbit(oscillator, *seed).orbit, parameter, bounds)


def listed(branch):
    return [(point.kind, point.value) for point in branch.special_points]


def assert_alike(one, other):
    """Both branches list the same special points, in this order or in the opposite one."""
    here, there = listed(one), listed(other)
    ways = [there, there[::-1]]
    assert [kind for kind, _ in here] in [[kind for kind, _ in way] for way in ways]
    for kind in SpecialKind:
        pairs = (
            sorted((point.value, point.error) for point in branch.special_points if point.kind == kind)
            for branch in (one, other)
        )
        for (here, error), (there, another) in zip(*pairs, strict=True):
            assert abs(here - there) <= 1e-12 * abs(here) + error + another


def from_end(branch, oscillator, bounds, end):
    """The branch followed from one of its own ends."""
    here = oscillator.at(**{branch.parameter: float(branch.values[end])})
    orbit = find_orbit(here, float(branch.t[end, 0]), float(branch.v[end, 0]), branch.upper_contacts).orbit
    return continue_orbit(here, orbit, branch.parameter, bounds)


@pytest.mark.parametrize("stiffness", [1e4, 1e5, 1e6, 1e7])
@pytest.mark.parametrize("seed", [QUIET, RATTLING])
def test_special_points_beyond_a_graze_agree_with_the_contact_times(stiffness, seed):
    """Independent: no impact map, the times of four pieces as unknowns, long floats."""
    branch = branch_of(Oscillator(stiffness=stiffness), seed)
    (graze,) = (point for point in branch.special_points if point.kind == SpecialKind.GRAZING)
    oscillator, t, v = graze.oscillator, graze.t, graze.v
    fall, above = touches_of(oscillator, t, v)[0, 0] - t[0], math.pi / math.sqrt(2.0 * stiffness)
    guess = np.array([fall, 0.0, 1.0 - fall - above, above, t[0], v[0], graze.value])
    found = special_points(stiffness, guess, 0.5 * above)
    assert found
    for kind, value in found:
        near = [point for point in branch.special_points if point.kind == KINDS[kind] and point.lower_contacts == 1]
        assert min(abs(point.value - value) for point in near) < 1e-14
    # Nothing else is listed so near the graze.
    reach = max(abs(value - graze.value) for _, value in found)
    listed_there = [
        point
        for point in branch.special_points
        if point.lower_contacts and abs(point.value - graze.value) <= 1.01 * reach
    ]
    assert len(listed_there) == len(found)


@pytest.mark.parametrize("stiffness", [1e4, 1e5, 1.5e5, 5e5, 1e6, 1e7])
def test_a_branch_is_the_same_from_both_sides_of_its_graze(stiffness):
    oscillator = Oscillator(stiffness=stiffness)
    one, other = (branch_of(oscillator, seed) for seed in (QUIET, AMID_CHAOS))
    assert all(end.reason == BranchEnd.BOUND for branch in (one, other) for end in branch.ends)
    assert SpecialKind.GRAZING in [kind for kind, _ in listed(one)]
    assert SpecialKind.PERIOD_DOUBLING in [kind for kind, _ in listed(one)]
    assert_alike(one, other)


@pytest.mark.parametrize("stiffness", [1.5e5, 5e5, 1e7])
def test_the_rattling_saddle_folds_next_to_the_graze_and_goes_on(stiffness):
    """It ended there, with "the orbit grazes -beta", and the fold was not listed."""
    oscillator = Oscillator(stiffness=stiffness)
    bounds = 0.55, 0.8
    branch = branch_of(oscillator, RATTLING, "damping", bounds)
    assert [end.reason for end in branch.ends] == [BranchEnd.BOUND, BranchEnd.BOUND]
    assert [kind for kind, _ in listed(branch)] == [SpecialKind.SADDLE_NODE, SpecialKind.GRAZING]
    for end in (0, -1):
        assert_alike(branch, from_end(branch, oscillator, bounds, end))


@pytest.mark.parametrize(
    ("parameter", "bounds", "graze"),
    [("eccentricity", (0.1, 0.15), 0.140242420804), ("damping", (0.5, 0.6), 0.560119355209)],
)
def test_p333_goes_on_as_p332(parameter, bounds, graze):
    oscillator = Oscillator(0.5191502741306242, 0.13174093733403552, 0.7865183268255314, 33041.04776830244)
    branch = branch_of(oscillator, (0.8776407657632459, 4.555529797993772, 3), parameter, bounds)
    (point,) = (point for point in branch.special_points if point.kind == SpecialKind.GRAZING)
    assert point.value == pytest.approx(graze, abs=1e-11)
    assert point.lower_contacts == 2
    assert BranchEnd.GRAZING not in [end.reason for end in branch.ends]
    # Doubling and saddle-node both lie within 1e-9 of the graze, on the side that meets -beta three times.
    beside = [kind for kind, value in listed(branch) if 0.0 < abs(value - point.value) < 1e-9]
    assert sorted(beside) == sorted([SpecialKind.PERIOD_DOUBLING, SpecialKind.SADDLE_NODE])
    for end in (0, -1):
        assert_alike(branch, from_end(branch, oscillator, bounds, end))


SEVERAL_AT_ONCE = Oscillator(0.602426, 0.112807, 0.518003, 1188740.4)
P331, P332 = (0.6075386402956633, 4.0090117237992695, 3), (0.640249489416311, 4.143728394155803, 3)


def test_flights_that_graze_at_once_are_passed_from_both_sides():
    """Within 1e-10 of .74955 P(3,3,1) becomes P(3,3,2), doubles, folds, becomes P(3,3,3) and again P(3,3,2).

    It ended there, with two points from one side and none from the other.
    """
    one, other = (branch_of(SEVERAL_AT_ONCE, seed, "damping", (0.42, 0.85)) for seed in (P331, P332))
    assert_alike(one, other)
    for branch in (one, other):
        assert [end.reason for end in branch.ends] == [BranchEnd.BOUND, BranchEnd.BOUND]
        narrow = [(kind, value) for kind, value in listed(branch) if abs(value - 0.7495526853) < 1e-9]
        kinds = [SpecialKind.GRAZING, SpecialKind.PERIOD_DOUBLING, SpecialKind.SADDLE_NODE] + 2 * [SpecialKind.GRAZING]
        assert [kind for kind, _ in narrow] in (kinds, kinds[::-1])
        # The branch turns at its saddle-node: neither orbit is there beyond it.
        fold = next(value for kind, value in narrow if kind == SpecialKind.SADDLE_NODE)
        assert fold - 1e-12 < branch.values.max() <= fold + 1e-14
        assert {int(met) for met in (branch.grazing_margin > 0.0).sum(axis=1)} == {1, 2, 3}


def test_a_curve_of_grazes_of_three_turns_does_not_become_one_of_a_single_turn():
    """The graze of P(1,1,0), three turns of which graze too, lies 5e-11 beside it: steps led there."""
    branch = branch_of(SEVERAL_AT_ONCE, P331, "damping", (0.42, 0.85))
    grazes = [p for p in branch.special_points if p.kind == SpecialKind.GRAZING and p.value > 0.7]
    assert len(grazes) == 3
    for point in grazes:
        curve = continue_special_point(point, "eccentricity", (0.6, 0.85), (0.1, 0.125), most_points=30)
        assert curve.values.tolist() == [[point.value, SEVERAL_AT_ONCE.eccentricity]]
        assert all("differs from turns of a shorter one" in end for end in curve.ends)


def test_a_branch_lost_at_a_graze_tells_which_orbits_lie_beside_it(monkeypatch):
    oscillator, seed = Oscillator(stiffness=1e6), QUIET
    whole = branch_of(oscillator, seed)
    monkeypatch.setattr(continuation, "first_touch", lambda *_: None)
    lost = branch_of(oscillator, seed)
    (end,) = (end for end in lost.ends if end.reason == BranchEnd.GRAZING)
    value, trace = re.search(
        r"next to it there is P\(1,1,1\) at damping = (\S+), of trace (\S+);", end.message
    ).groups()
    nearest = int(
        np.argmin(np.where(np.isfinite(whole.lower_speed[:, 0]), np.abs(whole.values - float(value)), np.inf))
    )
    here = oscillator.at(damping=float(value))
    orbit = find_orbit(here, float(whole.t[nearest, 0]), float(whole.v[nearest, 0])).orbit
    assert orbit.name == "P(1,1,1)"
    assert float(trace) == pytest.approx(float(np.trace(orbit.jacobians[0])), rel=1e-4)
    assert "not known" in end.message and "goes on" not in end.message


@pytest.mark.parametrize("stiffness", [1e4, 1e6])
def test_neighbouring_points_of_a_branch_do_not_pass_a_critical_trace_unlisted(stiffness):
    branch = branch_of(Oscillator(stiffness=stiffness), AMID_CHAOS)
    for kind, multiplier in ((SpecialKind.SADDLE_NODE, 1.0), (SpecialKind.PERIOD_DOUBLING, -1.0)):
        beyond = branch.trace - multiplier * (1.0 + branch.area) > 0.0
        assert np.count_nonzero(beyond[1:] != beyond[:-1]) == sum(which == kind for which, _ in listed(branch))


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [1e3, 1e4, 1e5, 1e6, 1e7])
@pytest.mark.parametrize("parameter", ["damping", "eccentricity", "half_backlash", "stiffness"])
def test_every_branch_of_the_papers_orbits_is_the_same_from_both_ends(stiffness, parameter):
    oscillator = Oscillator(stiffness=stiffness)
    value = oscillator.value_of(parameter)
    bounds = (0.3 * value, 3.0 * value) if parameter == "stiffness" else (0.85 * value, 1.25 * value)
    for found in find_orbits(oscillator, longest=2, cells=24):
        branch = continue_orbit(oscillator, found.orbit, parameter, bounds)
        for end in (0, 1):
            if branch.ends[end].reason == BranchEnd.BOUND:
                assert_alike(branch, from_end(branch, oscillator, bounds, -end))
