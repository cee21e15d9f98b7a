"""Every special point of a branch is reported once, also next to a graze, where the trace changes like a root."""

from itertools import pairwise

import pytest

from rattle_kernels import BranchEnd, Oscillator, SpecialKind, continue_orbit, find_orbit, find_orbits

# Each of these was located apart from the code, by bisection on the trace along the branch.
NEXT_TO_A_GRAZE = [
    (Oscillator(0.53, stiffness=1e3), (0.8504192, 4.15407487, 3), "damping", (0.52, 0.535), 0.524759667940852),
    (Oscillator(0.575, stiffness=1e5), (0.75129783, 4.36376225, 2), "damping", (0.555, 0.58), 0.557849456218305),
    (
        Oscillator(0.6, 0.092, stiffness=1e5), (0.76263991, 4.39259394, 2), "eccentricity", (0.0908, 0.0925),
        0.0912301605645279,
    ),
]  # fmt: skip


def values(branch, kind):
    return sorted(point.value for point in branch.special_points if point.kind == kind)


def branch_of(oscillator, seed, parameter, bounds):
    return continue_orbit(oscillator, find_orbit(oscillator, *seed).orbit, parameter, bounds)


@pytest.mark.parametrize(("oscillator", "seed", "parameter", "bounds", "doubling"), NEXT_TO_A_GRAZE)
def test_a_doubling_next_to_a_graze_of_the_piecewise_linear_model(oscillator, seed, parameter, bounds, doubling):
    branch = branch_of(oscillator, seed, parameter, bounds)
    (value,) = values(branch, SpecialKind.PERIOD_DOUBLING)
    assert value == pytest.approx(doubling, abs=1e-13)
    (graze,) = values(branch, SpecialKind.GRAZING)
    assert value == pytest.approx(graze, rel=1e-5)


@pytest.mark.parametrize("seed", [(0.67903753, 4.19850916, 4), (0.78584145, 4.22209854, 4)])
def test_three_doublings_of_one_branch(seed):
    """Two of them 1.2e-3 apart: Newton's method from one stretch found the doubling of another."""
    branch = branch_of(Oscillator(0.6, 0.089), seed, "eccentricity", (0.08, 0.1))
    doublings = values(branch, SpecialKind.PERIOD_DOUBLING)
    assert doublings == pytest.approx([0.0850594695123, 0.0862579263378, 0.0896158728925], abs=1e-12)
    grazes = values(branch, SpecialKind.GRAZING)
    assert grazes == pytest.approx([0.0830896195768, 0.0960847651031], abs=1e-12)


def test_a_doubled_branch_of_finite_stiffness_ends_at_doublings_and_has_every_point_once():
    """P(2,2,2) at kappa = 1e4 is born at a doubling of P(1,1,1) and ends at another; one flight grazes on the way."""
    oscillator = Oscillator(stiffness=1e4)
    (orbit,) = (one.orbit for one in find_orbits(oscillator, 2, cells=16) if one.orbit.name == "P(2,2,2)")
    branch = continue_orbit(oscillator, orbit, "damping", (0.3, 0.9))
    assert [end.reason for end in branch.ends] == [BranchEnd.HALVED, BranchEnd.HALVED]
    assert len(values(branch, SpecialKind.GRAZING)) == 2
    points = sorted((point.kind, point.value) for point in branch.special_points)
    for one, other in pairwise(points):
        assert one[0] != other[0] or other[1] - one[1] > 1e-9
