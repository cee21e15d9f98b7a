"""What a graze does: by an ODE integrator, by the orbit on its other side, by following motions."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rattle_kernels import (
    BranchEnd,
    GrazeScenario,
    Oscillator,
    SpecialKind,
    attractor_beyond,
    continue_orbit,
    find_orbits,
    graze_kind,
    grazing_velocity,
    next_impacts,
    orbit_beyond_graze,
)
from rattle_kernels.orbits.closure import OrbitShape, closure
from tests.rattle_kernels.orbits.grazes import BETWEEN, exponent_of_the_map, graze_of_single_contact


def turn_by_an_integrator(point, phase):
    """N of an orbit with one contact a turn, by differences of an ODE integrator's states at the touch."""
    damping, eccentricity, half_backlash = point.oscillator[:3]
    restitution = point.oscillator.restitution

    def acceleration(t, rate):
        angle = 2 * math.pi * t
        forcing = 2 * math.pi * math.cos(angle) + damping * math.sin(angle)
        return 4 * math.pi * damping - 2 * math.pi * eccentricity * forcing - damping * rate

    def meets(_, state):
        return state[0] - 2 * half_backlash

    meets.terminal, meets.direction = True, 1.0
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}

    def after_a_turn(height, rate):
        # Heights are above -beta. The touch is a minimum, which the integrator passes.
        here, end, state = phase, phase + 1.0, [height, rate]
        while here < end:
            ran = solve_ivp(lambda t, y: [y[1], acceleration(t, y[1])], (here, end), state, events=meets, **options)
            here, state = float(ran.t[-1]), ran.y[:, -1].tolist()
            if ran.status == 1:
                state = [2 * half_backlash, -restitution * state[1]]
        return np.array(state)

    step = 1e-4
    return np.column_stack(
        [(after_a_turn(*(step * one)) - after_a_turn(*(-step * one))) / (2 * step) for one in np.eye(2)]
    )


@pytest.mark.parametrize(
    "oscillator", [BETWEEN, Oscillator(0.3, 0.0543, 0.3, restitution=0.9), Oscillator(0.65, 0.13, half_backlash=0.5)]
)
def test_the_turn_at_the_touch_is_that_of_an_integrator(oscillator):
    point = graze_of_single_contact(oscillator)
    kind = graze_kind(point)
    # Differences err by the third derivative times the square of the step, some 1e-6, and by rounding over the step.
    np.testing.assert_allclose(kind.monodromy, turn_by_an_integrator(point, kind.phase), atol=1e-6)
    assert np.linalg.det(kind.monodromy) == pytest.approx(math.exp(-point.value) * oscillator.restitution**2, rel=1e-12)


def test_the_turn_has_the_multipliers_of_the_orbit_that_misses():
    point = graze_of_single_contact(BETWEEN)
    assert sorted(graze_kind(point).multipliers.real) == pytest.approx(sorted(point.multipliers.real), abs=1e-12)


GRAZING = [
    Oscillator(0.575),
    Oscillator(0.32, 0.0543, 0.3, restitution=0.9),
    pytest.param(Oscillator(0.6, 0.08, harmonics=((2, 0.01, 0.3),)), marks=pytest.mark.slow),
    pytest.param(Oscillator(0.45, 0.1, half_backlash=0.4), marks=pytest.mark.slow),
]


@pytest.mark.parametrize("oscillator", GRAZING)
def test_the_orbit_that_hits_lies_where_it_is_said_to(oscillator):
    scenarios = set()
    for found in find_orbits(oscillator, longest=2, cells=16):
        branch = continue_orbit(oscillator, found.orbit, "damping", (0.2, 0.9))
        for point in branch.special_points:
            if point.kind != SpecialKind.GRAZING or point.oscillator.is_loose:
                continue
            kind, other = graze_kind(point), orbit_beyond_graze(point, 1e-4)
            assert other is not None and (other[0].damping > point.value) == (kind.hits > 0)
            assert other[1].lower_contacts == point.lower_contacts + 1
            nearest = branch.values[np.argmin(np.abs(branch.values - point.value))]
            followed = found.orbit.lower_contacts == point.lower_contacts
            assert (nearest > point.value) == ((kind.misses if followed else kind.hits) > 0)
            scenarios.add(kind.scenario)
    assert scenarios


