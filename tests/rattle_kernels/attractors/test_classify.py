"""Attractors and solutions against the paper's text and against what must hold."""

import numpy as np
import pytest

from rattle_kernels import AttractorKind, CellGrid, Oscillator, find_attractors, map_cells, name_solutions, next_impacts
from rattle_kernels.attractors.seeds import landing_boxes
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit
from tests.rattle_kernels.impact_map.scalar_map import derivative
from tests.rattle_kernels.reference import entries, oscillator_of


def catalogue_of(oscillator, cells=60, iterations=499, grid=None):
    """Catalogue and shares of a small basin."""
    grid = grid or CellGrid(time_cells=cells, velocity_cells=cells)
    images = map_cells(oscillator, grid, iterations, (0, grid.velocity_cells), (0, grid.time_cells))
    landed = np.isfinite(images.landing_time)
    t, v = images.landing_time[landed], images.landing_velocity[landed]
    _, first = np.unique(landing_boxes(oscillator, t, v), return_index=True)
    attractors = find_attractors(oscillator, t[first], v[first])
    solution = np.zeros(grid.shape, np.int16)
    solution[landed] = name_solutions(oscillator, attractors, t, v)
    return attractors, solution


# What Sec. 5 and Figs. 8, 9, 12, 13 say is there; more than that may be found at a finer grid.
PAPER = {
    (0.6, 0.1): {"P(1,1,0)", "chaotic"},
    (0.575, 0.1): {"P(1,1,0)", "P(1,2,0)", "P(2,2,1)"},
    (0.55, 0.1): {"P(1,1,0)", "P(1,2,0)", "P(2,2,1)"},
    (0.527, 0.1): {"P(1,1,0)", "P(1,2,0)", "P(3,3,2)", "chaotic transient"},
    (0.5, 0.1): {"P(1,1,0)", "P(1,2,0)", "P(1,3,0)", "P(3,3,2)"},
    (0.7, 0.1): set(),
    (0.6, 0.067): {"P(1,1,0)"},
    (0.6, 0.056): set(),
}
EXACTLY = {(0.6, 0.1), (0.575, 0.1), (0.7, 0.1), (0.6, 0.067), (0.6, 0.056)}


@pytest.mark.parametrize("parameters", PAPER, ids=str)
def test_the_papers_motions_are_found(parameters):
    attractors, solution = catalogue_of(Oscillator(*parameters, 0.6))
    names = [attractor.name for attractor in attractors]
    assert names[0] == "permanent contact" and (solution >= 0).all()
    assert set(names[1:]) >= PAPER[parameters]
    if parameters in EXACTLY:
        assert set(names[1:]) == PAPER[parameters]


def test_the_catalogue_is_in_canonical_order_and_independent_of_the_order_of_seeds():
    oscillator = Oscillator(damping=0.575)
    rng = np.random.default_rng(0)
    t, v = rng.random(300), 7.0 * rng.random(300)
    landed = next_impacts(oscillator, t, v, applications=300)
    forwards = find_attractors(oscillator, landed.t, landed.v)
    backwards = find_attractors(oscillator, landed.t[::-1], landed.v[::-1])
    contacts = [attractor.upper_contacts for attractor in forwards]
    assert contacts == sorted(contacts)
    for one, other in zip(forwards, backwards, strict=True):
        assert one.name == other.name
        np.testing.assert_array_equal(one.time, other.time)


@pytest.mark.parametrize("damping", [0.5, 0.575, 0.65])
def test_attractors_are_mapped_onto_themselves(damping):
    oscillator = Oscillator(damping=damping)
    attractors, _ = catalogue_of(oscillator, cells=40)
    for attractor in attractors:
        if attractor.kind != AttractorKind.PERIODIC:
            continue
        after = next_impacts(oscillator, attractor.time, attractor.velocity)
        np.testing.assert_allclose(after.t, np.roll(attractor.time, -1), atol=1e-11)
        np.testing.assert_allclose(after.v, np.roll(attractor.velocity, -1), rtol=1e-10)
        assert attractor.upper_contacts == attractor.time.size
        assert attractor.lower_contacts == after.lower_impacts.sum()
        assert attractor.lyapunov_exponent < 0.0


@pytest.mark.parametrize("damping", [0.5, 0.55, 0.6, 0.65])
def test_p110_strikes_with_the_speed_that_balances_the_torque(damping):
    # Over one period the impulse 2v of the impact balances the mean torque 4 pi delta, and Phi returns to itself.
    attractors, _ = catalogue_of(Oscillator(damping=damping), cells=30, iterations=101)
    speeds = [attractor.velocity[0] for attractor in attractors if attractor.name == "P(1,1,0)"]
    assert speeds == pytest.approx([2.0 * np.pi * damping], abs=1e-11)


