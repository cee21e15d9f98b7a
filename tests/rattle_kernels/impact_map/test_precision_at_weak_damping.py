"""Double precision suffices at the machine's damping, where a turn contracts by 3e-4 and thousands go by unsettled."""

import numpy as np
import pytest

from rattle_kernels import CellGrid, Oscillator, build_trap_table, map_points, next_impacts
from rattle_kernels.lanes.traps import potential_in
from tests.rattle_kernels.impact_map.extended_precision import run_extended
from tests.rattle_kernels.machine import MACHINE, attractor_of, orbit_near


def test_the_map_is_good_to_1e_13():
    rng = np.random.default_rng(3)
    t, v = rng.random(150), rng.random(150) * 12.0 * MACHINE.damping
    once = next_impacts(MACHINE, t, v)
    exact = [run_extended(MACHINE, *point, 1)[:2] for point in zip(t, v, strict=True)]
    phase, speed = (np.array([float(value) for value in values]) for values in zip(*exact, strict=True))
    apart = once.t - phase
    assert np.abs(apart - np.rint(apart)).max() < 1e-13
    assert (np.abs(once.v - speed) / np.maximum(speed, 0.05 * MACHINE.damping)).max() < 1e-13


@pytest.mark.parametrize(("speed", "period"), [(2.475, 2), (2.0 * np.pi, 1)])
def test_energy_after_many_impacts_is_that_of_extended_precision(speed, period):
    orbit, impacts = orbit_near(speed, period), 1500 * period
    traps = build_trap_table(MACHINE, (attractor_of(orbit),))
    t, v = orbit.t[0] + 2e-3, orbit.v[0] * (1.0 + 1e-3)
    double = next_impacts(MACHINE, t, v, impacts)
    _, exact, elapsed = run_extended(MACHINE, t, v, impacts)
    assert float(double.v) ** 2 == pytest.approx(float(exact) ** 2, rel=1e-11)
    # What there is of damping: V falls by delta times the periods passed, to the order of its own amplitude.
    fall = np.log(potential_in(traps, 0, t, v) / potential_in(traps, 0, float(double.t), float(double.v)))
    assert fall == pytest.approx(MACHINE.damping * float(elapsed), rel=0.05)


@pytest.mark.parametrize(
    ("phase", "speed", "period", "worst"),
    [(None, 2.0 * np.pi, 1, 1e-12), (None, 2.475, 2, 1e-11), (0.3, 0.3, 1, 1e-7)],
    ids=["onto P(1,1,0)", "onto P(1,2,0)", "low bounces"],
)
def test_energy_is_that_of_extended_precision_all_along_1e5_impacts(phase, speed, period, worst):
    if phase is None:
        orbit = orbit_near(speed, period)
        t, v = orbit.t[0] + 2e-3, orbit.v[0] * (1.0 + 1e-3)
    else:
        t, v = phase, speed * MACHINE.damping
    exact, elapsed, apart = (t, v), 0.0, []
    for _ in range(20):
        *exact, passed = run_extended(MACHINE, *exact, 5000)
        landed = next_impacts(MACHINE, t, v, 5000)
        t, v, elapsed = float(landed.t), float(landed.v), elapsed + passed
        apart.append(abs(v**2 / float(exact[1]) ** 2 - 1.0))
    # Errors of the phase grow with the number of impacts where nothing pulls the motion back to an orbit.
    assert max(apart) < worst
    assert elapsed > 1000.0


def test_shares_stay_when_the_last_bits_change():
    oscillator = Oscillator(6e-3, 1e-3, 6e-3)
    grid = CellGrid(0.0, 1.0, 1000, 0.0, 12.0 * oscillator.damping, 1000)
    rng = np.random.default_rng(4)
    t, v = rng.random(1500), rng.random(1500) * 12.0 * oscillator.damping
    images = [
        map_points(oscillator, grid, 60_013, t, factor * v).image_cell for factor in (1.0, 1.0 + 2e-16, 1.0 - 2e-16)
    ]
    assert (images[0] != images[1]).mean() > 0.1  # chaotic transients forget their starts,
    cells = np.unique(np.concatenate(images))
    counts = np.array([[(image == cell).sum() for cell in cells] for image in images])
    common = counts.sum(axis=0) > 60
    # but not where they may go: a chi-square of what all three have in common.
    expected = counts[:, common].mean(axis=0)
    assert ((counts[:, common] - expected) ** 2 / expected).sum() < 2.0 * 2 * common.sum() + 20.0
