"""P of loose gears of finite stiffness: against an integrator, its limits on all sides, and what must hold."""

import itertools
import math

import numpy as np
import pytest

from rattle_kernels import (
    Direction,
    Oscillator,
    Outcome,
    OutsideDomain,
    eccentricity_bound_quiet,
    next_impacts,
    previous_impacts,
    stiffness_bound,
    time_history,
)
from rattle_kernels.attractors.loudness import loudness
from rattle_kernels.attractors.settled_orbit import attractor_of
from rattle_kernels.impact_map.flights import LOWER, UPPER
from rattle_kernels.impact_map.loose_map import RELEASED
from rattle_kernels.lanes.lyapunov import tangent_growth
from rattle_kernels.model.arcs import arcs_of, largest_eccentricity_of_one, rest_acceleration_over_phases
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.orbits.orbit_search import find_orbits
from tests.rattle_kernels.impact_map.integrator import integrated_loose_departure
from tests.rattle_kernels.impact_map.scalar_map import bounce, departure, departures, derivative
from tests.rattle_kernels.impact_map.test_loose_map import random_machine
from tests.rattle_kernels.impact_map.test_piecewise_linear_map import contact_of
from tests.rattle_kernels.impact_map.test_time_history import integrated, speed_scale
from tests.rattle_kernels.reference import phase_error

# Below its own resonance contact is so soft that quiet solutions exist beyond Eq. (8).
SOFT = Oscillator(0.6, 0.3, 0.6, 5.0)


def random_soft_machine(seed, *, least_stiffness=10.0, largest_stiffness=1e5, **drawn):
    """A machine of `random_machine` whose contacts take time; every other one loses energy there."""
    machine, rng, scale = random_machine(seed, **drawn)
    stiffness = math.exp(rng.uniform(math.log(least_stiffness), math.log(largest_stiffness)))
    bare = machine._replace(restitution=1.0, contact_damping=0.0 if seed % 2 else rng.uniform(0.0, 0.6))
    return check_oscillator(bare._replace(stiffness=max(stiffness, 1.01 * stiffness_bound(bare)))), rng, scale


def _moves(jacobian, v):
    """How far phase and speed of an end move with the phase of the beginning, and with parts of its speed."""
    return np.abs(np.array(jacobian).reshape(2, 2) * np.array([1.0, v])).max(axis=1)


_MACHINES = [*itertools.product((1.1, 2.0, 4.0), (10.0, 1e3, 1e5), (0.0, 0.2), (False, True))]


def _machine(gamma, stiffness, part, second):
    """Of one order or two, the inertia of which is that of gamma, on damping 0.2."""
    share = 0.5 if second else 1.0
    eccentricity = gamma * share * largest_eccentricity_of_one(0.2)
    harmonics = ((2, 0.25 * eccentricity, 0.3),) if second else ()
    return check_oscillator(Oscillator(0.2, eccentricity, 0.15, stiffness, contact_damping=part, harmonics=harmonics))


@pytest.mark.parametrize("case", _MACHINES, ids=str)
def test_next_departure_agrees_with_an_ode_integrator(case):
    oscillator, rng = _machine(*case), np.random.default_rng(_MACHINES.index(case))
    scale = speed_scale(oscillator)
    for t, v in zip(rng.random(4), scale * np.array([0.03, 0.3, 1.0, 1.5]), strict=True):
        impact, jacobian = derivative(oscillator, t, v)
        expected = integrated_loose_departure(oscillator, t, v, 50.0)
        if impact.outcome == Outcome.PERMANENT_CONTACT:
            assert expected is None
            continue
        time, speed, lower = expected
        assert (impact.outcome, impact.lower_impacts) == (Outcome.RETURNED, lower)
        assert impact.duration == pytest.approx(time - t, rel=1e-9)
        # Twelve digits a step, and steps as short as a tenth of a radian of the ringing; errors move the end.
        error = 1e-12 * impact.duration * max(100.0, 10.0 * math.sqrt(2.0 * oscillator.stiffness))
        late, faster = _moves(jacobian, v)
        assert phase_error(impact.t, repr(float(time % 1.0))) < error * max(1.0, late)
        assert abs(impact.v - speed) < error * max(scale, faster)


