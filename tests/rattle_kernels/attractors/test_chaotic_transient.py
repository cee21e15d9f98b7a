"""Chaos is told from what looks like it, and whether it lasts."""

import numpy as np
import pytest

from rattle_kernels import CellGrid, Harmonic, Oscillator, find_attractors, map_points, name_solutions, next_impacts
from rattle_kernels.attractors.attractor import ENSEMBLE, PERMANENT_CONTACT_ATTRACTOR, Attractor, AttractorKind
from rattle_kernels.attractors.chaotic_transient import follow_ensemble, note_orbits
from rattle_kernels.lanes.lyapunov import tangent_growth
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit
from tests.rattle_kernels.impact_map.scalar_map import departure, derivative
from tests.rattle_kernels.machine import MACHINE

CHAOTIC = 0.553, 4.703
IMPACTING, STIFF = Oscillator(), Oscillator(stiffness=1e5)


def growth_by_products(oscillator, t, v, impacts):
    """The same by DP of the scalar map at every departure that the lanes pass."""
    scale = lane_tables(oscillator).largest_grazing_speed
    vector, growth, elapsed = np.array([1.0, 0.0]), 0.0, 0.0
    for n in range(64 + impacts):
        impact, jacobian = derivative(oscillator, t, v)
        vector = np.array([[jacobian.tt, jacobian.tv * scale], [jacobian.vt / scale, jacobian.vv]]) @ vector
        if n >= 64:
            growth += np.log(np.hypot(*vector))
            elapsed += impact.duration
        vector /= np.hypot(*vector)
        t, v = (float(field[0]) for field in next_impacts(oscillator, [t], [v])[:2])
    return growth, elapsed


STARTS = [0.553, 0.2, 0.7], [4.703, 3.0, 5.5]
# Damping times duration goes beyond 1, where the lanes' polynomials end.
LONG = Oscillator(1.236, 0.33, 1.64)


@pytest.mark.parametrize(
    ("oscillator", "starts"),
    [
        pytest.param(IMPACTING, STARTS, id="impacting"),
        pytest.param(STIFF, STARTS, id="piecewise linear"),
        pytest.param(Oscillator(restitution=0.95), ([0.3268, 0.9796], [6.3564, 7.7634]), id="with losses"),
        pytest.param(
            Oscillator(eccentricity=0.08, harmonics=(Harmonic(2, 0.01, 0.1),)), ([0.0248], [8.7747]), id="harmonics"
        ),
        pytest.param(LONG, ([0.0256], [6.1787]), id="long flights"),
    ],
)
def test_tangent_vectors_grow_in_lanes_as_by_the_scalar_derivative(oscillator, starts):
    together = tangent_growth(oscillator, *starts, 40)
    for at, start in enumerate(zip(*starts, strict=True)):
        growth, elapsed = growth_by_products(oscillator, *start, 40)
        if np.isfinite(together.growth[at]):
            assert together.elapsed[at] == pytest.approx(elapsed, rel=1e-9)
            assert together.growth[at] == pytest.approx(growth, rel=1e-6, abs=1e-6)
    assert np.isfinite(together.growth).any()
    if oscillator is LONG:
        assert (together.elapsed / 40 * LONG.damping > 1.2).all()


@pytest.mark.parametrize("impacts", [1, 7, 8, 9, 100])
def test_growth_adds_up_whenever_vectors_are_rescaled(impacts):
    t, v = np.array([0.553]), np.array([4.703])
    whole = tangent_growth(IMPACTING, t, v, impacts)
    products = growth_by_products(IMPACTING, t[0], v[0], impacts)
    assert whole.growth[0] == pytest.approx(products[0], rel=1e-6, abs=1e-6)
    assert whole.elapsed[0] == pytest.approx(products[1], rel=1e-9)
    landed = next_impacts(IMPACTING, t, v, 64 + impacts, shortcuts=False)
    np.testing.assert_array_equal([whole.t, whole.v], [landed.t, landed.v])


def test_members_that_approach_an_orbit_are_counted_with_it_and_the_others_are_not():
    orbit = find_periodic_orbit(IMPACTING, 0.898, 3.77, 1, 5.5)
    near = 1e-4 * np.arange(-3, 4)
    t = np.append(orbit.t[0] + near, [CHAOTIC[0], 0.5])
    v = np.append(orbit.v[0] + near, [CHAOTIC[1], 1e-3])
    motions, members, asked = [PERMANENT_CONTACT_ATTRACTOR], [5], []
    approach = note_orbits(IMPACTING, t, v, motions, members, lambda: asked.append(1))
    assert approach.tolist() == [True] * 7 + [False] * 2
    assert [motion.name for motion in motions] == ["permanent contact", "P(1,1,0)"] and members == [5, 7]
    # A second call finds the orbit among the motions.
    assert note_orbits(IMPACTING, t[:2], v[:2], motions, members, lambda: None).all()
    assert len(motions) == 2 and members == [5, 9] and asked


