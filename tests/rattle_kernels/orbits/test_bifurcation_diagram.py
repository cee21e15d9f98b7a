"""Bifurcation diagrams: what is kept closes, both ways agree where one attractor is, permanent contact is marked."""

import math

import numpy as np
import pytest

from rattle_kernels import Oscillator, Outcome, OutsideDomain, bifurcation_diagram, next_impacts
from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from rattle_kernels.impact_map.chatter import descent_bound, fastest_below

# A departure of P(3,3,2) at damping 0.5 (Fig. 9(a)), where the paper's Fig. 11 begins.
P332 = (0.7641229, 4.00020845)


@pytest.fixture(scope="module")
def fig11():
    return bifurcation_diagram(Oscillator(), "damping", np.linspace(0.5, 0.6, 101), *P332, direction="both")


def row(diagram, value, way):
    found = np.flatnonzero(np.isclose(diagram.values, value))
    return found[0] if way == "up" else found[-1]


def test_figure_11_has_the_motions_the_paper_names(fig11):
    periods = {
        (value, way): fig11.period[row(fig11, value, way), 0] for value in fig11.values for way in ("up", "down")
    }
    assert periods[0.5, "up"] == 3  # P(3,3,2)
    assert periods[0.575, "up"] == 2  # P(2,2,1) ...
    assert periods[0.585, "up"] == 4  # ... after its doubling at 0.5819, P(4,4,2)
    assert periods[0.595, "up"] == 0  # chaos beyond the graze at 0.5922


def test_two_attractors_coexist_where_the_ways_differ(fig11):
    """Label A of Fig. 11: P(3,3,2) going up, chaos (here a long transient) coming down."""
    up, down = (row(fig11, 0.527, way) for way in ("up", "down"))
    assert fig11.period[up, 0] == 3
    assert fig11.period[down, 0] == 0
    assert np.ptp(fig11.v[down, 0]) > 0.3


def test_where_one_attractor_is_both_ways_find_it(fig11):
    for value in (0.55, 0.575, 0.59):
        up, down = (np.sort(fig11.v[row(fig11, value, way), 0]) for way in ("up", "down"))
        assert up == pytest.approx(down, abs=1e-6)


def test_what_is_kept_is_one_trajectory_of_the_lanes(fig11):
    i = row(fig11, 0.595, "up")
    impacts = next_impacts(Oscillator(damping=fig11.values[i]), fig11.t[i, 0, :-1], fig11.v[i, 0, :-1])
    assert impacts.v == pytest.approx(fig11.v[i, 0, 1:], abs=1e-9)


def test_the_first_value_has_the_seeds_own_motion_and_seeds_do_not_meet():
    both = bifurcation_diagram(Oscillator(), "damping", [0.5, 0.51], [P332[0], 0.93190114], [P332[1], math.pi])
    alone = bifurcation_diagram(Oscillator(), "damping", [0.51, 0.5], *P332)
    assert np.array_equal(both.v[:, :1], alone.v)
    assert both.period[0].tolist() == [3, 1]


def test_permanent_contact_is_marked_and_stays_while_quiet_exists():
    diagram = bifurcation_diagram(Oscillator(), "eccentricity", np.linspace(0.05, 0.1, 11), 0.9, 3.0, direction="down")
    assert diagram.outcome[0, 0] == Outcome.RETURNED
    quiet = diagram.outcome[:, 0] == Outcome.PERMANENT_CONTACT
    # P(1,1,0) ends at the bound of Eq. (41), 0.0596; what is left is quiet.
    assert quiet.tolist() == (diagram.values < 0.0596).tolist()
    assert np.isnan(diagram.v[quiet]).all() and np.isfinite(diagram.v[~quiet]).all()


def test_captured_means_what_it_means_everywhere():
    """At weak damping the corrected action proves more bounces captured than the plain one does: those count, too."""
    oscillator = Oscillator(damping=6e-4, eccentricity=1e-4, half_backlash=6e-4)
    bound = capture_bound(oscillator)
    plain = descent_bound(oscillator, np.empty(12), np.empty(12))
    between = math.sqrt(plain * bound)
    assert plain < 0.5 * bound
    v = fastest_below(oscillator, between, 0.0)
    diagram = bifurcation_diagram(oscillator, "damping", [oscillator.damping], 0.0, v, transient=0, kept=2)
    assert diagram.outcome[0, 0] == Outcome.PERMANENT_CONTACT


def test_contact_of_finite_stiffness_ends_where_quiet_does():
    """Beyond epsilon_crit1 (Eq. 3) no motion is quiet: what was permanent contact resumes from rest on the wall."""
    oscillator = Oscillator(stiffness=100.0)  # epsilon_crit1 = 0.15263
    diagram = bifurcation_diagram(oscillator, "eccentricity", np.linspace(0.14, 0.16, 21), 0.0, 1e-3)
    quiet = diagram.outcome[:, 0] == Outcome.PERMANENT_CONTACT
    assert quiet.tolist() == (diagram.values < 0.15263).tolist()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"parameter": "mass"}, "parameter must be"),
        ({"values": []}, "at least one"),
        ({"direction": "left"}, "direction must be"),
        ({"kept": 0}, "kept be positive"),
    ],
)
def test_what_cannot_be_drawn_is_refused(change, says):
    arguments = {"parameter": "damping", "values": [0.5], "t": 0.0, "v": 1.0} | change
    with pytest.raises(ValueError, match=says):
        bifurcation_diagram(Oscillator(), **arguments)


def test_values_outside_the_domain_are_refused_by_name():
    with pytest.raises(OutsideDomain, match="damping must be positive"):
        bifurcation_diagram(Oscillator(stiffness=1e4), "damping", [0.6, 0.0], 0.0, 1.0)
