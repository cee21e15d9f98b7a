"""What chaotic transients end in, against a plain following of motions on them."""

import numpy as np
import pytest

from rattle_kernels import (
    AttractorKind,
    CellGrid,
    Oscillator,
    find_attractors,
    map_points,
    name_solutions,
    next_impacts,
)
from rattle_kernels.attractors import attractor_search, chaotic_transient
from rattle_kernels.attractors.attractor import ENSEMBLE, PERMANENT_CONTACT_ATTRACTOR, Attractor
from rattle_kernels.attractors.chaotic_transient import LONGEST
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit

# Each with a landing point on its transient.
FIRST = Oscillator(0.532864758213935, 0.08051199076214174, 0.5340363492127678), (0.659073237619249, 3.765838346960068)
SECOND = Oscillator(0.5236941360313097, 0.07089027201346004, 0.5115028577974611), (0.7042324177162953, 3.72380340774147)
QUIET_AFTER = Oscillator(0.6092826795919148, 0.0902287992922673, 0.5572879474697906)


def catalogue_of(oscillator, start):
    return find_attractors(oscillator, [start[0]], [start[1]])


def transient_in(catalogue):
    (transient,) = (each for each in catalogue if each.kind == AttractorKind.CHAOTIC_TRANSIENT)
    return transient


@pytest.mark.parametrize(("oscillator", "start"), [FIRST, SECOND])
def test_the_orbit_that_a_transient_ends_in_is_in_the_catalogue_with_its_share(oscillator, start):
    """The points of the orbit lie where the transient passes, and were taken for points of it."""
    catalogue = catalogue_of(oscillator, start)
    transient = transient_in(catalogue)
    ((place, share),) = transient.ends
    assert catalogue[place].name == "P(4,4,2)" and 0.5 < share <= 1.0 and ENSEMBLE * share % 1.0 == 0.0
    assert (
        name_solutions(oscillator, catalogue, catalogue[place].time, catalogue[place].velocity).tolist() == [place] * 4
    )
    # Followed without shortcuts, of the motions that end by then all are on that orbit.
    later = next_impacts(oscillator, transient.time[:ENSEMBLE], transient.velocity[:ENSEMBLE], 400_000)
    again = next_impacts(oscillator, later.t, later.v, 4)
    apart = np.abs(again.t - later.t)
    settled = np.minimum(apart, 1.0 - apart) + np.abs(again.v - later.v) < 1e-9
    nearest = np.abs(later.v[:, None] - catalogue[place].velocity[None]).min(axis=1)
    assert settled.sum() > 16 and (nearest[settled] < 1e-9).all()
    # Of 64 members the shares differ by their errors: both are followed for some 400,000 to 540,000 impacts.
    assert abs(settled.mean() - share) < 4.0 * np.sqrt(2 * 0.25 / ENSEMBLE)


def test_the_orbit_after_the_first_machines_transient_has_the_multipliers_of_newtons_method():
    oscillator, start = FIRST
    catalogue = catalogue_of(oscillator, start)
    end = catalogue[transient_in(catalogue).ends[0][0]]
    orbit = find_periodic_orbit(oscillator, end.time[0], end.velocity[0], 4, largest_grazing_speed(oscillator))
    assert np.abs(orbit.multipliers) == pytest.approx(0.344, abs=5e-4)


def test_the_ends_keep_their_motions_when_a_catalogue_is_extended():
    oscillator, start = FIRST
    catalogue = catalogue_of(oscillator, start)
    # P(1,1,0) comes before P(4,4,2).
    rng = np.random.default_rng(8)
    grown = find_attractors(oscillator, rng.random(64), 6.4 * rng.random(64), known=catalogue)
    assert len(grown) > len(catalogue)
    for listed in (catalogue, grown):
        assert [(listed[place].name, share) for place, share in transient_in(listed).ends] == [("P(4,4,2)", 1.0)]


def test_a_transient_may_end_in_permanent_contact():
    oscillator = QUIET_AFTER
    rng = np.random.default_rng(8)
    catalogue = find_attractors(oscillator, rng.random(16), 7.0 * rng.random(16))
    assert transient_in(catalogue).ends == ((0, 1.0),)