def test_the_exponent_of_a_periodic_orbit_is_that_of_its_multipliers():
    orbit = find_periodic_orbit(IMPACTING, 0.898, 3.77, 1, 5.5)
    run = tangent_growth(IMPACTING, orbit.t, orbit.v, 20_000)
    assert run.exponent == pytest.approx(orbit.lyapunov_exponent, abs=1e-3)


def test_what_is_captured_on_the_way_has_no_exponent():
    run = tangent_growth(IMPACTING, np.array([0.5, 0.553]), np.array([1e-3, 4.703]), 40)
    assert np.isnan(run.growth).tolist() == np.isnan(run.t).tolist() == [True, False]


def test_the_exponent_of_chaos_is_positive_within_its_error_whatever_the_start():
    ensembles = [follow_ensemble(IMPACTING, t, 4.5) for t in (0.6, 0.65)]
    assert all(ensemble.chaotic and ensemble.captured == 0 and not ensemble.settled.size for ensemble in ensembles)
    assert abs(ensembles[0].exponent - ensembles[1].exponent) < 5.0 * np.hypot(ensembles[0].error, ensembles[1].error)


def test_points_of_chaos_are_departures_far_apart_in_time():
    ensemble = follow_ensemble(IMPACTING, *CHAOTIC)
    assert ensemble.t.size == 4096 and np.unique(ensemble.t).size == ensemble.t.size
    ahead = next_impacts(IMPACTING, ensemble.t[:64], ensemble.v[:64], 256)
    np.testing.assert_array_equal(ahead.t, ensemble.t[64:128])


@pytest.mark.parametrize(
    ("oscillator", "start"),
    [(Oscillator(eccentricity=0.1895), (0.5, 0.02)), (Oscillator(6e-4, 1e-4, 6e-4), (0.5, 3e-5)),
     (Oscillator(eccentricity=0.1895), (0.461, 1.133e-3)), (Oscillator(eccentricity=0.1895), (0.4171, 0.01135))],
)  # fmt: skip
def test_low_bounces_are_not_taken_for_chaos(oscillator, start):
    # Close to the bound of Eq. (8) low bounces are captured late; their tangent vectors grow, but not exponentially.
    assert not follow_ensemble(oscillator, *start).chaotic


def test_chaos_that_falls_into_low_bounces_is_a_transient_also_where_they_are_captured_late():
    # By independent code, 356 of 379 motions had left chaos for good after 131,072 impacts.
    life = -131_072 / np.log1p(-356 / 379)
    (chaos,) = find_attractors(Oscillator(0.3, 0.093954, 0.3), [0.1, 0.4], [1.0, 2.0])[1:]
    assert chaos.kind == AttractorKind.CHAOTIC_TRANSIENT
    assert abs(chaos.mean_life - life) < 4.0 * chaos.mean_life_error


@pytest.mark.slow
def test_low_bounces_are_followed_to_their_capture():
    oscillator = Oscillator(eccentricity=0.1895)
    rng = np.random.default_rng(9)
    landed = next_impacts(oscillator, rng.random(64), 7.0 * rng.random(64), 1499)
    left = np.isfinite(landed.t)
    t, v = landed.t[left], landed.v[left]
    later = next_impacts(oscillator, t, v, 130_000, shortcuts=True)
    late = np.isfinite(later.t)
    assert late.any()
    (quiet,) = find_attractors(oscillator, t, v)
    assert quiet.kind == AttractorKind.PERMANENT_CONTACT
    assert (name_solutions(oscillator, [quiet], t, v) == 0).all()
    assert (
        next_impacts(oscillator, later.t[late], later.v[late], 400_000, shortcuts=True).outcome
        == Outcome.PERMANENT_CONTACT
    ).all()


def catalogue_of(oscillator, speed=7.0, count=200):
    """Catalogue of landing points after the paper's k, and the place of each in it."""
    rng = np.random.default_rng(8)
    grid = CellGrid(velocity_stop=speed)
    landed = map_points(oscillator, grid, 1499, rng.random(count), speed * (1.0 - rng.random(count)))
    there = np.isfinite(landed.landing_time)
    t, v = landed.landing_time[there], landed.landing_velocity[there]
    catalogue = find_attractors(oscillator, t, v)
    return catalogue, name_solutions(oscillator, catalogue, t, v)


@pytest.mark.slow
@pytest.mark.parametrize(("damping", "end"), [(0.65, "P(3,3,1)"), (0.527, "P(3,3,2)")])
def test_a_transient_of_1e5_impacts_is_one_and_its_end_is_in_the_catalogue(damping, end):
    oscillator = Oscillator(damping=damping)
    catalogue, places = catalogue_of(oscillator)
    attractors = {attractor.name: attractor for attractor in catalogue}
    assert end in attractors and "chaotic" not in attractors and (places >= 0).all()
    life = attractors["chaotic transient"].mean_life
    assert attractors["chaotic transient"].label.startswith(f"chaotic transient of some {life:.1g} ± ")
    # Against a plain loop from other starts, each until it comes back close to itself or has made 300,000 impacts.
    lives = [impacts_until_settled(oscillator, 0.55 + 0.001 * n, 4.7, 300_000) for n in range(24)]
    gone = [impacts for impacts in lives if impacts < 300_000]
    assert 0.3 < life / (sum(lives) / len(gone)) < 3.0


