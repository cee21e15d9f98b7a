"""A branch is continuous: no step leads to another orbit of the same impact period."""

import math

import numpy as np
import pytest

from rattle_kernels import BranchEnd, Oscillator, SpecialKind, continue_orbit, find_orbit
from rattle_kernels.numerics.pseudo_arclength import Steps


def branch_of(oscillator, seed, parameter, bounds, **options):
    return continue_orbit(oscillator, find_orbit(oscillator, *seed).orbit, parameter, bounds, **options)


def values(branch, kind):
    return sorted(point.value for point in branch.special_points if point.kind == kind)


def test_a_branch_does_not_go_on_as_another_orbit_of_its_name():
    """Between .55447 and .56878 another P(3,3,2) is closer to the prediction than the orbit itself, in long steps."""
    branch = branch_of(Oscillator(0.6, 0.089), (0.72161, 4.29034, 3), "damping", (0.48, 0.72))
    assert values(branch, SpecialKind.SADDLE_NODE) == pytest.approx([0.5657665850556], abs=1e-12)
    assert values(branch, SpecialKind.PERIOD_DOUBLING) == pytest.approx([0.5885493540163], abs=1e-12)
    assert [end.reason for end in branch.ends] == [BranchEnd.BOUND, BranchEnd.GRAZING]


def test_long_and_short_steps_follow_the_same_branch():
    found = [
        branch_of(Oscillator(0.6, 0.089), (0.72161, 4.29034, 3), "damping", (0.55, 0.6), steps=Steps(most=most))
        for most in (0.02, 0.004)
    ]
    long, short = ([(point.kind, point.value) for point in branch.special_points] for branch in found)
    assert len(long) == len(short) == 2
    # The orbit lies on a bound to begin with: the branch ends there.
    assert all(branch.values.max() <= 0.6 for branch in found)
    for one, other in zip(long, short, strict=True):
        assert one[0] == other[0] and one[1] == pytest.approx(other[1], abs=1e-12)


def test_a_stiff_saddle_meets_the_attractor_in_a_saddle_node_next_to_the_graze():
    """At kappa = 1e5 P(1,1,1) ends next to the graze of P(1,1,0), .70508. It became P(1,1,0) at .6988, in one step."""
    branch = branch_of(Oscillator(stiffness=1e5), (0.8938, 3.99748, 1), "damping", (0.5, 0.75), direction="up")
    (fold,) = values(branch, SpecialKind.SADDLE_NODE)
    (graze,) = values(branch, SpecialKind.GRAZING)
    assert fold == pytest.approx(graze, abs=1e-8) and branch.values.max() <= fold
    meets = np.isfinite(branch.lower_speed[:, 0])
    turn = int(np.argmax(branch.values))
    assert meets[: turn + 1].all() and not branch.attracts[:turn].any()
    assert branch.attracts[turn + 1 :].all()


@pytest.mark.parametrize(
    ("stiffness", "parameter", "bounds", "seed"),
    [
        (20.0, "eccentricity", (0.01, 0.3), (0.25764856139027553, 2.057735775560052, 1)),
        (100.0, "stiffness", (5.0, 1e6), (0.0479576752479165, 3.195855202211113, 1)),
        (1e4, "stiffness", (5.0, 1e6), (0.9133295804477148, 3.7075602259586162, 1)),
    ],
)
def test_a_branch_that_leaves_the_domain_of_its_equations_ends_and_says_why(stiffness, parameter, bounds, seed):
    """The departure's speed tends to 0 there, so that the corrector's last step may lead to none."""
    branch = branch_of(Oscillator(stiffness=stiffness), seed, parameter, bounds, most_points=400)
    assert all(math.isfinite(end.value) and end.message for end in branch.ends)
    assert np.isfinite(branch.trace).all() and (branch.v > 0.0).all()
