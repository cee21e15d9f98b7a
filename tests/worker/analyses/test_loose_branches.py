"""Orbits of loose gears are followed by a job, through Gamma = 1, and it says where branches end and what is there."""

import math

import pytest

from rattle_kernels import Oscillator
from rattle_kernels.numerics.pausing import never_stopped
from worker.analyses.orbits import assemble, plan, summarise
from worker.jobs.orbits_job import Continuation, OrbitSeed, OrbitsJob

BOUND = 0.2 / math.hypot(2.0 * math.pi, 0.1)
"""Eccentricity at which Gamma is 1."""


def summary(job):
    """Compute all pieces of a job here."""
    parts = {}
    while ready := plan(job, parts).ready:
        parts |= {piece.name: piece.compute(*piece.arguments, pause=never_stopped) for piece in ready}
    return summarise(job, assemble(job, parts))


def test_a_branch_goes_through_gamma_1_and_ends_at_a_graze_of_the_upper_wall():
    along, second = Continuation("eccentricity", 0.01, 0.1), Continuation("half_backlash", 0.2, 0.4, 20)
    oscillator = Oscillator(0.1, 1.5 * BOUND, 0.3, restitution=0.7)
    told = summary(OrbitsJob(oscillator=oscillator, seeds=[OrbitSeed(0.966, 0.517)], continuation=along, curves=second))
    ((orbit,), (branch,)) = told["orbits"], told["branches"]
    assert orbit.name == "P(1,1,0)" and branch.lowest < BOUND < branch.highest
    kinds = {point.kind: point for point in told["special_points"]}
    assert kinds.keys() == {"saddle-node", "period doubling", "upper grazing"}
    assert kinds["upper grazing"].value == pytest.approx(0.0790754296146, abs=1e-12)
    assert "upper_grazing" in [end.reason for end in branch.ends]
    # Folds and doublings are followed in a second parameter. Of a graze beyond Eq. (8) it is said that it is not.
    for curve in told["curves"]:
        alone = told["special_points"][curve.special_point].kind == "upper grazing"
        assert (curve.points == 1) == alone == all("not followed" in end for end in curve.ends)


def test_an_orbit_that_rests_is_followed_between_its_first_and_its_last_release():
    along = Continuation("eccentricity", 0.01, 0.2)
    oscillator = Oscillator(0.1, 1.6 * BOUND, 0.3, restitution=0.3)
    told = summary(OrbitsJob(oscillator=oscillator, seeds=[OrbitSeed(0.861, 0.01)], continuation=along))
    ((orbit,), (branch,), (point,)) = told["orbits"], told["branches"], told["special_points"]
    assert orbit.name == point.orbit == "P(1,1,0)*" and orbit.branch == 0
    assert [end.reason for end in branch.ends] == ["held", "release"]
    assert branch.lowest == pytest.approx(BOUND, rel=1e-9)
    assert point.kind == "release" and point.value == branch.ends[1].value == branch.highest
    assert point.multipliers == [(0.0, 0.0), (0.0, 0.0)]
