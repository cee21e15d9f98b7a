"""No contact ends before the nodes of its cell in the table of guesses say, or ends where they say that none does."""

import math

import numpy as np
import pytest

from rattle_kernels import Oscillator, next_impacts
from rattle_kernels.impact_map.flights import UPPER
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.lanes.tables import ABSCISSAE, BLOCK, CONTACT_ABOVE, ENDLESS, PHASES, ROW, lane_tables
from rattle_kernels.model.contact import enter_contact
from rattle_kernels.model.contact_end import follow_contact
from rattle_kernels.model.contact_swings import ends_late_around, lasts_around
from rattle_kernels.model.domain import check_domain
from rattle_kernels.model.flight import acceleration_range
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from tests.rattle_kernels.impact_map.scalar_map import departure

OSCILLATORS = [
    Oscillator(stiffness=30.0),
    Oscillator(stiffness=300.0),
    Oscillator(stiffness=1e3),
    Oscillator(0.527, stiffness=2e3),
    Oscillator(0.06, 0.01, 0.06, stiffness=1e3),
    Oscillator(0.6, 0.18, 0.6, stiffness=1e3),
    Oscillator(stiffness=1e4),
]


@kernel
def follow_all(oscillator, phase, speed):
    duration = np.empty(phase.size)
    for i in range(phase.size):
        duration[i] = follow_contact(oscillator, UPPER, phase[i], speed[i]).duration
    return duration


@pytest.mark.parametrize("oscillator", OSCILLATORS, ids=lambda o: f"{o.damping:g}-{o.eccentricity:g}-{o.stiffness:g}")
def test_no_contact_of_a_cell_ends_a_swing_before_its_nodes(oscillator):
    tables = lane_tables(oscillator)
    above = tables.contact[CONTACT_ABOVE * BLOCK :][:BLOCK].reshape(-1, ROW)
    corners = np.stack([above[:-1, :-1], above[1:, :-1], above[:-1, 1:], above[1:, 1:]])
    turn = 2.0 * math.pi / math.sqrt(2.0 * oscillator.stiffness)
    least, most = corners.min(axis=0), corners.max(axis=0)
    assert not ((most == ENDLESS) & (least < ENDLESS)).any()
    row, column = np.nonzero((most > turn) & (most < ENDLESS))  # False where a corner is NaN
    rng = np.random.default_rng(3)
    chosen = rng.integers(0, row.size, 20_000)
    row, column = row[chosen], column[chosen]
    phase, abscissa = (row + rng.random(row.size)) / PHASES, (column + rng.random(row.size)) / ABSCISSAE
    duration = follow_all(oscillator, phase, tables.contact_speed * abscissa / (1.0 - abscissa))
    assert (duration > least[row, column] - 0.25 * turn).all()
    assert (duration < most[row, column] + 0.25 * turn).all()


WIDER = [
    Oscillator(stiffness=1e3, contact_damping=0.02),
    pytest.param(Oscillator(stiffness=1e3, harmonics=((2, 0.01, 0.3),)), marks=pytest.mark.slow),
    Oscillator(stiffness=1e3, permanent_after=1.0),
]


@pytest.mark.parametrize("oscillator", OSCILLATORS[1:] + WIDER, ids=str)
def test_no_contact_of_a_cell_ends_whose_nodes_say_that_none_does(oscillator):
    tables = lane_tables(check_domain(oscillator))
    above = tables.contact[CONTACT_ABOVE * BLOCK :][:BLOCK].reshape(-1, ROW)
    corners = np.stack([above[:-1, :-1], above[1:, :-1], above[:-1, 1:], above[1:, 1:]])
    row, column = np.nonzero((corners == ENDLESS).all(axis=0))
    assert row.size > 20
    rng = np.random.default_rng(8)
    chosen = rng.integers(0, row.size, 20_000)
    row, column = row[chosen], column[chosen]
    phase, abscissa = (row + rng.random(row.size)) / PHASES, (column + rng.random(row.size)) / ABSCISSAE
    for_ever = check_domain(oscillator)._replace(permanent_after=math.inf)
    assert np.isnan(follow_all(for_ever, phase, tables.contact_speed * abscissa / (1.0 - abscissa))).all()


@kernel
def ends_around(oscillator, phase, speed, phase_step, speed_step):
    """Whether a contact ends, whether one in its box does, and whether the box is said to hold no end."""
    least_press, _ = acceleration_range(oscillator)
    ends = follow_contact(oscillator, UPPER, phase, speed).outcome == OUTCOME_RETURNED
    lasting = lasts_around(enter_contact(oscillator, UPPER, phase, 0.0, speed), least_press, phase_step, speed_step)
    near_end = ends
    for i in range(-10, 11):
        for j in range(-10, 11):
            near = phase + 0.1 * i * phase_step, max(speed + 0.1 * j * speed_step, 0.0)
            near_end |= follow_contact(oscillator, UPPER, near[0], near[1]).outcome == OUTCOME_RETURNED
    return ends, near_end, lasting


