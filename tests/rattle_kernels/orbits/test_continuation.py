"""Branches: every point closes under P, special points have their multipliers, both ways give the same branch."""

import collections
import math

import numpy as np
import pytest

from rattle_kernels import (
    BranchEnd,
    Oscillator,
    SpecialKind,
    continue_orbit,
    continue_special_point,
    eccentricity_bound_single_contact,
    find_orbit,
    find_orbits,
    grazing_velocity,
    next_impacts,
    orbit_beyond_graze,
    single_contact_orbits,
)
from rattle_kernels.numerics.pseudo_arclength import Steps
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit

SCALE = 4.0


def orbits(oscillator, name, longest=4):
    found = find_orbits(oscillator, longest=longest, cells=24)
    return [one.orbit for one in found if one.orbit.name == name]


def only(points, kind):
    (point,) = (one for one in points if one.kind == kind)
    return point


def at(branch, i):
    return Oscillator(**{branch.parameter: float(branch.values[i])})


def gap(oscillator, t, v, applications):
    """How far a departure is from itself after some applications of the lanes."""
    image = next_impacts(oscillator, t, v, applications=applications)
    return np.hypot(np.sin(math.pi * (image.t - t)) / math.pi, (image.v - v) / SCALE)


@pytest.fixture(scope="module")
def fold():
    """P(1,2,0), node and saddle, at damping 0.575 (Fig. 10)."""
    oscillator = Oscillator(damping=0.575)
    pair = orbits(oscillator, "P(1,2,0)", longest=2)
    return [continue_orbit(oscillator, orbit, "damping", (0.45, 0.7)) for orbit in pair]


@pytest.fixture(scope="module")
def doubled():
    """P(4,4,2) at damping 0.585 (Fig. 11, between B and C)."""
    oscillator = Oscillator(damping=0.585)
    (orbit,) = orbits(oscillator, "P(4,4,2)")
    return continue_orbit(oscillator, orbit, "damping", (0.5, 0.7))


def test_every_point_of_a_branch_closes_under_the_map(fold, doubled):
    for branch in (*fold, doubled):
        for i in range(0, len(branch.values), 5):
            assert gap(at(branch, i), branch.t[i], branch.v[i], branch.upper_contacts).max() < 1e-8


def test_multipliers_agree_with_differences_of_the_map(fold):
    branch, step = fold[0], 1e-6
    for i in range(0, len(branch.values), 10):
        t = branch.t[i, 0] + step * np.array([1, -1, 0, 0])
        v = branch.v[i, 0] + step * np.array([0, 0, 1, -1])
        image = next_impacts(at(branch, i), t, v, applications=2)
        trace = (image.t[0] - image.t[1] + image.v[2] - image.v[3]) / (2 * step)
        assert branch.multipliers[i].sum().real == pytest.approx(trace, abs=1e-6)
        assert branch.multipliers[i].prod().real == pytest.approx(math.exp(-branch.values[i]), rel=1e-12)


def test_node_and_saddle_lie_on_one_branch_and_meet_at_one_fold(fold):
    folds = [only(branch.special_points, SpecialKind.SADDLE_NODE) for branch in fold]
    assert folds[0].value == pytest.approx(folds[1].value, abs=1e-12)
    assert folds[0].value == pytest.approx(0.5997, abs=5e-5)  # the paper's
    assert abs(folds[0].multipliers - 1).min() < 1e-8
    assert folds[0].multipliers.prod().real == pytest.approx(math.exp(-folds[0].value), rel=1e-10)
    for branch, point in zip(fold, folds, strict=True):
        assert branch.ends[0].reason == branch.ends[1].reason == BranchEnd.BOUND
        assert branch.values.max() <= point.value
        assert 0 < np.count_nonzero(branch.attracts) < len(branch.values)
        assert gap(point.oscillator, point.t, point.v, 2).max() < 1e-10
    # No such orbit just beyond the fold, a pair just before it.
    assert orbits(Oscillator(damping=folds[0].value + 1e-4), "P(1,2,0)", longest=2) == []
    assert len(orbits(Oscillator(damping=folds[0].value - 1e-4), "P(1,2,0)", longest=2)) == 2


