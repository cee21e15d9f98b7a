"""P beyond the bound of Eq. (8): against references, an integrator, closed forms, and what must hold."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from rattle_kernels import Oscillator, Outcome, grazing_velocity, next_impacts, previous_impacts
from rattle_kernels.impact_map.loose_map import RELEASED
from rattle_kernels.model.arcs import arcs_of, largest_eccentricity_of_one
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit
from tests.rattle_kernels.impact_map.integrator import integrated_loose_impact
from tests.rattle_kernels.impact_map.scalar_map import bounce, bounce_with_derivative, departure, derivative
from tests.rattle_kernels.reference import phase_error, speed_error

_TABLE = json.loads((Path(__file__).parents[1] / "data" / "beyond.json").read_text())


def _oscillator(entry):
    names = "damping", "eccentricity", "half_backlash", "restitution"
    harmonics = tuple(map(tuple, entry["harmonics"]))
    return check_oscillator(Oscillator(**{name: entry[name] for name in names}, harmonics=harmonics))


def _start(entry):
    return float.fromhex(entry["t"]), float.fromhex(entry["v"])


def _name(entry):
    return f"{len(entry['harmonics'])}-{entry['restitution']}"


@pytest.mark.parametrize("entry", _TABLE["applications"], ids=_name)
def test_next_departure_agrees_with_the_reference(entry):
    oscillator = _oscillator(entry)
    assert oscillator.is_loose
    impact, rests_below = bounce(oscillator, *_start(entry))
    assert (impact.outcome, rests_below) == (Outcome.RETURNED, entry["sticks_below"])
    assert impact.lower_impacts == entry["lower_impacts"]
    assert phase_error(impact.t, entry["t_next"]) <= 1e-13
    assert speed_error(impact.v, entry["v_next"]) <= 1e-12
    assert impact.duration == pytest.approx(float(entry["duration"]), rel=1e-12)


@pytest.mark.parametrize("entry", _TABLE["rests"], ids=_name)
def test_motion_that_comes_to_rest_is_released_where_its_arc_ends(entry):
    oscillator, (t, v) = _oscillator(entry), _start(entry)
    for _ in range(10_000):
        t, v, _, outcome, _ = departure(oscillator, t, v)
        assert outcome == Outcome.RETURNED
        if v == RELEASED:
            break
    assert v == RELEASED and phase_error(t, entry["released_at"]) <= 1e-11


# Gamma is inertia torque over drag torque, 1 at the bound of Eq. (8).
def random_machine(seed, *, most_orders=3, least_gamma=1.05, largest_gamma=32.0):
    rng = np.random.default_rng(seed)
    damping = 10.0 ** rng.uniform(-2.0, 0.0)
    orders = np.concatenate([[1], rng.choice(np.arange(2, most_orders + 30), rng.integers(0, most_orders), False)])
    shares, phases = rng.dirichlet(np.ones(orders.size)), rng.random(orders.size)
    rates = 2.0 * math.pi * orders
    gamma = math.exp(rng.uniform(math.log(least_gamma), math.log(largest_gamma)))
    # Bounds on what each order adds to the acceleration.
    amplitudes = shares * gamma * 4.0 * math.pi * damping / (rates * np.hypot(rates, damping))
    harmonics = tuple(zip(orders[1:].tolist(), amplitudes[1:].tolist(), phases[1:].tolist(), strict=True))
    restitution = rng.choice([0.6, 0.7, 0.8, 0.9, 0.95, 1.0])
    half_backlash = damping * 10.0 ** rng.uniform(-1.0, 1.0)
    machine = Oscillator(damping, amplitudes[0], half_backlash, restitution=restitution, harmonics=harmonics)
    scale = math.sqrt(4.0 * half_backlash * 4.0 * math.pi * damping * gamma)
    return check_oscillator(machine), rng, scale


@pytest.mark.parametrize("seed", range(12))
def test_next_departure_agrees_with_an_ode_integrator(seed):
    oscillator, rng, scale = random_machine(seed, most_orders=2)
    t, v = rng.random(), scale * rng.uniform(0.05, 1.0)
    impact, rests_below = bounce(oscillator, t, v)
    assert impact.outcome == Outcome.RETURNED
    if rests_below or impact.lower_impacts > 20:
        pytest.skip("bounces that accumulate are no task for an integrator")
    time, speed, lower = integrated_loose_impact(oscillator, t, v)
    assert impact.lower_impacts == lower
    assert phase_error(impact.t, repr(float(time % 1.0))) < 1e-8
    assert abs(impact.v - speed) < 1e-7 * scale


def _loss(r):
    return (1.0 - r) / (1.0 + r)


_BALLS = [(m, r, gamma) for m in (1, 2, 3) for r in (0.6, 0.8, 0.95, 1.0) for gamma in (1.5, 3.0, 6.0)]


@pytest.mark.parametrize(("m", "r", "gamma"), [each for each in _BALLS if each[2] > math.pi * each[0] * _loss(each[1])])
def test_bouncing_ball_has_its_orbits_and_multipliers_in_closed_form(m, r, gamma):
    damping = 1e-10
    ball = check_oscillator(Oscillator(damping, gamma * damping / math.pi, 1.0, restitution=r))
    v, sine = 4.0 * math.pi * damping * m * r / (1.0 + r), -math.pi * m * _loss(r) / gamma
    motions = 0
    for cosine in (-math.sqrt(1.0 - sine * sine), math.sqrt(1.0 - sine * sine)):
        t = math.atan2(sine, cosine) / (2.0 * math.pi) % 1.0
        (impact, _), (_, jacobian) = bounce(ball, t, v), derivative(ball, t, v)
        if impact.duration < m - 0.01:  # the ground is in the way of this one
            continue
        motions += 1
        assert phase_error(impact.t, repr(t)) < 1e-8 and impact.v == pytest.approx(v, rel=1e-8)
        determinant = jacobian.tt * jacobian.vv - jacobian.tv * jacobian.vt
        assert determinant == pytest.approx(r * r, rel=1e-6)
        # It is -1 - r^2, and the orbit doubles, where gamma cos = 2 (1 + r^2)/(1 + r)^2.
        trace = (1.0 + r) ** 2 * (1.0 - gamma * cosine) - 2.0 * r
        assert jacobian.tt + jacobian.vv == pytest.approx(trace, rel=1e-6, abs=1e-6)
    assert motions > 0


def _impact_pairs(half_backlash, eccentricity, r):
    """Symmetric motions of period 1 with one impact on each wall, without damping and drag: phase, speed, DP's trace.

    y'' = e'', e = eps cos 2 pi t. By symmetry half a period leads from one wall to the other, where speed, phase and
    signs come again. A departure of speed v at the angle theta = 2 pi t arrives with v + 2 e', and leaves with r times
    that: e' = v (1 - r)/(2 r). It crosses 2 beta: v + e' = 4 (beta - eps cos theta). Without e' = -2 pi eps sin theta
    and v = 8 r (beta - eps cos theta)/(1 + r) that is 2 pi eps sin theta - k eps cos theta = -k beta,
    k = 4 (1 - r)/(1 + r).
    With c = e'' and V = v/r, the speed of arrival, and q = c/(2 V), the derivative over half a period is

        H = (r - q,  -1/(2 V);  r c (1 + r - q),  r (1 - q)),

    of determinant r^2 and trace 2 r - (1 + r) q. DP is H^2.
    """
    k = 4.0 * _loss(r)
    size, lag = eccentricity * math.hypot(2.0 * math.pi, k), math.atan2(k, 2.0 * math.pi)
    if k * half_backlash >= size:
        return
    turn = math.asin(-k * half_backlash / size)
    for angle in (lag + turn, lag + math.pi - turn):
        v = 8.0 * r * (half_backlash - eccentricity * math.cos(angle)) / (1.0 + r)
        t, slope = angle / (2.0 * math.pi) % 1.0, -2.0 * math.pi * eccentricity * math.sin(angle)
        tau = np.linspace(0.0, 0.5, 2002)[1:-1]
        change = eccentricity * (np.cos(2.0 * math.pi * (t + tau)) - math.cos(angle))
        if v > 0.0 and (np.abs(half_backlash - v * tau + change - slope * tau) < half_backlash).all():
            q = -2.0 * math.pi**2 * eccentricity * math.cos(angle) * r / v
            half = 2.0 * r - (1.0 + r) * q
            yield t, v, q, half * half - 2.0 * r * r


_PAIRS = [(beta, eps, r) for beta in (0.3, 0.6) for eps in (0.05, 0.1, 0.2) for r in (0.6, 0.8, 0.95, 1.0)]


@pytest.mark.parametrize(("half_backlash", "eccentricity", "r"), [each for each in _PAIRS if [*_impact_pairs(*each)]])
def test_impact_pair_has_its_orbits_in_closed_form(half_backlash, eccentricity, r):
    damping = 1e-8
    machine = check_oscillator(Oscillator(damping, eccentricity, half_backlash, restitution=r))
    for t, v, q, _ in _impact_pairs(half_backlash, eccentricity, r):
        # What damping and drag add to y'' is below this: |y'| is at most v + 2 max|e'|. They act for half a period.
        added = damping * (4.0 * math.pi + 2.0 * math.pi * eccentricity + v + 4.0 * math.pi * eccentricity)
        place, speed = added / 8.0, added / 2.0
        # The impact is later by what is missing of its way, and y'' = -c acts for so long; then H carries both.
        V, c = v / r, abs(2.0 * q * v / r)
        late, faster = place / V, r * (speed + c * place / V)
        phase_bound = late + abs(r - q) * late + faster / (2.0 * V)
        speed_bound = faster + r * c * abs(1.0 + r - q) * late + r * abs(1.0 - q) * faster
        impact, _ = bounce(machine, t, v)
        assert impact.outcome == Outcome.RETURNED and impact.lower_impacts == 1
        # Terms of second order in damping are 1e-8 of these.
        assert phase_error(impact.t, repr(t)) < 1.01 * phase_bound and abs(impact.v - v) < 1.01 * speed_bound


@pytest.mark.parametrize(("half_backlash", "eccentricity", "r"), [each for each in _PAIRS if [*_impact_pairs(*each)]])
def test_impact_pair_has_its_multipliers_in_closed_form(half_backlash, eccentricity, r):
    for t, v, _, trace in _impact_pairs(half_backlash, eccentricity, r):
        traces = []
        for damping in (1e-6, 5e-7):
            machine = check_oscillator(Oscillator(damping, eccentricity, half_backlash, restitution=r))
            orbit = find_periodic_orbit(machine, t, v, 1, v)
            assert orbit.name == "P(1,1,1)"
            # Of areas v dv dt damping leaves e^{-delta} in a period, and each impact r^2.
            assert np.linalg.det(orbit.jacobians[0]) == pytest.approx(r**4 * math.exp(-damping), rel=1e-8)
            traces.append(np.trace(orbit.jacobians[0]))
        # Half the damping leaves half of what is of first order in it. What is of second order is less by its size.
        whole, half = traces
        assert abs(2.0 * half - whole - trace) < 0.01 * abs(whole - trace)


def _assert_lands_alike(found, i, impact, jacobian, v):
    """A lane lands where the scalar path does: next to a graze the end moves with the inverse speed."""
    assert (found.lower_impacts[i], found.outcome[i]) == (impact.lower_impacts, impact.outcome)
    if impact.outcome != Outcome.RETURNED:
        return
    moves = np.abs(np.array(jacobian)) * np.array([1.0, v, 1.0, v])
    assert phase_error(found.t[i], repr(impact.t)) <= 1e-12 * max(1.0, moves[:2].max())
    assert abs(found.v[i] - impact.v) <= 1e-12 * max(impact.v, v, moves[2:].max())


@pytest.mark.parametrize("seed", range(12))
def test_lanes_follow_the_scalar_path(seed):
    oscillator, rng, scale = random_machine(seed, most_orders=2)
    t, v = rng.random(300), scale * 10.0 ** rng.uniform(-4.0, 0.3, 300)
    once, settled = next_impacts(oscillator, t, v), next_impacts(oscillator, t, v, shortcuts=True)
    for i in range(t.size):
        _assert_lands_alike(once, i, *bounce_with_derivative(oscillator, t[i], v[i]), v[i])
        _assert_lands_alike(settled, i, *derivative(oscillator, t[i], v[i]), v[i])


@pytest.mark.parametrize("damping", [0.1, 0.6])
def test_lanes_follow_the_scalar_path_where_the_acceleration_at_rest_has_one_zero(damping):
    """Gamma = 1: what comes to rest stays; bounces that reach the zero of a(t), some of them on an orbit, go on."""
    oscillator = Oscillator(damping, largest_eccentricity_of_one(damping), 0.3, restitution=0.7)
    assert arcs_of(oscillator).begin.size == 1
    rng = np.random.default_rng(1)
    t, v = rng.random(300), 10.0 ** rng.uniform(-4.0, 1.0, 300)
    once, settled = next_impacts(oscillator, t, v), next_impacts(oscillator, t, v, shortcuts=True)
    for i in range(t.size):
        _assert_lands_alike(once, i, *bounce_with_derivative(oscillator, t[i], v[i]), v[i])
        _assert_lands_alike(settled, i, *derivative(oscillator, t[i], v[i]), v[i])
    assert 0 < (settled.outcome == Outcome.PERMANENT_CONTACT).sum() < t.size


@pytest.mark.parametrize("seed", range(12))
def test_previous_impact_undoes_an_impact_without_a_rest(seed):
    oscillator, rng, scale = random_machine(seed, most_orders=2)
    t, v = rng.random(200), scale * 10.0 ** rng.uniform(-2.0, 0.3, 200)
    tried = 0
    for i in range(t.size):
        loose, forwards = bounce(oscillator, t[i], v[i]), bounce_with_derivative(oscillator, t[i], v[i])[1]
        impact = loose.impact
        if loose.rests_below or impact.outcome != Outcome.RETURNED or impact.v == RELEASED:
            continue
        tried += 1
        back = previous_impacts(oscillator, impact.t, impact.v)
        assert (back.outcome, back.lower_impacts) == (Outcome.RETURNED, impact.lower_impacts)
        # Rounding of the end moves the beginning by the derivative of the inverse. Of P the determinant is known: an
        # impact multiplies v dv dt by r^2, and a flight by e^(-delta tau).
        a, b, c, d = forwards
        kept, damped = oscillator.restitution ** (2 * impact.lower_impacts + 2), oscillator.damping * impact.duration
        determinant = kept * math.exp(-damped) * v[i] / impact.v
        moves = np.abs(np.array([d, b, c, a])) / determinant
        allowed = 1e-13 * max(1.0, moves[0] + moves[1] * impact.v)
        assert phase_error(back.t, repr(float(t[i]))) <= allowed
        assert abs(back.v - v[i]) <= 1e-13 * max(v[i], moves[2] + moves[3] * impact.v)
    assert tried > 100


def test_nothing_comes_before_a_release():
    back = previous_impacts(Oscillator(0.6, 0.22, 0.6, restitution=0.7), [0.3, 0.3], [RELEASED, 0.2])
    assert back.outcome.tolist() == [Outcome.OUTSIDE_SECTION, Outcome.RETURNED]
    assert np.isnan(back.t).tolist() == np.isnan(back.v).tolist() == [True, False]


def test_a_lane_of_a_loose_gear_does_not_depend_on_its_neighbours():
    oscillator, rng, scale = random_machine(3, most_orders=2)
    t, v = rng.random(150), scale * 10.0 ** rng.uniform(-3.0, 0.3, 150)
    together = next_impacts(oscillator, t, v, applications=40, shortcuts=True)
    for i in range(0, t.size, 7):
        alone = next_impacts(oscillator, t[i:], v[i:], applications=40, shortcuts=True)
        for field, later in zip(together, alone, strict=True):
            np.testing.assert_array_equal(field[i:], later)


def _follow(seeds, departures, applications, **drawn):
    """How random departures of random machines end, and what is no number or no phase without a name."""
    outcomes, nameless = np.zeros(len(Outcome), np.int64), 0
    for seed in seeds:
        oscillator, rng, scale = random_machine(seed, **drawn)
        t, v = rng.random(departures), scale * 10.0 ** rng.uniform(-12.0, 1.0, departures)
        after = next_impacts(oscillator, t, v, applications, shortcuts=True)
        outcomes += np.bincount(after.outcome, minlength=len(Outcome))
        lands = (0.0 <= after.t) & (after.t < 1.0) & (after.v > 0.0) & np.isfinite(after.v)
        nameless += int((~lands & (after.outcome == Outcome.RETURNED)).sum())
    return outcomes, nameless


def test_random_departures_of_random_machines_never_end_without_a_name():
    outcomes, nameless = _follow(range(40), 250, 4, most_orders=2, least_gamma=1.05)
    assert nameless == 0 and outcomes[Outcome.NOT_CONVERGED] == outcomes[Outcome.OUTSIDE_SECTION] == 0


@pytest.mark.slow
def test_a_million_random_departures_never_end_without_a_name():
    outcomes, nameless = _follow(range(1000), 1000, 4, least_gamma=0.6)
    assert nameless == 0 and outcomes[Outcome.NOT_CONVERGED] == outcomes[Outcome.OUTSIDE_SECTION] == 0


def test_machine_below_the_bound_is_followed_as_before():
    oscillator = check_oscillator(Oscillator())
    assert not oscillator.is_loose and oscillator.in_kernels is oscillator
    assert check_oscillator(Oscillator(eccentricity=0.2)).is_loose


@pytest.mark.parametrize(("gamma", "r"), [(1.1, 0.7), (2.0, 0.9), (4.0, 1.0), (16.0, 0.6)])
def test_grazing_curve_divides_departures_that_meet_the_lower_wall_from_those_that_come_back(gamma, r):
    oscillator = Oscillator(0.6, gamma * 0.6 / math.pi, 0.6, restitution=r)
    t = np.arange(200) / 200
    speeds = grazing_velocity(oscillator, t)
    above = next_impacts(oscillator, t, np.maximum(speeds * (1.0 + 1e-9), 1e-9))
    below = next_impacts(oscillator, t, np.maximum(speeds * (1.0 - 1e-9), 1e-12))
    assert (above.lower_impacts[speeds > 0.0] > 0).all() and (below.lower_impacts[speeds > 0.0] == 0).all()
    assert (above.lower_impacts[speeds == 0.0] > 0).all() and np.isfinite(speeds).all()
