"""A picture of branches says where one of them is not followed further."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from rattle_kernels import BranchEnd, Oscillator, continue_orbit, find_orbit
from worker.analyses.orbit_tables import SPECIALS, branch_table
from worker.analyses.orbits import plot_branches

LOST = "not followed further"


@pytest.fixture(scope="module")
def branch():
    orbit = find_orbit(Oscillator(), 0.6017, 3.77).orbit
    return continue_orbit(Oscillator(), orbit, "damping", (0.59, 0.61))


def lost_ends(branch, stiffness, *reasons):
    ends = tuple(end._replace(reason=reason) for end, reason in zip(branch.ends, reasons, strict=True))
    columns = branch_table("damping").of([branch._replace(ends=ends)]) | SPECIALS.of(branch.special_points)
    columns |= {"name": np.array(["P(1,1,0)"]), "branch_orbit": np.array([0])}
    job = SimpleNamespace(continuation=SimpleNamespace(parameter="damping"), oscillator=Oscillator(stiffness=stiffness))
    axes = Figure().subplots()
    plot_branches(axes, job, columns)
    return [tuple(line.get_xydata()[0]) for line in axes.lines if line.get_marker() == "x"], axes


@pytest.mark.parametrize("reason", [BranchEnd.GRAZING, BranchEnd.STALLED, BranchEnd.POINTS])
def test_an_end_that_is_not_passed_is_marked_at_its_place(branch, reason):
    marks, axes = lost_ends(branch, 1e5, BranchEnd.BOUND, reason)
    assert marks == [(branch.values[-1], branch.v[-1, 0])]
    assert axes.get_legend_handles_labels()[1].count(LOST) == 1
    marks, axes = lost_ends(branch, 1e5, reason, reason)
    assert marks == [(branch.values[i], branch.v[i, 0]) for i in (0, -1)]
    assert axes.get_legend_handles_labels()[1].count(LOST) == 1


def test_a_true_end_is_not_marked(branch):
    assert lost_ends(branch, 1e5, BranchEnd.BOUND, BranchEnd.HALVED)[0] == []
    # Without a stiffness a graze is where a branch ends.
    assert lost_ends(branch, np.inf, BranchEnd.BOUND, BranchEnd.GRAZING)[0] == []
