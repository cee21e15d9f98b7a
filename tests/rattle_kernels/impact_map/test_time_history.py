"""Time histories against an ODE integrator, the impact maps, and the energy that forcing and damping leave."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import simpson, solve_ivp

from rattle_kernels import Direction, Oscillator, Outcome, OutsideDomain, eccentricity_bound_quiet, time_history
from rattle_kernels.impact_map.time_history import FREEPLAY, contact_along, end_of_piece, flight_along, piece_from
from rattle_kernels.numerics.jit import kernel
from tests.rattle_kernels.impact_map.scalar_map import departure
from tests.rattle_kernels.reference import entries, oscillator_of, phase_error
from tests.strategies import oscillators

STIFF = Oscillator(stiffness=1000.0)


@kernel
def beginning(oscillator, phase, displacement, velocity):
    return piece_from(oscillator, phase, displacement, velocity)


@kernel
def ending(oscillator, piece):
    return end_of_piece(oscillator, piece)


@kernel
def along_flight(oscillator, piece, elapsed, displacement, velocity):
    flight_along(oscillator, piece, elapsed, displacement, velocity)


@kernel
def along_stay(oscillator, piece, elapsed, displacement, velocity):
    contact_along(oscillator, piece, elapsed, displacement, velocity)


def state_along(oscillator, piece, elapsed):
    displacement, velocity = np.empty_like(elapsed), np.empty_like(elapsed)
    along = along_flight if piece.regime == FREEPLAY else along_stay
    along(oscillator, piece, elapsed, displacement, velocity)
    return displacement, velocity


def speed_scale(oscillator):
    return math.sqrt(16.0 * math.pi * oscillator.damping * oscillator.half_backlash)


@st.composite
def starts(draw, impacting=None):
    """Oscillator of either model and any state: on a wall, between, beyond; Phi' of any sign, and none."""
    oscillator = draw(oscillators())
    impacting = draw(st.booleans()) if impacting is None else impacting
    if not impacting:
        oscillator = oscillator._replace(stiffness=10.0 ** draw(st.floats(0.5, 6.0)))
    beta = oscillator.half_backlash
    inside = draw(st.one_of(st.floats(-1.0, 1.0), st.sampled_from([-1.0, 1.0, 0.0, -1.0 + 1e-16, 1.0 - 1e-16])))
    ratio = 1.0 if impacting else draw(st.sampled_from([1.0, 1.0, 1.5, 1.0 + 1e-15]))
    velocity = speed_scale(oscillator) * draw(st.one_of(st.floats(-2.0, 2.0), st.sampled_from([0.0, -1e-9, 1e-9])))
    # Halves and the like, so that a shift by a period keeps all digits.
    return oscillator, draw(st.integers(0, 1023)) / 1024, inside * ratio * beta, velocity


@given(starts())
@settings(max_examples=300)
def test_every_piece_ends_where_the_next_begins_and_not_before(case):
    oscillator, *state = case
    piece = beginning(oscillator, *state)
    stiff = 0.0 if math.isinf(oscillator.stiffness) else oscillator.stiffness
    for _ in range(5):
        end = ending(oscillator, piece)
        assert end.outcome in (Outcome.RETURNED, Outcome.PERMANENT_CONTACT)
        if math.isinf(end.duration) or (piece.regime != FREEPLAY and not stiff):
            duration = 0.0 if end.duration == 0.0 else 10.0
        else:
            duration = end.duration
        if duration > 0.0:
            displacement, velocity = state_along(oscillator, piece, duration * np.arange(1, 401) / 400)
            length = np.abs(displacement).max() + oscillator.half_backlash
            depth = piece.regime * displacement - oscillator.half_backlash
            if piece.regime == FREEPLAY:
                depth = oscillator.half_backlash - np.abs(displacement)
            assert depth.min() >= -1e-13 * length
            if math.isfinite(end.duration):
                # Phi at the end is off by what the rounding of its time makes of the speed there.
                speed = np.abs(velocity).max()
                assert abs(displacement[-1] - end.next_piece.displacement) <= 1e-13 * (length + speed * duration)
                assert abs(velocity[-1] - end.next_piece.velocity) <= 1e-12 * (speed + math.sqrt(stiff) * length)
        if math.isinf(end.duration):
            return
        piece = end.next_piece


