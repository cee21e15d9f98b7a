"""What lies over a picture of basins: where it is drawn, what it consists of, and what is refused."""

import io

import numpy as np
import pytest
from matplotlib.figure import Figure

from rattle_kernels import (
    Oscillator,
    Piece,
    eccentricity_bound_smooth_maxima,
    find_attractors,
    grazing_velocity,
    next_impacts,
    previous_impacts,
)
from worker.errors import InvalidJob
from worker.pictures.figure_file import PictureFormat, save_figure
from worker.pictures.overlay import Lines, Marks, attractor_marks, grazing_line
from worker.pictures.overlay_kind import OverlayKind, overlays_for, parse_overlays
from worker.results.figure import basin_figure, draw_basin
from worker.results.opening import open_basin
from worker.results.panel import Look

OSCILLATOR = Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6)


def path_of(overlay, time_start=0.0):
    axes = Figure().subplots()
    overlay.draw(axes, time_start)
    (line,) = axes.lines
    return line.get_xydata()


@pytest.mark.parametrize("time_start", [0.0, 0.25, 0.9])
def test_a_curve_that_runs_beyond_the_window_goes_on_at_its_beginning(time_start):
    t = np.linspace(0.7, 2.3, 33)
    path = path_of(Lines("", "white", (Piece(t, t),)), time_start)
    t_drawn, v_drawn = path[np.isfinite(path[:, 0])].T
    assert t_drawn.min() > time_start - 1e-12 and t_drawn.max() < time_start + 1.0 + 1e-12
    np.testing.assert_allclose(np.exp(2j * np.pi * t_drawn), np.exp(2j * np.pi * v_drawn), atol=1e-12)
    assert np.nanmax(np.abs(np.diff(path[:, 0]))) < 0.1
    assert np.nansum(np.diff(path[:, 0])) == pytest.approx(1.6)


def test_pieces_are_not_joined_to_each_other():
    pieces = Piece(np.array([0.1, 0.2]), np.array([1.0, 1.0])), Piece(np.array([0.2, 0.3]), np.array([5.0, 5.0]))
    assert np.nanmax(np.abs(np.diff(path_of(Lines("", "white", pieces))[:, 1]))) == 0.0


def test_marks_are_put_on_the_phases_of_the_window():
    marks = Marks("", "white", np.array([0.1, 0.95]), np.array([1.0, 2.0]), "x")
    np.testing.assert_allclose(path_of(marks, 0.9), [[1.1, 1.0], [0.95, 2.0]])


@pytest.fixture(scope="module")
def attractors():
    landed = next_impacts(OSCILLATOR, [0.9, 0.7], [3.7, 4.3], 1499)
    return find_attractors(OSCILLATOR, landed.t, landed.v)


@pytest.fixture(scope="module")
def overlays(attractors):
    return {overlay.label: overlay for overlay in overlays_for(OverlayKind, OSCILLATOR, attractors, (0.0, 7.0))}


@pytest.mark.slow
def test_all_kinds_are_there_and_saddles_amid_chaos_are_left_out(overlays):
    saddles = "saddle P(1,1,0)", "saddle P(1,1,1)"
    assert overlays.keys() == {
        "grazing curve", "pre-image 1 of grazing", "pre-image 2 of grazing", "stable manifold of P(1,1,0)",
        "stable manifold of P(1,1,1)", "P(1,1,0)", "chaotic", *saddles,
    }  # fmt: skip
    found = [(*overlays[name].t, *overlays[name].v) for name in saddles]
    np.testing.assert_allclose(found, [(0.6017074510, 3.7699111843), (0.8901235211, 3.9882401959)], atol=1e-9)


def test_a_first_preimage_is_mapped_from_the_grazing_curve(overlays):
    (curve,) = overlays["grazing curve"].pieces
    np.testing.assert_array_equal(curve.v, grazing_velocity(OSCILLATOR, curve.t))
    before = previous_impacts(OSCILLATOR, 0.2, grazing_velocity(OSCILLATOR, 0.2))
    pieces = overlays["pre-image 1 of grazing"].pieces
    apart = [np.hypot((piece.t - before.t + 0.5) % 1.0 - 0.5, piece.v - before.v).min() for piece in pieces]
    assert min(apart) < 0.05


def test_basins_carry_what_is_asked_for_and_no_more(store, attractors):
    with open_basin(store.location) as basin:
        looks = Look(overlays=()), Look(overlays=("grazing",))
        counts = [len(draw_basin(basin, Figure().subplots(), look).lines) for look in looks]
    assert counts == [0, 1]
    plain, laid = io.BytesIO(), io.BytesIO()
    save_figure(basin_figure(store.location, Look(overlays=())), plain, PictureFormat.PNG)
    asked = Look(overlays=(OverlayKind.GRAZING, OverlayKind.PREIMAGES))
    save_figure(basin_figure(store.location, asked), laid, PictureFormat.PNG)
    assert plain.getvalue() != laid.getvalue()
    assert [marks.marker for marks in attractor_marks(attractors)] == ["x", "."]
    assert grazing_line(OSCILLATOR._replace(stiffness=1e4)).pieces[0].v.min() > 0.0


def test_a_loose_gear_has_both_curves_of_grazes():
    loose = Oscillator(eccentricity=0.4, restitution=0.7)
    found = overlays_for(["grazing", "preimages"], loose, (), (0.0, 12.0))
    assert [each.label for each in found] == [
        "pre-image 1 of grazing", "pre-image 2 of grazing", "pre-image 1 of grazing +beta",
        "pre-image 2 of grazing +beta", "grazing curve", "grazing +beta",
    ]  # fmt: skip
    # At Gamma = 1 no flight touches +beta from below.
    edge = loose._replace(eccentricity=eccentricity_bound_smooth_maxima(loose))
    assert [each.label for each in overlays_for(["grazing"], edge, (), (0.0, 12.0))] == ["grazing curve"]


def test_names_of_overlays_are_read_and_others_refused():
    assert parse_overlays("grazing, saddles") == (OverlayKind.GRAZING, OverlayKind.SADDLES)
    assert parse_overlays("") == ()
    for wrong in (lambda: parse_overlays("grazin"), lambda: overlays_for(["grazin"], OSCILLATOR, (), (0.0, 7.0))):
        with pytest.raises(InvalidJob, match="no overlay 'grazin'; choose among proven,grazing,preimages,manifolds"):
            wrong()


@pytest.mark.parametrize("kind", ["preimages", "manifolds"])
def test_what_needs_the_map_backwards_is_refused_for_finite_stiffness(kind):
    with pytest.raises(InvalidJob, match=f"the overlay {kind} needs the map backwards"):
        overlays_for([kind], OSCILLATOR._replace(stiffness=1e4), (), (0.0, 7.0))
