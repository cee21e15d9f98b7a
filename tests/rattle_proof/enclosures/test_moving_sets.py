"""Sets that are followed for some impacts hold the exact images of their departures, as boxes, strips and trails."""

from fractions import Fraction

import numpy as np
import pytest
from flint import arb

from rattle_kernels import largest_grazing_speed
from rattle_kernels.numerics.jit import kernel_as_written
from rattle_proof.enclosures.flight import Box
from rattle_proof.enclosures.growth import IMPACTS, empty_trails, follow_boxes
from rattle_proof.enclosures.interval import Interval, point
from rattle_proof.enclosures.lattice import empty_lattice
from rattle_proof.enclosures.moving_set import _without_turns, advance, set_out, strip_of
from rattle_proof.enclosures.targets import NO_QUIET, NOTHING_KNOWN, Targets
from rattle_proof.enclosures.windows import NO_WINDOWS
from tests.rattle_proof.enclosures.exact_flights import ExactMap
from tests.rattle_proof.enclosures.machines import OSCILLATORS, departures_in, machine_and_some

_BOXES = 100
_TIMES = 1000


@kernel_as_written
def _strips(machine, oscillator, boxes, strips):
    for k in range(boxes.shape[0]):
        moving = set_out(Box(Interval(boxes[k, 0], boxes[k, 1]), Interval(boxes[k, 2], boxes[k, 3])), False)
        for n in range(strips.shape[1]):
            proven, moving = advance(machine, oscillator, moving)
            if not proven:
                break
            strip = strip_of(moving)
            strips[k, n, 0], strips[k, n, 1] = strip.t
            strips[k, n, 2], strips[k, n, 3] = strip.v
            strips[k, n, 4], strips[k, n, 5] = strip.offset
            strips[k, n, 6] = strip.slope


def _images(exact, t, v, impacts):
    place = arb(t), arb(v)
    for _ in range(impacts):
        place = exact.image(place[0].mid(), place[1].mid())
        yield place


def _off(exact, boxes, strips, random, height=1.0, turns=False):
    """Departures whose images lie outside of strips, which have speeds in units of `height`."""
    off, looked_at = [], 0
    for t, v, strip in zip(*departures_in(boxes, random), strips, strict=True):
        for (time, speed), (early, late, low, high, least, most, slope) in zip(
            _images(exact, t, v, strips.shape[1]), strip, strict=True
        ):
            if np.isnan(early):
                break
            looked_at += 1
            # Whole turns were taken off.
            time -= round(float(time) - 0.5 * (early + late))
            speed = speed / height
            offset = speed - arb(slope) * time
            held = time >= early and time <= late and speed >= low and speed <= high
            if not (held and offset >= least and offset <= most):
                off.append((t, v, early, late, low, high, least, most, slope))
    return off, looked_at


@pytest.mark.parametrize("part", [0.0, 1e-4, 0.1])
@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_strips_hold_images(oscillator, part):
    random = np.random.default_rng(6)
    machine, some = machine_and_some(oscillator, part, random)
    t, v = random.random(_BOXES), random.uniform(0.2, 1.2, _BOXES) * largest_grazing_speed(oscillator)
    size = 10.0 ** random.uniform(-8.0, -3.0, (2, _BOXES))
    boxes = np.stack([t - size[0], t + size[0], v * (1.0 - size[1]), v * (1.0 + size[1])], axis=1)
    strips = np.full((_BOXES, 3, 7), np.nan)
    _strips(machine, oscillator, boxes, strips)
    off, looked_at = _off(ExactMap(some), boxes, strips, random)
    assert off == []
    assert looked_at > _BOXES / 4


def test_trails_hold_images_in_single_precision():
    oscillator, random = OSCILLATORS[0], np.random.default_rng(7)
    machine, _ = machine_and_some(oscillator, 0.0, random)
    # Boxes so small that single precision is coarse beside the strips.
    lattice = empty_lattice(0.0, 2.0**-13, 2**16, 2.0**-20)
    lattice = lattice._replace(first=2**21)
    targets = Targets(lattice, NOTHING_KNOWN, np.empty((0, 8)), NO_WINDOWS, NO_QUIET, NOTHING_KNOWN)
    boxes = np.stack([random.integers(0, n, _BOXES) for n in lattice.ends.shape], axis=1).astype(np.int32)
    ends, trails = np.zeros(_BOXES, np.uint16), empty_trails(_BOXES)
    follow_boxes(machine, oscillator, targets, boxes, ends, trails)
    assert not ends.any() and trails.shape == (_BOXES, IMPACTS, 7)
    t, v = boxes[:, 1] / 2**16, (2**21 + boxes[:, 0]) * 2.0**-20
    sides = np.stack([t, t + 2.0**-16, v, v + 2.0**-20], axis=1)
    strips = trails.astype(np.float64)
    # Rows count from the first.
    strips[..., 2:6] += 2**21
    off, looked_at = _off(ExactMap(oscillator), sides, strips, random, height=2.0**-20)
    assert off == []
    assert looked_at > _BOXES


@kernel_as_written
def _moved_by_turns(times, moved):
    for k in range(times.size):
        moving = _without_turns(set_out(Box(point(times[k]), point(1.0)), False))
        moved[k, 0] = moving.t
        moved[k, 1], moved[k, 2] = moving.all.t


def test_whole_turns_are_taken_off_without_rounding():
    """A disc around an orbit near phase 0 has departures before it: to add a turn to them would round."""
    random = np.random.default_rng(8)
    times = np.concatenate([random.uniform(0.0, 3.0, _TIMES), -(10.0 ** random.uniform(-18.0, -0.1, _TIMES))])
    moved = np.empty((times.size, 3))
    _moved_by_turns(times, moved)
    assert moved[:, 0].max() < 1.0
    for time, (middle, early, late) in zip(times.tolist(), moved.tolist(), strict=True):
        turns = Fraction(time) - Fraction(middle)
        assert turns.denominator == 1 and turns >= 0
        assert Fraction(early) <= Fraction(time) - turns <= Fraction(late)