@given(starts(impacting=False))
@settings(max_examples=50)
def test_without_impacts_the_samples_are_continuous_and_at_every_contact(case):
    oscillator, *state = case
    history = time_history(oscillator, *state, periods=3.0, samples_per_period=500, most_contacts=2000)
    assert (np.diff(history.time) >= 0.0).all()
    at = np.isin(history.time, history.contacts.time)
    np.testing.assert_allclose(np.abs(history.displacement[at]), oscillator.half_backlash, rtol=1e-15)
    # Samples miss the fastest moments of a ringing: it starts with what the start has, or with contact at rest.
    forcing = 4.0 * math.pi * oscillator.damping
    forcing += 2.0 * math.pi * oscillator.eccentricity * math.hypot(2.0 * math.pi, oscillator.damping)
    omega = math.sqrt(2.0 * oscillator.stiffness)
    depth = max(abs(state[1]) - oscillator.half_backlash, 0.0)
    speed = np.abs(history.velocity).max() + omega * depth + 3.0 * forcing / omega
    assert (np.abs(np.diff(history.displacement)) <= 1.01 * speed * np.diff(history.time) + 1e-13).all()
    steepest = 1.1 * ((omega + oscillator.damping) * speed + 3.0 * forcing)
    assert (np.abs(np.diff(history.velocity)) <= steepest * np.diff(history.time) + 1e-13 * speed).all()


@given(starts(impacting=True))
@settings(max_examples=50)
def test_impacts_are_two_samples_that_differ_in_the_sign_of_the_velocity(case):
    oscillator, *state = case
    history = time_history(oscillator, *state, periods=3.0, most_contacts=500)
    assert (np.abs(history.displacement) <= (1.0 + 1e-14) * oscillator.half_backlash).all()
    assert set(history.contacts.direction) <= {Direction.IMPACT}
    for time, wall, _, speed in list(zip(*history.contacts, strict=True))[:50]:
        (here,) = np.nonzero(history.time == time)
        assert (history.displacement[here] == wall * oscillator.half_backlash).any()
        assert {wall * speed, -wall * speed} <= set(history.velocity[here])


def force(oscillator, time):
    angle = 2.0 * math.pi * time
    forcing = 4.0 * math.pi**2 * np.cos(angle) + 2.0 * math.pi * oscillator.damping * np.sin(angle)
    return 4.0 * math.pi * oscillator.damping - oscillator.eccentricity * forcing


def integrated(oscillator, start, times):
    """Phi, Phi' at some times, by an ODE integrator that shares nothing with the kernels, restarted at each wall."""
    beta, stiffness = oscillator.half_backlash, oscillator.stiffness
    begin, *state = start
    found = np.empty((2, times.size))
    done = 0
    while done < times.size:
        inward = np.sign(state[1]) if state[1] else 1.0
        wall = (
            np.sign(state[0]) if abs(state[0]) > beta or (abs(state[0]) == beta and inward == np.sign(state[0])) else 0
        )
        if wall and math.isinf(stiffness):
            state, wall = [state[0], -state[1]], 0

        def motion(time, state, wall=wall):
            spring = 2.0 * stiffness * (state[0] - wall * beta) if wall else 0.0
            return [state[1], force(oscillator, time) - oscillator.damping * state[1] - spring]

        events = []
        for level in (wall,) if wall else (-1, 1):
            event = lambda time, state, level=level: state[0] - level * beta  # noqa: E731
            event.terminal, event.direction = True, -level if wall else level
            events.append(event)
        run = solve_ivp(
            motion, (begin, times[-1] + 1e-9), state, "DOP853", rtol=1e-12, atol=1e-13, max_step=0.05, events=events,
            dense_output=True,
        )  # fmt: skip
        reached = int(np.searchsorted(times, run.t[-1], side="right"))
        if reached > done:
            found[:, done:reached] = run.sol(times[done:reached])
        done, begin = reached, run.t[-1]
        level = next(
            (level for level, met in zip((wall,) if wall else (-1, 1), run.t_events, strict=True) if met.size), 0
        )
        state = [level * beta, run.y[1, -1]]
    return found


def random_case(seed):
    rng = np.random.default_rng(seed)
    damping = 10.0 ** rng.uniform(-1.0, 0.0)
    oscillator = Oscillator(damping, 0.0, damping * rng.uniform(0.3, 2.0), 10.0 ** rng.uniform(1.0, 4.0))
    oscillator = oscillator._replace(eccentricity=rng.uniform(0.0, 0.9) * eccentricity_bound_quiet(oscillator))
    if seed % 2:
        oscillator = oscillator._replace(stiffness=math.inf)
    reach = 1.0 if seed % 2 else 1.3
    displacement = oscillator.half_backlash * rng.uniform(-reach, reach)
    return oscillator, (rng.uniform(-3.0, 3.0), displacement, speed_scale(oscillator) * rng.uniform(-2.0, 2.0))