def test_papers_grazes_are_a_fold_and_a_change_of_name():
    (double,) = (each.orbit for each in find_orbits(Oscillator(0.585), longest=4) if each.orbit.name == "P(4,4,2)")
    (point,) = (
        end for end in continue_orbit(Oscillator(0.585), double, "damping", (0.583, 0.6)).special_points
        if end.kind == SpecialKind.GRAZING
    )  # fmt: skip
    kind = graze_kind(point)
    assert kind.scenario == GrazeScenario.FOLDS and kind.misses == kind.hits == -1
    (single,) = (each.orbit for each in find_orbits(Oscillator(0.575), longest=2) if each.orbit.name == "P(2,2,1)")
    branch = continue_orbit(Oscillator(0.575), single, "damping", (0.5, 0.58))
    assert branch.ends[0].reason == BranchEnd.GRAZING
    (point,) = (each for each in branch.special_points if each.kind == SpecialKind.GRAZING)
    kind = graze_kind(point)
    assert kind.scenario == GrazeScenario.PERSISTS and kind.misses == 1 and kind.hits == -1
    assert attractor_beyond(kind, 1e-6) is None, "multipliers are complex: a later turn hits deeper"


@pytest.mark.parametrize("distance", [3e-6, pytest.param(3e-5, marks=pytest.mark.slow)])
def test_chaos_begins_at_once_as_the_leading_terms_say(distance):
    """Multipliers 0.90 and 0.52: no windows of periodic motion follow the graze (Nordmark)."""
    point = graze_of_single_contact(BETWEEN)
    kind = graze_kind(point)
    assert kind.scenario == GrazeScenario.PERSISTS and kind.misses == 1
    there = attractor_beyond(kind, distance)
    beyond = point.oscillator.at(damping=point.value - distance)
    exponent, impacts = exponent_of_the_map(beyond, float(point.t[0]), float(point.v[0]), 20_000)
    # Terms of the size of the push are left out: relative to the turn's own size, 20 times the root of the depth.
    left_out = 20.0 * math.sqrt(kind.rate * distance)
    assert exponent > 0.0
    assert there.exponent == pytest.approx(exponent, rel=left_out)
    assert there.impacts == pytest.approx(impacts, rel=left_out)


def least_stretch(kind, depth):
    """By how much each return to -beta stretches at least, by leading terms, and the widest cone (theory, Grazes)."""
    slower, faster = sorted(kind.multipliers.real)
    part, push = kind.monodromy[0, 1] / (faster - slower), 1.0 + kind.restitution
    widest, beside = 2.0 * slower / (faster - slower), slower / (faster - slower)
    steep = part * push * math.sqrt(kind.acceleration / (2.0 * (1.0 - faster) * depth))
    assert kind.monodromy[0, 1] * push * math.sqrt(2.0 * kind.acceleration) >= faster * math.sqrt((1 - faster) * depth)
    assert (1.0 - slower / faster) * (steep - widest) >= 2.0
    # Beyond so many turns both powers are nothing beside 1.
    n = np.arange(1.0, 2000.0)
    soon = (faster**n - slower**n) * (steep - widest) - faster**n
    late = (faster - faster**n * (1.0 + beside)) / (2.0 * (1.0 - faster)) - faster**n * (1.0 + widest)
    return float(np.maximum(soon, late).min()), widest


