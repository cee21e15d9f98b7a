"""Low bounces as the judge encloses them, against bounces that are integrated in floating point numbers."""

import math

import numpy as np
import pytest
from flint import arb, ctx
from scipy.optimize import brentq

from rattle_proof.verification.machine import Machine
from rattle_proof.verification.targets import quiet
from rattle_proof.verification.targets.low_bounces import low_bounces
from rattle_proof.verification.targets.quiet import acceleration_at_rest

DAMPING, WAVES = 0.6, ((1.0, 0.1, 0.0), (2.0, 0.013, 0.3), (7.0, 0.0007, 0.85))
NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)
TIMES = np.linspace(0.0, 1.0, 40, endpoint=False).tolist()


@pytest.fixture(autouse=True)
def digits():
    before = ctx.prec
    ctx.prec = 80
    yield
    ctx.prec = before


def machine(restitution):
    return Machine((DAMPING,) * 2, (0.5, 0.5), (restitution,) * 2, [(n, a, a, phase, phase) for n, a, phase in WAVES])


def felt(t):
    """The right side of Eq. (4)."""
    total = 4 * math.pi * DAMPING
    for order, amplitude, phase in WAVES:
        speed, angle = 2 * math.pi * order, 2 * math.pi * (order * t + phase)
        total = total - amplitude * speed * (speed * np.cos(angle) + DAMPING * np.sin(angle))
    return total


def bounce(t, tau):
    """Speeds of departure and of arrival of the bounce that lasts tau."""
    left = 0.5 * tau * (1.0 - NODES)  # of the bounce, at the nodes
    forces = 0.5 * tau * WEIGHTS * felt(t + tau - left)
    v = (forces * -np.expm1(-DAMPING * left)).sum() / -math.expm1(-DAMPING * tau)
    return v, (forces * np.exp(-DAMPING * left)).sum() - v * math.exp(-DAMPING * tau)


def growth(t, tau, restitution):
    """How much the action v^3/a grows."""
    v, arrival = bounce(t, tau)
    return (restitution * arrival / v) ** 3 * felt(t) / felt(t + tau) - 1.0


@pytest.mark.parametrize("tau", [0.003, 0.02, 0.04])
def test_speeds_and_actions(tau):
    for t in TIMES:
        found, (v, _) = low_bounces(machine(1.0), arb(t), arb(tau)), bounce(t, tau)
        for told, right in ((found.speed, v), (found.action, v**3 / felt(t))):
            assert abs(float(told.mid()) - right) <= float(told.rad()) + 1e-13 * right
            assert float(told.rad()) < 1e-9 * right


# With a restitution of 10 no action falls by the test that counts it: the other is left, which is that of elastic ones.
@pytest.mark.parametrize(("told", "restitution"), [(1.0, 1.0), (10.0, 1.0), (0.98, 0.98), (0.95, 0.95)])
def test_an_action_falls_up_to_the_durations_at_which_it_does_not(told, restitution):
    durations, tried = np.linspace(0.004, 0.08, 39), 0
    for t in TIMES:
        grown = [growth(t, tau, restitution) for tau in durations]
        for tau, one, other in zip(durations, grown, grown[1:], strict=False):
            if one * other < 0.0:
                edge = brentq(lambda at, t=t: growth(t, at, restitution), tau, tau + 0.002, xtol=1e-12)
                tried += 1
                for near in (0.99 * edge, 1.01 * edge):
                    falls = low_bounces(machine(told), arb(t), arb(near)).falls
                    assert falls == (growth(t, near, restitution) < 0.0), (t, near)
    assert tried


def test_at_longer_bounces_their_images_say_whether_the_action_falls():
    elastic, told = machine(1.0), []
    assert acceleration_at_rest(elastic).holds
    for t in TIMES:
        for tau in (0.1, 0.2):
            v = bounce(t, tau)[0]
            assert 0.0 < v and v * v < 2.0 * elastic.least_acceleration * float(elastic.gap.lower()), "-beta is not met"
            told.append(quiet._falls(elastic, arb(t), arb(v)))
            assert told[-1] == (growth(t, tau, 1.0) < 0.0), (t, tau)
    assert set(told) == {True, False}


def test_a_box_falls_only_where_every_bounce_of_it_does():
    random, told = np.random.default_rng(1), set()
    for _ in range(60):
        t, tau = random.uniform(0.0, 1.0), random.uniform(0.0, 0.1)
        times, durations = arb(t).union(arb(t + 0.004)), arb(tau).union(arb(tau + 0.004))
        found = low_bounces(machine(1.0), times, durations)
        told.add(found.falls)
        corners = [(t + 0.004 * x, tau + 0.004 * y) for x in (0.0, 0.5, 1.0) for y in (0.01, 0.5, 1.0)]
        assert not found.falls or all(growth(*corner, 1.0) < 0.0 for corner in corners)
        assert all(found.speed.contains(arb(bounce(*corner)[0])) for corner in corners)
    assert told == {True, False}
