"""Pre-images of the grazing curve: their points graze when they should, and their pieces are smooth and meet."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rattle_kernels import Oscillator, OutsideDomain, grazing_velocity, next_impacts
from rattle_kernels.impact_map.flights import BACKWARDS
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.manifolds.curve_images import CurveMap, first_points, next_image
from rattle_kernels.manifolds.grazing_preimages import TooManyPoints, grazing_preimages, speed_of_no_return
from rattle_kernels.manifolds.polyline import CurveResolution, chord_lengths, split_at_wrap, turning_angles
from tests.rattle_kernels.impact_map.scalar_map import apply
from tests.strategies import oscillators

PAPER = Oscillator()
SCALE = lane_tables(PAPER).largest_grazing_speed
NUDGES = (-1e-11, -1e-12, 0.0, 1e-12, 1e-11)


@pytest.fixture(scope="module")
def orders():
    return grazing_preimages(PAPER, 3)


def misses(t, v, order):
    """How far from grazing points are after so many impacts."""
    t, v = apply(PAPER, t, v, order)
    return np.abs(v - grazing_velocity(PAPER, t))


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_a_point_of_order_n_grazes_after_n_impacts(orders, order):
    for piece in orders[order]:
        assert misses(piece.t[1:-1], piece.v[1:-1], order).max() < 1e-9
        # An end lies on the grazing curve, or on a pre-image of lower order, where P has a root: rounding decides on
        # which side, and on one of them its root (1e-8) is seen.
        ends = np.array([0, -1])
        nudged = [misses(piece.t[ends], piece.v[ends] + nudge, order) for nudge in NUDGES]
        assert np.min(nudged, axis=0).max() < 1e-9


def test_the_first_preimage_consists_of_two_curves(orders):
    """As the paper says; one above the grazing curve, one below, and they meet on it (Sec. 6.1)."""
    above, below = orders[1]
    assert (above.v[1:-1] > grazing_velocity(PAPER, above.t[1:-1])).all()
    assert (below.v[1:-1] < grazing_velocity(PAPER, below.t[1:-1])).all()
    for piece in above, below:
        ends = np.array([0, -1])
        assert piece.v[ends] == pytest.approx(grazing_velocity(PAPER, piece.t[ends]), abs=1e-12)


def test_the_first_preimage_parts_second_impacts(orders):
    """Just above the curve the impact after the next is with -beta, just below it is not, or the other way round."""
    for piece, rises in zip(orders[1], (True, False), strict=True):
        t, v = piece.t[5:-5], piece.v[5:-5]
        sides = [next_impacts(PAPER, *next_impacts(PAPER, t, v + shift)[:2]).lower_impacts for shift in (-1e-6, 1e-6)]
        assert (sides[0] != sides[1]).all(), rises


def test_each_order_is_one_closed_curve_round_the_cylinder(orders):
    for pieces in orders:
        for piece, following in zip(pieces, (*pieces[1:], pieces[0]), strict=True):
            assert piece.v[-1] == pytest.approx(following.v[0], abs=1e-12)
            apart = piece.t[-1] - following.t[0]
            assert apart == pytest.approx(np.rint(apart), abs=1e-12)
        assert sum(piece.t[-1] - piece.t[0] for piece in pieces) == pytest.approx(1.0, abs=1e-9)


def test_pieces_are_as_fine_as_asked():
    resolution = CurveResolution(chord=0.02, angle=0.1, finest=1e-5)
    for pieces in grazing_preimages(PAPER, 2, resolution):
        for t, v in pieces:
            chords, angles = chord_lengths(t, v, SCALE), turning_angles(t, v, SCALE)
            assert chords.max() <= resolution.chord
            short = np.maximum(chords[:-1], chords[1:]) <= resolution.finest
            assert (short | (angles <= resolution.angle)).all()


def test_a_window_keeps_what_lies_in_it_and_no_more(orders):
    inside = grazing_preimages(PAPER, 3, velocity_limits=(3.0, 5.0))
    for clipped, whole in zip(inside, orders, strict=True):
        assert min(piece.v.min() for piece in clipped) >= 3.0 and max(piece.v.max() for piece in clipped) <= 5.0
        kept = sum(chord_lengths(*piece, SCALE).sum() for piece in clipped)
        chords = [(chord_lengths(*piece, SCALE), 0.5 * (piece.v[1:] + piece.v[:-1])) for piece in whole]
        assert kept == pytest.approx(sum(c[(v > 3.0) & (v < 5.0)].sum() for c, v in chords), abs=0.05)


def test_pieces_are_drawn_within_one_period(orders):
    for piece in split_at_wrap(orders[3]):
        assert piece.t.min() >= 0.0 and piece.t.max() <= 1.0


@settings(max_examples=10)
@given(oscillator=oscillators(), phase=st.floats(0.0, 1.0), part=st.floats(1.0, 5.0))
def test_backwards_all_speeds_rise_above_the_speed_of_no_return(oscillator, phase, part):
    speed = part * speed_of_no_return(oscillator)
    assert apply(oscillator, np.array([phase]), np.array([speed]), -1)[1][0] > speed


def test_what_cannot_be_computed_is_refused():
    with pytest.raises(ValueError, match="order must be at least 0"):
        grazing_preimages(PAPER, -1)
    with pytest.raises(OutsideDomain, match="stiffness must be infinite"):
        grazing_preimages(PAPER._replace(stiffness=1e4), 1)
    with pytest.raises(TooManyPoints, match="pre-image 2 .* lower order"):
        grazing_preimages(PAPER, 4, most_points=500)
    with pytest.raises(ValueError, match="chord must be positive"):
        grazing_preimages(PAPER, 1, CurveResolution(chord=0.0))
    with pytest.raises(ValueError, match="velocity_limits must be"):
        grazing_preimages(PAPER, 1, velocity_limits=(5.0, 3.0))


def test_a_corner_is_where_a_graze_follows_a_graze():
    """Corners of the image of any curve lie on the grazing curve, to rounding."""
    phase = np.linspace(0.0, 1.0, 9)
    backwards = CurveMap(PAPER, BACKWARDS, 1, 0.0, SCALE)
    image = next_image(backwards, first_points(phase, 3.0 + 3.0 * phase), CurveResolution(), 100_000)
    corners = image.at(image.corner)
    assert corners.corner.size >= 1
    assert np.abs(corners.v[-1] - grazing_velocity(PAPER, corners.t[-1])).max() < 1e-13
