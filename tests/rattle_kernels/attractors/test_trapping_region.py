"""Traps: what enters one is finished, and lands where the plain loop lands."""

import numpy as np
import pytest

from rattle_kernels import CellGrid, Oscillator, check_domain, find_attractors, map_points
from rattle_kernels.attractors.trap_table import build_trap_table
from rattle_kernels.attractors.trapping_region import find_trap
from rattle_kernels.cell_mapping.iterations import settled_iterations
from rattle_kernels.lanes.run import next_impacts, run_lanes
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.lanes.traps import potential_in
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit
from tests.rattle_kernels.machine import MACHINE, attractor_of, orbit_near

ROAD = [Oscillator(0.06, 0.01, 0.06), Oscillator(6e-3, 1e-3, 6e-3), Oscillator(6e-3, 1e-3, 6e-3, stiffness=1000.0)]
_TWO = ((2, 1e-4, 0.3), (3, 3e-5, 0.1))
WIDER = [
    Oscillator(6e-3, 1e-3, 6e-3, restitution=0.9995),
    pytest.param(Oscillator(6e-3, 8e-4, 6e-3, restitution=0.999, harmonics=_TWO), marks=pytest.mark.slow),
    pytest.param(Oscillator(6e-3, 1e-3, 6e-3, harmonics=_TWO), marks=pytest.mark.slow),
    pytest.param(Oscillator(6e-3, 1e-3, 6e-3, 1000.0, contact_damping=1e-4, harmonics=_TWO), marks=pytest.mark.slow),
]
ITERATIONS = 60_013


def points(oscillator, count):
    rng = np.random.default_rng(7)
    return rng.random(count), rng.random(count) * 12.0 * oscillator.damping


def known_attractors(oscillator, count=150):
    settled, _ = run_lanes(oscillator, *points(oscillator, count), ITERATIONS, shortcuts=True)
    left = np.isfinite(settled.t)
    return find_attractors(oscillator, settled.t[left], settled.v[left])


@pytest.mark.parametrize("oscillator", [*ROAD, *WIDER], ids=str)
def test_images_are_those_of_the_plain_loop(oscillator):
    oscillator = check_domain(oscillator)
    grid = CellGrid(0.0, 1.0, 1000, 0.0, 12.0 * oscillator.damping, 1000)
    traps = build_trap_table(oscillator, known_attractors(oscillator))
    t, v = points(oscillator, 150)
    caught = map_points(oscillator, grid, ITERATIONS, t, v, traps=traps)
    plain = map_points(oscillator, grid, ITERATIONS, t, v, shortcuts=False)
    np.testing.assert_array_equal(caught.image_cell, plain.image_cell)
    apart = caught.landing_time - plain.landing_time
    assert np.nanmax(np.abs(apart - np.rint(apart))) < 1e-8
    assert caught.applications < 0.8 * map_points(oscillator, grid, ITERATIONS, t, v).applications


def test_levels_fall_by_what_impacts_lose_too():
    oscillator = Oscillator(6e-3, 1e-3, 6e-3, restitution=0.9995)
    traps = build_trap_table(oscillator, known_attractors(oscillator))
    assert traps.first.size >= 5
    orbits = [find_periodic_orbit(oscillator, traps.time[first], traps.speed[first], int(period), 0.1)
              for first, period in zip(traps.first, traps.period, strict=True)]  # fmt: skip
    lost = [
        6e-3 * orbit.forcing_periods - 2.0 * (orbit.upper_contacts + orbit.lower_contacts) * np.log(0.9995)
        for orbit in orbits
    ]
    np.testing.assert_allclose(traps.rate, 0.5 * np.array(lost), rtol=1e-9)


@pytest.mark.slow
def test_images_at_the_machines_own_damping_are_those_of_the_plain_loop():
    grid = CellGrid(0.0, 1.0, 1000, 0.0, 12.0 * MACHINE.damping, 1000)
    iterations, (t, v) = settled_iterations(MACHINE.damping), points(MACHINE, 64)
    waited = map_points(MACHINE, grid, iterations, t, v)
    there = np.isfinite(waited.landing_time)
    traps = build_trap_table(
        MACHINE, find_attractors(MACHINE, waited.landing_time[there], waited.landing_velocity[there])
    )
    caught = map_points(MACHINE, grid, iterations, t, v, traps=traps)
    plain = map_points(MACHINE, grid, iterations, t, v, shortcuts=False)
    np.testing.assert_array_equal(caught.image_cell, plain.image_cell)
    assert caught.applications < 0.5 * waited.applications < 0.25 * plain.applications


@pytest.mark.parametrize(("speed", "period"), [(2.0 * np.pi, 1), (2.475, 2)])
def test_traps_at_the_machines_damping_are_wide_and_contract(speed, period):
    orbit = orbit_near(speed, period)
    trap = find_trap(MACHINE, orbit, lane_tables(MACHINE).largest_grazing_speed)
    assert trap.radius > 3e-3
    angles = np.linspace(0.0, 2.0 * np.pi, 333, endpoint=False)
    dt, dv = np.linalg.inv(trap.frame) @ (0.5 * trap.radius * np.array([np.cos(angles), np.sin(angles)]))
    after = next_impacts(MACHINE, orbit.t[0] + dt, orbit.v[0] + dv, 200 * period)
    traps = build_trap_table(MACHINE, (attractor_of(orbit),))
    start, end = (
        np.array([potential_in(traps, 0, *point) for point in zip(t, v, strict=True)])
        for t, v in ((orbit.t[0] + dt, orbit.v[0] + dv), (after.t, after.v))
    )
    # 200 turns: by e^-0.12 in the limit, by e^-0.06 at least.
    assert (end < np.exp(-0.06) * start).all()
    assert (end > np.exp(-0.24) * start).all()


def test_an_orbit_with_real_multipliers_has_no_trap():
    # Between its saddle-node and where its multipliers meet on the real axis.
    oscillator = Oscillator(0.6, 0.0597, 0.6)
    scale = lane_tables(oscillator).largest_grazing_speed
    orbits = (find_periodic_orbit(oscillator, phase, 1.2 * np.pi, 1, scale) for phase in np.linspace(0.0, 0.95, 20))
    orbit = next(found for found in orbits if found is not None and found.attracts)
    assert np.abs(orbit.multipliers.imag).max() == 0.0
    assert find_trap(oscillator, orbit, scale) is None


def test_traps_leave_chaos_and_the_paper_s_images_alone():
    oscillator = Oscillator()
    grid = CellGrid(velocity_cells=200, time_cells=200)
    t, v = points(oscillator, 300)
    traps = build_trap_table(oscillator, known_attractors(oscillator))
    caught = map_points(oscillator, grid, 1499, t, v, traps=traps)
    plain = map_points(oscillator, grid, 1499, t, v)
    np.testing.assert_array_equal(caught.image_cell, plain.image_cell)