def test_the_machines_for_the_integrator_meet_both_walls():
    lower = [int(departures(_machine(*case), [0.1, 0.4, 0.7], [1.5] * 3)[2].max()) for case in _MACHINES]
    assert lower.count(0) < len(lower) // 2 and max(lower) > 1


@pytest.mark.parametrize("seed", range(8))
def test_the_stiff_limit_is_the_elastic_impacting_map(seed):
    elastic, rng, scale = random_machine(seed, most_orders=2, largest_gamma=6.0)
    elastic = elastic._replace(restitution=1.0)
    tried = 0
    for t, v in zip(rng.random(20), scale * rng.uniform(0.3, 1.5, 20), strict=True):
        (impact, _), (_, jacobian) = bounce(elastic, t, v), derivative(elastic, t, v)
        # Next to a graze the error is no multiple of the contact's duration, which is pi/sqrt(2 kappa).
        if max(_moves(jacobian, v) / np.array([1.0, scale])) > 20.0 or impact.lower_impacts > 3:
            continue
        errors = []
        for stiffness in (1e8, 1e10, 1e12):
            stiff = departure(elastic._replace(stiffness=stiffness), t, v)
            assert stiff.lower_impacts == impact.lower_impacts
            apart = phase_error(stiff.t, repr(impact.t)) + abs(stiff.v - impact.v) / scale
            errors.append(apart * math.sqrt(2.0 * stiffness))
        tried += 1
        # What multiplies 1/sqrt(kappa) settles, ten times closer for stiffness 100 times higher.
        assert abs(errors[2] - errors[1]) < 0.2 * abs(errors[1] - errors[0]) + 1e-3 * errors[2]
    assert tried > 5


def _differences(oscillator, t, v, impact, part):
    columns = []
    for dt, dv in ((part, 0.0), (0.0, part * v)):
        ends = [departure(oscillator, t + sign * dt, v + sign * dv) for sign in (1.0, -1.0)]
        if {(end.outcome, end.lower_impacts) for end in ends} != {(impact.outcome, impact.lower_impacts)}:
            return None
        apart = ends[0].t - ends[1].t
        columns.append(np.array([apart - round(apart), ends[0].v - ends[1].v]) / (2.0 * (dt + dv)))
    return np.array(columns).T


@pytest.mark.parametrize("seed", range(12))
def test_the_derivative_agrees_with_differences_and_has_the_determinant_that_damping_leaves(seed):
    oscillator, rng, scale = random_soft_machine(seed, most_orders=2)
    tried = 0
    for t, v in zip(rng.random(20), scale * rng.uniform(0.02, 1.5, 20), strict=True):
        impact, jacobian = derivative(oscillator, t, v)
        if impact.outcome != Outcome.RETURNED:
            continue
        exact = np.array(jacobian).reshape(2, 2)
        units = np.outer([1.0, impact.v], [1.0, 1.0 / v])
        sizes = np.abs(exact) / units
        history = time_history(oscillator, t, oscillator.half_backlash, -v, departures=1, samples_per_period=1)
        times, direction = history.contacts.time, history.contacts.direction
        held = times[direction == Direction.OUT].sum() - times[direction == Direction.IN].sum()
        # v dv dt shrinks by damping in freeplay, and by that of the contact for as long as it lasts.
        more = 2.0 * oscillator.contact_damping * math.sqrt(2.0 * oscillator.stiffness)
        left = math.exp(-oscillator.damping * impact.duration - more * held) * v / impact.v
        # Rounding of the products that are subtracted.
        lost = 1e-13 * (abs(exact[0, 0] * exact[1, 1]) + abs(exact[0, 1] * exact[1, 0]))
        assert abs(np.linalg.det(exact) - left) <= 1e-9 * left + lost
        known = [_differences(oscillator, t, v, impact, 10.0**-n) for n in range(4, 9)]
        known = [each for each in known if each is not None]
        if len(known) < 2:
            continue
        tried += 1
        errors = np.min([np.abs(each - exact) for each in known], axis=0) / units
        assert (errors <= 1e-4 * sizes + 1e-7 * max(1.0, sizes.max())).all(), (errors, sizes)
    assert tried > 5


