"""`dataset.rattle`: draws, measures and lists what a result holds, and says what its kind has not."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr

import rattle
from worker.errors import InvalidJob
from worker.pictures.colours import Palette, colours_of
from worker.results import opening
from worker.results.measures import measure_basins
from worker.results.summary import summarise


@pytest.fixture(scope="module")
def pairs(kept):
    """Four basins over two parameters."""
    return rattle.sweep(damping=[0.6, 0.7], eccentricity=[0.05, 0.1], cells=10, iterations=101, progress=False)


def test_it_knows_what_it_is_on(basin, sweep):
    assert basin.rattle.kind == "basin" and sweep.rattle.kind == "sweep" and basin.rattle.complete
    assert "damping=0.6" in repr(basin.rattle) and basin.rattle.oscillator.half_backlash == 0.6
    assert basin.rattle.job.digest == basin.attrs["request_sha256"]
    with pytest.raises(InvalidJob, match="no result of this project"):
        _ = xr.Dataset().rattle


def test_attractors_are_a_small_dataset(basin):
    assert basin.rattle.attractors.name.values.tolist() == ["permanent contact", "P(1,1,0)", "chaotic"]
    assert set(basin.rattle.attractors.sizes) == {"attractor", "end", "point"}
    assert [each.name for each in basin.rattle.catalogue()] == basin.name.values.tolist()


def test_a_basin_is_drawn_with_its_motions_named(basin):
    axes = basin.rattle.plot(overlays=["grazing"])
    assert [text.get_text().split()[0] for text in axes.get_legend().get_texts()] == [
        "permanent",
        "chaotic",
        "P(1,1,0)",
        "grazing",
    ]
    assert len(axes.images) == 1 and len(axes.lines) == 1
    assert basin.rattle.overlay("attractors", ax=axes) is axes and len(axes.lines) == 3
    with pytest.raises(InvalidJob, match="choose among proven,grazing"):
        basin.rattle.plot(overlays=["saddle"])


def test_a_basin_is_drawn_in_colours_and_with_a_title_of_ones_own(basin):
    numbers, names = basin.solution.values, basin.name.values.tolist()
    usual = np.array(basin.rattle.plot(overlays=[]).images[0].get_array())
    axes = basin.rattle.plot(overlays=[], colors={"P(1,1,0)": "#ff8000"}, title="mine")
    image, own = np.array(axes.images[0].get_array()), numbers == names.index("P(1,1,0)")
    assert own.any() and (image[own] == [1.0, 128 / 255, 0.0]).all()
    np.testing.assert_array_equal(image[~own], usual[~own])
    (entry,) = [
        patch
        for patch, text in zip(axes.get_legend().get_patches(), axes.get_legend().get_texts(), strict=False)
        if text.get_text().startswith("P(1,1,0)")
    ]
    assert entry.get_facecolor()[:3] == (1.0, 128 / 255, 0.0) and axes.get_title() == "mine"


def test_a_sample_is_drawn_as_points_in_the_colours_of_their_motions(kept):
    sample = rattle.basin(sample=300, seed=7, iterations=101, progress=False)
    names, numbers = sample.name.values.tolist(), sample.solution.values
    axes = sample.rattle.plot(overlays=[], colors={"P(1,1,0)": "#ff8000"})
    (points,) = axes.collections
    assert axes.get_legend().get_title().get_text() == "", "nothing is speckled"
    np.testing.assert_array_equal(points.get_offsets(), np.transpose([sample.time, sample.velocity]))
    assert axes.get_xlim() == (0.0, 1.0) and axes.get_ylim() == (0.0, 7.0)
    wanted = np.array(colours_of(sample.rattle.catalogue()))
    wanted[names.index("P(1,1,0)")] = [1.0, 128 / 255, 0.0]
    np.testing.assert_allclose(points.get_facecolor()[:, :3], wanted[numbers])


@pytest.mark.parametrize("palette", Palette)
def test_a_basin_is_drawn_in_a_palette(basin, palette):
    axes = basin.rattle.plot(overlays=[], palette=palette.value)
    image = np.array(axes.images[0].get_array())
    quiet = colours_of(basin.rattle.catalogue(), palette)[0]
    assert np.allclose(image[basin.solution.values == 0], quiet)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"palette": "viridis"}, "no palette 'viridis': take paper or colour_blind"),
        ({"colors": {"P(9,9,9)": "red"}}, r"no motion 'P\(9,9,9\)' to colour: there are permanent contact"),
        ({"colors": {"permanent contact": "reddish"}}, "reddish"),
    ],
)
def test_colours_that_are_not_known_are_refused(basin, asked, told):
    with pytest.raises(InvalidJob, match=told):
        basin.rattle.plot(**asked)


def test_overlays_have_a_colour_and_a_width_of_ones_own(basin):
    axes = basin.rattle.plot(overlays=[])
    basin.rattle.overlay("grazing", ax=axes, color="red", linewidth=3.0)
    assert [(line.get_color(), line.get_linewidth()) for line in axes.lines] == [("red", 3.0)]


def test_a_sweep_is_drawn_side_by_side_and_its_shares_over_the_parameter(sweep):
    figure = sweep.rattle.plot(colors={"permanent contact": "white"}, title="three dampings")
    assert figure.get_suptitle() == "three dampings"
    assert figure.legends[0].get_patches()[0].get_facecolor() == (1.0, 1.0, 1.0, 1.0)
    assert [axes.get_title() for axes in figure.axes] == ["δ = 0.55", "δ = 0.6", "δ = 0.7", ""]
    lines = sweep.rattle.plot_shares().axes[0].get_lines()
    assert len(lines) == sweep.sizes["attractor"]
    with pytest.raises(InvalidJob, match="those of kind sweep have"):
        sweep.rattle.basin(damping=0.6).rattle.plot_shares()


def test_a_basin_of_a_sweep_is_measured_as_it_is_alone(sweep):
    one = sweep.rattle.basin(damping=0.6)
    assert one.rattle.kind == "basin" and one.rattle.oscillator.damping == 0.6
    with pytest.raises(InvalidJob, match="0.55, 0.6, 0.7"):
        sweep.rattle.basin(damping=0.61)


def test_all_basins_of_a_sweep_come_in_order_with_its_colours(pairs):
    values = [(each.rattle.oscillator.damping, each.rattle.oscillator.eccentricity) for each in pairs.rattle.basins()]
    assert values == [(0.6, 0.05), (0.6, 0.1), (0.7, 0.05), (0.7, 0.1)]
    assert {tuple(each.rattle.colours) for each in pairs.rattle.basins()} == {tuple(pairs.rattle.colours)}
    assert len(pairs.rattle.colours) == pairs.sizes["attractor"]


def test_cells_have_the_names_of_their_motions_and_none_where_they_are_missing(basin, sweep):
    np.testing.assert_array_equal(basin.rattle.cell_names(), basin.name.values[basin.solution])
    part = sweep.assign(solution=sweep.solution.where(sweep.damping < 0.7, -9).astype(np.int16))
    names = part.rattle.cell_names()
    assert names.dims == sweep.solution.dims and set(names.sel(damping=0.7).values.ravel()) == {""}
    assert "" not in names.sel(damping=[0.55, 0.6])


def test_images_are_counted_as_in_the_summary(basin, sweep, kept):
    for result in (basin, sweep):
        assert result.rattle.image_counts() == summarise(rattle.cache.location_of(result.rattle.job)).image_counts
    assert sum(basin.rattle.image_counts().values()) > 0
    sample = rattle.basin(sample=64, iterations=101, progress=False)
    counts = summarise(rattle.cache.location_of(sample.rattle.job)).image_counts
    assert sample.rattle.image_counts() == counts and "sink" not in counts
    assert sample.rattle.shown.sizes["sample"] == 64 and sample.rattle.cell_names().sizes == {"sample": 64}


def test_of_many_cells_every_nth_is_shown(basin, monkeypatch):
    monkeypatch.setattr(opening, "_MOST_CELLS", 15)
    shown = basin.copy().rattle.shown
    np.testing.assert_array_equal(shown.solution, basin.solution[::3, ::3])
    np.testing.assert_array_equal(shown.share, basin.share)


def test_shares_are_drawn_on_axes_that_are_there(sweep, pairs):
    axes = plt.figure().add_subplot()
    assert sweep.rattle.plot_shares(axes) is axes and axes.get_legend() is None
    assert len(axes.get_lines()) == sweep.sizes["attractor"]
    assert len(pairs.rattle.plot_shares().axes) > pairs.sizes["attractor"]
    with pytest.raises(InvalidJob, match="leave out ax"):
        pairs.rattle.plot_shares(axes)


def test_measures_are_those_of_the_worker(basin):
    xr.testing.assert_identical(basin.rattle.measures(), measure_basins(basin))
    least = basin.rattle.least_disturbance()
    np.testing.assert_array_equal(least, basin.rattle.measures().least_disturbance)
    assert least.dims == ("time",)


def test_tables_have_words_for_codes_and_a_row_for_each_motion(basin, sweep, tmp_path):
    table = basin.rattle.to_table()
    assert table["name"].tolist() == basin.name.values.tolist() and table.columns[:3].tolist() == [
        "name",
        "share",
        "kind",
    ]
    assert table["kind"].tolist() == ["permanent_contact", "periodic", "chaotic"]
    shares = sweep.rattle.to_table()
    assert set(shares.columns) >= {"damping", "name", "share"} and not shares["share"].isna().any()
    assert shares.groupby("damping")["share"].sum().tolist() == pytest.approx([1.0, 1.0, 1.0])
    sweep.rattle.to_csv(tmp_path / "shares.csv")
    pd.testing.assert_frame_equal(
        pd.read_csv(tmp_path / "shares.csv", dtype=shares.dtypes.to_dict()), shares, check_dtype=False
    )
    with pytest.raises(InvalidJob, match="there are damping, attractor"):
        sweep.rattle.to_table("motions")


@pytest.mark.parametrize(
    ("verb", "given", "first"),
    [
        ("bifurcation", {"damping": [0.58, 0.59], "seeds": [(0.9, 3.7)], "transient": 50, "kept": 4}, "visit"),
        ("orbits", {"longest": 1, "cells": 8}, "name"),
        ("manifolds", {"saddles": [(0.6017, 3.7699)], "arclength": 2}, "name"),
        ("grazing_curve", {"order": 1}, "order_arclength"),
        ("trajectory", {"velocity": 4.0, "periods": 2.0}, "displacement"),
    ],
)
def test_every_kind_of_result_is_drawn_and_listed(verb, given, first):
    options = {} if verb == "trajectory" else {"progress": False}
    result = getattr(rattle, verb)(**given, **options)
    figure = result.rattle.plot()
    assert figure.axes[0].lines and figure.axes[0].get_title()
    assert result.rattle.to_table().columns[0] == first and len(result.rattle.to_table()) > 0
    with pytest.raises(InvalidJob, match="has no measures"):
        result.rattle.measures()


def test_curves_lie_over_a_basin(basin):
    axes = basin.rattle.plot(overlays=[], legend=False)
    grown = rattle.manifolds(saddles=[(0.6017, 3.7699)], arclength=2, progress=False)
    grown.rattle.overlay(ax=axes)
    rattle.grazing_curve(order=1, progress=False).rattle.overlay(ax=axes)
    labels = [line.get_label() for line in axes.lines]
    assert labels == ["stable manifold of P(1,1,0)", "grazing curve", "pre-image 1"]