def test_a_branch_continued_back_from_its_end_is_the_same(fold):
    branch = fold[0]
    end = find_periodic_orbit(at(branch, 0), branch.t[0, 0], branch.v[0, 0], 2, SCALE)
    back = continue_orbit(at(branch, 0), end, "damping", (0.45, 0.7), direction="up")
    assert back.ends[0].reason == BranchEnd.START
    assert back.values[-1] == pytest.approx(0.45, abs=1e-12)
    assert np.sort(back.v[-1]) == pytest.approx(np.sort(branch.v[-1]), abs=1e-9)
    there, again = (only(one.special_points, SpecialKind.SADDLE_NODE) for one in (branch, back))
    assert there.value == pytest.approx(again.value, abs=1e-12)


def test_the_doubled_branch_begins_at_the_doubling_and_ends_at_a_graze(doubled):
    assert [end.reason for end in doubled.ends] == [BranchEnd.HALVED, BranchEnd.GRAZING]
    doubling = only(doubled.special_points, SpecialKind.PERIOD_DOUBLING)
    assert abs(doubling.multipliers + 1).min() < 1e-8
    assert doubling.upper_contacts == 2
    assert doubling.value == pytest.approx(0.5819, abs=1e-4)
    graze = only(doubled.special_points, SpecialKind.GRAZING)
    assert graze.value == pytest.approx(0.5922, abs=5e-5)
    assert graze.v[0] == pytest.approx(float(grazing_velocity(graze.oscillator, graze.t[0])), abs=1e-12)
    # A hair slower, so that the first flight misses the wall: the orbit closes from there.
    assert gap(graze.oscillator, graze.t[0], graze.v[0] * (1 - 1e-12), 4) < 1e-9


def test_the_same_doubling_is_met_on_the_branch_that_doubles(doubled):
    oscillator = Oscillator(damping=0.575)
    (orbit,) = orbits(oscillator, "P(2,2,1)", longest=2)
    branch = continue_orbit(oscillator, orbit, "damping", (0.55, 0.6))
    there, here = (only(one.special_points, SpecialKind.PERIOD_DOUBLING) for one in (doubled, branch))
    assert here.value == pytest.approx(there.value, abs=1e-12)
    before, after = branch.values < here.value, branch.values > here.value
    assert branch.attracts[before].all() and not branch.attracts[after].any()


def test_single_contact_orbits_fold_at_the_exact_bound_of_equation_41():
    node, saddle = orbits(Oscillator(), "P(1,1,0)", longest=1)
    for orbit in (node, saddle):
        branch = continue_orbit(Oscillator(), orbit, "eccentricity", (0.03, 0.19))
        point = only(branch.special_points, SpecialKind.SADDLE_NODE)
        assert point.value == pytest.approx(0.059643058193045, abs=1e-13)
        assert point.t[0] == pytest.approx(0.75, abs=1e-7)
        for i in range(len(branch.values)):
            closed = single_contact_orbits(at(branch, i))
            nearest = min(np.hypot(one.t - branch.t[i, 0], one.v - branch.v[i, 0]) for one in closed)
            assert nearest < 1e-7  # near the fold t is known to the root of rounding only


def test_the_curve_of_that_fold_is_the_closed_form():
    orbit, _ = orbits(Oscillator(), "P(1,1,0)", longest=1)
    branch = continue_orbit(Oscillator(), orbit, "eccentricity", (0.03, 0.19))
    point = only(branch.special_points, SpecialKind.SADDLE_NODE)
    curve = continue_special_point(point, "damping", (0.001, 0.2), (0.05, 0.7))
    exact = [eccentricity_bound_single_contact(Oscillator(damping)) for _, damping in curve.values]
    assert curve.values[:, 0] == pytest.approx(np.array(exact), abs=1e-11)
    assert curve.values[:, 1].min() < 0.08 and curve.values[:, 1].max() == pytest.approx(0.7)
    assert all("a bound" in end for end in curve.ends)


def test_a_curve_of_grazes_grazes_all_along(doubled):
    graze = only(doubled.special_points, SpecialKind.GRAZING)
    curve = continue_special_point(graze, "eccentricity", (0.5, 0.7), (0.08, 0.12))
    for (damping, eccentricity), t, v in zip(curve.values[::10], curve.t[::10], curve.v[::10], strict=True):
        oscillator = Oscillator(damping, eccentricity)
        assert v == pytest.approx(float(grazing_velocity(oscillator, t)), abs=1e-10)
        assert gap(oscillator, t, v * (1 - 1e-12), 4) < 1e-8