@pytest.mark.parametrize("stiffness", [30.0, 1e3, 1e5])
@pytest.mark.parametrize("part", [0.0, 0.3])
def test_the_map_has_no_seam_where_gears_get_loose(stiffness, part):
    """P is smooth in the eccentricity: from below it is extrapolated across the bound of Eq. (8)."""
    bound, h = largest_eccentricity_of_one(0.6), 1e-7
    rng, tried = np.random.default_rng(5), 0
    machines = [Oscillator(0.6, bound * (1.0 + n * h), 0.6, stiffness, contact_damping=part) for n in (-3, -2, -1, 1)]
    assert [machine.is_loose for machine in machines] == [False, False, False, True]
    for t, v in zip(rng.random(100), 7.0 * rng.random(100), strict=True):
        ends = [departure(machine, t, v) for machine in machines]
        if len({(end.outcome, end.lower_impacts) for end in ends}) > 1 or ends[0].outcome != Outcome.RETURNED:
            continue
        phase, speed = np.array([(end.t - round(end.t - ends[0].t), end.v) for end in ends]).T
        curved = [each[0] - 2.0 * each[1] + each[2] for each in (phase, speed)]
        if max(map(abs, curved)) > 1e-11:  # next to a graze
            continue
        tried += 1
        for each, bend in zip((phase, speed), curved, strict=True):
            # A line, and what it misses: three times the bend. Its slope has four times the rounding.
            assert abs(each[3] - (3.0 * each[2] - 2.0 * each[1])) <= 4.0 * abs(bend) + 1e-12
    assert tried > 80


@pytest.mark.parametrize("seed", range(40))
def test_lanes_follow_the_scalar_path_and_nothing_ends_without_a_name(seed):
    oscillator, rng, scale = random_soft_machine(seed, most_orders=2, least_stiffness=1e-2, largest_stiffness=1e7)
    t, v = rng.random(300), scale * 10.0 ** rng.uniform(-12.0, 1.0, 300)
    phase, speed, lower, outcome = departures(oscillator, t, v)
    once, many = next_impacts(oscillator, t, v), next_impacts(oscillator, t, v, 20, shortcuts=True)
    assert set(outcome) <= {Outcome.RETURNED, Outcome.PERMANENT_CONTACT}
    np.testing.assert_array_equal(once.outcome, outcome)
    np.testing.assert_array_equal(once.lower_impacts, lower)
    for after in (once, many):
        lands = (0.0 <= after.t) & (after.t < 1.0) & (after.v > 0.0) & np.isfinite(after.v)
        assert (lands == (after.outcome == Outcome.RETURNED)).all()
        assert set(after.outcome) <= {Outcome.RETURNED, Outcome.PERMANENT_CONTACT}
    for i in np.flatnonzero(outcome == Outcome.RETURNED)[::10]:
        late, faster = _moves(derivative(oscillator, t[i], v[i])[1], v[i])
        assert phase_error(once.t[i], repr(float(phase[i]))) <= 1e-12 * max(1.0, late)
        assert abs(once.v[i] - speed[i]) <= 1e-12 * max(speed[i], v[i], faster)


def test_a_lane_of_a_loose_gear_does_not_depend_on_its_neighbours():
    oscillator, rng, scale = random_soft_machine(3, most_orders=2)
    t, v = rng.random(150), scale * 10.0 ** rng.uniform(-3.0, 0.3, 150)
    together = next_impacts(oscillator, t, v, applications=40, shortcuts=True)
    for i in range(0, t.size, 7):
        alone = next_impacts(oscillator, t[i:], v[i:], applications=40, shortcuts=True)
        for field, later in zip(together, alone, strict=True):
            np.testing.assert_array_equal(field[i:], later)


