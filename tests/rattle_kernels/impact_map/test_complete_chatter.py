"""Complete chatter: what is shown to come to rest does, within its bounds; what is not is followed to the same end."""

import math

import numpy as np
import pytest

from rattle_kernels.impact_map.arc_flights import next_loose_contact
from rattle_kernels.impact_map.complete_chatter import accumulates, comes_to_rest
from rattle_kernels.model.arcs import arcs_of, rest_acceleration_over_phases, time_to_release
from rattle_kernels.numerics.jit import kernel
from tests.rattle_kernels.impact_map.test_loose_map import random_machine


@kernel
def _is_sure(oscillator, wall, phase, speed):
    return comes_to_rest(oscillator, wall, phase, speed)


@kernel
def _accumulates(oscillator, wall, phase, speed):
    return accumulates(oscillator, wall, phase, speed)


@kernel
def _bounce(oscillator, wall, phase, velocity):
    return next_loose_contact(oscillator, wall, phase, velocity)


def _departures(seed, count=40):
    oscillator, rng, scale = random_machine(seed, most_orders=2)
    for _ in range(count):
        yield oscillator, rng.choice([-1.0, 1.0]), rng.random(), scale * 10.0 ** rng.uniform(-6.0, 0.0)


@pytest.mark.parametrize("seed", range(12))
def test_bounces_that_are_sure_to_come_to_rest_keep_their_bounds(seed):
    sure = 0
    for oscillator, wall, phase, speed in _departures(seed):
        if not _is_sure(oscillator, wall, phase, speed):
            continue
        sure += 1
        arcs, begin, first = arcs_of(oscillator), phase, speed
        pressing = wall * float(rest_acceleration_over_phases(oscillator).at(phase))
        least, elapsed = 0.5 * pressing, 0.0
        shrink = oscillator.restitution * math.sqrt(1.0 + 3.0 * arcs.change * first / least**2)
        while speed > 1e-12 * first:
            end = _bounce(oscillator, wall, phase, -wall * speed)
            assert end.found and end.wall == wall
            # 1e-9 is what the kernel keeps for rounding.
            assert end.duration <= 3.0 * speed / least * (1.0 + 1e-9)
            phase, after = end.phase % 1.0, oscillator.restitution * abs(end.velocity)
            assert after <= shrink * speed * (1.0 + 1e-9)
            speed, elapsed = after, elapsed + end.duration
        assert elapsed <= 3.0 * first / (least * (1.0 - shrink)) * (1.0 + 1e-9)
        assert elapsed < time_to_release(arcs, begin)
    assert sure > 0 or oscillator.restitution == 1.0


@pytest.mark.parametrize("seed", range(12))
def test_bounces_accumulate_where_following_them_ends_before_the_arc(seed):
    for oscillator, wall, phase, speed in _departures(seed):
        told, first = _accumulates(oscillator, wall, phase, speed), speed
        arcs, left = arcs_of(oscillator), math.inf
        felt = rest_acceleration_over_phases(oscillator)
        rests = wall * float(felt.at(phase)) > 0.0 and oscillator.restitution < 1.0
        if rests:
            left = time_to_release(arcs, phase)
        # Bounces of 1e-12 of the first add up to nothing, but for an arc that ends within as little.
        while rests and speed > 1e-12 * first:
            end = _bounce(oscillator, wall, phase, -wall * speed)
            left -= end.duration
            rests = end.wall == wall and left > 0.0
            phase, speed = end.phase % 1.0, oscillator.restitution * abs(end.velocity)
        assert told == rests


def test_elastic_impacts_never_come_to_rest():
    oscillator, *_ = random_machine(0)
    elastic = oscillator._replace(restitution=1.0)
    for phase in np.arange(20) / 20:
        assert not any(_accumulates(elastic, wall, phase, 1e-9) for wall in (-1.0, 1.0))
