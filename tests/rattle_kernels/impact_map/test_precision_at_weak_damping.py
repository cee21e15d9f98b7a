"""Double precision suffices at the machine's damping, where a turn contracts by 3e-4 and thousands go by unsettled."""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from scipy.stats import chi2, norm

from rattle_kernels import CellGrid, Oscillator, map_points, next_impacts
from rattle_kernels.attractors.trap_table import build_trap_table
from rattle_kernels.lanes.traps import potential_in
from tests.rattle_kernels.impact_map.extended_precision import departures, run_extended
from tests.rattle_kernels.impact_map.rounding import energy_rounding
from tests.rattle_kernels.impact_map.scalar_map import apply
from tests.rattle_kernels.machine import MACHINE, attractor_of, orbit_near
from tests.rattle_kernels.reference import low_bounces

# The longest chain of roundings of a flight, counted in `lane_flight`: two of the phase's sine, two of the polynomials
# in the duration, eight of the displacement, two of the step, two of the sums that give phase and velocity.
ROUNDINGS_OF_A_FLIGHT = 16
EVERY = 5000


def by_lanes(t, v, impacts, oscillator=MACHINE):
    """Departure after so many impacts by the kernel that maps cells."""
    landed = next_impacts(oscillator, t, v, impacts)
    return float(landed.t), float(landed.v)


def by_careful_path(t, v, impacts):
    """The same by the scalar kernel."""
    phase, speed = apply(MACHINE, [t], [v], impacts)
    return float(phase[0]), float(speed[0])


def slowed_by(ulps):
    """The lanes with a speed too low by so many ulps after each impact."""

    def slowed(t, v, impacts):
        for _ in range(impacts):
            t, v = by_lanes(t, v, 1)
            v -= ulps * np.spacing(v)
        return t, v

    return slowed


def overdamped(t, v, impacts):
    """The lanes with a damping too high by the part 1e-12."""
    return by_lanes(t, v, impacts, MACHINE._replace(damping=MACHINE.damping * (1.0 + 1e-12)))


def energy_errors(fly, t, v, exact_speeds):
    """Relative error of v^2 at every 5000th impact."""
    errors = []
    for exact in exact_speeds:
        t, v = fly(t, v, EVERY)
        errors.append(abs(float((Fraction(v) / exact) ** 2 - 1)))
    return np.array(errors)


def test_the_map_errs_by_its_roundings_alone():
    rng = np.random.default_rng(3)
    starts = np.stack([rng.random(150), rng.random(150) * 12.0 * MACHINE.damping], axis=1)
    once = next_impacts(MACHINE, *starts.T)
    shift = Fraction(1, 2**60)
    for (t, v), phase, speed, lower_impacts in zip(starts, once.t, once.v, once.lower_impacts, strict=True):
        exact_t, exact_v, duration = run_extended(MACHINE, t, v, 1)
        by_t, by_v = (
            [abs(float((there - here) / shift)) for there, here in zip(moved[:2], (exact_t, exact_v), strict=True)]
            for moved in (
                run_extended(MACHINE, Fraction(t) + shift, v, 1),
                run_extended(MACHINE, t, Fraction(v) + shift, 1),
            )
        )
        # A rounding of the start, carried on by the map, and one of what comes out.
        roundings = 2.0**-53 * ROUNDINGS_OF_A_FLIGHT * (1 + lower_impacts)
        allowed_t = roundings * (by_t[0] + by_v[0] * v + float(duration))
        allowed_v = roundings * (by_t[1] + by_v[1] * v + float(exact_v))
        apart = Fraction(phase) - exact_t
        assert abs(float(apart - round(apart))) < allowed_t < 1e-13
        assert abs(float(Fraction(speed) - exact_v)) < allowed_v < 1e-13 * float(exact_v)


@pytest.mark.parametrize(("speed", "period"), [(2.475, 2), (2.0 * np.pi, 1)])
def test_motions_sink_onto_orbits_as_their_damping_says(speed, period):
    orbit = orbit_near(speed, period)
    traps = build_trap_table(MACHINE, (attractor_of(orbit),))
    t, v = orbit.t[0] + 2e-3, orbit.v[0] * (1.0 + 1e-3)
    *_, elapsed = run_extended(MACHINE, t, v, 1500 * period)
    fall = np.log(potential_in(traps, 0, t, v) / potential_in(traps, 0, *by_lanes(t, v, 1500 * period)))
    # V falls by delta times the periods passed, to the order of its own amplitude.
    assert fall == pytest.approx(MACHINE.damping * float(elapsed), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "period"), [(2.0 * np.pi, 1), (2.475, 2)], ids=["onto P(1,1,0)", "onto P(1,2,0)"])
def test_energy_onto_orbits_errs_by_rounding_alone_along_1e5_impacts(speed, period):
    orbit = orbit_near(speed, period)
    t, v = float(orbit.t[0] + 2e-3), float(orbit.v[0] * (1.0 + 1e-3))
    path = [(t, v, 0), *itertools.islice(departures(MACHINE, t, v), 20 * EVERY)]
    checkpoints = range(EVERY, 20 * EVERY + 1, EVERY)
    errors = energy_errors(by_lanes, t, v, [path[impact][1] for impact in checkpoints])
    assert (errors < energy_rounding(MACHINE, path, checkpoints)).all()
    assert path[-1][2] > 20 * EVERY / period - 1


@pytest.mark.parametrize("fly", [by_lanes, by_careful_path])
def test_energy_of_low_bounces_errs_by_rounding_alone_along_1e5_impacts(fly):
    start, exact = low_bounces(MACHINE)
    errors = energy_errors(fly, *start, [Fraction(checkpoint["v"]) for checkpoint in exact])
    assert (errors < [checkpoint["rounding"] for checkpoint in exact]).all()


@pytest.mark.parametrize("fly", [slowed_by(1), slowed_by(4), overdamped], ids=["an ulp", "1e-15", "damping"])
def test_energy_of_low_bounces_tells_what_is_wrong_by_more_than_rounding(fly):
    start, exact = low_bounces(MACHINE)
    errors = energy_errors(fly, *start, [Fraction(exact[0]["v"])])
    assert errors[0] > exact[0]["rounding"]


def test_whole_numbers_reach_what_300_bits_do():
    start, exact = low_bounces(MACHINE)
    path = [(*start, 0), *itertools.islice(departures(MACHINE, *start), EVERY)]
    phase, speed, elapsed = path[-1]
    # An impact loses some 16 times 2^-128 of the displacement, 4 pi/(delta v) times that of the phase: 1e-29, where
    # half an ulp is 3e-17 and the file's bound 2e-10. That makes 1e-22.
    assert abs(float((speed / Fraction(exact[0]["v"])) ** 2 - 1)) < 1e-21
    assert abs(float(phase - Fraction(exact[0]["t"]))) < 1e-21
    assert float(elapsed) == pytest.approx(exact[0]["elapsed"], abs=5e-7)  # as printed
    assert energy_rounding(MACHINE, path, [EVERY])[0] == pytest.approx(exact[0]["rounding"], rel=2.5e-3)  # as printed


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
    # but not where they may go: a chi-square of what all three have in common, within five standard errors.
    expected = counts[:, common].mean(axis=0)
    assert ((counts[:, common] - expected) ** 2 / expected).sum() < chi2.isf(norm.sf(5.0), 2 * common.sum())
