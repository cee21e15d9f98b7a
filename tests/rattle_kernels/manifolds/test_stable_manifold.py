"""Manifolds of saddles: where their points go, that they are invariant, where their smooth arcs end."""

import functools

import numpy as np
import pytest

from rattle_kernels import Oscillator, OutsideDomain, grazing_velocity
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.manifolds.polyline import CurveResolution, chord_lengths, turning_angles
from rattle_kernels.manifolds.saddle import NotASaddle, directions, find_saddle
from rattle_kernels.manifolds.stable_manifold import (
    ManifoldEnd,
    ManifoldLimits,
    stable_manifold,
    unstable_manifold,
)
from tests.rattle_kernels.impact_map.scalar_map import apply
from tests.rattle_kernels.manifolds.polylines import distance_to

PAPER = Oscillator()
BEFORE_FOLD = PAPER._replace(damping=0.575)
# Figs. 15-17: A and B; a P(1,1,1) that flips, within chaos; Fig. 10: the saddle that collides with the attracting
# P(1,2,0) at damping 0.5997.
SADDLES = {
    "P(1,1,0)": (PAPER, 0.6, 3.77, 1),
    "P(1,1,1)": (PAPER, 0.89, 3.988, 1),
    "P(1,1,1) in chaos": (PAPER, 0.63, 4.57, 1),
    "P(1,2,0)": (BEFORE_FOLD, 0.786, 1.613, 2),
}
# Beyond Eq. (8): P jumps where a flight grazes +beta from below.
LOOSE = {
    "P(1,1,0) of loose gears": (Oscillator(eccentricity=0.4, restitution=0.7), 0.5679, 3.1046, 1),
    "P(1,1,2) of loose gears": (Oscillator(0.3, 0.6, 0.6, restitution=0.9), 0.57792, 6.82786, 1),
}
ALL = SADDLES | LOOSE
# Rounding, 1e-15, grows by 3 where the distance along a stable manifold falls by 5. Along an unstable one it is the
# other way round, and roots at corners come in addition: shorter ones, and less close.
LENGTHS = {stable_manifold: 10.0, unstable_manifold: 3.0}
RNG = np.random.default_rng(1)


@functools.cache
def saddle_of(name):
    oscillator, t, v, period = ALL[name]
    return oscillator, find_saddle(oscillator, t, v, period), lane_tables(oscillator).largest_grazing_speed


@functools.cache
def manifold_of(name, grow):
    oscillator, saddle, _ = saddle_of(name)
    return grow(oscillator, saddle, ManifoldLimits(LENGTHS[grow]))


def unsettled_pieces(branches):
    """Arcs of the branches, those left out that end in an attracting orbit, from which rounding knows no way back."""
    return [piece for branch in branches if branch.end != ManifoldEnd.SETTLED for piece in branch.pieces]


def inner_points(branches):
    """Points that are no ends of arcs."""
    pieces = [piece for piece in unsettled_pieces(branches) if piece.t.size > 2]
    t = np.concatenate([piece.t[1:-1] for piece in pieces])
    return t, np.concatenate([piece.v[1:-1] for piece in pieces])


def from_saddle(name, t, v):
    """Vectors to points from the nearest point of the orbit, in the plane (t, v/velocity_scale), and which point."""
    _, saddle, scale = saddle_of(name)
    apart = np.subtract.outer(t, saddle.t)
    vectors = np.stack([apart - np.rint(apart), np.subtract.outer(v, saddle.v) / scale], axis=-1)
    nearest = np.hypot(*np.moveaxis(vectors, -1, 0)).argmin(axis=-1)
    return np.take_along_axis(vectors, nearest[..., None, None], axis=-2)[..., 0, :], nearest


def approach(name, t, v, sense, applications=120):
    """Vectors from the orbit, (applications + 1, points, 2), and which of its points is the nearest."""
    oscillator = ALL[name][0]
    path, nearest = [], []
    for _ in range(applications + 1):
        vector, near = from_saddle(name, t, v)
        path.append(vector)
        nearest.append(near)
        t, v = apply(oscillator, t, v, sense)
    return np.array(path), np.array(nearest)


def coordinates(name, path, nearest, along):
    """Coordinates of vectors along the invariant direction `along`, those along the other one taken off."""
    _, saddle, scale = saddle_of(name)
    both = [directions(saddle, at, scale) for at in range(saddle.upper_contacts)]
    frames = np.array([np.column_stack([getattr(d, along), getattr(d, other(along))]) for d in both])
    frames[:, 1, :] /= scale
    return np.linalg.solve(frames[nearest], path[..., None])[..., 0, 0]


def other(along):
    return "stable" if along == "unstable" else "unstable"


