"""Pictures: right colours in the right places, honest about what is missing."""

import io

import numpy as np
import pytest
import xarray as xr
from matplotlib.image import imread

from rattle_kernels import AttractorKind, CellGrid, loudness
from tests.worker.basins.made_up import CHAOS, QUIET, RATTLE, motion, near
from worker.errors import InvalidJob, StoreConflict
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.swept_parameter import SweptParameter
from worker.kinds import KINDS
from worker.pictures import colours
from worker.pictures.colours import Palette
from worker.pictures.figure_file import PictureFormat, new_figure, save_figure
from worker.pictures.window import Window
from worker.results.figure import basin_figure
from worker.results.opening import attractors_of, job_of, open_basin
from worker.results.panel import Basins, Layer, Look, Panel
from worker.results.shares import shares_figure
from worker.stores import layout
from worker.stores.basin_store import BasinStore
from worker.stores.layout import LABELLED, SOLUTION, TileState
from worker.stores.solution_table import SolutionTable, motion_of


def drawn(store, layer=Layer.SOLUTION):
    buffer = io.BytesIO()
    save_figure(basin_figure(store.location, Look(layer)), buffer, PictureFormat.PNG)
    buffer.seek(0)
    return imread(buffer)[..., :3]


@pytest.mark.parametrize("tiles", ["all", "some"])
@pytest.mark.parametrize(
    "look", [Look(), Look(Layer.STEP, overlays=()), Look(window=Window(0.75, 1.25, 1.0, 6.0), palette=Palette.PAPER)]
)
def test_a_dataset_is_drawn_as_its_store_is(store, look, tiles):
    if tiles == "some":
        store.write_ledger(np.array([TileState.ASSEMBLED, TileState.PENDING] * (store.tiling.tiles // 2)))
    figure, one, other = new_figure(), io.BytesIO(), io.BytesIO()
    with open_basin(store.location) as basin:
        KINDS["basin"].draw(basin, figure, look)
    save_figure(figure, one, PictureFormat.PNG)
    save_figure(KINDS["basin"].figure(store.location, look), other, PictureFormat.PNG)
    assert one.getvalue() == other.getvalue()


def test_only_tiles_that_are_there_are_read_of_an_unfinished_basin(store):
    whole = Panel(Basins(xr.open_zarr(store.location)), 0)._read("step", (0, 128), (0, 128))
    store.write_ledger(np.array([TileState.ASSEMBLED, TileState.PENDING] * (store.tiling.tiles // 2)))
    with open_basin(store.location) as basin:
        panel = Panel(Basins(basin), 0, most_cells=10)
    part, size = panel._read("step", (0, 130), (0, 130)), store.tiling.tile_columns
    there = np.arange(0, 128, 13) // size % 2 == 0
    np.testing.assert_array_equal(part[:, there], whole[::13, ::13][:, there])
    assert (part[:, ~there] == layout.MISSING).all()


def orange(picture):
    """Where a picture has the hue of chaos, in any brightness."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return (red > 0.3) & (np.abs(green / np.maximum(red, 0.01) - 0.44) < 0.25) & (blue < 0.1)


def test_each_motion_has_its_colour(store):
    picture = drawn(store)
    assert near(picture, colours.PERMANENT_CONTACT) > 0.2
    assert near(picture, colours.colours_of((RATTLE,))[0]) > 0.1
    assert near(picture, colours.CHAOTIC) > 0.02 and orange(picture).mean() > 0.1
    assert near(picture, colours.MISSING) < 0.02


def test_chaos_is_speckled_by_group(store):
    picture = drawn(store)
    assert len(np.unique(picture[orange(picture)][:, 1].round(2))) >= 3


def test_the_legend_shows_the_shades_of_chaos(store):
    legend = basin_figure(store.location).axes[0].get_legend()
    names = [text.get_text().split("   ")[0] for text in legend.texts]
    entries = dict(zip(names, legend.legend_handles, strict=True))
    hatched = {name: patch.get_hatch() for name, patch in entries.items() if hasattr(patch, "get_hatch")}
    assert hatched.pop(CHAOS.name) and not any(hatched.values()) and len(hatched) >= 2


@pytest.mark.parametrize("layer", [Layer.GROUP, Layer.PERIOD, Layer.STEP])
def test_hsus_numbers_have_a_scale_of_whole_numbers(store, layer):
    figure = basin_figure(store.location, Look(layer))
    shown, scale = figure.axes[0].images[0], figure.axes[-1]
    ticks = scale.get_yticks()
    assert ticks.tolist() == ticks.round().tolist() and ticks.size > 1
    numbers = np.unique(shown.get_array().compressed())
    assert len(np.unique(shown.norm(numbers))) == numbers.size, "each number has a colour of its own"


def test_loudness_has_one_colour_for_each_power_and_a_scale_from_silence(store):
    with open_basin(store.location) as basin:
        solution, motions = basin.solution.values, attractors_of(basin)
        oscillator = job_of(basin).oscillator
    figure = basin_figure(store.location, Look(Layer.LOUDNESS))
    shown, scale = figure.axes[0].images[0], figure.axes[-1]
    powers = np.array([loudness(oscillator, each).impact_power for each in motions])
    known = np.isfinite(powers[solution])
    assert known.any()
    np.testing.assert_array_equal(shown.get_array().filled(-1.0), np.where(known, powers[solution], -1.0))
    assert scale.get_ylim() == (0.0, np.nanmax(powers[solution]))
    assert "impact power" in scale.get_ylabel()


def test_missing_tiles_are_hatched_and_said(store):
    whole = near(drawn(store), colours.MISSING)
    states = np.full(store.tiling.tiles, TileState.ASSEMBLED)
    states[0] = TileState.PENDING
    store.write_ledger(states)
    assert near(drawn(store), colours.MISSING) > whole + 0.05


def test_a_store_without_any_label_is_drawn(tmp_path):
    store = BasinStore.create_or_resume(
        str(tmp_path / "new.zarr"), BasinJob(grid=CellGrid(time_cells=64, velocity_cells=64))
    )
    for layer in Layer:
        assert near(drawn(store, layer), colours.MISSING) > 0.2


@pytest.mark.parametrize("layer", [Layer.GROUP, Layer.PERIOD, Layer.STEP, Layer.LOUDNESS])
def test_the_same_store_gives_the_same_bytes(store, layer):
    one, other = io.BytesIO(), io.BytesIO()
    save_figure(basin_figure(store.location, Look(layer)), one, PictureFormat.PNG)
    save_figure(basin_figure(store.location, Look(layer)), other, PictureFormat.PNG)
    assert one.getvalue() == other.getvalue()


def test_a_place_that_is_no_store_is_refused(tmp_path):
    with pytest.raises(StoreConflict, match="is no basin store"):
        save_figure(basin_figure(str(tmp_path)), io.BytesIO(), PictureFormat.PNG)


def test_motions_of_one_name_are_told_apart_and_kinds_keep_their_colours():
    twin = motion(AttractorKind.PERIODIC, (1, 1, 0), [0.6], [3.5])
    first, second = colours.colours_of((RATTLE, twin))
    assert first != second
    assert colours.colours_of((CHAOS, QUIET)) == [colours.CHAOTIC, colours.PERMANENT_CONTACT]


def test_every_variable_has_dimensions_and_a_fill_that_is_no_value():
    tables = *layout.MOTIONS, *layout.measured(1), *layout.CHANGES, *layout.IMAGE_SET
    for places in (layout.CELLS, layout.SAMPLE):
        arrays = *places.coordinates, *places.mapped, *places.labelled, places.solution, places.own_solution
        for variable in (*arrays, places.ledger, layout.GRAZING, *tables):
            assert variable.dims and variable.meaning
            assert variable.fill in (layout.MISSING, np.inf, 0, "")
    assert all(np.isnan(variable.fill) for variable in layout.POINTS)


@pytest.fixture
def sweep(tmp_path):
    """Made-up sweep of two parameters: every basin has the colour of one motion or the other; the last is missing."""
    vary = SweptParameter("damping", (0.5, 0.6)), SweptParameter("half_backlash", (0.6, 0.7))
    job = SweepJob(grid=CellGrid(time_cells=64, velocity_cells=64), iterations=1, vary=vary)
    store = BasinStore.create_or_resume(str(tmp_path / "sweep.zarr"), job)
    table = SolutionTable.empty(job)
    numbers = [table.append(motion_of(attractor)) for attractor in (QUIET, RATTLE)]
    store.solutions.make_room(table, 1)
    for basin in range(3):
        solution = np.full(job.grid.shape, basin % 2, np.int16)
        store.tiles.write((*LABELLED, SOLUTION), store.tiling.tile(basin), (solution, solution, solution, solution))
        table.enter(basin, numbers, (QUIET, RATTLE), np.array([1.0 - basin % 2, basin % 2]))
        store.solutions.write_points(basin, numbers, (QUIET, RATTLE))
    store.solutions.write(table)
    states = np.full(store.tiling.tiles, TileState.ASSEMBLED)
    states[3] = TileState.PENDING
    store.write_ledger(states)
    return store


def test_basins_of_a_sweep_are_drawn_side_by_side_in_shared_colours(sweep):
    picture = drawn(sweep)
    for colour in (colours.PERMANENT_CONTACT, colours.colours_of((RATTLE,))[0], colours.MISSING):
        assert near(picture, colour) > 0.05
    assert near(picture, colours.PERMANENT_CONTACT) > 1.5 * near(picture, colours.colours_of((RATTLE,))[0])
    for layer in Layer:
        drawn(sweep, layer)


@pytest.mark.slow
def test_of_many_basins_some_are_drawn(tmp_path):
    vary = (SweptParameter("damping", tuple(np.linspace(0.6, 0.7, 100).tolist())),)
    job = SweepJob(grid=CellGrid(time_cells=4, velocity_cells=4), vary=vary)
    store = BasinStore.create_or_resume(str(tmp_path / "new.zarr"), job)
    assert near(drawn(store), colours.MISSING) > 0.2


def test_shares_are_drawn_over_two_parameters_and_refused_over_none(sweep, store):
    buffer = io.BytesIO()
    save_figure(shares_figure(sweep.location), buffer, PictureFormat.PNG)
    assert buffer.getvalue().startswith(b"\x89PNG")
    with pytest.raises(InvalidJob, match="single basin"):
        save_figure(shares_figure(store.location), io.BytesIO(), PictureFormat.PNG)