@pytest.mark.parametrize("seed", range(40))
def test_histories_agree_with_an_ode_integrator(seed):
    oscillator, start = random_case(seed)
    history = time_history(oscillator, *start, periods=2.0, samples_per_period=97, most_contacts=60)
    # The velocity is two-valued at impacts: samples beside them are compared.
    beside = ~np.isin(history.time, history.contacts.time) & (history.time > start[0])
    expected = integrated(oscillator, start, history.time[beside])
    found = np.array([history.displacement[beside], history.velocity[beside]])
    scale = np.array([[oscillator.half_backlash], [speed_scale(oscillator)]])
    assert (np.abs(found - expected) / scale).max() < 1e-7


def _energy(oscillator, displacement, velocity):
    depth = np.maximum(np.abs(displacement) - oscillator.half_backlash, 0.0)
    stiffness = 0.0 if math.isinf(oscillator.stiffness) else oscillator.stiffness
    return 0.5 * velocity**2 + stiffness * depth**2


@pytest.mark.parametrize("seed", range(40))
def test_energy_grows_by_the_work_of_the_forcing_less_what_damping_takes(seed):
    oscillator, start = random_case(seed)
    history = time_history(oscillator, *start, periods=4.0, samples_per_period=4000, most_contacts=300)
    time, displacement, velocity = history[:3]
    power = velocity * (force(oscillator, time) - oscillator.damping * velocity)
    energy = _energy(oscillator, displacement, velocity)
    # Pieces are cut at the contacts, of which impacts are two samples.
    ends = np.flatnonzero(np.isin(time, history.contacts.time))
    cuts = np.unique([0, *ends, time.size - 1])
    worst = 0.0
    for first, last in zip(cuts[:-1], cuts[1:], strict=True):
        work = simpson(power[first : last + 1], x=time[first : last + 1])
        worst = max(worst, abs(energy[last] - energy[first] - work))
    assert worst < 1e-7 * energy.max()


@pytest.mark.parametrize("seed", range(20))
def test_the_departures_are_those_of_the_impact_map(seed):
    oscillator, start = random_case(seed)
    history = time_history(oscillator, *start, departures=20)
    t, v = (field[history.departures] for field in (history.contacts.time, history.contacts.speed))
    lower = np.flatnonzero((history.contacts.wall < 0) & (history.contacts.direction != Direction.OUT))
    for i in range(len(t) - 1):
        impact = departure(oscillator, t[i] % 1.0, v[i])
        assert phase_error(impact.t, repr(float(t[i + 1] % 1.0))) < 1e-12
        assert impact.v == pytest.approx(v[i + 1], rel=1e-11)
        assert impact.lower_impacts == ((history.departures[i] < lower) & (lower < history.departures[i + 1])).sum()
    if len(t) < 20:
        assert history.outcome == Outcome.PERMANENT_CONTACT
        assert not len(t) or departure(oscillator, t[-1] % 1.0, v[-1]).outcome == Outcome.PERMANENT_CONTACT


@given(starts())
@settings(max_examples=50)
def test_a_start_some_periods_later_is_the_same_motion(case):
    oscillator, t, displacement, velocity = case
    here = time_history(oscillator, t, displacement, velocity, periods=2.5, most_contacts=200)
    later = time_history(oscillator, t + 2.0**30, displacement, velocity, periods=2.5, most_contacts=200)
    np.testing.assert_array_equal(here.displacement, later.displacement)
    np.testing.assert_array_equal(here.velocity, later.velocity)
    np.testing.assert_array_equal(here.time + 2.0**30, later.time)
    assert here.outcome == later.outcome


@pytest.mark.parametrize("stiffness", [100.0, 1000.0, 1e5])
def test_the_quiet_solution_stays_quiet(stiffness):
    oscillator = Oscillator(stiffness=stiffness)
    damping, square = oscillator.damping, 2.0 * stiffness
    drive = -oscillator.eccentricity * (4.0 * math.pi**2 - 2j * math.pi * damping)
    answer = drive / (square - 4.0 * math.pi**2 + 2j * math.pi * damping)
    level = oscillator.half_backlash + 4.0 * math.pi * damping / square
    turn = np.exp(2j * math.pi * 0.3)
    start = 0.3, level + (answer * turn).real, (2j * math.pi * answer * turn).real
    history = time_history(oscillator, *start, periods=50)
    expected = level + (answer * np.exp(2j * math.pi * history.time)).real
    np.testing.assert_allclose(history.displacement, expected, rtol=1e-13)
    assert history.outcome == Outcome.PERMANENT_CONTACT and history.contacts.time.size == 0
    assert history.time[-1] == 50.3 and not history.truncated


