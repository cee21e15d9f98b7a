"""What is not proven of a basin is pale and hatched exactly there, in pictures of any size and window."""

import io

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rattle_proof.unproven import draw_unproven
from tests.rattle_proof.proven_store import lay_proof
from worker.errors import InvalidJob
from worker.pictures import colours
from worker.pictures.figure_file import PictureFormat, save_figure
from worker.pictures.overlay_kind import OverlayKind
from worker.pictures.window import Window
from worker.results.figure import basin_figure, draw_basin
from worker.results.opening import open_basin
from worker.results.panel import Layer, Look

CELLS, HIGHEST = 128, 7.0
# The quiet half of the made-up basin is proven but for the cells of t < 0.25; nothing of chaos is, half of P(1,1,0).
EARLY = 32
NOT_TRIED = 255


def made_up():
    proven = np.full((CELLS, CELLS), 64)
    proven[:64, :EARLY], proven[64:, :64], proven[64:, 64:] = 0, 48, 0
    return proven, np.where(proven < 64, 3, 0)


@pytest.fixture
def proof(store):
    return lay_proof(store.location, *made_up())


def veiled(colour, part):
    return np.array(colour) + 0.65 * part * (1.0 - np.array(colour))


def pixels_in(figure, axes, early, late, low, high):
    """Colours of the pixels of a part of the plane, but for its rim."""
    FigureCanvasAgg(figure).draw()
    image = np.asarray(figure.canvas.buffer_rgba())[::-1, :, :3] / 255.0
    (x0, y0), (x1, y1) = axes.transData.transform([(early, low), (late, high)]).astype(int)
    return image[y0 + 3 : y1 - 2, x0 + 3 : x1 - 2]


def share_of(pixels, colour, tolerance=0.02):
    return (np.abs(pixels - colour).max(axis=-1) < tolerance).mean()


def lines_in(pixels):
    """Share of the pixels darker than anything that is pale."""
    return (pixels.max(axis=-1) < 0.5).mean()


def seen(store, **look):
    figure = basin_figure(store.location, Look(**{"overlays": (OverlayKind("proven"),)} | look))
    return figure, figure.axes[0]


def seen_with_axes_of_ones_own(store):
    figure = Figure(figsize=(10.0, 6.5), dpi=110)
    with open_basin(store.location) as basin:
        return figure, draw_basin(basin, figure.subplots(), Look(overlays=("proven",)))


@pytest.mark.parametrize("drawn", [seen, seen_with_axes_of_ones_own])
def test_what_is_not_proven_is_pale_and_hatched_and_the_rest_is_as_ever(proof, drawn):
    figure, axes = drawn(proof)
    quiet, rattle = colours.PERMANENT_CONTACT, (0x56 / 255, 0xB4 / 255, 0xE9 / 255)
    clean = pixels_in(figure, axes, 0.25, 1.0, 0.0, 3.5)
    assert share_of(clean, quiet) == 1.0
    unproven = pixels_in(figure, axes, 0.0, 0.25, 0.0, 3.5)
    assert share_of(unproven, quiet) == 0.0 and 0.6 < share_of(unproven, veiled(quiet, 1.0))
    assert 0.01 < lines_in(unproven) < 0.4
    partly = pixels_in(figure, axes, 0.0, 0.5, 3.5, 7.0)
    assert share_of(partly, veiled(rattle, 0.25)) == 1.0, "pale by the part that is not proven, and not hatched"
    assert lines_in(pixels_in(figure, axes, 0.5, 1.0, 3.5, 7.0)) > 0.01


def test_the_legend_says_how_much_is_not_proven(proof):
    share = 1.0 - made_up()[0].mean() / 64.0
    for drawn in (seen, seen_with_axes_of_ones_own):
        legend = drawn(proof)[1].get_legend()
        labels = {text.get_text(): handle for text, handle in zip(legend.texts, legend.legend_handles, strict=True)}
        assert labels[f"not proven   {100 * share:.2f} %"].get_hatch()


def test_the_legend_has_the_bounds_of_each_share(store):
    """The share of each of three motions is at most what is not proven of the others; quiet's less what rattles."""
    told = {"shares": [0.5, 0.25, 0.125], "quiet": {"motion": 0, "level": 0.09}, "never_quiet": 0.4375}
    proof = lay_proof(store.location, *made_up(), {"certificate": told})
    for drawn in (seen, seen_with_axes_of_ones_own):
        labels = [text.get_text().split("\n") for text in drawn(proof)[1].get_legend().texts]
        bounds = {lines[0].split("   ")[0]: lines[1] for lines in labels if len(lines) > 1}
        assert sorted(bounds.values()) == [
            "proven: 12.50 % to 25.00 %", "proven: 25.00 % to 37.50 %", "proven: 50.00 % to 56.25 %",
        ]  # fmt: skip
        assert bounds["permanent contact"] == "proven: 50.00 % to 56.25 %"


