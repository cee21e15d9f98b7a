"""Time histories of loose gears: against an integrator, P, the energy balance, and what a rest must be."""

import math

import numpy as np
import pytest
from scipy.integrate import simpson

from rattle_kernels import Direction, Oscillator, Outcome, next_impacts, time_history
from rattle_kernels.impact_map.loose_map import RELEASED
from rattle_kernels.model.arcs import rest_acceleration_over_phases
from tests.rattle_kernels.impact_map.test_loose_map import random_machine
from tests.rattle_kernels.impact_map.test_time_history import integrated, speed_scale
from tests.rattle_kernels.reference import phase_error

# P(1,1,0)* is its one attractor but for a few departures in a hundred.
RESTING = Oscillator(0.6, 0.22, 0.6, restitution=0.7)


def _start(oscillator, rng, scale):
    return rng.uniform(-3.0, 3.0), oscillator.half_backlash * rng.uniform(-1.0, 1.0), scale * rng.uniform(-1.0, 1.0)


@pytest.mark.parametrize("seed", range(12))
def test_histories_from_inside_the_backlash_agree_with_an_integrator(seed):
    rng = np.random.default_rng(seed)
    damping = 10.0 ** rng.uniform(-1.0, 0.0)
    eccentricity = rng.uniform(1.1, 6.0) * damping / math.pi
    oscillator = Oscillator(damping, eccentricity, damping * rng.uniform(0.5, 3.0))
    start = _start(oscillator, rng, speed_scale(oscillator))
    history = time_history(oscillator, *start, periods=2.0, samples_per_period=97, most_contacts=60)
    assert history.outcome == Outcome.RETURNED
    beside = ~np.isin(history.time, history.contacts.time) & (history.time > start[0])
    expected = integrated(oscillator, start, history.time[beside])
    found = np.array([history.displacement[beside], history.velocity[beside]])
    scale = np.array([[oscillator.half_backlash], [speed_scale(oscillator)]])
    # Twelve digits, of which elastic contacts of two periods may cost some.
    assert (np.abs(found - expected) / scale).max() < 1e-6


@pytest.mark.parametrize("seed", range(20))
def test_what_forcing_gives_damping_and_impacts_take(seed):
    oscillator, rng, scale = random_machine(seed, most_orders=2)
    history = time_history(oscillator, *_start(oscillator, rng, scale), periods=3.0, samples_per_period=20_000)
    assert not history.truncated
    time, _, velocity, contacts = history[:4]
    power = velocity * (rest_acceleration_over_phases(oscillator).at(time) - oscillator.damping * velocity)
    cuts = np.unique([0, *np.flatnonzero(np.isin(time, contacts.time)), time.size - 1])
    work = sum(simpson(power[a : b + 1], x=time[a : b + 1]) for a, b in zip(cuts[:-1], cuts[1:], strict=True))
    impacts, begun = contacts.direction == Direction.IMPACT, contacts.direction == Direction.IN
    lost = 0.5 * (1.0 - oscillator.restitution**2) * (contacts.speed[impacts] ** 2).sum()
    lost += 0.5 * (contacts.speed[begun] ** 2).sum()
    gained = 0.5 * (velocity[-1] ** 2 - velocity[0] ** 2)
    assert abs(work - lost - gained) < 1e-8 * max(lost, 0.5 * scale**2)


@pytest.mark.parametrize("seed", range(12))
def test_departures_are_those_of_the_impact_map_until_a_rest(seed):
    oscillator, rng, scale = random_machine(seed, most_orders=2)
    t, v = rng.random(), scale * rng.uniform(0.05, 1.0)
    history = time_history(oscillator, t, oscillator.half_backlash, -v, departures=10)
    contacts = history.contacts
    for i in history.departures:  # each from the one before, for errors of many grow
        if contacts.direction[i] == Direction.OUT:
            rested = next_impacts(oscillator, t, v, shortcuts=True)
            assert rested.v == RELEASED and contacts.speed[i] == 0.0
            met, v = float(rested.t), RELEASED
        else:
            one, v = next_impacts(oscillator, t, v), oscillator.restitution * float(contacts.speed[i])
            met = float(one.t)
            assert float(one.v) == pytest.approx(v, rel=1e-9)
        t = float(contacts.time[i] % 1.0)
        assert phase_error(met, repr(t)) < 1e-10


def test_gear_rests_on_the_wall_until_its_arc_ends():
    history = time_history(RESTING, 0.0, 0.6, -0.5, periods=50.0)
    contacts, felt = history.contacts, rest_acceleration_over_phases(RESTING)
    assert history.outcome == Outcome.RETURNED and not history.truncated
    begins, ends = (np.flatnonzero(contacts.direction == each) for each in (Direction.IN, Direction.OUT))
    assert ends.size > 40 and (ends == begins[: ends.size] + 1).all()
    for begin, end in zip(contacts.time[begins], contacts.time[ends], strict=False):
        during = (history.time > begin) & (history.time < end)
        assert during.any() and (history.displacement[during] == 0.6).all() and (history.velocity[during] == 0.0).all()
        assert (felt.at(history.time[during]) > 0.0).all()
        # The release is the zero of a: rounding of a phase, times the slope of a.
        assert abs(felt.at(end % 1.0)) < 1e-13 * felt.slope.size
    # Superstable: all that came to rest leaves at one phase.
    assert np.ptp(contacts.time[ends] % 1.0) < 1e-13
    assert (np.diff(history.time) >= 0.0).all() and (np.abs(history.displacement) <= 0.6 * (1.0 + 1e-14)).all()


@pytest.mark.parametrize("wall", [1.0, -1.0])
def test_start_at_rest_on_a_wall_leaves_where_the_arc_ends(wall):
    loose = Oscillator(0.6, 0.6, 0.6, restitution=0.7)
    felt = rest_acceleration_over_phases(loose)
    phases = np.arange(200) / 200
    pressed = phases[wall * felt.at(phases) > 0.0]
    history = time_history(loose, float(pressed[0]), wall * 0.6, 0.0, periods=1.0)
    assert history.contacts.direction[0] == Direction.OUT and history.contacts.wall[0] == wall
    assert abs(felt.at(history.contacts.time[0] % 1.0)) < 1e-13 * felt.slope.size
    loose_at = phases[wall * felt.at(phases) < 0.0]
    away = time_history(loose, float(loose_at[0]), wall * 0.6, 0.0, periods=0.01)
    assert (wall * away.displacement[2:] < 0.6).all()
