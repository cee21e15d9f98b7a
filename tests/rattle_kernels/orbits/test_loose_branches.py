"""Branches of loose gears: closed forms, the way through Gamma = 1, grazes and releases from both sides."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from rattle_kernels import (
    BranchEnd,
    Oscillator,
    SpecialKind,
    continue_orbit,
    continue_special_point,
    find_orbit,
    find_orbits,
)
from rattle_kernels.impact_map.loose_map import RELEASED
from rattle_kernels.orbits.orbit_contacts import contacts_from, rest_after
from tests.rattle_kernels.impact_map.integrator import integrated_loose_impact
from tests.rattle_kernels.orbits.test_loose_orbits import machine
from tests.rattle_kernels.reference import phase_error

TWO_PI = 2.0 * math.pi


def bound(oscillator):
    """Eccentricity at which Gamma is 1."""
    return 2.0 * oscillator.damping / math.hypot(TWO_PI, oscillator.damping)


def values(branch, kind):
    return [point.value for point in branch.special_points if point.kind == kind]


def reasons(branch):
    return [end.reason for end in branch.ends]


def displacement(oscillator, t, velocity, tau):
    """Of a flight from the wall it leaves: the sum of the forcing, a drift and what fades."""
    at = t + tau
    forcing = oscillator.eccentricity * (np.cos(TWO_PI * at) - math.cos(TWO_PI * t))
    fades = velocity + oscillator.eccentricity * TWO_PI * math.sin(TWO_PI * t) - 4.0 * math.pi
    return forcing + 4.0 * math.pi * tau - fades * np.expm1(-oscillator.damping * tau) / oscillator.damping


def nearest(oscillator, t, velocity, longest, wall):
    """Least distance of a flight from a level, from many samples and a parabola through the three lowest."""
    tau = np.linspace(longest * 1e-3, longest, 200_001)
    away = np.abs(displacement(oscillator, t, velocity, tau) - wall)
    inner = np.flatnonzero((away[1:-1] < away[:-2]) & (away[1:-1] <= away[2:])) + 1
    i = inner[away[inner].argmin()]
    left, here, right = away[i - 1 : i + 2]
    return here - (right - left) ** 2 / (8.0 * (right + left - 2.0 * here))


@pytest.mark.parametrize(("damping", "periods"), [(0.01, 1), (0.001, 2)])
def test_a_bouncing_ball_folds_and_doubles_where_its_closed_form_says(damping, periods):
    """P(m,1,0) over one turn: u = 4 pi d m - v is the speed of arrival, y(m) = 0 gives the sine, tr DP the cosine.

    With E = e^(-d m) and s = (1 - E)/d: tr DP = r (1 + r) s a/v - r (1 + E), det DP = r^2 E. As d tends to 0 these are
    Gamma = pi m (1-r)/(1+r) and Gamma^2 = [pi m (1-r)/(1+r)]^2 + [2 (1+r^2)/(1+r)^2]^2, from which they differ by O(d).
    """
    r, d, m = 0.5, damping, periods
    speed = 4.0 * math.pi * d * m * r / (1.0 + r)
    fade = math.exp(-d * m)
    stretch = -math.expm1(-d * m) / d
    phi1 = stretch / m
    sine = (speed - 4.0 * math.pi * d * m * (1.0 - phi1) / (d * m) / phi1) / TWO_PI  # eps sin(2 pi t)
    fold = abs(sine)
    felt = -speed * (1.0 - r) * (1.0 - r * fade) / (r * (1.0 + r) * stretch)
    cosine = (4.0 * math.pi * d - TWO_PI * d * sine - felt) / TWO_PI**2
    doubling = math.hypot(sine, cosine)
    limit = math.pi * m * (1.0 - r) / (1.0 + r)
    scale = bound(Oscillator(d))
    assert fold / scale == pytest.approx(limit, rel=2.0 * d * m)
    assert doubling / scale == pytest.approx(math.hypot(limit, 2.0 * (1.0 + r * r) / (1.0 + r) ** 2), rel=2.0 * d * m)

    eccentricity = 1.1 * fold
    ball = Oscillator(d, eccentricity, 1000.0 * d, restitution=r)
    start = find_orbit(ball, (0.5 - math.asin(sine / eccentricity) / TWO_PI) % 1.0, speed).orbit
    assert start.name == f"P({m},1,0)"
    branch = continue_orbit(ball, start, "eccentricity", (0.5 * fold, 1.1 * doubling))
    assert values(branch, SpecialKind.SADDLE_NODE) == [pytest.approx(fold, rel=1e-11)]
    assert values(branch, SpecialKind.PERIOD_DOUBLING) == [pytest.approx(doubling, rel=1e-11)]
    assert branch.v == pytest.approx(speed, rel=1e-9)
    # The branch of m = 1 goes on below Eq. (8), where 1.05 is the limit of its fold; that of m = 2 is all beyond it.
    assert reasons(branch) == [BranchEnd.BOUND] * 2


def test_an_impact_pair_folds_where_its_closed_form_says():
    """Where inertia alone acts, k beta = eps sqrt(4 pi^2 + k^2) at the fold; with damping d it differs by O(d)."""
    r, eccentricity = 0.6, 0.1
    k = 4.0 * (1.0 - r) / (1.0 + r)
    fold, found = eccentricity * math.hypot(TWO_PI, k) / k, []
    for damping in (0.02, 0.01):
        pair = Oscillator(damping, eccentricity, 0.4, restitution=r)
        orbits = [each.orbit for each in find_orbits(pair, 1, velocity=(0.1, 2.0), cells=8)]
        symmetric = next(orbit for orbit in orbits if orbit.name == "P(1,1,1)")
        found += values(continue_orbit(pair, symmetric, "half_backlash", (0.3, 0.8)), SpecialKind.SADDLE_NODE)
    assert len(found) == 2
    # Linear in d: what is left is O(d^2), some 1e-4 of the whole.
    assert 2.0 * found[1] - found[0] == pytest.approx(fold, rel=3e-4)
    assert abs(found[1] - fold) < 0.6 * abs(found[0] - fold)


@pytest.fixture(scope="module")
def striking():
    """P(1,1,1) at Gamma = 1.5, node and saddle, followed down through Gamma = 1 to their fold and up again."""
    pair = [each.orbit for each in find_orbits(machine(1.5), 1, velocity=(0.8, 2.0), cells=8)]
    pair = [orbit for orbit in pair if orbit.name == "P(1,1,1)"]
    return [continue_orbit(machine(1.5), orbit, "eccentricity", (0.02, 0.12)) for orbit in pair]


@pytest.fixture(scope="module")
def bouncing():
    """P(1,1,0) at Gamma = 1.5, both orbits: one folds below Gamma = 1, and both lie on one branch through it."""
    pair = [each.orbit for each in find_orbits(machine(1.5), 1, velocity=(0.2, 0.8), cells=8)]
    return [continue_orbit(machine(1.5), orbit, "eccentricity", (0.01, 0.12)) for orbit in pair]


def test_a_branch_goes_through_gamma_1_without_a_seam(bouncing):
    for branch in bouncing:
        at = branch.values - bound(machine(1.5))
        crossings = np.flatnonzero(at[:-1] * at[1:] < 0.0)
        assert crossings.size == 2  # down to the fold, and back
        for i in crossings:
            steps = np.abs(np.diff(branch.multipliers[i - 2 : i + 4], axis=0)).max(axis=1)
            assert steps[2] < 2.0 * max(steps[1], steps[3])
            for j in (i, i + 1):
                oscillator = machine(1.5).at(eccentricity=float(branch.values[j]))
                there = find_orbit(oscillator, branch.t[j, 0], branch.v[j, 0]).orbit
                assert there.t[0] == pytest.approx(branch.t[j, 0], abs=1e-9)
                assert there.v[0] == pytest.approx(branch.v[j, 0], abs=1e-9)
                assert there.multipliers.sum().real == pytest.approx(branch.trace[j], abs=1e-7)
    both = [branch.special_points for branch in bouncing]
    assert len(both[0]) == len(both[1]) >= 3
    for one, other in zip(*(sorted(points, key=lambda each: each.value) for points in both), strict=True):
        assert (one.kind, one.orbit_name) == (other.kind, other.orbit_name)
        assert one.value == pytest.approx(other.value, abs=1e-12)


def test_an_orbit_from_below_gamma_1_leads_to_the_same_branch(bouncing):
    below = machine(0.8)
    assert not below.is_loose
    orbit = find_orbits(below, 1, velocity=(0.2, 0.8), cells=8)[0].orbit
    branch = continue_orbit(below, orbit, "eccentricity", (0.01, 0.12))
    assert {*reasons(branch)} == {*reasons(bouncing[0])}
    for kind in (SpecialKind.SADDLE_NODE, SpecialKind.PERIOD_DOUBLING, SpecialKind.UPPER_GRAZING):
        assert values(branch, kind) == pytest.approx(values(bouncing[0], kind), abs=1e-12)


def test_points_of_branches_return_by_an_integrator(bouncing, striking):
    for branch in (bouncing[0], striking[0]):
        for i in range(3, branch.values.size, branch.values.size // 5):
            oscillator = machine(1.5).at(eccentricity=float(branch.values[i]))
            time, speed, lower = integrated_loose_impact(oscillator, branch.t[i, 0], branch.v[i, 0])
            assert phase_error(branch.t[i, 0], repr(float(time % 1.0))) < 1e-7
            assert speed == pytest.approx(branch.v[i, 0], abs=1e-7)
            assert lower == (branch is striking[0])


def test_a_graze_of_the_upper_wall_is_one_point_from_both_sides(bouncing):
    (end,) = (end for end in bouncing[0].ends if end.reason == BranchEnd.UPPER_GRAZING)
    (graze,) = (point for point in bouncing[0].special_points if point.kind == SpecialKind.UPPER_GRAZING)
    assert end.value == graze.value and "+beta from below" in end.message
    # A maximum touches +beta between two contacts.
    assert nearest(graze.oscillator, graze.t[0], -graze.v[0], 1.0, 0.0) < 1e-10
    assert graze.multipliers.prod().real == pytest.approx(0.7**2 * math.exp(-0.1), rel=1e-9)
    # On the other side it is a contact, and the orbit another one.
    others = [each.orbit for each in find_orbits(machine(1.5), 2, velocity=(0.0, 2.0), cells=12)]
    found = []
    for orbit in others:
        if orbit.name == "P(1,2,0)":
            branch = continue_orbit(machine(1.5), orbit, "eccentricity", (0.03, 0.09))
            assert reasons(branch) == [BranchEnd.UPPER_GRAZING] * 2
            found.append(min(abs(value - graze.value) for value in values(branch, SpecialKind.UPPER_GRAZING)))
    assert len(found) == 2 and max(found) < 1e-12


def test_a_graze_of_the_lower_wall_is_one_point_from_both_sides():
    wide = machine(3.0, 0.4, 0.1)
    orbits = find_orbits(wide, 1, velocity=(0.3, 1.0), cells=8)
    striking = next(each.orbit for each in orbits if each.orbit.name == "P(1,1,1)")
    branch = continue_orbit(wide, striking, "half_backlash", (0.05, 0.4))
    (graze,) = (point for point in branch.special_points if point.kind == SpecialKind.GRAZING)
    assert graze.oscillator.is_loose and graze.orbit_name == "P(1,1,0)"
    assert nearest(graze.oscillator, graze.t[0], -graze.v[0], 1.0, -2.0 * graze.value) < 1e-10
    missing = graze.oscillator.at(half_backlash=graze.value + 1e-3)
    orbit = find_orbit(missing, graze.t[0], graze.v[0]).orbit
    assert orbit.name == "P(1,1,0)"
    back = continue_orbit(missing, orbit, "half_backlash", (0.05, 0.4))
    assert values(back, SpecialKind.GRAZING) == [pytest.approx(graze.value, abs=1e-12)]


def test_turns_of_a_shorter_orbit_that_merge_have_its_graze():
    """P(2,2,1) becomes two turns of P(1,1,0), of which one meets -beta and the other just misses it."""
    wide = Oscillator(0.40451567271093214, 0.20417778544994755, 0.3045298521354495, restitution=0.6728239895585392)
    orbits = find_orbits(wide, 2, velocity=(0.0, 3.0), cells=8)
    orbit = next(each.orbit for each in orbits if each.orbit.name == "P(2,2,1)")
    branch = continue_orbit(wide, orbit, "half_backlash", (0.15, 0.31), direction="down")
    assert branch.ends[0].reason == BranchEnd.GRAZING
    (graze,) = branch.special_points
    assert graze.orbit_name == "P(1,1,0)" and graze.residual < 1e-10
    missing = graze.oscillator.at(half_backlash=graze.value + 1e-4)
    shorter = continue_orbit(missing, find_orbit(missing, graze.t[0], graze.v[0]).orbit, "half_backlash", (0.15, 0.31))
    assert graze.value in [pytest.approx(value, abs=1e-12) for value in values(shorter, SpecialKind.GRAZING)]


def test_where_two_arcs_become_one_rest_begins_a_contact_earlier_and_the_name_alone_changes():
    lasting = Oscillator(
        0.04865224987067225, 0.08491229547412708, 0.055859270223941174, restitution=0.16356431050810052,
        harmonics=((2, 0.025473688642238125, 0.9507765881800887),),
    )  # fmt: skip
    orbit = find_orbit(lasting, 0.866990503638, RELEASED, 2).orbit
    assert orbit.name == "P(1,2,1)*"
    branch = continue_orbit(lasting, orbit, "damping", (0.015, 0.12))
    assert reasons(branch) == [BranchEnd.RELEASE, BranchEnd.RENAMED]
    (release,) = branch.special_points
    assert release.value == branch.ends[0].value
    # Beyond, the same motion has a contact less.
    beyond = lasting.at(damping=branch.ends[1].value + 1e-9)
    assert find_orbit(beyond, branch.t[-1, branch.v[-1].argmin()], RELEASED).orbit.name == "P(1,1,1)*"


def test_halves_of_an_orbit_half_a_period_apart_are_no_doubling():
    """P(2,2,0) from Gamma = 1.2 on has departures whose phases come to differ by 1/2."""
    doubled = machine(1.5)
    orbits = find_orbits(doubled, 2, velocity=(0.3, 0.8), cells=12)
    orbit = next(each.orbit for each in orbits if each.orbit.name == "P(2,2,0)")
    branch = continue_orbit(doubled, orbit, "eccentricity", (0.03, 0.15))
    assert {*reasons(branch)} == {BranchEnd.HALVED, BranchEnd.BOUND}
    apart = (branch.t[:, 1] - branch.t[:, 0]) % 1.0
    assert apart.min() < 0.5 < apart.max()
    assert all(point.residual < 1e-10 for point in branch.special_points)


@pytest.fixture(scope="module")
def resting():
    """P(1,1,0)* at Gamma = 1.6, followed in the eccentricity and in the restitution."""
    oscillator = machine(1.6, 0.3)
    found = find_orbits(oscillator, 1, velocity=(0.0, 2.0), cells=6)
    orbit = next(each.orbit for each in found if each.orbit.rests)
    ways = (("eccentricity", (0.01, 0.2)), ("restitution", (0.05, 1.0)), ("half_backlash", (0.01, 1.0)))
    return {name: continue_orbit(oscillator, orbit, name, limits) for name, limits in ways}


def test_a_branch_of_a_resting_orbit_is_that_of_its_release(resting):
    for name, branch in resting.items():
        assert branch.attracts.all() and not branch.multipliers.any()
        assert (branch.v == RELEASED).all()
        for i in range(0, branch.values.size, 10):
            oscillator = machine(1.6, 0.3).at(**{name: float(branch.values[i])})
            felt = 4.0 * math.pi * oscillator.damping
            angle = TWO_PI * branch.t[i, 0]
            drive = TWO_PI * math.cos(angle) + oscillator.damping * math.sin(angle)
            assert felt == pytest.approx(TWO_PI * oscillator.eccentricity * drive, abs=1e-12)
            orbit = find_orbit(oscillator, branch.t[i, 0] + 1e-3, 1e-3).orbit
            assert orbit.rests and orbit.t[0] == pytest.approx(branch.t[i, 0], abs=1e-12)


def test_it_ends_at_gamma_1_where_nothing_is_released(resting):
    branch = resting["eccentricity"]
    assert branch.ends[0].reason == BranchEnd.HELD
    assert branch.ends[0].value == pytest.approx(bound(machine(1.0)), rel=1e-12)


def rate_of_release(restitution):
    """The power of the distance from a release with which a rest shrinks.

    Near the end t* of the arc a(t) is linear. Bounces that begin at t* - s with speed w |a'| s^2 and last x s depend on
    w alone: w = x/2 - x^2/6, and next it is r (x/2 - x^2/3)/(1 - x)^2. Those that accumulate at t* itself keep w. A
    deviation of w grows by mu each bounce, while s shrinks by 1 - x.
    """
    x = brentq(lambda x: restitution * (3.0 - 2.0 * x) - (1.0 - x) ** 2 * (3.0 - x), 1e-9, 1.0 - 1e-9)
    here = 0.5 - x / 3.0
    following = 0.5 - 2.0 * x / 3.0 + 2.0 * (0.5 * x - x * x / 3.0) / (1.0 - x)
    mu = restitution * following / (1.0 - x) ** 2 / here
    return -math.log1p(-x) / math.log(mu)


@pytest.mark.parametrize("name", ["eccentricity", "restitution"])
def test_towards_a_release_rest_shrinks_by_the_power_that_theory_says(resting, name):
    (release,) = (point for point in resting[name].special_points if point.kind == SpecialKind.RELEASE)
    assert resting[name].ends[1].reason == BranchEnd.RELEASE and release.orbit_name == "P(1,1,0)*"
    assert release.residual < 1e-8 and release.error < 1e-15
    left = []
    for part in (1e-6, 1e-8, 1e-10):
        oscillator = release.oscillator.at(**{name: release.value * (1.0 - part)})
        orbit = find_orbit(oscillator, release.t[0], RELEASED).orbit
        contacts = contacts_from(oscillator, 1.0, orbit.t[0], 0.0, 1)
        left.append(rest_after(oscillator, contacts, 0))
    power = rate_of_release(release.oscillator.restitution)
    # In two decades; the power itself is that of the limit.
    assert np.log(np.array(left[:-1]) / left[1:]) / math.log(100.0) == pytest.approx(power, abs=2e-3)


def bounces(oscillator, t):
    """A gear released at t, bounce by bounce, by roots of its displacement, until it is slow or misses the wall."""
    time, speed = t, 0.0
    while time == t or (speed > 1e-5 and time < t + 1.0):

        def beyond(tau, time=time, speed=speed):
            return displacement(oscillator, time, -speed, tau)

        # A bounce takes 2 v/a; the first flight is none.
        tau = np.linspace(0.05, 1.0, 4001) if time == t else np.geomspace(0.1 * speed, 1.0, 4001)
        above = np.flatnonzero(beyond(tau) >= 0.0)
        if not above.size:
            break
        end = brentq(beyond, tau[above[0] - 1], tau[above[0]], xtol=1e-15)
        drift = -speed + oscillator.eccentricity * TWO_PI * math.sin(TWO_PI * time) - 4.0 * math.pi
        time += end
        forcing = oscillator.eccentricity * TWO_PI * math.sin(TWO_PI * time)
        speed = oscillator.restitution * (4.0 * math.pi - forcing + drift * math.exp(-oscillator.damping * end))
        yield time, speed


@pytest.mark.parametrize("name", ["eccentricity", "restitution"])
def test_a_release_is_there_from_both_sides_by_brute_force(resting, name):
    (release,) = (point for point in resting[name].special_points if point.kind == SpecialKind.RELEASE)
    for side in (-1.0, 1.0):
        oscillator = release.oscillator.at(**{name: release.value * (1.0 + side * 1e-3)})
        turn = math.asin(4.0 * math.pi * oscillator.damping / (TWO_PI * oscillator.eccentricity)
                         / math.hypot(TWO_PI, oscillator.damping))  # fmt: skip
        t = (turn - math.atan2(TWO_PI, oscillator.damping)) / TWO_PI % 1.0
        assert phase_error(release.t[0], repr(t)) < 1e-3
        times, speeds = np.array(list(bounces(oscillator, t))).T
        left = t + 1.0 - times
        if side < 0.0:
            # All bounces to come take 3 v/a at most, much less than what is left of the arc: it rests before its end.
            assert speeds[-1] <= 1e-5 and left[-1] > 5e-3 and np.diff(speeds).max() < 0.0
        else:
            # It bounces on until the arc ends, and is thrown.
            assert speeds[left > 0.0].min() > 2e-5 and left.min() < 1e-2


def test_a_resting_orbit_grazes_the_lower_wall_where_its_release_falls_as_deep(resting):
    branch = resting["half_backlash"]
    assert branch.ends[0].reason == BranchEnd.GRAZING
    (graze,) = (point for point in branch.special_points if point.kind == SpecialKind.GRAZING)
    assert nearest(graze.oscillator, graze.t[0], 0.0, 0.9, -2.0 * graze.value) < 1e-9


def test_curves_of_folds_go_through_gamma_1_and_others_say_that_they_are_not_followed(striking, resting):
    fold = next(point for point in striking[0].special_points if point.kind == SpecialKind.SADDLE_NODE)
    assert fold.oscillator.is_loose
    curve = continue_special_point(fold, "half_backlash", (0.02, 0.06), (0.1, 0.5))
    loose = curve.values[:, 0] > bound(machine(1.0))
    assert loose.any() and not loose.all() and np.nanmax(curve.residual) < 1e-9
    release = resting["restitution"].special_points[-1]
    alone = continue_special_point(release, "half_backlash", (0.1, 0.9), (0.1, 0.5))
    assert len(alone.values) == 1 and all("not followed" in end for end in alone.ends)