@pytest.mark.parametrize(
    ("damping", "start"),
    [(0.6079079079079079, (0.5342400126931213, 4.542657972910141)),
     (0.515015015015015, (0.6489820298489566, 4.463135657209052))],
)  # fmt: skip
def test_weak_chaos_behind_a_cascade_is_chaos_by_an_exponent_that_a_longer_run_has_too(damping, start):
    oscillator = Oscillator(damping=damping)
    ensemble = follow_ensemble(oscillator, *start)
    assert ensemble.chaotic and 0.003 < ensemble.exponent < 0.007
    longer = tangent_growth(oscillator, np.full(64, start[0]), start[1] * (1.0 + 1e-9 * np.arange(64)), 65_536)
    assert longer.exponent == pytest.approx(ensemble.exponent, rel=0.1)


def test_far_down_a_cascade_of_period_doublings_the_orbit_that_attracts_is_found():
    # P(384,384,128) has lost its stability already, and lies within 1e-6 of the one that has doubled.
    oscillator, start = Oscillator(damping=0.527027027027027), ([0.6554355652996406], [4.670922390326611])
    catalogue = find_attractors(oscillator, *start)
    assert [attractor.name for attractor in catalogue] == ["permanent contact", "P(768,768,256)"]
    assert name_solutions(oscillator, catalogue, *map(np.array, start)).tolist() == [1]
    t, v = catalogue[1].time[:1], catalogue[1].velocity[:1]
    half, whole = (next_impacts(oscillator, t, v, n) for n in (384, 768))
    assert 1e-8 < abs(half.v - v) < 1e-5 and abs(whole.v - v) < 1e-11


def test_a_little_before_that_doubling_the_orbit_of_half_its_length_attracts():
    """The values that docs/decisions/0023 prints: the doubling lies between .527027 and .527027027027027."""
    catalogue = find_attractors(Oscillator(damping=0.527027), [0.6554355652996406], [4.670922390326611])
    assert [attractor.name for attractor in catalogue] == ["permanent contact", "P(384,384,128)"]


@pytest.mark.parametrize("damping", [0.6, 0.625, 0.675])
def test_a_chaotic_attractor_holds_what_is_on_it(damping):
    catalogue, _ = catalogue_of(Oscillator(damping=damping))
    assert catalogue[-1].name == catalogue[-1].label == "chaotic" and np.isnan(catalogue[-1].mean_life)


@pytest.mark.slow
def test_at_the_machines_damping_nothing_is_called_chaotic_after_too_few_impacts():
    catalogue, _ = catalogue_of(MACHINE, 12.0 * MACHINE.damping, 64)
    assert not any(attractor.is_chaotic for attractor in catalogue)


def impacts_until_settled(oscillator, t, v, most):
    """Impacts after which a motion is on an orbit of up to 12 impacts, or captured."""
    kept_t, kept_v = t, v
    for n in range(1, most):
        impact = departure(oscillator, t, v)
        if impact.outcome != 0 or impact.v < 1e-3:
            return n
        t, v = impact.t, impact.v
        if n % 12 == 0:
            if abs(t - kept_t) + abs(v - kept_v) < 1e-9:
                return n
            kept_t, kept_v = t, v
    return most


def test_the_mean_life_is_that_of_the_exponential_law():
    ensemble = follow_ensemble(IMPACTING, *CHAOTIC)
    assert ensemble.impacts == 64 * 256 and np.isnan(ensemble.mean_life(0))
    assert ensemble.mean_life(ENSEMBLE // 2) == pytest.approx(ensemble.impacts / np.log(2.0))
    assert ensemble.mean_life(1) == pytest.approx(ENSEMBLE * ensemble.impacts, rel=0.01)


def transient_of(mean_life):
    """A chaotic transient without points."""
    kind, nothing = AttractorKind.CHAOTIC_TRANSIENT, np.empty(0)
    return Attractor(kind, 0, 0, 0, np.nan, np.nan, nothing, nothing, mean_life)


@pytest.mark.parametrize("life", [25_000.0, 40_000.0])
def test_mean_lives_that_are_counted_again_differ_by_their_error(life):
    ensemble, rng = follow_ensemble(IMPACTING, *CHAOTIC), np.random.default_rng(5)
    gone = (rng.exponential(life, (4000, ENSEMBLE)) < ensemble.impacts).sum(axis=1)
    counted = [ensemble.mean_life(left) for left in gone.tolist()]
    transient = transient_of(life)
    # The law is to first order; the next order is the square of an error of a fifth.
    assert np.std(counted) == pytest.approx(transient.mean_life_error, rel=0.15)


def test_a_mean_life_that_one_of_the_ensemble_has_told_is_known_to_itself():
    ensemble = follow_ensemble(IMPACTING, *CHAOTIC)
    transient = transient_of(ensemble.mean_life(1))
    assert transient.mean_life_error == pytest.approx(transient.mean_life, rel=0.02)
    assert transient.label == "chaotic transient of some 1e+06 ± 1e+06 impacts"
    assert np.isnan(transient_of(np.nan).mean_life_error)
