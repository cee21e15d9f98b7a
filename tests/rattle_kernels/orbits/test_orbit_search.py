"""Periodic orbits found by search: they close, their multipliers are those of P, none of those known is missed."""

import math

import numpy as np
import pytest

from rattle_kernels import (
    Oscillator,
    find_attractors,
    find_orbits,
    grazing_velocity,
    largest_grazing_speed,
    next_impacts,
    single_contact_orbits,
)


@pytest.fixture(scope="module")
def at_06():
    return find_orbits(Oscillator(), longest=4, cells=32)


def named(found, name):
    return [one for one in found if one.orbit.name == name]


def test_the_papers_saddles_are_found(at_06):
    """Fig. 15: P(1,1,0) in closed form, P(1,1,1) numerically."""
    _, closed = single_contact_orbits(Oscillator())
    saddles = [one.orbit for one in named(at_06, "P(1,1,0)") if not one.orbit.attracts]
    assert len(saddles) == 1
    assert (saddles[0].t[0], saddles[0].v[0]) == pytest.approx((closed.t, closed.v), abs=1e-12)
    assert len(named(at_06, "P(1,1,1)")) == 2
    assert not any(one.orbit.attracts for one in named(at_06, "P(1,1,1)"))


def test_every_orbit_closes_under_the_map_after_its_own_period_only(at_06):
    for one in at_06:
        orbit = one.orbit
        after = next_impacts(Oscillator(), orbit.t, orbit.v)
        assert after.v == pytest.approx(np.roll(orbit.v, -1), abs=1e-9)
        assert np.sin(math.pi * (after.t - np.roll(orbit.t, -1))) == pytest.approx(0, abs=1e-9)
        assert after.lower_impacts.sum() == orbit.lower_contacts
        assert len(np.unique(np.round(orbit.v, 6))) == orbit.upper_contacts


def test_multipliers_agree_with_differences_of_the_map_and_areas_shrink_with_damping(at_06):
    for one in at_06:
        orbit, step = one.orbit, 1e-6
        t = orbit.t[0] + step * np.array([1, -1, 0, 0])
        v = orbit.v[0] + step * np.array([0, 0, 1, -1])
        image = next_impacts(Oscillator(), t, v, applications=orbit.upper_contacts)
        around = np.array([image.t - orbit.t[0] - np.rint(image.t - orbit.t[0]), image.v])
        differences = np.column_stack([around[:, 0] - around[:, 1], around[:, 2] - around[:, 3]]) / (2 * step)
        size = np.abs(orbit.multipliers).max()
        assert np.trace(differences) == pytest.approx(orbit.multipliers.sum().real, abs=1e-4 * (1 + size))
        assert np.linalg.det(orbit.jacobians[0]) == pytest.approx(math.exp(-0.6 * orbit.forcing_periods), rel=1e-9)


def test_margins_say_which_flights_meet_the_lower_wall(at_06):
    for one in at_06:
        margin = one.orbit.v - grazing_velocity(Oscillator(), one.orbit.t)
        assert one.grazing_margin == pytest.approx(margin, abs=1e-12)
        assert (one.lower_speed > 0).tolist() == (margin > 0).tolist()
        assert (margin > 0).sum() == one.orbit.lower_contacts
        assert one.grazing_distance == np.abs(margin).min()


@pytest.mark.parametrize("stiffness", [math.inf, pytest.param(1e4, marks=pytest.mark.slow)])
def test_no_attracting_orbit_is_missed(stiffness):
    oscillator = Oscillator(damping=0.5, stiffness=stiffness)
    random = np.random.default_rng(4)
    attractors = find_attractors(oscillator, random.uniform(0, 1, 300), random.uniform(0, 7, 300))
    short = sorted(a.name for a in attractors if 0 < a.upper_contacts <= 4)
    found = find_orbits(oscillator, longest=4, cells=32)
    assert short == sorted(one.orbit.name for one in found if one.orbit.attracts)


@pytest.mark.slow
def test_a_finer_search_finds_the_same(at_06):
    finer = find_orbits(Oscillator(), longest=4, cells=48)
    assert [one.orbit.name for one in finer] == [one.orbit.name for one in at_06]


def test_only_orbits_that_enter_the_region_are_listed(at_06):
    low = find_orbits(Oscillator(), longest=2, velocity=(3.0, 3.9), cells=20)
    assert [one.orbit.name for one in low] == ["P(1,1,0)", "P(1,1,0)"]


def where_a_dense_newton_search_leads(oscillator, period, fastest, cells=100):
    """Fixed points of P^p by Newton's method from every cell: derivatives are differences, and P alone is called."""
    middles = (np.arange(cells) + 0.5) / cells
    t, v = (axis.ravel() for axis in np.meshgrid(middles, fastest * middles))

    def moved(t, v):
        after = next_impacts(oscillator, t % 1.0, v, applications=period)
        return np.array([after.t - t - np.rint(after.t - t), after.v - v])

    step = 1e-7
    for _ in range(15):
        gap = moved(t, v)
        by_t = (moved(t + step, v) - moved(t - step, v)) / (2.0 * step)
        by_v = (moved(t, v + step) - moved(t, v - step)) / (2.0 * step)
        determinant = by_t[0] * by_v[1] - by_v[0] * by_t[1]
        with np.errstate(all="ignore"):
            dt = (by_v[0] * gap[1] - by_v[1] * gap[0]) / determinant
            dv = (by_t[1] * gap[0] - by_t[0] * gap[1]) / determinant
        # Near v = 0 every phase is fixed.
        kept = (np.abs(dt) < 0.5) & (v + dv > 0.02 * fastest) & (v + dv < fastest)
        t, v, dt, dv = t[kept] + dt[kept], v[kept] + dv[kept], dt[kept], dv[kept]
    ended = np.hypot(dt, dv) < 1e-9
    return np.unique(np.round(np.column_stack([t[ended] % 1.0, v[ended]]), 7), axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [math.inf, 2e4])
@pytest.mark.parametrize(
    "parameters", [(0.32525, 0.074024, 0.6006), (0.56061, 0.14874, 0.58625), (0.24643, 0.056663, 0.67424)]
)
def test_newtons_method_from_every_cell_leads_to_no_other_orbit(parameters, stiffness):
    oscillator = Oscillator(*parameters, stiffness)
    fastest = 1.6 * largest_grazing_speed(oscillator)
    found = find_orbits(oscillator, 3, velocity=(0.0, fastest))
    known = np.array([point for one in found for point in zip(one.orbit.t, one.orbit.v, strict=True)])
    reached = 0
    for period in (1, 2, 3):
        points = where_a_dense_newton_search_leads(oscillator, period, fastest)
        apart = np.subtract.outer(points[:, 0], known[:, 0])
        faster = np.subtract.outer(points[:, 1], known[:, 1])
        assert (np.hypot(apart - np.rint(apart), faster).min(axis=1) < 1e-5).all()
        reached += len(points)
    assert reached >= len(found)