def test_a_window_is_named_like_the_plane_it_was_cut_from():
    grid = CellGrid(0.5, 0.7, 30, 4.2, 4.8, 30)
    attractors, solution = catalogue_of(Oscillator(), grid=grid, iterations=7)
    full, _ = catalogue_of(Oscillator())
    t, v = np.meshgrid(grid.time_centres(), grid.velocity_centres())
    by_full = name_solutions(Oscillator(), full, t.ravel(), v.ravel()).reshape(grid.shape)
    names = np.array([attractor.name for attractor in attractors])[solution]
    np.testing.assert_array_equal(names, np.array([attractor.name for attractor in full])[by_full])


def test_a_point_is_named_alone_as_in_company():
    attractors, _ = catalogue_of(Oscillator())
    rng = np.random.default_rng(3)
    t, v = rng.random(200), 7.0 * rng.random(200)
    together = name_solutions(Oscillator(), attractors, t, v)
    alone = [int(name_solutions(Oscillator(), attractors, t[i : i + 1], v[i : i + 1])[0]) for i in range(0, 200, 10)]
    assert together[::10].tolist() == alone


def test_a_point_of_an_unknown_motion_is_a_stranger():
    permanent_contact = find_attractors(Oscillator(damping=0.7), [], [])
    assert name_solutions(Oscillator(), permanent_contact, [0.89829], [3.76991]).tolist() == [-1]
    grown = find_attractors(Oscillator(), [0.89829], [3.76991], known=permanent_contact)
    assert [attractor.name for attractor in grown] == ["permanent contact", "P(1,1,0)"]


_BEYOND = entries("map_impacting.json", inside_domain=False)


@pytest.mark.parametrize("entry", entries("map_impacting.json") + _BEYOND, ids=lambda entry: entry["category"])
def test_the_derivative_of_the_map_agrees_with_the_reference(entry):
    printed = np.array([float(x) for x in entry["DP"]])
    jacobian = np.array(derivative(oscillator_of(entry), float(entry["t0"]), float(entry["v0"]))[1])
    # Next to grazing DP goes with the inverse speed at -beta, which the input's last digit changes by DP^2 times
    # itself.
    largest = np.abs(printed).max()
    allowed = 1e-11 * largest + (1e-15 * largest**3 if entry["category"] == "near_graze" else 0.0)
    np.testing.assert_allclose(jacobian, printed, rtol=1e-9, atol=allowed)


def test_the_saddle_p110_is_found_by_newton_with_its_multipliers():
    orbit = find_periodic_orbit(Oscillator(), 0.3, 3.7, 1, 5.5)
    assert orbit is not None and not orbit.attracts
    assert orbit.v.tolist() == pytest.approx([1.2 * np.pi], abs=1e-12)
    # Freeplay contracts areas in (t, v dv) by e^(-delta) a period, whatever the impacts do.
    assert np.prod(orbit.multipliers).real == pytest.approx(np.exp(-0.6), rel=1e-9)


def test_newton_finds_the_own_period_of_an_orbit():
    orbit = find_periodic_orbit(Oscillator(), 0.898, 3.77, 6, 5.5)
    assert orbit is not None and (orbit.upper_contacts, orbit.forcing_periods) == (1, 1)


@pytest.mark.parametrize("point", [(np.nan, np.nan), (0.3, -1.0), (0.3, 0.0), (np.inf, 1.0)])
def test_what_is_no_departure_is_not_named(point):
    catalogue = find_attractors(Oscillator(damping=0.7), [0.3], [1.0])
    with pytest.raises(ValueError, match="must be finite"):
        find_attractors(Oscillator(damping=0.7), [point[0]], [point[1]])
    with pytest.raises(ValueError, match="positive speeds"):
        name_solutions(Oscillator(damping=0.7), catalogue, [point[0]], [point[1]])


def test_phases_count_modulo_one_and_any_speed_is_followed():
    catalogue, _ = catalogue_of(Oscillator(), cells=40)
    named = name_solutions(Oscillator(), catalogue, [0.898, 5.898, -0.102, -1e-20, 0.5], [3.77, 3.77, 3.77, 1.0, 1e30])
    assert named[:3].tolist() == [1, 1, 1] and named[3] == 0
    # Each contact costs it some delta times beta of its speed: it is followed, and it never arrives.
    assert named[4] == -1


def test_rest_on_the_wall_is_no_orbit():
    assert find_periodic_orbit(Oscillator(), 0.3, 1e-3, 1, 5.5) is None


@pytest.mark.parametrize("damping", [0.515615615615616, 0.515815815815816])
def test_a_chaotic_attractor_of_narrow_bands_is_found_once(damping):
    # A transient of some 30,000 impacts passes by the bands: taken for an attractor of its own it would hide them.
    attractors, solution = catalogue_of(Oscillator(damping=damping), iterations=1499)
    assert [attractor.name for attractor in attractors].count("chaotic") <= 2
    assert (solution >= 0).all()
