"""A notebook's view of a store: opened plain or consolidated, drawn like the project's own picture."""

import io
import json

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.image import imread

from rattle_kernels import CellGrid, Oscillator, basin_entropy, global_integrity_measure, integrity_factor
from tests.worker.basins.made_up import CHAOS, QUIET, RATTLE, near
from tests.worker.basins.test_pipeline import run
from worker.errors import InvalidJob, StoreConflict
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.swept_parameter import SweptParameter
from worker.pictures import colours
from worker.results import opening
from worker.results.figure import draw_basin
from worker.results.opening import attractors_of, basin_of, job_of, open_basin
from worker.results.panel import Look


@pytest.fixture(autouse=True)
def without_a_screen():
    matplotlib.use("agg")
    yield
    plt.close("all")


def without_consolidated_metadata(location):
    root = location / "zarr.json"
    metadata = json.loads(root.read_text())
    del metadata["consolidated_metadata"]
    root.write_text(json.dumps(metadata))


@pytest.mark.parametrize("plain", [False, True], ids=["consolidated", "plain"])
def test_a_store_is_opened_with_its_job_and_its_attractors(store, tmp_path, plain):
    if plain:
        without_consolidated_metadata(tmp_path / "made_up.zarr")
    with open_basin(tmp_path / "made_up.zarr") as basin:
        assert job_of(basin) == store.job
        found = attractors_of(basin)
        assert [attractor.name for attractor in found] == [attractor.name for attractor in (QUIET, RATTLE, CHAOS)]
        for read, written in zip(
            found, store.solutions.read_catalogue(0, store.solutions.read(), [0, 1, 2]), strict=True
        ):
            np.testing.assert_array_equal(np.array(read[:6]), np.array(written[:6]))
            np.testing.assert_array_equal(read.time, written.time)
            np.testing.assert_array_equal(read.velocity, written.velocity)


def test_its_arrays_are_what_the_measures_take(store):
    with open_basin(store.location) as basin:
        assert global_integrity_measure(basin.solution) == 0.5
        disc = integrity_factor(basin.solution, job_of(basin).grid, velocity_scale=7.0)
        assert disc.radius == pytest.approx(0.25, abs=0.01)


def test_arrays_of_a_large_result_are_read_tile_by_tile(store, monkeypatch):
    with open_basin(store.location) as basin:
        assert basin.solution.chunks is None
        whole = basin.load()
    monkeypatch.setattr(opening, "_ONE_PIECE", whole.drop_vars("attractor").nbytes - 1)
    with open_basin(store.location) as basin:
        assert basin.solution.chunks is not None
        assert basin.load().identical(whole)


def drawn(axes):
    buffer = io.BytesIO()
    axes.figure.savefig(buffer, format="png")
    buffer.seek(0)
    return imread(buffer)[..., :3]


def test_it_is_drawn_in_the_projects_colours(store):
    with open_basin(store.location) as basin:
        axes = draw_basin(basin, plt.figure(layout="constrained").add_subplot())
    picture = drawn(axes)
    assert near(picture, colours.PERMANENT_CONTACT) > 0.2
    assert near(picture, colours.colours_of((RATTLE,))[0]) > 0.1
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.0, 1.0), (0.0, 7.0))
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names[0].startswith("permanent contact") and names[3:] == ["grazing curve"]


def test_a_part_of_a_basin_is_drawn_on_the_axes_it_is_given(store):
    _, (left, right) = plt.subplots(1, 2)
    with open_basin(store.location) as basin:
        part = basin.sel(time=slice(0.0, 0.5), velocity=slice(3.5, 7.0))
        assert draw_basin(part, right, Look(legend=False)) is right
    assert not left.images and right.get_legend() is None
    assert right.get_xlim() == pytest.approx((0.0, 0.5)) and right.get_ylim() == pytest.approx((3.5, 7.0))
    image, expected = right.images[0].get_array(), colours.colours_of((RATTLE,))[0]
    assert image.shape == (64, 64, 3) and (image == expected).all()