@pytest.mark.parametrize("lower_speed", [0.01, 0.003])
def test_at_the_graze_the_doubled_orbit_meets_a_saddle_and_vanishes(doubled, lower_speed):
    """A nonsmooth fold: P(4,4,2) and P(4,4,3) both exist below 0.5922, neither above."""
    graze = only(doubled.special_points, SpecialKind.GRAZING)
    oscillator, orbit = orbit_beyond_graze(graze, lower_speed)
    assert oscillator.damping < graze.value
    assert orbit.name == "P(4,4,3)" and not orbit.attracts
    assert gap(oscillator, orbit.t, orbit.v, 4).max() < 1e-9
    back = continue_orbit(oscillator, orbit, "damping", (0.5, 0.7), direction="up")
    assert back.ends[1].reason == BranchEnd.GRAZING
    assert back.ends[1].value == pytest.approx(graze.value, abs=1e-12)


def test_at_another_graze_a_motion_goes_on_under_another_name():
    oscillator = Oscillator(damping=0.575)
    (orbit,) = orbits(oscillator, "P(2,2,1)", longest=2)
    branch = continue_orbit(oscillator, orbit, "damping", (0.5, 0.6), direction="down")
    graze = only(branch.special_points, SpecialKind.GRAZING)
    beyond, other = orbit_beyond_graze(graze)
    assert other.name == "P(2,2,2)"
    assert beyond.damping < graze.value < branch.values.min()


def test_only_a_graze_has_another_side():
    orbit, _ = orbits(Oscillator(), "P(1,1,0)", longest=1)
    branch = continue_orbit(Oscillator(), orbit, "eccentricity", (0.03, 0.19))
    with pytest.raises(ValueError, match="must be a graze"):
        orbit_beyond_graze(only(branch.special_points, SpecialKind.SADDLE_NODE))


@pytest.mark.slow
def test_finite_stiffness_passes_grazes_and_turns_in_folds():
    """P(3,3,2) becomes P(3,3,3) by a graze and then folds; the impacting model's branch ends at its graze."""
    oscillator = Oscillator(stiffness=1000.0)
    (orbit,) = orbits(oscillator, "P(3,3,2)", longest=3)
    branch = continue_orbit(oscillator, orbit, "damping", (0.55, 0.8), steps=Steps(most=2e-3))
    graze = only(branch.special_points, SpecialKind.GRAZING)
    fold = only(branch.special_points, SpecialKind.SADDLE_NODE)
    assert graze.lower_contacts == 2
    assert [end.reason for end in branch.ends] == [BranchEnd.BOUND, BranchEnd.BOUND]
    contacts = np.isfinite(branch.lower_speed).sum(axis=1)
    assert set(contacts.tolist()) == {2, 3}
    assert abs(fold.multipliers - 1).min() < 1e-8
    # Softly: on either side of the graze the trace is close to that at it.
    (last,) = np.flatnonzero(np.diff(contacts))
    assert branch.trace[last : last + 2] == pytest.approx(graze.multipliers.sum().real, abs=0.5)


@pytest.mark.slow
def test_fig_7s_orbit_of_the_stiff_model_ends_at_a_stiffness():
    """P(1,2,0) at damping 0.6: with kappa = 1e6 its saddle-node is not yet passed, in the impacting model it is."""
    oscillator = Oscillator(stiffness=1e6)
    node, saddle = sorted(orbits(oscillator, "P(1,2,0)", longest=2), key=lambda orbit: not orbit.attracts)
    assert node.attracts and not saddle.attracts
    branch = continue_orbit(oscillator, node, "stiffness", (1e5, 3e7), direction="up")
    fold = only(branch.special_points, SpecialKind.SADDLE_NODE)
    assert fold.value == pytest.approx(8.79988e6, rel=1e-6)
    assert gap(fold.oscillator, fold.t, fold.v, 2).max() < 1e-7
    beyond = [len(orbits(Oscillator(stiffness=fold.value * part), "P(1,2,0)", longest=2)) for part in (0.99, 1.01)]
    assert beyond == [2, 0]