def test_members_that_begin_beside_chaos_do_not_make_it_a_transient():
    """Of 64 motions on it a plain loop over the scalar map sees none end within a million impacts."""
    oscillator = Oscillator(0.5012620476358172, 0.08044398105330211, 0.5144521024255886)
    rng, speed = np.random.default_rng(8), 12.0 * oscillator.damping
    grid = CellGrid(velocity_stop=speed)
    landed = map_points(oscillator, grid, 1499, rng.random(64), speed * (1.0 - rng.random(64)))
    there = np.isfinite(landed.landing_time)
    catalogue = find_attractors(oscillator, landed.landing_time[there], landed.landing_velocity[there])
    assert [each.name for each in catalogue] == ["permanent contact", "P(1,2,0)", "P(4,4,2)", "chaotic"]
    chaos = catalogue[-1]
    assert np.isnan(chaos.mean_life) and chaos.ends == ()
    # No orbit of up to 12 impacts after a hundred thousand.
    later = next_impacts(oscillator, chaos.time[:ENSEMBLE], chaos.velocity[:ENSEMBLE], 100_000)
    apart = [np.abs(next_impacts(oscillator, later.t, later.v, n).v - later.v) for n in range(1, 13)]
    assert np.min(apart) > 1e-9


@pytest.mark.parametrize(("oscillator", "start"), [FIRST, SECOND])
def test_the_ensemble_is_followed_for_a_bounded_number_of_applications(monkeypatch, oscillator, start):
    applied, run_lanes, follow_to_ends = [], chaotic_transient.run_lanes, attractor_search.follow_to_ends

    def counted(oscillator, t, v, applications, **others):
        applied.append(t.size * applications)
        return run_lanes(oscillator, t, v, applications, **others)

    def followed(*of):
        with monkeypatch.context() as meanwhile:
            meanwhile.setattr(chaotic_transient, "run_lanes", counted)
            return follow_to_ends(*of)

    monkeypatch.setattr(attractor_search, "follow_to_ends", followed)
    transient = transient_in(catalogue_of(oscillator, start))
    assert 0 < sum(applied) <= ENSEMBLE * LONGEST
    # A member that has ended is not followed further. Its life is known by a third, and a leg is 16,384 impacts.
    assert sum(applied) < ENSEMBLE * (3.0 * transient.mean_life + 16_384)


def test_two_transients_that_are_one_end_in_the_mean_of_both():
    def transient(ends):
        points = np.array([0.5, 0.6]), np.array([1.0, 2.0])
        return Attractor(AttractorKind.CHAOTIC_TRANSIENT, 0, 0, 0, 0.2, 0.01, *points, 1e5, ends)

    chaos = transient(())._replace(kind=AttractorKind.CHAOTIC, mean_life=np.nan)
    one, other = transient(((0, 0.25), (2, 0.5))), transient(((2, 1.0),))
    assert attractor_search._united(one, other).ends == ((0, 0.125), (2, 0.75))
    # None of the other ensemble has ended.
    assert attractor_search._united(chaos, other).ends == ((2, 0.5),)
    assert attractor_search._united(chaos, chaos).ends == PERMANENT_CONTACT_ATTRACTOR.ends == ()


@pytest.mark.slow
@pytest.mark.parametrize(("damping", "turn"), [(0.527, 3), (0.592, 4)])
def test_chaos_beside_the_papers_orbits_of_three_and_four_impacts_ends_in_them(damping, turn):
    """What docs/paper/figures.md says of Figs. 11 to 13, of 256 motions that start with v = 3 to 5."""
    oscillator, rng = Oscillator(damping=damping), np.random.default_rng(1)
    kept, t, v = [], rng.random(256), 3.0 + 2.0 * rng.random(256)
    for impacts in (50_000, 350_000):
        t, v = next_impacts(oscillator, t, v, impacts)[:2]
        speeds = np.array([next_impacts(oscillator, t, v, n).v - v for n in range(1, 13)])
        irregular = (np.abs(speeds) > 1e-6).all(axis=0) & (v > 1e-2)
        on_orbit = (np.abs(speeds[turn - 1]) < 1e-6) & (np.abs(speeds[: turn - 1]) > 1e-6).all(axis=0)
        kept.append((int(irregular.sum()), int(on_orbit.sum())))
    assert kept[0][0] > 30 and kept[1][0] <= 3
    assert kept[1][1] - kept[0][1] >= kept[0][0] - 3