@pytest.mark.parametrize("wall", [UPPER, LOWER])
@pytest.mark.parametrize("speed", [0.0, 5e-324, 1e-300, 1e-100, 1e-20, 1e-12])
def test_contacts_of_hardly_any_speed_end_where_nothing_presses(wall, speed):
    oscillator = Oscillator(0.6, 0.4, 0.6, 1000.0)
    ends, felt = arcs_of(oscillator).begin, rest_acceleration_over_phases(oscillator)
    for phase in np.append(np.arange(40) / 40, ends):
        contact = contact_of(oscillator, wall, phase, speed)
        assert contact.outcome == Outcome.RETURNED and contact.duration >= 0.0 and contact.speed >= 0.0
        if phase in ends:
            continue
        if wall * felt.at(phase) > 0.0:  # it goes in, for half a swing of the ringing or until its arc ends
            assert contact.duration > min(2.0 / math.sqrt(2.0 * oscillator.stiffness), ((ends - phase) % 1.0).min())
        else:
            thrown = 2.0 * speed / abs(felt.at(phase))
            assert contact.duration == pytest.approx(thrown, rel=1e-6, abs=1e-17) and abs(contact.speed - speed) < 1e-15


@pytest.mark.parametrize("speed", [RELEASED, 1e-20, 1e-6])
def test_departures_without_speed_from_the_ends_of_arcs_go_on(speed):
    """One of the two ends releases a gear that was pressed to +beta, the other one presses it back at once."""
    oscillator = Oscillator(0.6, 0.4, 0.6, 1000.0)
    impact = departure(oscillator, arcs_of(oscillator).begin[1], speed)
    assert impact.outcome == Outcome.RETURNED and impact.duration > 0.1
    for _ in range(100):
        impact = departure(oscillator, impact.t, impact.v)
        assert impact.outcome == Outcome.RETURNED


def test_a_soft_contact_may_be_permanent_beyond_the_bound_and_none_is_where_there_is_no_quiet_solution():
    assert SOFT.is_loose and SOFT.eccentricity < eccentricity_bound_quiet(SOFT)
    rng = np.random.default_rng(7)
    t, v = rng.random(500), 3.0 * rng.random(500)
    assert 0 < (next_impacts(SOFT, t, v).outcome == Outcome.PERMANENT_CONTACT).sum() < 500
    beyond = SOFT._replace(eccentricity=1.05 * eccentricity_bound_quiet(SOFT))
    for oscillator in (beyond, SOFT._replace(stiffness=1e3)):
        assert oscillator.eccentricity > eccentricity_bound_quiet(oscillator)
        assert (next_impacts(oscillator, t, v).outcome == Outcome.RETURNED).all()


def test_contacts_longer_than_a_rotation_are_permanent_by_the_rule_of_the_paper():
    rng = np.random.default_rng(8)
    t, v = rng.random(500), 3.0 * rng.random(500)
    exact, paper = (next_impacts(SOFT._replace(permanent_after=after), t, v).outcome for after in (math.inf, 1.0))
    assert (paper >= exact).all() and (paper > exact).any()


def test_the_way_back_is_refused_with_its_reason():
    with pytest.raises(OutsideDomain, match="a contact of finite stiffness is followed forwards only"):
        previous_impacts(SOFT, 0.1, 1.0)