def test_a_window_across_the_end_of_the_period_is_hatched_on_both_sides(proof):
    figure, axes = seen(proof, window=Window(0.75, 1.5, 0.5, 3.0))
    quiet = colours.PERMANENT_CONTACT
    assert share_of(pixels_in(figure, axes, 0.75, 1.0, 0.5, 3.0), quiet) == 1.0
    assert share_of(pixels_in(figure, axes, 1.0, 1.25, 0.5, 3.0), quiet) == 0.0
    assert lines_in(pixels_in(figure, axes, 1.0, 1.25, 0.5, 3.0)) > 0.01
    assert share_of(pixels_in(figure, axes, 1.25, 1.5, 0.5, 3.0), quiet) == 1.0


def test_what_has_not_been_tried_is_not_proven_and_the_share_is_not_known_yet(store):
    proven, reason = made_up()
    proven[:64, 64:] = reason[:64, 64:] = NOT_TRIED
    figure, axes = seen(lay_proof(store.location, proven, reason))
    assert share_of(pixels_in(figure, axes, 0.25, 0.5, 0.0, 3.5), colours.PERMANENT_CONTACT) == 1.0
    assert share_of(pixels_in(figure, axes, 0.5, 1.0, 0.0, 3.5), colours.PERMANENT_CONTACT) == 0.0
    assert "not proven" in [text.get_text() for text in axes.get_legend().texts]


@pytest.mark.parametrize("layer", [Layer.GROUP, Layer.STEP])
def test_hsus_numbers_are_hatched_as_well(proof, layer):
    figure, axes = seen(proof, layer=layer)
    assert len(np.unique(pixels_in(figure, axes, 0.0, 0.25, 0.0, 3.5).reshape(-1, 3), axis=0)) > 2
    assert len(np.unique(pixels_in(figure, axes, 0.25, 1.0, 0.0, 3.5).reshape(-1, 3), axis=0)) == 1


@pytest.mark.parametrize("file", PictureFormat)
def test_every_format_is_hatched_and_the_same_proof_gives_the_same_bytes(proof, file):
    plain, one, other = io.BytesIO(), io.BytesIO(), io.BytesIO()
    save_figure(basin_figure(proof.location, Look(overlays=())), plain, file)
    for buffer in (one, other):
        save_figure(seen(proof)[0], buffer, file)
    assert one.getvalue() == other.getvalue() != plain.getvalue()


def painted(proven, pixels):
    """A proof alone on black, on so many pixels each way."""
    figure = Figure(figsize=(1.0, 1.0), dpi=pixels)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), facecolor="black")
    axes.set_axis_off()
    figure.set_facecolor("black")
    draw_unproven(axes, proven, (0.0, 1.0, 0.0, HIGHEST))
    FigureCanvasAgg(figure).draw()
    return np.asarray(figure.canvas.buffer_rgba())[::-1, :, 0]


@pytest.mark.parametrize("pixels", [300, 3000])
def test_one_thin_row_of_cells_is_seen_at_any_size(pixels):
    proven = np.full((300, 300), 64)
    proven[100] = 0
    image = painted(proven, pixels)
    row = slice(100 * pixels // 300, 101 * pixels // 300)
    assert (image[row] > 0).all() and (image[: row.start] == 0).all() and (image[row.stop :] == 0).all()


def test_lines_keep_their_distance_on_paper_whatever_the_cells():
    def crossings(cells):
        image = painted(np.zeros((cells, cells), np.uint8), 600)
        dark = image[300] < 110
        return np.count_nonzero(np.diff(dark.astype(int)) == 1)

    assert crossings(10) == crossings(700) > 5


def test_an_outline_stays_short_where_every_third_cell_is_proven():
    axes = Figure().subplots()
    draw_unproven(axes, 64 * (np.indices((1500, 1500)).sum(axis=0) % 3 == 0), (0.0, 1.0, 0.0, HIGHEST))
    assert 0 < len(axes.patches[0].get_path().vertices) <= 5 * 512 * 256


def test_where_no_proof_was_asked_for_it_is_said(store):
    with pytest.raises(InvalidJob, match="nothing is proven of this basin"):
        seen(store)
    with open_basin(store.location) as basin, pytest.raises(InvalidJob, match="nothing is proven of this basin"):
        draw_basin(basin, Figure().subplots(), Look(overlays=("proven",)))
