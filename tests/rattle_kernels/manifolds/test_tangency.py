"""Tangencies of manifolds, against polylines of the manifolds, what tips do, and how long chaos lasts beyond them."""

import math

import numpy as np
import pytest

from rattle_kernels import (
    CurveResolution,
    ManifoldLimits,
    NoTangency,
    Oscillator,
    Outcome,
    OutsideDomain,
    find_orbits,
    find_saddle,
    find_tangency,
    follow_tangency,
    largest_grazing_speed,
    manifold_gap,
    manifold_tips,
    next_impacts,
    stable_manifold,
)

# Chaos at a damping of 0.528, eps = 0.1; and below the graze of P(1,1,0) of the sequel.
CHAOS = Oscillator(damping=0.528, eccentricity=0.1, half_backlash=0.6)
SMALL = Oscillator(damping=0.762, eccentricity=0.0972, half_backlash=0.6)


@pytest.fixture(scope="module")
def saddles():
    """P(3,3,3), whose unstable manifold has the outermost tip of the chaos, and the P(3,3,2) beside the sink."""
    touching = find_saddle(CHAOS, 0.7924564435, 4.1891587831, 3)
    bounding = find_saddle(CHAOS, 0.6882465292, 4.0243343365, 3)
    assert (touching.name, bounding.name) == ("P(3,3,3)", "P(3,3,2)")
    return touching, bounding


@pytest.fixture(scope="module")
def crisis(saddles):
    (tip,) = manifold_tips(CHAOS, saddles[0], only=(0, 1))
    return find_tangency(CHAOS, saddles[0], tip, saddles[1], "damping", (0.5275, 0.5285))


@pytest.fixture(scope="module")
def homoclinic():
    saddle = find_saddle(SMALL, 0.7302, 4.7878)
    assert saddle.name == "P(1,1,0)"
    tip = manifold_tips(SMALL, saddle)[0]
    return find_tangency(SMALL, saddle, tip, saddle, "eccentricity", (0.0971, 0.0976))


def _mean_life(oscillator, leaves, departures, impacts, legs):
    """Impacts of a chaotic transient followed in legs, by those that left it; the number that left."""
    t, v = departures
    followed, left = 0, 0
    for _ in range(legs):
        landed = next_impacts(oscillator, t, v, impacts, shortcuts=True)
        going = (landed.outcome == Outcome.RETURNED) & ~leaves(oscillator, landed)
        followed += impacts * t.size
        left += int((~going).sum())
        t, v = landed.t[going], landed.v[going]
    return followed / max(left, 1), left


def _cycles(oscillator, landed):
    """Whether motions stay beside a motion of three impacts for 60 of them. In chaos errors grow e^0.26 a period."""
    t, v = landed.t, np.where(landed.outcome == Outcome.RETURNED, landed.v, 1.0)
    stays = np.ones(t.size, np.bool_)
    for _ in range(20):
        after = next_impacts(oscillator, np.where(np.isfinite(t), t, 0.0), v, 3)
        stays &= np.abs(after.v - v) < 0.05
        t, v = after.t, after.v
    return stays


def _never(oscillator, landed):
    return np.zeros(landed.t.size, np.bool_)


def _in_chaos(oscillator, time, velocity, count, leaves):
    # Scattered as Kronecker's sequence, the same each time.
    n = np.arange(40 * count)
    t = time[0] + (time[1] - time[0]) * ((n * 0.7548776662466927) % 1.0)
    v = velocity[0] + (velocity[1] - velocity[0]) * ((n * 0.5698402909980532) % 1.0)
    landed = next_impacts(oscillator, t, v, 300, shortcuts=True)
    stays = (landed.outcome == Outcome.RETURNED) & ~leaves(oscillator, landed) & (landed.v > 3.9)
    assert stays.sum() >= count
    return landed.t[stays][:count], landed.v[stays][:count]


def test_the_distance_is_that_from_a_polyline_of_the_manifold(saddles):
    touching, bounding = saddles
    scale = largest_grazing_speed(CHAOS)
    fine = CurveResolution(chord=1e-3, angle=0.02, finest=1e-5)
    grown = stable_manifold(CHAOS, bounding, ManifoldLimits(arclength=2.0), fine)
    pieces = [piece for branch in grown for piece in branch.pieces]
    seen = 0
    for tip in manifold_tips(CHAOS, touching):
        gap = manifold_gap(CHAOS, tip, bounding)
        if gap is None or gap.nearest > 0.01:
            continue
        nearest = math.inf
        for t, v in pieces:
            t = t - np.rint(t[0] - tip.t)
            begin = np.stack([t - tip.t, (v - tip.v) / scale], axis=1)
            along = np.diff(begin, axis=0)
            part = np.clip(-(begin[:-1] * along).sum(axis=1) / (along * along).sum(axis=1), 0.0, 1.0)
            nearest = min(nearest, float(np.linalg.norm(begin[:-1] + part[:, None] * along, axis=1).min()))
        # A polyline is off by chord times angle over 8.
        assert abs(gap.distance) == pytest.approx(nearest, abs=fine.chord * fine.angle / 8.0)
        seen += 1
    assert seen >= 3


