"""A window of a picture shows its own cells, at the places where the whole picture has them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from rattle_kernels import CellGrid
from worker.errors import InvalidJob
from worker.pictures.window import Window, parse_window
from worker.results.figure import basin_figure
from worker.results.opening import open_basin
from worker.results.panel import Basins, Layer, Look, Panel
from worker.stores.layout import TileState


def panel(store, look, most_cells=1000):
    with open_basin(store.location) as basin:
        return Panel(Basins(basin), 0, look, most_cells)


def colour(axes, t, v):
    """What is drawn at a place; None where no image is."""
    for image in reversed(axes.images):  # later ones lie above
        left, right, low, high = image.get_extent()
        if left <= t < right and low <= v < high:
            rows, columns = image.get_array().shape[:2]
            at = int((v - low) / (high - low) * rows), int((t - left) / (right - left) * columns)
            return tuple(np.atleast_1d(image.get_array()[at]))
    return None


@pytest.mark.parametrize("most_cells", [1000, 10])
@pytest.mark.parametrize("layer", [Layer.SOLUTION, Layer.GROUP])
@pytest.mark.parametrize(
    "window",
    [
        Window(0.3, 0.7, 3.0, 4.0),
        Window(0.75, 1.25, 1.0, 6.0),
        Window(-0.2, 0.8, 0.0, 7.0),
        Window(0.5, 0.503, 3.4, 3.6),
    ],
)
def test_a_window_shows_the_cells_that_are_there(store, window, layer, most_cells):
    axes, whole = Figure().subplots(), Figure().subplots()
    shown = panel(store, Look(layer, window=window), most_cells)
    shown.draw(axes)
    panel(store, Look(layer)).draw(whole)
    assert axes.get_xlim() == window[:2] and axes.get_ylim() == window[2:]
    width, height = 1.0 / 128, 7.0 / 128
    for part in np.random.default_rng(1).random((50, 2)):
        t = window.time_start + part[0] * (window.time_stop - window.time_start)
        v = window.velocity_start + part[1] * (window.velocity_stop - window.velocity_start)
        # Of cells that are left out, the first of `every` stands for its neighbours.
        column, row = (int((x % 1.0 if x is t else x) / size) // shown.every for x, size in ((t, width), (v, height)))
        centre = (column * shown.every + 0.5) * width, (row * shown.every + 0.5) * height
        assert colour(axes, t, v) == colour(whole, *centre) is not None


def test_a_small_window_of_a_large_basin_shows_every_cell(store):
    assert panel(store, Look(), 10).every == 13
    assert panel(store, Look(window=Window(0.5, 0.56, 3.0, 3.4)), 10).every == 1


def test_tiles_that_are_missing_are_hatched_in_a_window_across_the_end_of_the_period(store):
    states = store.read_ledger()
    states[1] = TileState.PENDING  # lower right: t 0.5 to 1
    store.write_ledger(states)
    axes = Figure().subplots()
    panel(store, Look(window=Window(0.75, 1.25, 0.0, 7.0))).hatch_missing(axes)
    assert sorted(patch.get_x() for patch in axes.patches) == [0.5, 1.5]


def test_a_picture_of_a_window_says_what_its_shares_are_of(store):
    told = basin_figure(store.location, Look(window=Window(0.3, 0.7, 3.0, 4.0))).axes[0].get_title()
    assert "shares are those of t 0 to 1, v 0 to 7" in told
    assert "shares" not in basin_figure(store.location).axes[0].get_title()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "four numbers"),
        ("0.2,0.6,3", "four numbers"),
        ("0.2,0.6,3,5,7", "four numbers"),
        ("0.2;0.6;3;5", "four numbers"),
        ("0.2,nan,3,5", "finite"),
        ("0.6,0.2,3,5", "the time of a window ends"),
        ("0.2,0.6,5,5", "the velocity of a window ends"),
        ("0,1.1,3,5", "at most one period"),
        ("7,7.5,3,5", "from -1 to 2"),
    ],
)
def test_what_is_no_window_is_refused(text, told):
    with pytest.raises(InvalidJob, match=told):
        parse_window(text)


def test_a_window_where_nothing_was_computed_is_refused_with_what_was(store):
    with pytest.raises(InvalidJob, match="the job covers t 0 to 1, v 0 to 7"):
        basin_figure(store.location, Look(window=Window(0.2, 0.4, 7.0, 9.0)))
    with pytest.raises(InvalidJob, match="there is no basin 1: there are 1"):
        basin_figure(store.location, Look(panel=1))


@given(
    start=st.floats(-1.0, 2.0), width=st.floats(1e-6, 1.0), first=st.floats(0.0, 0.99), span=st.floats(1e-3, 1.0),
    part=st.floats(0.0, 0.999),
)  # fmt: skip
def test_every_place_that_a_window_shows_is_in_one_copy_of_the_grid_or_in_none(start, width, first, span, part):
    grid = CellGrid(first, first + span, 10, 0.0, 7.0, 10)
    window = Window(start, start + width, 0.0, 7.0)
    t = start + part * width
    inside = [period for period in window.periods_over(grid) if grid.time_start + period <= t < grid.time_stop + period]
    # Beside the edges, where a rounded phase may be on either side.
    if min(abs((t - edge + 0.5) % 1.0 - 0.5) for edge in (grid.time_start, grid.time_stop)) > 1e-9:
        assert len(inside) == ((t - grid.time_start) % 1.0 < span)
        for period in inside:
            _, (left, right) = window.cells_of(grid, period)
            assert left <= (t - grid.time_start - period) / (span / 10) <= right