@pytest.mark.parametrize(("distance", "told"), [(3e-7, 4.17), (3e-6, 3.66), (3e-5, 2.41), (1e-4, 1.65)])
def test_each_return_stretches_by_leading_terms(distance, told):
    """From anywhere in the region that is never left, along both edges of the cone."""
    kind = graze_kind(graze_of_single_contact(BETWEEN))
    depth, push = kind.rate * distance, 1.0 + kind.restitution
    least, widest = least_stretch(kind, depth)
    assert told < least < told + 0.01
    # All are real, which NumPy tells by another type only before 2.5.
    multipliers, vectors = (each.real for each in np.linalg.eig(kind.monodromy))
    vectors = vectors / vectors[0]
    slower, faster = sorted(multipliers)
    slow, fast = np.argmax(multipliers), np.argmin(multipliers)
    random = np.random.default_rng(0)
    returns = []
    for _ in range(200):
        # Heights from the lowest to where the flight misses, and as far along the other direction as the region goes.
        x = -(random.uniform(0.0, 1.0) ** 4) * (1.0 - faster) * depth
        along = (x + depth) / (1.0 - random.uniform(0.0, 1.0) * slower / faster)
        place = np.empty(2)
        place[slow], place[fast] = along, x + depth - along
        place = vectors @ place
        for cone in (0.0, widest):
            z, tangent = place.copy(), vectors[:, slow] * (1.0 + cone) - vectors[:, fast] * cone
            while True:
                if z[0] < depth:
                    u = math.sqrt(2.0 * kind.acceleration * (depth - z[0]))
                    z[1] += push * u
                    tangent[1] -= push * kind.acceleration / u * tangent[0]
                z, tangent = kind.monodromy @ z, kind.monodromy @ tangent
                assert z[0] >= faster * depth * (1.0 - 1e-9)
                if z[0] < depth:
                    break
            returns.append(abs(tangent[0]))
            turned = -np.linalg.solve(vectors, tangent)[fast] / tangent[0]
            assert 0.0 <= turned <= widest
    assert min(returns) >= least


@pytest.mark.parametrize("distance", [3e-6, 1e-3])
def test_each_return_of_the_map_itself_stretches(distance):
    """The change of the height of the lowest point, from one flight that meets -beta to the next."""
    point = graze_of_single_contact(BETWEEN)
    oscillator = point.oscillator.at(damping=point.value - distance)
    t, v = float(point.t[0]), float(point.v[0])
    along, logarithm, before, stretches = np.array([1.0, 0.3]), 0.0, None, []
    for n in range(4000):
        off = v - grazing_velocity(oscillator, t)
        bend = (grazing_velocity(oscillator, t + 1e-6) - grazing_velocity(oscillator, t - 1e-6)) / 2e-6
        if off > 0.0 and n > 500:
            there = logarithm + math.log(abs(along[1] - bend * along[0]))
            if before is not None:
                stretches.append(there - before)
            before = there
        along = closure(oscillator, "damping", OrbitShape(1, 1), t, v).jacobian @ along
        length = np.linalg.norm(along)
        along, logarithm = along / length, logarithm + math.log(length)
        landed = next_impacts(oscillator, t, v)
        t, v = float(landed.t), float(landed.v)
    assert len(stretches) > 50 and min(stretches) > 0.0


def test_its_size_grows_like_the_root_of_the_distance():
    kind = graze_kind(graze_of_single_contact(BETWEEN))
    small, large = attractor_beyond(kind, 1e-8), attractor_beyond(kind, 1e-6)
    # Up to the powers of the multipliers between two impacts, which are whole numbers of turns.
    assert 5.0 < large.size / small.size < 20.0


def test_a_graze_beyond_eq_8_has_no_flight_that_passes_and_other_points_are_refused():
    point = graze_of_single_contact(BETWEEN)
    assert graze_kind(point._replace(oscillator=point.oscillator._replace(eccentricity=0.9, restitution=0.8))) is None
    with pytest.raises(ValueError, match="must be a graze of -beta"):
        graze_kind(point._replace(kind=SpecialKind.SADDLE_NODE))
