"""Images of departures by balls: against reference tables, the kernels' P and its derivative."""

import numpy as np
import pytest
from flint import arb, ctx

from rattle_kernels import Harmonic, Oscillator, grazing_velocity, next_impacts
from rattle_kernels.impact_map.jacobian import next_impact_with_jacobian
from rattle_proof.stiffness.contact import Contact, Side, StiffMachine, first_end, lasts
from rattle_proof.stiffness.impact_map import NotProven, passage
from rattle_proof.verification.machine import ball
from tests.rattle_kernels.reference import entries, oscillator_of

OSCILLATORS = (
    Oscillator(0.6, 0.1, 0.6, stiffness=1e3),
    Oscillator(0.6, 0.1, 0.6, stiffness=1e5, contact_damping=0.1),
    Oscillator(0.6, 0.05, 0.6, stiffness=1e4, harmonics=(Harmonic(2.0, 0.01, 0.3), Harmonic(3.0, 0.004, 0.8))),
)


@pytest.fixture(autouse=True)
def digits():
    before, ctx.prec = ctx.prec, 160
    yield
    ctx.prec = before


def of_point(machine, t, v):
    return passage(machine, arb(t), arb(v), arb(t), arb(v))


def test_tables_of_reference_lie_within_balls_of_twenty_digits():
    tried, printed = 0, arb(0, 1e-20)
    for entry in entries("map_pwl.json"):
        if entry["outcome"] != "map":
            continue
        try:
            found = of_point(StiffMachine(oscillator_of(entry)), float(entry["t0"]), float(entry["v0"])).image
        except NotProven:
            continue
        tried += 1
        assert found.all_t.rad() < 1e-20 and found.all_v.rad() < 1e-20
        assert (found.all_t - arb(entry["t1"]) + printed).contains_integer(), entry
        assert (found.all_v - arb(entry["v1"]) + printed).contains(0), entry
    assert tried > 200


@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_images_of_boxes_hold_the_kernels_images_and_slopes_of_their_points(oscillator):
    machine, random, tried = StiffMachine(oscillator), np.random.default_rng(5), 0
    for _ in range(60):
        t, v, wide = random.random(), random.uniform(0.5, 7.0), 10.0 ** random.uniform(-7.0, -3.0)
        try:
            found = passage(machine, arb(t), arb(v), arb(t) + arb(0, wide), arb(v) + arb(0, wide))
        except NotProven:
            continue
        tried += 1
        rounding = arb(0, 1e-9)
        slowest = found.slowest
        for along_t, along_v in ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0), (0.3, -0.7)):
            t1, v1 = t + 0.99 * along_t * wide, v + 0.99 * along_v * wide
            impact = next_impacts(oscillator, [t1], [v1])
            assert (found.image.all_t + rounding - arb(float(impact.t[0]))).contains_integer()
            assert (found.image.all_v + rounding).contains(arb(float(impact.v[0])))
            assert slowest <= arb(float(impact.v[0])) + 1e-9 and slowest <= v1
            _, jacobian = next_impact_with_jacobian(oscillator, t1, v1)
            for one, told in zip(found.image.slope, jacobian, strict=True):
                assert (one + arb(0, 1e-6 * max(1.0, abs(told)))).contains(arb(float(told)))
    assert tried > 25


@pytest.mark.parametrize("oscillator", OSCILLATORS)
@pytest.mark.parametrize("side", Side)
def test_depths_solve_their_differential_equation(oscillator, side):
    machine = StiffMachine(oscillator)
    contact = Contact(machine, side, arb(0.37), arb(1.3))
    h = arb(2) ** -45
    tau = arb(0.4) / machine.frequency
    assert abs(contact.height(arb(0))) < 1e-30 and abs(contact.velocity(arb(0)) - contact.w) < 1e-30
    rate = (contact.height(tau + h) - contact.height(tau - h)) / (2 * h)
    assert abs(rate - contact.velocity(tau)) < 1e-12
    bend = (contact.velocity(tau + h) - contact.velocity(tau - h)) / (2 * h)
    felt = side.value * machine.freeplay.acceleration(contact.t + tau)
    missed = bend + machine.drag * contact.velocity(tau) + machine.square * contact.height(tau) - felt
    assert abs(missed) < 1e-6


def test_a_contact_that_touches_the_wall_on_its_way_is_not_said_to_last():
    # The slow part is so deep that slow contacts swing several times.
    machine = StiffMachine(Oscillator(0.6, 0.1, 0.6, stiffness=100.0))
    ended = longer = known = 0
    for w in np.linspace(0.02, 0.5, 49):
        contact = Contact(machine, Side.UPPER, arb(0.3), arb(float(w)))
        end = first_end(contact)
        if end is None:
            continue
        ended += 1
        around = arb(end) + arb(0, 1e-4)
        known += lasts(contact, around)
        # Beyond the first end the depth is negative, whatever comes then.
        assert not lasts(contact, around + arb.pi() / machine.frequency)
        longer += float(machine.frequency) * end > 1.5 * np.pi
    # Those that end almost at a turning point are not decided within so wide a ball.
    assert ended > 10 and longer > 0 and known > 0.9 * ended


def test_a_ball_of_contacts_some_of_which_end_early_is_not_said_to_last():
    machine = StiffMachine(Oscillator(0.6, 0.1, 0.6, stiffness=100.0))
    ends = {}
    for w in np.linspace(0.02, 0.5, 97):
        end = first_end(Contact(machine, Side.UPPER, arb(0.3), arb(float(w))))
        ends[float(w)] = np.inf if end is None else end
    speeds = sorted(ends)
    jumps = [(a, b) for a, b in zip(speeds, speeds[1:], strict=False) if abs(ends[a] - ends[b]) > 0.1]
    assert jumps
    for a, b in jumps:
        late = max(end for end in (ends[a], ends[b]) if np.isfinite(end))
        both = Contact(machine, Side.UPPER, arb(0.3), ball(a, b))
        assert not lasts(both, arb(late) + arb(0, 1e-3))


def test_what_meets_the_grazing_curve_or_reaches_no_speed_is_refused():
    machine = StiffMachine(OSCILLATORS[0])
    with pytest.raises(NotProven, match="grazing"):
        v = arb(float(grazing_velocity(OSCILLATORS[0], [0.6])[0]))
        passage(machine, arb(0.6), v, arb(0.6) + arb(0, 1e-3), v + arb(0, 1e-3))
    with pytest.raises(NotProven, match="no speed"):
        passage(machine, arb(0.6), arb(0.1), arb(0.6), arb(0.1) + arb(0, 0.2))


def test_a_later_root_is_not_taken_for_the_end_of_a_contact(monkeypatch):
    machine = StiffMachine(Oscillator(0.6, 0.1, 0.6, stiffness=100.0))

    def second_end(contact):
        return first_end(contact) + 2.0 * np.pi / float(machine.frequency)

    of_point(machine, 0.1, 3.2)
    monkeypatch.setattr("rattle_proof.stiffness.impact_map.first_end", second_end)
    with pytest.raises(NotProven, match="early"):
        of_point(machine, 0.1, 3.2)
