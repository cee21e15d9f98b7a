"""Chaos that does not hold what is on it is not called chaotic, however long its transients."""

import math

import numpy as np
import pytest

from rattle_kernels import AttractorKind, CellGrid, Oscillator, find_attractors, map_points, name_solutions
from rattle_kernels.chaotic_leak import chaotic_leak
from tests.rattle_kernels.machine import MACHINE


def catalogue_of(oscillator, iterations, speed=7.0, count=200):
    rng = np.random.default_rng(8)
    grid = CellGrid(velocity_stop=speed)
    landed = map_points(oscillator, grid, iterations, rng.random(count), speed * (1.0 - rng.random(count)))
    there = np.isfinite(landed.landing_time)
    t, v = landed.landing_time[there], landed.landing_velocity[there]
    catalogue = find_attractors(oscillator, t, v)
    return catalogue, name_solutions(oscillator, catalogue, t, v)


# Where motions end that leave it, and its mean life as docs/paper.md has it.
@pytest.mark.parametrize(("damping", "end", "life"), [(0.527, "P(3,3,2)", 1e5), (0.65, "P(3,3,1)", 1.04e5)])
def test_a_transient_of_1e5_impacts_is_one_and_its_end_is_in_the_catalogue(damping, end, life):
    oscillator = Oscillator(damping=damping)
    catalogue, places = catalogue_of(oscillator, 1499)
    transient = next(each for each in catalogue if each.kind == AttractorKind.CHAOTIC_TRANSIENT)
    assert "chaotic" not in {each.name for each in catalogue} and (places >= 0).all()
    others = [each for each in catalogue if each.kind != AttractorKind.CHAOTIC_TRANSIENT]
    assert end in {each.name for each in others}
    assert life / 2.0 < chaotic_leak(oscillator, transient, others).mean_life < 2.0 * life
    # An empty catalogue knows no end: it is found.
    assert end in {each.name for each in chaotic_leak(oscillator, transient, others[:1]).orbits}


@pytest.mark.parametrize("damping", [0.6, 0.625, 0.675])
def test_a_chaotic_attractor_holds_what_is_on_it(damping):
    oscillator = Oscillator(damping=damping)
    catalogue, _ = catalogue_of(oscillator, 1499)
    assert catalogue[-1].name == "chaotic"
    assert math.isinf(chaotic_leak(oscillator, catalogue[-1], catalogue[:-1]).mean_life)


def test_at_the_machines_damping_nothing_is_called_chaotic_after_too_few_impacts():
    catalogue, _ = catalogue_of(MACHINE, 1499, 12.0 * MACHINE.damping, 64)
    assert "chaotic" not in {each.name for each in catalogue}
