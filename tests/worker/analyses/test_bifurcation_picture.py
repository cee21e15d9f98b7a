"""The picture of a diagram has at each value the colour of the motion that is there, as the page has."""

import io
import re
from pathlib import Path

import pytest
from matplotlib import image
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

import rattle
from worker.analyses.bifurcation import draw_diagram, names_of
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.region import Departure
from worker.jobs.swept_parameter import SweptParameter
from worker.results import motion_names
from worker.results.figure import figure_of_store
from worker.stores.analysis_store import AnalysisStore

POOLS_OF_THE_PAGE = Path(__file__).parents[3] / "service" / "explorer" / "js" / "plane" / "pools.js"
# Motions at these values of Fig. 7 (bottom)'s machine, on one branch from the chaos at 0.6.
NAMES = {0.575: "P(2,2,1)", 0.582: "P(4,4,2)", 0.6: "no period seen"}


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    location = tmp_path_factory.mktemp("diagram") / "diagram.zarr"
    rattle.bifurcation(
        damping=list(NAMES), seeds=[(0.553, 4.703)], transient=4000, kept=24, store=location, progress=False,
        eccentricity=0.1, half_backlash=0.6,
    )  # fmt: skip
    return str(location)


def colours_of_the_page():
    """Colours by name, and the pool's, of the page's usual palette."""
    text = POOLS_OF_THE_PAGE.read_text()
    own = dict(re.findall(r'"([^"]+)": "(#\w{6})"', text[text.index("OWN") :].partition('"colour_blind"')[2]))
    pool = re.findall(r"#\w{6}", text.partition('"colour_blind"')[2].partition("]")[0])
    return own, pool


@pytest.mark.slow
def test_each_departure_has_the_colour_of_the_motion_there(store):
    figure = figure_of_store(store)
    (axes,) = figure.axes
    buffer = io.BytesIO()
    # Away from the frame, and large enough for dots of several pixels.
    axes.set_xlim(0.57, 0.61)
    figure.savefig(buffer, dpi=600)
    buffer.seek(0)
    pixels = image.imread(buffer, format="png")
    own, pool = colours_of_the_page()
    expected = {0.575: own["P(2,2,1)"], 0.582: pool[0], 0.6: own["chaotic"]}
    columns = AnalysisStore(store).read_tables()
    figure.dpi = 600
    for value, speeds in zip(columns["damping"], columns["velocity"][:, 0], strict=True):
        for speed in speeds[-4:]:
            x, y = axes.transData.transform((value, speed))
            seen = to_hex(pixels[pixels.shape[0] - 1 - int(y), int(x), :3])
            assert seen == expected[float(value)], (value, speed)


def test_the_key_names_them(store):
    (axes,) = figure_of_store(store).axes
    listed = {line.get_label(): to_hex(line.get_color()) for line in axes.lines}
    own, pool = colours_of_the_page()
    assert listed == {
        "P(2,2,1)": own["P(2,2,1)"], "P(4,4,2)": pool[0],
        "no period within 12 impacts: chaos, or longer": own["chaotic"],
    }  # fmt: skip
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [line.get_label() for line in axes.lines]


def test_where_there_are_too_many_to_name_those_that_repeat_are_not_called_chaos(store, monkeypatch):
    monkeypatch.setattr("worker.analyses.bifurcation.MOST_NAMED", 2)
    columns = AnalysisStore(store).read_tables()
    job = BifurcationJob(vary=SweptParameter("damping", tuple(NAMES)), seeds=(Departure(0.553, 4.703),), kept=24)
    told = names_of(job, columns).ravel().tolist()
    assert told == ["repeats after 2 impacts", "repeats after 4 impacts", motion_names.NO_PERIOD]
    figure = Figure()
    draw_diagram(job, columns, figure)
    assert len({to_hex(line.get_color()) for line in figure.axes[0].lines}) == 3
