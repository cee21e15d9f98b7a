"""The judge's own formulae, against floating point numbers of the equation as the paper prints it; and its parts."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb, ctx

from rattle_proof.verification import work
from rattle_proof.verification.checking import _targets
from rattle_proof.verification.claims import Core, Disc, claims_of
from rattle_proof.verification.flight import Slope
from rattle_proof.verification.machine import Machine, ball
from rattle_proof.verification.targets import discs
from rattle_proof.verification.targets.quiet import COLUMNS, acceleration_at_rest
from rattle_proof.verification.work import Subject

DAMPING, WAVES = 0.6, ((1.0, 0.1, 0.0), (2.0, 0.013, 0.3), (7.0, 0.0007, 0.85))
TIMES = (0.0, 0.11, 0.37, 0.62, 0.93)
MACHINE = Machine((DAMPING,) * 2, (0.5, 0.5), (0.9, 0.9), [(n, a, a, phase, phase) for n, a, phase in WAVES])
# Damping, and amplitude and phase of the second order, within tolerances.
WIDE = Machine((0.59, 0.61), (0.5, 0.5), (0.9, 0.9), [(1.0, 0.1, 0.1, 0.0, 0.0), (2.0, 0.012, 0.014, 0.29, 0.31)])


@pytest.fixture(autouse=True)
def digits():
    before = ctx.prec
    ctx.prec = 80
    yield
    ctx.prec = before


def nth(n, t, damping=DAMPING, waves=WAVES):
    """The n-th derivative of the right side of Eq. (4): each order is a cosine, its derivative i times its speed."""
    sides = 4 * math.pi * damping if n == 0 else 0.0
    for order, amplitude, phase in waves:
        speed = 2 * math.pi * order
        turning = complex(math.cos(speed * t + 2 * math.pi * phase), math.sin(speed * t + 2 * math.pi * phase))
        sides += (amplitude * (-(speed**2) + 1j * damping * speed) * (1j * speed) ** n * turning).real
    return sides


def same(found, told):
    return abs(float(found) - told) <= 1e-12 * (1 + abs(told))


@pytest.mark.parametrize("t", TIMES)
def test_the_acceleration_is_the_right_side_of_equation_4(t):
    printed = 4 * math.pi * 0.6 - 4 * math.pi**2 * 0.1 * math.cos(2 * math.pi * t)
    printed -= 2 * math.pi * 0.6 * 0.1 * math.sin(2 * math.pi * t)
    alone = Machine((0.6, 0.6), (0.6, 0.6), (1.0, 1.0), [(1.0, 0.1, 0.1, 0.0, 0.0)])
    assert same(alone.acceleration(arb(t)), printed) and same(alone.derivatives(arb(t), 1)[0], printed)
    assert same(MACHINE.acceleration(arb(t)), nth(0, t))


@pytest.mark.parametrize("t", TIMES)
def test_derivatives_of_the_acceleration(t):
    found = MACHINE.derivatives(arb(t), 5)
    assert len(found) == 5 and all(same(each, nth(n, t)) for n, each in enumerate(found))


@pytest.mark.parametrize("t", TIMES)
def test_the_error_and_its_derivatives(t):
    turns = [2 * math.pi * (order * t + phase) for order, _, phase in WAVES]
    speeds = [2 * math.pi * order for order, _, _ in WAVES]
    sizes = [amplitude for _, amplitude, _ in WAVES]
    value, rate, bend = MACHINE.error(arb(t))
    assert same(value, sum(a * math.cos(x) for a, x in zip(sizes, turns, strict=True)))
    assert same(rate, -sum(a * s * math.sin(x) for a, s, x in zip(sizes, speeds, turns, strict=True)))
    assert same(bend, -sum(a * s**2 * math.cos(x) for a, s, x in zip(sizes, speeds, turns, strict=True)))


@pytest.mark.parametrize("tau", [1e-9, 0.01, 0.4, 3.0])
def test_the_decay_of_freeplay(tau):
    e, d = MACHINE.decay(arb(tau))
    assert same(e, -math.expm1(-DAMPING * tau) / DAMPING) and same(d, math.exp(-DAMPING * tau))


def test_slopes_multiply_turn_back_and_have_the_norm_of_matrices():
    random = np.random.default_rng(3)
    for _ in range(20):
        one, other = random.normal(size=(2, 2, 2))
        slopes = [Slope(*(arb(each) for each in matrix.ravel())) for matrix in (one, other)]
        product = [float(each) for each in slopes[0].times(slopes[1])]
        assert product == pytest.approx((one @ other).ravel().tolist(), rel=1e-12, abs=1e-12)
        assert float(discs.norm_of(slopes[0])) == pytest.approx(np.linalg.norm(one, 2), rel=1e-12)
        inverse = discs.inverse_of(Disc(1, 1, 0.5, 4.0, tuple(map(tuple, one.tolist())), 0.1))
        assert [float(each) for each in inverse] == pytest.approx(np.linalg.inv(one).ravel().tolist(), rel=1e-9)


def test_balls_hold_every_machine_and_time_within():
    random = np.random.default_rng(0)
    span = 0.05
    for t in TIMES:
        accelerations = WIDE.acceleration(ball(t, t + span)), *WIDE.derivatives(ball(t, t + span), 3)
        decays = WIDE.decay(ball(0.3, 0.4))
        for _ in range(40):
            damping, amplitude = random.uniform(0.59, 0.61), random.uniform(0.012, 0.014)
            waves = ((1.0, 0.1, 0.0), (2.0, amplitude, random.uniform(0.29, 0.31)))
            at, tau = t + span * random.random(), random.uniform(0.3, 0.4)
            told = [nth(n, at, damping, waves) for n in (0, 0, 1, 2)]
            told += [-math.expm1(-damping * tau) / damping, math.exp(-damping * tau)]
            for found, value in zip((*accelerations, *decays), told, strict=True):
                assert found.contains(arb(value)), (t, at)


def test_decays_of_the_least_and_greatest_damping_and_duration_are_held():
    e, d = WIDE.decay(ball(0.3, 0.4))
    least, most = -math.expm1(-0.61 * 0.3) / 0.61, -math.expm1(-0.59 * 0.4) / 0.59
    # A ball of 80 bits has a radius of 30, rounded upwards.
    assert float(e.lower()) == pytest.approx(least, abs=1e-9) and float(e.upper()) == pytest.approx(most, abs=1e-9)
    for damping, tau in ((0.59, 0.3), (0.59, 0.4), (0.61, 0.3), (0.61, 0.4)):
        assert (d + arb(0, 1e-15)).contains(arb(math.exp(-damping * tau)))


def test_the_least_acceleration_is_a_bound_and_close():
    assert acceleration_at_rest(MACHINE).holds
    least = min(nth(0, t) for t in np.linspace(0.0, 1.0, 20001))
    # Over a 1024th of a period a(t) changes by less than its greatest slope does.
    slope = max(abs(nth(1, t)) for t in np.linspace(0.0, 1.0, 20001))
    assert least - 2.0 * slope / 1024 < MACHINE.least_acceleration <= least


def _certificate(parts):
    told = {"damping": (0.6, 0.6), "half_backlash": (0.6, 0.6), "restitution": (0.9, 0.9)}
    told |= {"harmonics": [(1.0, 0.1, 0.1, 0.0, 0.0)]}
    return {
        "machine": told | {"damping": (0.5, 0.8)},
        "parts": [told | {"damping": (low, low + 0.1)} for low in parts],
        "motions": ["permanent contact", "P(1,1,0)"],
        "quiet": {"motion": 0, "level": 0.01},
        "discs": [],
        "rattling": None,
        "lattice": {"height": 0.25, "first": 1},
        "impacts": {"trail": 4},
    }


PARTS = (0.5, 0.6, 0.7)


@pytest.fixture
def subject():
    """Three parts; their lattices are alike but for one box of the last."""
    ends = np.tile(np.arange(1, 3, dtype=np.uint16).repeat(6).reshape(3, 4), (3, 1))
    ends[8, 1] = 1
    certificate = _certificate(PARTS)
    claims = claims_of(certificate, {"ends": ends, "rounds": np.arange(36).reshape(9, 4)})
    of_parts = tuple(claims.of_part(n) for n in range(3))
    return Subject(SimpleNamespace(certificate=certificate), claims, None, of_parts, None)


def test_each_part_has_its_own_machine_and_lattice(subject):
    for n, low in enumerate(PARTS):
        part = subject.claims.of_part(n)
        assert part.machine.damping.contains(arb(low + 0.05)) and not part.machine.damping.contains(arb(low - 0.01))
        np.testing.assert_array_equal(part.lattice.rounds, np.arange(36).reshape(9, 4)[3 * n : 3 * n + 3])
        assert part.lattice.ends[2, 1] == (1 if n == 2 else 2)


def test_a_box_is_claimed_only_where_all_parts_say_the_same(subject):
    alike = subject.claims.lattice.ends
    assert alike[2, 1] == 0 and np.count_nonzero(alike == 0) == 1
    np.testing.assert_array_equal(subject.claims.lattice.rounds, np.arange(24, 36).reshape(3, 4))


def test_the_core_and_every_box_are_tried_for_each_part(subject, monkeypatch):
    monkeypatch.setattr(work, "try_column", lambda machine, core, column: (machine, core, column))
    monkeypatch.setattr(work, "try_box", lambda ends, trail, row, column: (ends.machine, trail, row, column))
    ((what, _, places),) = _targets(subject)
    machines = subject.claims.parts
    tried = {subject.try_one(what, tuple(place)) for place in places.tolist()}
    assert tried == {(machine, Core(0, 0.01), column) for machine in machines for column in range(COLUMNS)}
    tried = [subject.try_one("boxes", (row, 1)) for row in range(9)]
    assert tried == [(machines[row // 3], 4, row % 3, 1) for row in range(9)]