def first_exit(name, path, nearest, along, close):
    """Coordinate along a direction, as a part of the distance, where points leave again after coming close.

    They come so close that one application more takes them to about the distance `close`. A multiplier below zero
    changes the sign each time; that is taken off.
    """
    _, saddle, scale = saddle_of(name)
    local = directions(saddle, 0, scale)
    inside = close / abs(local.unstable_multiplier if along == "unstable" else 1.0 / local.stable_multiplier)
    distance = np.hypot(path[..., 0], path[..., 1])
    exits = np.logical_or.accumulate(distance < inside, axis=0) & (distance > 3.0 * inside)
    assert exits.any(axis=0).all()
    when = exits.argmax(axis=0), np.arange(distance.shape[1])
    flips = local.stable_multiplier < 0.0
    sign = np.where(flips & (when[0] % 2 == 1), -1.0, 1.0)
    return sign * coordinates(name, path[when], nearest[when], along) / distance[when]


WAYS = [(stable_manifold, 1, "unstable", 1e-5), (unstable_manifold, -1, "stable", 1e-3)]


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("grow, sense, away, close", WAYS, ids=["stable", "unstable"])
def test_points_come_to_the_saddle_and_leave_along_the_other_direction(name, grow, sense, away, close):
    t, v = inner_points(manifold_of(name, grow))
    few = RNG.choice(t.size, 200, replace=False)
    path, nearest = approach(name, t[few], v[few], sense)
    assert np.abs(first_exit(name, path, nearest, away, close)) == pytest.approx(1.0, abs=0.05)


