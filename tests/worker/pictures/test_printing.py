"""Pictures for papers and talks: their size, letters, text, key and caption, and what would exhaust memory."""

import io
import re
import threading

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

from worker.errors import InvalidJob
from worker.pictures.annotations import parse_annotations
from worker.pictures.colours import Paint, parse_paints
from worker.pictures.figure_file import PictureFormat, new_figure, save_figure
from worker.pictures.printing import MOST_PIXELS, Printing
from worker.pictures.window import Window
from worker.results.caption import caption_of
from worker.results.figure import basin_figure
from worker.results.opening import open_basin
from worker.results.panel import Layer, Look
from worker.stores.provenance import REFERENCES


def saved(figure, picture_format, **how):
    buffer = io.BytesIO()
    save_figure(figure, buffer, picture_format, **how)
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("asked", "size"),
    [
        ({"width": 86.0, "dpi": 300}, (1016, 660)),
        ({"height": 60.0, "dpi": 254}, (923, 600)),
        ({"width": 100.0, "height": 50.0, "dpi": 254}, (1000, 500)),
        ({}, (1100, 715)),
    ],
)
def test_a_picture_has_the_size_in_mm_and_the_dots_per_inch_that_are_asked_for(asked, size):
    picture = Image.open(io.BytesIO(saved(new_figure(), PictureFormat.PNG, printing=Printing(**asked))))
    assert picture.size == pytest.approx(size, abs=1)


def test_letters_have_the_size_that_is_asked_for_also_those_of_ticks_that_come_later():
    figure = Figure(figsize=(4.0, 3.0))
    for axes in figure.subplots(2, 2, sharex=True, sharey=True).flat:
        axes.plot([0.0, 1.0])
        axes.set(xlabel="x", title="larger than ordinary")
    saved(figure, PictureFormat.PNG, printing=Printing(width=400.0, font_size=5.0))
    sizes = {text.get_text(): text.get_fontsize() for text in figure.findobj(Text) if text.get_text()}
    assert sizes.pop("larger than ordinary") == pytest.approx(6.0)
    assert set(sizes.values()) == {5.0} and len(sizes) > 5


def test_editable_text_stays_text_and_other_pictures_do_not_know(store):
    before = saved(basin_figure(store.location), PictureFormat.SVG)
    edited = saved(basin_figure(store.location), PictureFormat.SVG, printing=Printing(editable=True))
    assert b"<text" not in before and "β = 0.6" in re.sub("<[^>]*>", "", edited.decode())
    figure = basin_figure(store.location)
    assert saved(figure, PictureFormat.SVG) == before
    assert b"/Type3" in saved(figure, PictureFormat.PDF)
    assert b"/Type3" not in saved(figure, PictureFormat.PDF, printing=Printing(editable=True))


def test_pictures_saved_at_once_have_each_their_own_text():
    answers = {}

    def save(number):
        figure = Figure()
        figure.text(0.5, 0.5, "words")
        how = Printing(editable=number % 2 == 0)
        answers[number] = b"<text" in saved(figure, PictureFormat.SVG, printing=how)

    threads = [threading.Thread(target=save, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == {number: number % 2 == 0 for number in range(8)}


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"width": 1200.0, "height": 1200.0, "dpi": 1200}, "at most 40 million pixels, not 56693 x 56693"),
        ({"width": 2000.0}, "the width of a picture is 20 to 1200 mm, not 2000"),
        ({"height": 0.0}, "the height"),
        ({"dpi": 2400}, "the resolution of a picture is 30 to 1200 dpi"),
        ({"font_size": 400.0}, "4 to 36 points"),
        ({"width": float("nan")}, "the width"),
    ],
)
def test_a_picture_that_would_exhaust_memory_is_refused(asked, told):
    with pytest.raises(InvalidJob, match=told):
        save_figure(new_figure(), io.BytesIO(), PictureFormat.PNG, Printing(**asked))


@pytest.mark.parametrize("asked", [Printing(width=20.0, font_size=36.0), Printing(width=20.0, height=1200.0)])
def test_a_picture_with_no_room_beside_its_letters_is_refused(store, asked):
    with pytest.raises(InvalidJob, match="letters leave no room"):
        saved(basin_figure(store.location), PictureFormat.PNG, printing=asked)


def test_a4_at_600_dpi_is_not_too_large():
    figure = new_figure()
    Printing(width=297.0, height=210.0, dpi=600).apply(figure)
    wide, high = figure.get_size_inches() * 600
    assert 0.8 * MOST_PIXELS < wide * high < MOST_PIXELS


