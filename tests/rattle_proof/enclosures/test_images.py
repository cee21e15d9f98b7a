"""Enclosures of P and DP hold the exact images of the departures in a box (balls of 256 bits)."""

import numpy as np
import pytest
from flint import arb

from rattle_proof.enclosures.impact import LOST, PROVEN, STRADDLES, enclose_images
from tests.rattle_proof.enclosures.exact_flights import ExactMap
from tests.rattle_proof.enclosures.machines import (
    OSCILLATORS,
    boxes_of_departures,
    departures_in,
    machine_and_some,
    some_within,
    tolerances_of,
)

SLOW = pytest.mark.slow


def _between(low, high):
    return arb(low).union(arb(high))


def _off(boxes, images, oscillator, random):
    """Boxes with a departure whose image lies outside of its enclosure, or with two that DP does not explain."""
    exact, off = ExactMap(oscillator), []
    ones, others = departures_in(boxes, random), departures_in(boxes, random)
    for k in np.flatnonzero(images.states != LOST):
        (t, v), hull = (ones[0][k], ones[1][k]), images.hulls[k]
        one = exact.image(t, v)
        held = one.t >= hull[0] and one.t <= hull[1] and one.v >= hull[2] and one.v <= hull[3]
        if held and images.states[k] == PROVEN:
            dt, dv = arb(others[0][k]) - arb(t), arb(others[1][k]) - arb(v)
            other = exact.image(others[0][k], others[1][k])
            slope = [[_between(*element) for element in row] for row in images.slopes[k]]
            held = all(
                (change - by_t * dt - by_v * dv).contains(0)
                for change, (by_t, by_v) in zip((other.t - one.t, other.v - one.v), slope, strict=True)
            )
        if not held:
            off.append((k, boxes[k], t, v, hull))
    return off


@pytest.mark.parametrize("boxes", [1_500, pytest.param(10_000, marks=[SLOW, pytest.mark.timeout(1800)])])
@pytest.mark.parametrize("part", [0.0, 1e-3, 0.02])
@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_no_image_lies_outside_and_no_difference(oscillator, part, boxes):
    random = np.random.default_rng(boxes)
    machine, some = machine_and_some(oscillator, part, random)
    tried = boxes_of_departures(oscillator, boxes, random)
    images = enclose_images(machine, oscillator, tried)
    others = [some_within(oscillator, tolerances_of(oscillator, part), random) for _ in range(3)] if part else []
    for each in (some, *others):
        assert _off(tried, images, each, random) == []
    # What is lost proves nothing: the rest was looked at.
    assert np.bincount(images.states, minlength=3)[PROVEN] > boxes / 5
    # Of a machine within wide tolerances, flights near grazing are lost.
    assert part > 0.0 or np.bincount(images.states, minlength=3)[STRADDLES] > 0
