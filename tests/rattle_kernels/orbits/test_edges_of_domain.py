"""Branches and curves that run into a closed edge of the domain end on it: restitution 1, no amplitude, no damping."""

import numpy as np
import pytest

from rattle_kernels import (
    BranchEnd,
    Oscillator,
    SpecialKind,
    continue_orbit,
    continue_special_point,
    eccentricity_bound_single_contact,
    single_contact_orbits,
)
from rattle_kernels.orbits.orbit_search import find_orbit

# Two harmonics beside the first, as in other tests: kernels are compiled for that number of them.
HARMONICS = ((2, 0.01, 0.25), (3, 0.0005, 0.3))
LOSSY = Oscillator(restitution=0.95, harmonics=HARMONICS)
STIFF = Oscillator(stiffness=400.0, contact_damping=0.02, harmonics=HARMONICS)


def single_contact(oscillator):
    """P(1,1,0) of either model; the closed form of the impacting one is a guess for the stiff one."""
    rigid = oscillator._replace(stiffness=np.inf, contact_damping=0.0)
    found = [find_orbit(oscillator, closed.t, closed.v) for closed in single_contact_orbits(rigid)]
    return next(each.orbit for each in found if each is not None and each.orbit.name == "P(1,1,0)")


@pytest.mark.parametrize(
    ("oscillator", "parameter", "bounds", "edge"),
    [
        (LOSSY, "restitution", (0.9, 1.0), 1.0),
        (LOSSY, "amplitude_2", (0.0, 0.012), 0.0),
        (STIFF, "contact_damping", (0.0, 0.025), 0.0),
    ],
)
def test_a_branch_ends_on_the_edge_itself(oscillator, parameter, bounds, edge):
    branch = continue_orbit(oscillator, single_contact(oscillator), parameter, bounds)
    (end,) = (end for end in branch.ends if abs(end.value - edge) < 1e-6)
    assert (end.reason, end.value) == (BranchEnd.BOUND, edge)
    place = int(np.abs(branch.values - edge).argmin())
    assert branch.values[place] == edge
    there = find_orbit(oscillator.at(**{parameter: edge}), branch.t[place, 0], branch.v[place, 0])
    assert (there.orbit.t[0], there.orbit.v[0]) == pytest.approx((branch.t[place, 0], branch.v[place, 0]), abs=1e-9)


def test_a_branch_that_begins_on_the_edge_has_nothing_beyond():
    elastic = LOSSY.at(restitution=1.0)
    branch = continue_orbit(elastic, single_contact(elastic), "restitution", (0.98, 1.0))
    assert [end.reason for end in branch.ends] == [BranchEnd.BOUND] * 2
    assert sorted(end.value for end in branch.ends) == pytest.approx([0.98, 1.0])


@pytest.mark.slow
def test_a_curve_ends_on_the_edge_too():
    branch = continue_orbit(LOSSY, single_contact(LOSSY), "eccentricity", (0.03, 0.11))
    (fold,) = (point for point in branch.special_points if point.kind == SpecialKind.SADDLE_NODE)
    curve = continue_special_point(fold, "restitution", (0.01, 0.11), (0.9, 1.0))
    assert all("a bound" in end for end in curve.ends)
    assert curve.values[-1, 1] == pytest.approx(1.0, abs=1e-15)
    exact = [
        eccentricity_bound_single_contact(Oscillator(0.6, restitution=r, harmonics=HARMONICS)) for _, r in curve.values
    ]
    assert curve.values[:, 0] == pytest.approx(np.array(exact), abs=1e-11)