def test_what_is_not_computed_yet_is_grey(store):
    with open_basin(store.location) as basin:
        axes = draw_basin(basin.assign(solution=basin.solution.where(basin.time > 0.5, -9)), plt.figure().add_subplot())
    assert (axes.images[0].get_array()[:, :64] == colours.MISSING).all()


@pytest.mark.parametrize("place", ["nowhere", "."])
def test_a_place_that_is_no_basin_is_refused(tmp_path, place):
    with pytest.raises(StoreConflict, match="is no basin store"):
        open_basin(tmp_path / place)


PALE_BLUE = colours.colours_of((RATTLE,))[0]
SWEEP = SweepJob(
    grid=CellGrid(time_cells=24, velocity_cells=20), iterations=499,
    vary=(SweptParameter("damping", (0.575, 0.6)), SweptParameter("eccentricity", (0.05, 0.1))),
)  # fmt: skip


@pytest.fixture(scope="module")
def sweep(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("sweeps") / "sweep.zarr"
    run(SWEEP, location, client)
    with open_basin(location) as dataset:
        yield dataset


def test_a_basin_of_a_sweep_is_read_like_one_computed_alone(sweep, client, tmp_path):
    job = BasinJob(oscillator=Oscillator(damping=0.575, eccentricity=0.1), grid=SWEEP.grid, iterations=499)
    run(job, tmp_path / "alone.zarr", client)
    basin = basin_of(sweep, damping=0.575, eccentricity=0.1 + 1e-15)
    with open_basin(tmp_path / "alone.zarr") as alone:
        assert job_of(basin) == job and basin.attrs["request_sha256"] == alone.attrs["request_sha256"]
        assert basin_entropy(basin.solution) == basin_entropy(alone.solution)
        names = (np.array([motion.name for motion in attractors_of(each)]) for each in (basin, alone))
        np.testing.assert_array_equal(*(name[each.solution] for name, each in zip(names, (basin, alone), strict=True)))
        assert basin_of(alone).identical(alone)


def test_a_panel_is_drawn_with_its_own_solutions_in_the_colours_of_the_sweep(sweep):
    quiet, rattle = (basin_of(sweep, damping=0.575, eccentricity=value) for value in (0.05, 0.1))
    listed = [text.get_text() for text in draw_basin(quiet, plt.figure().add_subplot()).get_legend().get_texts()]
    assert listed == ["permanent contact   100.00 %", "grazing curve"]
    assert [motion.time.size for motion in attractors_of(quiet)] == [0] * sweep.sizes["attractor"]
    axes = draw_basin(rattle, plt.figure().add_subplot())
    listed = {text.get_text().split("  ")[0] for text in axes.get_legend().get_texts()}
    assert listed == {"permanent contact", "P(1,1,0)", "P(1,2,0)", "P(2,2,1)", "grazing curve"}
    assert near(np.asarray(axes.images[0].get_array()), PALE_BLUE) > 0.02


@pytest.mark.parametrize(
    "values", [{}, {"damping": 0.6}, {"damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6}], ids=len
)
def test_a_panel_takes_one_value_of_each_swept_parameter(sweep, values):
    with pytest.raises(InvalidJob, match="swept is damping, eccentricity"):
        basin_of(sweep, **values)


def test_a_value_that_is_not_swept_is_refused(sweep):
    with pytest.raises(InvalidJob, match=r"damping takes the values 0\.575, 0\.6"):
        basin_of(sweep, damping=0.59, eccentricity=0.1)


def test_the_legend_names_the_curves_and_is_whole_in_a_file(store):
    with open_basin(store.location) as basin:
        axes = draw_basin(basin, plt.figure(layout="constrained").add_subplot())
    listed = [text.get_text() for text in axes.get_legend().get_texts()]
    assert "grazing curve" in listed and "chaos" in axes.get_legend().get_title().get_text()
    axes.figure.canvas.draw()
    within = axes.get_legend().get_window_extent()
    assert within.x1 <= axes.figure.bbox.x1 and within.y0 >= axes.figure.bbox.y0