@pytest.mark.slow
def test_contact_loss_is_met_from_both_sides():
    """At kappa = 100 a stay of P(1,1,0) splits: beyond that it is P(1,2,0), whose slowest departure tends to 0."""
    oscillator = Oscillator(stiffness=100.0)
    one = [orbit for orbit in orbits(oscillator, "P(1,1,0)", longest=2) if orbit.v[0] < 1.0]
    two = orbits(oscillator, "P(1,2,0)", longest=2)
    points = []
    for orbit in (*one, *two):
        branch = continue_orbit(oscillator, orbit, "damping", (0.5, 0.8))
        assert BranchEnd.CONTACT_LOSS in [end.reason for end in branch.ends]
        points.append(only(branch.special_points, SpecialKind.CONTACT_LOSS))
    assert len(points) == 2
    assert points[0].value == pytest.approx(points[1].value, abs=1e-10)
    assert points[0].v[0] == 0.0 and points[0].residual < 1e-10


def test_a_branch_with_finite_stiffness_ends_at_the_edge_of_the_domain_and_says_so():
    stiff = Oscillator(stiffness=1e4)
    _, saddle = sorted(orbits(stiff, "P(1,1,0)", longest=1), key=lambda orbit: orbit.t[0], reverse=True)
    branch = continue_orbit(stiff, saddle, "eccentricity", (0.05, 0.5), direction="up")
    assert branch.ends[1].reason == BranchEnd.DOMAIN
    assert branch.ends[1].value == pytest.approx(0.19012, abs=1e-4)
    assert "eccentricity = 0.190" in branch.ends[1].message


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"parameter": "mass"}, "parameter must"),
        ({"bounds": (0.7, 0.8)}, "outside"),
        ({"direction": "left"}, "must be"),
    ],
)
def test_what_cannot_be_followed_is_refused(change, says):
    orbit, _ = orbits(Oscillator(), "P(1,1,0)", longest=1)
    arguments = {"parameter": "damping", "bounds": (0.5, 0.7)} | change
    with pytest.raises(ValueError, match=says):
        continue_orbit(Oscillator(), orbit, **arguments)


def test_a_branch_that_passes_close_by_its_start_goes_on():
    """Orbits on both sides of a fold, and a part of the branch that returns, lie within a step of each other."""
    oscillator = Oscillator(0.7364397061069343, 0.10722700471040196, 0.6584309774674322, 39441.09941661308)
    bounds = (0.43, 0.669)
    branch = continue_orbit(oscillator, find_orbit(oscillator, 0.7452219, 4.95472382, 3).orbit, "half_backlash", bounds)
    assert [end.reason for end in branch.ends] == [BranchEnd.BOUND, BranchEnd.BOUND]
    kinds = collections.Counter(point.kind for point in branch.special_points)
    assert kinds == {SpecialKind.GRAZING: 5, SpecialKind.SADDLE_NODE: 3, SpecialKind.PERIOD_DOUBLING: 4}


@pytest.mark.slow
def test_an_isola_ends_where_it_began():
    """At the fold of P(1,1,0) a small second harmonic leaves it at half of the phases: node and saddle, one loop."""
    oscillator = Oscillator(eccentricity=0.05964305819304491, harmonics=((2, 1e-3, 0.25),))
    pair = [each.orbit for each in find_orbits(oscillator, longest=1) if each.orbit.name == "P(1,1,0)"]
    branches = [continue_orbit(oscillator, orbit, "phase_2", (-1.0, 2.0)) for orbit in pair]
    assert len(branches) == 2
    for branch in branches:
        assert {end.reason for end in branch.ends} == {BranchEnd.CLOSED}
        assert [point.kind for point in branch.special_points] == [SpecialKind.SADDLE_NODE] * 2
        # Beyond its start by a part of the last step, once around.
        way = np.diff(branch.values)
        assert np.sum(way[1:] * way[:-1] < 0.0) == 2 and abs(branch.values[-1] - branch.values[0]) <= abs(way[0])
    places = [sorted(point.value for point in branch.special_points) for branch in branches]
    np.testing.assert_allclose(places[0], places[1], atol=1e-12)