@pytest.mark.parametrize("seed", range(12))
def test_histories_agree_with_an_integrator(seed):
    rng = np.random.default_rng(seed)
    damping = 10.0 ** rng.uniform(-1.0, 0.0)
    oscillator = Oscillator(
        damping, rng.uniform(1.1, 6.0) * damping / math.pi, damping * rng.uniform(0.5, 3.0), 10.0 ** rng.uniform(1, 4)
    )
    beta, scale = oscillator.half_backlash, speed_scale(oscillator)
    start = rng.uniform(-3.0, 3.0), beta * rng.uniform(-1.5, 1.5), scale * rng.uniform(-1.0, 1.0)
    history = time_history(oscillator, *start, periods=3.0, samples_per_period=97)
    assert not history.truncated
    beside = ~np.isin(history.time, history.contacts.time) & (history.time > start[0])
    found = np.array([history.displacement[beside], history.velocity[beside]])
    expected = integrated(oscillator, start, history.time[beside])
    # Twelve digits, of which contacts of three periods may cost some.
    assert (np.abs(found - expected) / np.array([[beta], [scale]])).max() < 1e-6


@pytest.mark.parametrize("seed", range(12))
def test_departures_of_histories_are_those_of_the_impact_map(seed):
    oscillator, rng, scale = random_soft_machine(seed, most_orders=2)
    t, v = rng.random(), scale * rng.uniform(0.05, 1.0)
    history = time_history(oscillator, t, oscillator.half_backlash, -v, departures=10, periods=1e3)
    contacts = history.contacts
    for i in history.departures:
        one = next_impacts(oscillator, t, v)
        t, v = float(contacts.time[i] % 1.0), float(contacts.speed[i])
        assert phase_error(float(one.t), repr(t)) < 1e-10 and one.v == pytest.approx(v, rel=1e-8)


@pytest.mark.parametrize("wall", [1.0, -1.0])
def test_start_at_rest_on_a_wall_is_followed_from_any_phase(wall):
    oscillator = Oscillator(0.6, 0.6, 0.6, 1000.0)
    for phase in (*np.arange(20) / 20, *arcs_of(oscillator).begin):
        history = time_history(oscillator, float(phase), wall * 0.6, 0.0, periods=2.0)
        assert not history.truncated and history.outcome == Outcome.RETURNED
        assert np.isfinite(history.displacement).all() and history.time[-1] == phase + 2.0


def test_orbits_return_by_an_integrator_and_are_as_loud_and_as_stable_as_their_histories():
    oscillator = check_oscillator(
        Oscillator(0.1, 1.5 * largest_eccentricity_of_one(0.1), 0.3, 1e3, contact_damping=0.2)
    )
    found = [each.orbit for each in find_orbits(oscillator, 2, velocity=(0.0, 2.0), cells=8)]
    assert any(orbit.attracts for orbit in found) and any(not orbit.attracts for orbit in found)
    for orbit in found:
        for i in range(orbit.upper_contacts):
            after = (i + 1) % orbit.upper_contacts
            time, speed, _ = integrated_loose_departure(oscillator, orbit.t[i], orbit.v[i])
            assert phase_error(orbit.t[after], repr(float(time % 1.0))) < 1e-9 and abs(orbit.v[after] - speed) < 1e-9
        if not orbit.attracts:
            continue
        growth = tangent_growth(oscillator, orbit.t[:1], orbit.v[:1], 240)
        assert growth.exponent == pytest.approx(orbit.lyapunov_exponent, abs=0.02)
        heard = loudness(oscillator, attractor_of(orbit))
        assert heard.impacts_per_period == (orbit.upper_contacts + orbit.lower_contacts) / orbit.forcing_periods
        start = orbit.t[0], oscillator.half_backlash, -orbit.v[0]
        history = time_history(oscillator, *start, departures=orbit.upper_contacts)
        entering = history.contacts.speed[history.contacts.direction == Direction.IN]
        assert heard.largest_impact_speed == pytest.approx(entering.max(), rel=1e-9)
        times = history.contacts.time
        touching = (times[1:] - times[:-1])[history.contacts.direction[1:] == Direction.OUT].sum()
        assert heard.time_in_contact == pytest.approx(touching / orbit.forcing_periods, rel=1e-9)
        assert heard.impact_power == pytest.approx(0.5 * (entering**2).sum() / orbit.forcing_periods, rel=1e-9)