def beside(name, grow, shift):
    """Points a little to the left and to the right of long arcs, seen along them."""
    scale = saddle_of(name)[2]
    pieces = [piece for piece in unsettled_pieces(manifold_of(name, grow)) if piece.t.size > 20]
    at = [(piece, k) for piece in pieces for k in (8, piece.t.size // 2, -9)]
    t, v = np.array([(piece.t[k], piece.v[k]) for piece, k in at]).T
    dt, dv = np.array([(p.t[k + 1] - p.t[k - 1], (p.v[k + 1] - p.v[k - 1]) / scale) for p, k in at]).T
    step_t, step_v = -shift * dv / np.hypot(dt, dv), shift * scale * dt / np.hypot(dt, dv)
    return (t + step_t, v + step_v), (t - step_t, v - step_v)


@pytest.mark.parametrize("name", ALL)
def test_points_on_the_two_sides_of_a_stable_manifold_part(name):
    left, right = (
        first_exit(name, *approach(name, t, v, 1), "unstable", 1e-3) for t, v in beside(name, stable_manifold, 1e-12)
    )
    assert left.size > 10
    assert (np.sign(left) == -np.sign(right)).all()


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("grow, sense", [(stable_manifold, 1), (unstable_manifold, -1)], ids=["stable", "unstable"])
def test_images_lie_on_the_manifold_within_the_resolution(name, grow, sense):
    """Towards the saddle, so that images of all points lie on what was grown; a chord is off by h alpha/8."""
    oscillator, _, scale = saddle_of(name)
    branches = manifold_of(name, grow)
    t, v = inner_points(branches)
    few = RNG.choice(t.size, 500, replace=False)
    image_t, image_v = apply(oscillator, t[few], v[few], sense)
    resolution = CurveResolution()
    assert (
        distance_to([piece for branch in branches for piece in branch.pieces], image_t, image_v, scale).max()
        < resolution.chord * resolution.angle / 8.0
    )


@pytest.mark.parametrize("name", SADDLES)
def test_smooth_arcs_end_where_a_flight_grazes(name):
    """Ends of a stable manifold's arcs lie on the grazing curve, or P takes them there."""
    oscillator = SADDLES[name][0]
    branches = manifold_of(name, stable_manifold)
    t, v = np.array([(piece.t[0], piece.v[0]) for branch in branches for piece in branch.pieces[1:]]).T
    misses = []
    for _ in range(16):
        misses.append(np.abs(v - grazing_velocity(oscillator, t)))
        t, v = apply(oscillator, t, v, 1)
    assert (np.min(misses, axis=0) < 1e-9).all()
    on_the_curve = misses[0] < 1e-6
    assert on_the_curve.sum() > 1
    assert misses[0][on_the_curve].max() < 1e-12


@pytest.mark.parametrize("name", SADDLES)
@pytest.mark.parametrize("grow", [stable_manifold, unstable_manifold])
def test_branches_are_as_long_and_as_fine_as_asked_and_begin_at_the_saddle(name, grow):
    _, saddle, scale = saddle_of(name)
    resolution = CurveResolution()
    branches = manifold_of(name, grow)
    assert [(b.point, b.side) for b in branches] == [(i, s) for i in range(saddle.upper_contacts) for s in (1, -1)]
    for branch in branches:
        assert branch.arclength == pytest.approx(LENGTHS[grow]) or branch.end == ManifoldEnd.SETTLED
        assert (branch.pieces[0].t[0], branch.pieces[0].v[0]) == (saddle.t[branch.point], saddle.v[branch.point])
        assert np.sign(branch.pieces[0].t[1] - branch.pieces[0].t[0]) == branch.side
        for piece, following in zip(branch.pieces[:-1], branch.pieces[1:], strict=True):
            assert piece.v[-1] == following.v[0] and (piece.t[-1] - following.t[0]) % 1.0 in (0.0, pytest.approx(1.0))
        for t, v in branch.pieces:
            chords = chord_lengths(t, v, scale)
            short = np.maximum(chords[:-1], chords[1:]) <= resolution.finest
            assert chords.max() <= resolution.chord
            # One angle of an arc may be larger: that between two images of the first chord.
            assert (~short & (turning_angles(t, v, scale) > resolution.angle)).sum() <= 1


@pytest.mark.parametrize(
    "name, stable, unstable",
    [
        ("P(1,1,0)", 0.2109152, 2.60204873),
        ("P(1,1,1)", 0.01839883, 29.8286125),
        ("P(1,1,1) in chaos", -0.1805335, -3.0399442),
        ("P(1,2,0)", 0.2449520, 2.2972050),
    ],
)
def test_multipliers_are_told_apart_and_their_product_is_the_damping_of_a_turn(name, stable, unstable):
    oscillator, saddle, scale = saddle_of(name)
    local = directions(saddle, 0, scale)
    assert (local.stable_multiplier, local.unstable_multiplier) == pytest.approx((stable, unstable), rel=1e-6)
    assert stable * unstable == pytest.approx(np.exp(-oscillator.damping * saddle.forcing_periods), rel=1e-6)


def test_up_to_velocity_40_every_piece_lies_within_the_limits():
    oscillator, saddle, _ = saddle_of("P(1,1,0)")
    towards_later, towards_earlier = stable_manifold(oscillator, saddle, ManifoldLimits(30.0, 0.0, 40.0))
    speeds = np.concatenate([piece.v for piece in towards_later.pieces])
    assert towards_later.end == ManifoldEnd.FAST and 39.0 < speeds.max() <= 40.0
    assert towards_earlier.end == ManifoldEnd.ARCLENGTH
    slow = stable_manifold(oscillator, saddle, ManifoldLimits(30.0, 3.0, 7.0))[0]
    assert 3.0 <= min(piece.v.min() for piece in slow.pieces) <= max(piece.v.max() for piece in slow.pieces) <= 7.0


def test_a_branch_that_ends_in_an_attracting_orbit_settles():
    branches = manifold_of("P(1,2,0)", unstable_manifold)
    settled = [branch for branch in branches if branch.end == ManifoldEnd.SETTLED]
    assert len(settled) == 2
    for branch in settled:
        end = branch.pieces[-1]
        t, v = apply(BEFORE_FOLD, end.t[-1:], end.v[-1:], 2)
        assert abs(v[0] - end.v[-1]) < 1e-5


def test_a_bound_on_points_is_kept_and_told():
    oscillator, saddle, _ = saddle_of("P(1,1,1) in chaos")
    for branch in stable_manifold(oscillator, saddle, ManifoldLimits(arclength=100.0, points=2000)):
        assert branch.end == ManifoldEnd.POINTS
        assert 500 < sum(piece.t.size for piece in branch.pieces) < 4000


@pytest.mark.parametrize(
    "oscillator, t, v, period, message",
    [
        (PAPER, 0.898, 3.77, 1, r"P\(1,1,0\) .* is a focus: .* nearer to a saddle"),
        (PAPER._replace(eccentricity=0.05966), 0.76, 3.77, 1, r"is a node: .* both lie inside"),
        (PAPER, 0.1, 1.0, 1, "found no periodic orbit"),
    ],
)
def test_what_is_no_saddle_is_named(oscillator, t, v, period, message):
    with pytest.raises(NotASaddle, match=message):
        find_saddle(oscillator, t, v, period)


def test_requests_that_make_no_sense_are_refused():
    oscillator, saddle, _ = saddle_of("P(1,1,0)")
    with pytest.raises(ValueError, match="period must be at least 1"):
        find_saddle(oscillator, 0.6, 3.77, 0)
    with pytest.raises(ValueError, match="seed must be finite"):
        find_saddle(oscillator, 0.6, -1.0)
    with pytest.raises(OutsideDomain, match="stiffness must be infinite"):
        stable_manifold(oscillator._replace(stiffness=1e5), saddle)
    for limits, message in [
        (ManifoldLimits(arclength=0.0), "arclength must be positive"),
        (ManifoldLimits(1.0, 7.0, 3.0), "lowest_velocity < highest_velocity"),
        (ManifoldLimits(points=3), "points must be at least 100"),
    ]:
        with pytest.raises(ValueError, match=message):
            stable_manifold(oscillator, saddle, limits)