def test_the_rule_of_one_rotation_changes_the_outcome_but_not_the_motion():
    differing = [entry for entry in entries("map_pwl.json") if entry["plc_one_rotation"] and not entry["plc_rigorous"]]
    for entry in differing[:10]:
        oscillator, t, v = oscillator_of(entry), float(entry["t0"]), float(entry["v0"])
        start = t, oscillator.half_backlash, -v
        exact = time_history(oscillator, *start, departures=1)
        paper = time_history(oscillator._replace(permanent_after=1.0), *start, departures=1)
        assert (exact.outcome, paper.outcome) == (Outcome.RETURNED, Outcome.PERMANENT_CONTACT)
        np.testing.assert_array_equal(exact.displacement, paper.displacement)
        assert phase_error(exact.contacts.time[-1] % 1.0, entry["t1"]) < 1e-13


def test_rest_on_the_upper_wall_is_for_ever_and_from_the_lower_one_a_flight():
    rest = time_history(Oscillator(), 0.2, 0.6, 0.0, periods=5)
    assert rest.outcome == Outcome.PERMANENT_CONTACT and (rest.displacement == 0.6).all()
    flight = time_history(Oscillator(), 0.2, -0.6, 0.0, departures=1)
    assert flight.contacts.wall.tolist() == [1] and (flight.displacement[1:] > -0.6).all()


@pytest.mark.parametrize(("displacement", "velocity"), [(0.6, 2.0), (-0.6, -2.0)])
def test_a_start_into_the_wall_is_an_impact_at_once(displacement, velocity):
    history = time_history(Oscillator(), 0.2, displacement, velocity, periods=1)
    assert history.contacts.time[0] == 0.2 and history.contacts.speed[0] == 2.0
    assert history.velocity[:2].tolist() == [velocity, -velocity]
    assert time_history(STIFF, 0.2, displacement, velocity, periods=1).contacts.time[0] > 0.2


def test_contacts_beyond_the_limit_truncate_and_say_where():
    for oscillator in (Oscillator(), STIFF):
        history = time_history(oscillator, 0.2, 0.6, -4.0, periods=50, most_contacts=7)
        assert history.truncated and history.contacts.time.size == 7
        assert history.time[-1] == history.contacts.time[-1] < 50.0


def test_low_bounces_are_captured():
    history = time_history(Oscillator(), 0.2, 0.6, -0.1, periods=3)
    assert history.outcome == Outcome.PERMANENT_CONTACT and not history.truncated


def test_a_history_ends_with_its_last_departure():
    for oscillator in (Oscillator(), STIFF):
        history = time_history(oscillator, 0.2, 0.6, -4.0, departures=7)
        assert history.departures.size == 7 and history.departures[-1] == history.contacts.time.size - 1
        assert history.time[-1] == history.contacts.time[-1]
        assert history.velocity[-1] == -history.contacts.speed[-1]


@pytest.mark.parametrize(
    ("oscillator", "start", "goal", "told"),
    [
        (Oscillator(), (0.0, 0.7, 0.0), {"periods": 1}, "within the backlash, at most 0.6"),
        (Oscillator(), (math.nan, 0.0, 0.0), {"periods": 1}, "time must be finite"),
        (STIFF, (0.0, math.inf, 0.0), {"periods": 1}, "displacement must be finite"),
        (STIFF, (0.0, 0.0, 0.0), {}, "say how far"),
        (STIFF, (0.0, 0.0, 0.0), {"periods": -1.0}, "periods must not be negative"),
        (STIFF, (0.0, 0.0, 0.0), {"departures": 0}, "departures must be at least 1"),
        (STIFF, (0.0, 0.0, 0.0), {"periods": 1, "samples_per_period": 0}, "samples_per_period must be"),
    ],
)
def test_what_cannot_be_followed_is_refused(oscillator, start, goal, told):
    with pytest.raises(ValueError, match=told):
        time_history(oscillator, *start, **goal)


def test_an_oscillator_outside_the_domain_is_refused():
    with pytest.raises(OutsideDomain, match="damping must be positive"):
        time_history(STIFF._replace(damping=0.0), 0.0, 0.0, 0.0, periods=1)