@pytest.mark.parametrize("picture_format", PictureFormat)
def test_a_file_carries_its_caption(store, picture_format):
    with open_basin(store.location) as basin:
        caption = caption_of(basin)
    content = saved(basin_figure(store.location), picture_format, caption=caption)
    if picture_format == PictureFormat.PNG:
        assert Image.open(io.BytesIO(content)).text["Description"] == caption
    elif picture_format == PictureFormat.SVG:
        assert f"<dc:description>{caption}</dc:description>" in content.decode()
    else:
        assert b"/Subject" in content and caption.encode("utf-16-be")[:40] in content
    assert saved(basin_figure(store.location), picture_format) != content


def test_a_caption_has_parameters_window_and_what_to_cite(store):
    with open_basin(store.location) as basin:
        caption, step = caption_of(basin), caption_of(basin, Look(Layer.STEP))
    for words in ("impacting model, δ = 0.6, ε = 0.1, β = 0.6", "v from 0 to 7, 128 x 128 cells, k = 1.", REFERENCES):
        assert words in caption
    assert "how soon" in step and "how soon" not in caption


def test_a_caption_says_what_the_colours_of_each_layer_are(store):
    with open_basin(store.location) as basin:
        said = [caption_of(basin, Look(layer)) for layer in Layer]
    assert all("Colours are" in caption for caption in said) and len(set(said)) == len(Layer)


def test_a_key_names_all_that_lies_over_a_basin(store):
    def told(look):
        figure = basin_figure(store.location, look)
        legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
        return {text.get_text().partition("   ")[0] for legend in legends for text in legend.get_texts()}

    laid = {"grazing curve", "departures of a motion that repeats", "departures of chaos"}
    assert laid - told(Look()) == laid - {"grazing curve"}
    assert laid <= told(Look(overlay_key=True))
    assert told(Look(Layer.STEP, overlay_key=True)) == laid
    assert told(Look(Layer.STEP)) == set()
    assert told(Look(Layer.STEP, overlays=(), overlay_key=True)) == set()


def test_motions_have_the_colours_that_are_given(store):
    paints = parse_paints("P(1,1,0):00ff00/1;chaotic:102030")
    assert paints == {"P(1,1,0)": Paint((0.0, 1.0, 0.0), 1), "chaotic": Paint((16 / 255, 32 / 255, 48 / 255), 0)}
    image = basin_figure(store.location, Look(own_colours=paints, overlays=())).axes[0].images[0].get_array()
    upper_left = {tuple(colour) for colour in image[64:, :64].reshape(-1, 3).tolist()}
    assert upper_left == {(0.0, 1.0, 0.0), (0.0, 0.0, 0.0)}
    assert {tuple(colour) for colour in image[64:, 64:].reshape(-1, 3).tolist()} == {(16 / 255, 32 / 255, 48 / 255)}


def test_annotations_are_drawn_in_the_period_that_is_seen_and_in_no_legend(store):
    written = parse_annotations(["0.3,4.1,a fold, here"], ["0.9,1,1.1,2.5", "0,0,1,1,", "0.8,1,0.9,2,a, b"])
    look = Look(window=Window(0.75, 1.25, 0.0, 7.0), annotations=written, overlay_key=True)
    axes = basin_figure(store.location, look).axes[0]
    told = {text.get_text(): text.xy for text in axes.texts}
    assert told["a fold, here"] == pytest.approx((1.3, 4.1))
    assert told["Δt = 0.2, Δv = 1.5"] == pytest.approx((1.0, 1.75))
    assert told["a, b"] == pytest.approx((0.85, 1.5)) and len(told) == 3, "a plain line says nothing"
    assert not [text for text in axes.get_legend().get_texts() if "note" in text.get_text() or "Δ" in text.get_text()]


@pytest.mark.parametrize(
    ("notes", "measures", "told"),
    [
        (["0.3"], [], "a note is a time, a speed and a label"),
        (["a,b,c"], [], "a note is"),
        (["0.3,inf,c"], [], "a note is"),
        (["0.3,4," + 61 * "x"], [], "at most 60 letters"),
        ([], ["1,2,3"], "a measure is two points"),
        ([], ["1,2,3,x"], "a measure is two points"),
        ([], ["1,2,3,4," + 61 * "x"], "the label of a measure has at most 60 letters"),
        (21 * ["0.3,4,x"], [], "at most 20 notes"),
    ],
)
def test_an_annotation_that_is_none_is_refused(notes, measures, told):
    with pytest.raises(InvalidJob, match=told):
        parse_annotations(notes, measures)


@pytest.mark.parametrize("text", ["P(1,1,0)", "P(1,1,0):red", "P(1,1,0):00ff00/4", ":00ff00", "a:00FF00"])
def test_a_colour_that_is_none_is_refused(text):
    with pytest.raises(InvalidJob, match="a motion's colour is written as"):
        parse_paints(text)