@pytest.mark.parametrize("part", [2.0, 4.0, 6.0])
@pytest.mark.parametrize("oscillator", [OSCILLATORS[1], OSCILLATORS[2], WIDER[0]], ids=str)
def test_where_contacts_are_said_to_last_none_ends(oscillator, part):
    oscillator = check_domain(oscillator)
    scale, rng = lane_tables(oscillator).contact_speed, np.random.default_rng(9)
    said, mixed = 0, 0
    for phase, speed in zip(rng.random(1500).tolist(), (0.8 * scale * rng.random(1500)).tolist(), strict=True):
        steps = part * 0.5 / PHASES, part * scale / ABSCISSAE
        ends, near_end, lasting = ends_around(oscillator, phase, speed, *steps)
        assert not (lasting and near_end), (phase, speed)
        said, mixed = said + lasting, mixed + (near_end and not ends)
    assert said > 20 and mixed > 5


@kernel
def earliest_around(oscillator, phase, speed, phase_step, speed_step):
    """Duration of a contact, the least one in its box, and whether the box is said to hold no earlier end."""
    least_press, _ = acceleration_range(oscillator)
    duration = follow_contact(oscillator, UPPER, phase, speed).duration
    contact = enter_contact(oscillator, UPPER, phase, 0.0, speed)
    late = ends_late_around(contact, duration, least_press, phase_step, speed_step)
    earliest = duration
    for i in range(-10, 11):
        for j in range(-10, 11):
            near = phase + 0.1 * i * phase_step, max(speed + 0.1 * j * speed_step, 0.0)
            ended = follow_contact(oscillator, UPPER, near[0], near[1]).duration
            earliest = min(earliest, ended) if ended == ended else earliest
    return duration, earliest, late


@pytest.mark.parametrize("part", [0.2, 1.0, 5.0])
@pytest.mark.parametrize("oscillator", OSCILLATORS[1:4], ids=lambda o: f"{o.damping:g}-{o.stiffness:g}")
def test_where_a_contact_is_said_to_end_late_none_nearby_ends_early(oscillator, part):
    turn = 2.0 * math.pi / math.sqrt(2.0 * oscillator.stiffness)
    scale, rng = lane_tables(oscillator).contact_speed, np.random.default_rng(6)
    said, jumps = 0, 0
    for phase, speed in zip(rng.random(1500).tolist(), (1.5 * scale * rng.random(1500)).tolist(), strict=True):
        steps = part * 0.5 / PHASES, part * scale / ABSCISSAE
        duration, earliest, late = earliest_around(oscillator, phase, speed, *steps)
        if not turn < duration < 8.0 * turn:
            continue
        early = earliest < duration - 0.5 * turn
        assert not (late and early), (phase, speed)
        said, jumps = said + late, jumps + early
    assert said > 20 and jumps > 5


def test_lanes_and_the_careful_path_agree_where_contacts_take_several_swings():
    oscillator, rng = Oscillator(stiffness=1e3), np.random.default_rng(4)
    t, v = rng.random(6000), 1.2 * (1.0 - rng.random(6000))
    together = next_impacts(oscillator, t, v)
    alone = [departure(oscillator, *each) for each in zip(t.tolist(), v.tolist(), strict=True)]
    assert [impact.outcome for impact in alone] == together.outcome.tolist()
    off = np.abs([impact.t for impact in alone] - together.t)
    assert np.nanmax(np.minimum(off, 1.0 - off)) < 1e-11
    np.testing.assert_allclose(together.v, [impact.v for impact in alone], rtol=1e-9, atol=1e-11)


def test_few_contacts_of_several_swings_need_the_careful_path():
    rng = np.random.default_rng(1)
    t, v = rng.random(20_000), 7.0 * (1.0 - rng.random(20_000))
    _, run = run_lanes(Oscillator(stiffness=1e3), t, v, 100, shortcuts=False)
    # One in 27 took it when all contacts of several swings did, one in 47 when all permanent ones did.
    assert run.careful_flights < 0.018 * run.applications


def test_a_contact_that_counts_as_permanent_after_a_time_does_so_in_lanes():
    oscillator, rng = Oscillator(stiffness=1e3), np.random.default_rng(5)
    t, v = rng.random(6000), 1.2 * (1.0 - rng.random(6000))
    strict = oscillator._replace(permanent_after=0.5)
    strictly = next_impacts(strict, t, v).outcome
    assert (next_impacts(oscillator, t, v).outcome != strictly).sum() > 30
    alone = [departure(strict, *each).outcome for each in zip(t.tolist(), v.tolist(), strict=True)]
    assert alone == strictly.tolist()
