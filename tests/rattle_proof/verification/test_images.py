"""Images by the judge's balls: against reference tables, the kernels' P, and the kernels' enclosures."""

import numpy as np
import pytest
from flint import arb, ctx

from rattle_kernels import next_impacts
from rattle_proof.enclosures.impact import LOST, enclose_images
from rattle_proof.enclosures.machine import machine_of
from rattle_proof.verification.impact import image
from rattle_proof.verification.machine import Machine
from rattle_proof.verification.targets.quiet import acceleration_at_rest
from tests.rattle_kernels.reference import entries, oscillator_of
from tests.rattle_proof.enclosures.machines import OSCILLATORS, boxes_of_departures, departures_in


@pytest.fixture(autouse=True)
def digits():
    before = ctx.prec
    ctx.prec = 200
    yield
    ctx.prec = before


def exactly(oscillator):
    """The judge's machine for one oscillator."""
    waves = [(1.0, oscillator.eccentricity, 0.0), *oscillator.harmonics]
    each = (oscillator.damping, oscillator.half_backlash, oscillator.restitution)
    machine = Machine(*((value, value) for value in each), [(n, a, a, phase, phase) for n, a, phase in waves])
    acceleration_at_rest(machine)
    return machine


def image_of(machine, t, v):
    return image(machine, arb(t), arb(v), arb(t), arb(v))


def spread(low, high):
    return arb(float(low)).union(arb(float(high)))


@pytest.mark.parametrize("category", ["random", "near_graze"])
def test_tables_of_reference_lie_within_balls_of_thirty_digits(category):
    chosen = [entry for entry in entries("map_impacting.json") if entry["category"] == category][:10]
    assert len(chosen) == 10
    for entry in chosen:
        found = image_of(exactly(oscillator_of(entry)), float(entry["t0"]), float(entry["v0"]))
        printed = arb(0, 1e-25)
        assert found.all_t.rad() < 1e-25 and found.all_v.rad() < 1e-25
        assert (found.all_t - arb(entry["t1"]) + printed).contains_integer()
        assert (found.all_v - arb(entry["v1"]) + printed).contains(0)


@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_images_of_boxes_hold_the_kernels_images_of_their_points(oscillator):
    ctx.prec = 64
    random = np.random.default_rng(3)
    machine, boxes = exactly(oscillator), boxes_of_departures(oscillator, 80, random)
    t, v = departures_in(boxes, random)
    impacts = next_impacts(oscillator, t, v)
    tried = 0
    for k, (left, right, low, high) in enumerate(boxes):
        all_t, all_v = spread(left, right), spread(low, high)
        found = image(machine, all_t.mid(), all_v.mid(), all_t, all_v)
        if found is None:
            continue
        tried += 1
        # The kernels' own rounding comes on top.
        rounding = arb(0, 1e-9)
        assert (found.all_v + rounding).contains(arb(float(impacts.v[k]))), boxes[k]
        off = found.all_t + rounding - arb(float(impacts.t[k]))
        assert off.contains_integer(), boxes[k]
    assert tried > len(boxes) / 3


@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_enclosures_of_the_kernels_hold_images_by_balls_of_200_bits(oscillator):
    random = np.random.default_rng(4)
    boxes, machine = boxes_of_departures(oscillator, 80, random), exactly(oscillator)
    enclosed = enclose_images(machine_of(oscillator), oscillator, boxes)
    t, v = departures_in(boxes, random)
    tried = 0
    for k in np.flatnonzero(enclosed.states != LOST):
        found, (left, right, low, high) = image_of(machine, float(t[k]), float(v[k])), enclosed.hulls[k]
        if found is None:
            continue
        tried += 1
        assert spread(left, right).overlaps(found.all_t) and spread(low, high).overlaps(found.all_v), boxes[k]
        assert found.all_t.rad() < 1e-20 and found.all_v.rad() < 1e-20
    assert tried > len(boxes) / 3