def test_chaos_at_0_527_ends_where_a_tip_of_p333_touches_the_stable_manifold_of_p332(crisis):
    assert crisis.value == pytest.approx(0.5278804461295, abs=1e-12) and abs(crisis.gap.distance) < 1e-12
    assert crisis.slope > 0.0  # below that damping the tip reaches across
    inner, outer = sorted(np.abs(crisis.unstable.multipliers))
    assert crisis.exponent == pytest.approx(1.0 + math.log(outer) / -math.log(inner))


@pytest.mark.parametrize(("beyond", "falls"), [(-1e-6, True), (1e-6, False)])
def test_the_tip_falls_to_the_sink_beyond_it_and_stays_in_chaos_before_it(crisis, saddles, beyond, falls):
    oscillator = CHAOS.at(damping=crisis.value + beyond)
    touching = find_saddle(oscillator, float(crisis.unstable.t[0]), float(crisis.unstable.v[0]), 3)
    (tip,) = manifold_tips(oscillator, touching, only=(crisis.tip.point, crisis.tip.side))
    # It comes to 1e-5 of the saddle, and leaves it by ln(1e5)/ln(2.67) = 12 turns; as many again lead to the sink.
    landed = next_impacts(oscillator, [tip.t], [tip.v], 72 + crisis.gap.impacts)
    assert bool(_cycles(oscillator, landed)[0]) is falls


@pytest.mark.parametrize(("beyond", "leaks"), [(-1e-4, True), (1e-5, False)])
def test_chaos_leaks_beyond_the_crisis_alone(crisis, beyond, leaks):
    oscillator = CHAOS.at(damping=crisis.value + beyond)
    departures = _in_chaos(oscillator, (0.0, 1.0), (3.9, 4.7), 200, _cycles)
    life, left = _mean_life(oscillator, _cycles, departures, 4000, 50)
    # A life of 1.2e6 impacts, of which 4e7 are followed: 33 leave.
    assert (left > 0) is leaks
    assert not leaks or life == pytest.approx(1.2e6, rel=5.0 / math.sqrt(left))


def test_the_crisis_of_the_small_chaos_is_homoclinic_and_lives_grow_by_its_exponent(homoclinic):
    assert homoclinic.value == pytest.approx(0.09742234697, abs=1e-10)
    inner, outer = np.log(np.sort(np.abs(homoclinic.unstable.multipliers)))
    assert homoclinic.exponent == pytest.approx(inner / (inner + outer)) == pytest.approx(1.3566, abs=1e-4)
    lives = []
    for beyond, impacts in ((1e-6, 2000), (1e-5, 150)):
        oscillator = SMALL.at(eccentricity=homoclinic.value + beyond)
        departures = _in_chaos(oscillator, (0.715, 0.76), (4.75, 4.9), 1000, _never)
        life, left = _mean_life(oscillator, _never, departures, impacts, 80)
        assert left > 900
        lives.append(life)
    power = math.log10(lives[0] / lives[1])
    # It is that in the limit; from 1e-5 on it rises from 1.2. Each life has an error of 3 %.
    assert 1.2 - 0.04 < power < homoclinic.exponent + 0.04
    before = SMALL.at(eccentricity=homoclinic.value - 1e-6)
    life, left = _mean_life(before, _never, _in_chaos(before, (0.715, 0.76), (4.75, 4.9), 200, _never), 20_000, 4)
    assert left == 0


def test_it_is_followed_in_a_second_parameter_and_back(crisis):
    values = 0.1 + 2e-4 * np.arange(1, 6)
    curve = follow_tangency(crisis, "eccentricity", values)
    assert [found.oscillator.eccentricity for found in curve] == values.tolist()
    assert max(abs(found.gap.distance) for found in curve) < 1e-12
    back = follow_tangency(curve[-1], "eccentricity", values[3::-1])
    assert [found.value for found in back] == pytest.approx([found.value for found in curve[3::-1]], abs=1e-12)
    near, far = follow_tangency(curve[-1], "eccentricity", [values[-1], 0.1])
    assert near is curve[-1]
    assert far.value == pytest.approx(crisis.value, abs=1e-12)


def test_what_is_no_tangency_says_why(crisis, saddles):
    touching, bounding = saddles
    (tip,) = manifold_tips(CHAOS, touching, only=(0, 1))
    with pytest.raises(NoTangency, match=r"same side at both bounds: .* at damping = 0\.5279.*, .* at 0\.5285"):
        find_tangency(CHAOS, touching, tip, bounding, "damping", (0.5279, 0.5285))
    with pytest.raises(ValueError, match=r"only must be a point of P\(3,3,3\), 0 to 2, and \+1 or -1"):
        manifold_tips(CHAOS, touching, only=(3, 1))
    quiet = next(
        found.orbit for found in find_orbits(CHAOS, 1) if found.orbit.name == "P(1,1,0)" and not found.orbit.attracts
    )
    with pytest.raises(NoTangency, match="does not follow the stable manifold of P\\(1,1,0\\)"):
        find_tangency(CHAOS, touching, tip, quiet, "damping", (0.5275, 0.5285))
    with pytest.raises(OutsideDomain, match="Eq. 8"):
        manifold_tips(CHAOS.at(eccentricity=0.4), touching)
    with pytest.raises(NoTangency, match="lost at eccentricity = 0.2, after 0 values"):
        follow_tangency(crisis, "eccentricity", [0.2])
    with pytest.raises(ValueError, match="another than the first, damping"):
        follow_tangency(crisis, "damping", [0.53])
