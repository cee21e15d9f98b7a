"""Turning points of boxes, and their slow impacts with -beta, hold those of exact flights (balls of 256 bits)."""

import numpy as np
import pytest

from rattle_kernels.impact_map.flights import fly_over
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_proof.enclosures.flight import Box
from rattle_proof.enclosures.impact import _slow_impacts, downwards
from rattle_proof.enclosures.interval import Interval, point
from rattle_proof.enclosures.turning_point import turning_points
from tests.rattle_proof.enclosures.exact_flights import ExactMap, Flight
from tests.rattle_proof.enclosures.machines import OSCILLATORS, boxes_of_departures, departures_in, machine_and_some

_BOXES = 300


@inlined_as_written
def _a_quarter_into(a):
    return point(min(max(0.75 * a.low + 0.25 * a.high, a.low), a.high))


@kernel_as_written
def _enclose(machine, oscillator, boxes, turns, slow):
    for k in range(boxes.shape[0]):
        box = downwards(Box(Interval(boxes[k, 0], boxes[k, 1]), Interval(boxes[k, 2], boxes[k, 3])))
        # Not in the middle: else the sign of a slope would not matter.
        centre = Box(_a_quarter_into(box.t), _a_quarter_into(box.w))
        over = fly_over(oscillator, centre.t.low, centre.w.low)
        turn = turning_points(machine, centre, box, 0.5 * over.duration)
        if not turn.found:
            continue
        turns[k, 0], turns[k, 1] = turn.t
        turns[k, 2], turns[k, 3] = turn.height
        met = _slow_impacts(machine, box, turn)
        slow[k, 0], slow[k, 1] = met.t
        slow[k, 2], slow[k, 3] = met.w


def _tried(oscillator, part):
    """Boxes with their enclosures, a departure in each, and the map of a machine within."""
    random = np.random.default_rng(12)
    machine, some = machine_and_some(oscillator, part, random)
    boxes = boxes_of_departures(oscillator, _BOXES, random)
    turns, slow = np.full((2, _BOXES, 4), np.nan)
    _enclose(machine, oscillator, boxes, turns, slow)
    found = np.isfinite(turns[:, 0])
    assert np.count_nonzero(found) > _BOXES / 3
    t, v = departures_in(boxes, random)
    return ExactMap(some), zip(t[found], v[found], turns[found], slow[found], strict=True)


def _lies_in(box, t, v):
    return bool(t >= box[0]) and bool(t <= box[1]) and bool(v >= box[2]) and bool(v <= box[3])


@pytest.mark.parametrize("part", [0.0, 1e-3])
@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_turning_points_of_a_box_hold_those_of_its_departures(oscillator, part):
    exact, tried = _tried(oscillator, part)
    for t, v, turns, _ in tried:
        flight = Flight(exact, t, -v)
        tau, height = exact.turning_point(flight, exact.over(t, v))
        assert _lies_in(turns, t + tau, height), (t, v)


@pytest.mark.parametrize("part", [0.0, 1e-3])
@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_impacts_with_the_lower_wall_are_no_earlier_and_no_faster_than_is_said(oscillator, part):
    exact, tried = _tried(oscillator, part)
    met = 0
    for t, v, _, slow in tried:
        lower = exact.lower_impact(t, v)
        if lower is not None:
            met += 1
            assert _lies_in(slow, *lower), (t, v)
    assert met > _BOXES / 30
