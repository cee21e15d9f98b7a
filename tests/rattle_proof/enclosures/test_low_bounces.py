"""The change of the action over low bounces, against balls of 512 bits: durations of 1e-9 to a tenth of a period."""

import numpy as np
import pytest
from flint import arb, ctx

from rattle_kernels.numerics.jit import kernel_as_written
from rattle_proof.enclosures.interval import Interval
from rattle_proof.enclosures.low_bounces import low_bounces
from tests.rattle_proof.enclosures.exact_flights import ExactMap
from tests.rattle_proof.enclosures.machines import OSCILLATORS, machine_and_some

_BOXES = 400


@kernel_as_written
def _bounds(machine, boxes, bounds):
    for k in range(boxes.shape[0]):
        each = low_bounces(machine, Interval(boxes[k, 0], boxes[k, 1]), Interval(boxes[k, 2], boxes[k, 3]))
        bounds[k, 0], bounds[k, 1] = each.growth
        bounds[k, 2], bounds[k, 3] = each.gain
        bounds[k, 4], bounds[k, 5] = each.speed
        bounds[k, 6], bounds[k, 7] = each.action


def _exact(exact, t, tau):
    """Growth, gain, speed and action of the bounce from t that lasts tau: its speed solves a linear equation."""
    ctx.prec = 512
    t, tau = arb(t), arb(tau)
    start, rate, _ = exact.error(t)
    end, rate_then, _ = exact.error(t + tau)
    left = (-exact.damping * tau).exp()
    drag = -(4 * arb.pi() * tau + end - start) * exact.damping / (1 - left)
    v = -(drag + 4 * arb.pi() + rate)
    after = 4 * arb.pi() + rate_then + drag * left
    a, b = exact.acceleration(t), exact.acceleration(t + tau)
    growth = ((after / v) ** 3 * a / b - 1) * (b / a) / tau
    return growth, exact.restitution**3 * (after / v) ** 3 - b / a, v, v**3 / a


@pytest.mark.parametrize("part", [0.0, 1e-3])
@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_bounds_hold_exact_bounces(oscillator, part):
    random = np.random.default_rng(5)
    machine, some = machine_and_some(oscillator, part, random)
    longest = min(0.1, 0.5 / oscillator.damping) / max([1.0, *(h.order for h in oscillator.harmonics)])
    tau, t = longest * 10.0 ** random.uniform(-8.0, 0.0, _BOXES), random.random(_BOXES)
    boxes = np.stack([t, t + 10.0 ** random.uniform(-9.0, -1.0, _BOXES), tau, tau], axis=1)
    boxes[:, 3] *= 1.0 + 10.0 ** random.uniform(-9.0, 0.0, _BOXES)
    boxes[::5, 2] = 0.0
    # Single bounces: there the rest of Taylor's series is what is wide.
    boxes[1::4, 1], boxes[1::4, 3] = boxes[1::4, 0], boxes[1::4, 2]
    bounds = np.empty((_BOXES, 8))
    _bounds(machine, boxes, bounds)
    exact = ExactMap(some)
    inside = boxes[:, ::2] + random.choice([0.0, 0.5, 1.0], (_BOXES, 2)) * (boxes[:, 1::2] - boxes[:, ::2])
    for (t, tau), bound in zip(inside, bounds, strict=True):
        for n, value in enumerate(_exact(exact, t, tau) if tau > 0.0 else ()):
            assert value >= bound[2 * n] and value <= bound[2 * n + 1], (n, t, tau)


def test_without_a_duration_a_bounce_grows_as_fast_as_damping_takes_away():
    """S tends to -delta: the box may begin at 0 and still be proven."""
    machine, _ = machine_and_some(OSCILLATORS[0], 0.0, None)
    bounds = np.empty((1, 8))
    _bounds(machine, np.array([[0.3, 0.3, 0.0, 1e-9]]), bounds)
    assert bounds[0, :2] == pytest.approx(-0.6, abs=1e-6)
