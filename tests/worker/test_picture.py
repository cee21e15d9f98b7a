"""Pictures: right colours in the right places, honest about what is missing."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

from rattle_kernels import AttractorKind, CellGrid
from tests.worker.made_up import CHAOS, QUIET, RATTLE, motion, near
from worker import colours, layout
from worker.basin_job import BasinJob
from worker.errors import StoreConflict
from worker.layout import TileState
from worker.picture import Layer, draw_basin
from worker.store import BasinStore


def drawn(store, layer=Layer.SOLUTION):
    buffer = io.BytesIO()
    draw_basin(store.location, buffer, layer=layer)
    buffer.seek(0)
    return imread(buffer)[..., :3]


def test_each_motion_has_its_colour(store):
    picture = drawn(store)
    assert near(picture, colours.PERMANENT_CONTACT) > 0.2
    assert near(picture, colours.colours_of((RATTLE,))[0]) > 0.1
    reddish = (picture[..., 0] > 0.3) & (picture[..., 1] < 0.1) & (picture[..., 2] < 0.1)
    assert reddish.mean() > 0.1
    assert near(picture, colours.MISSING) < 0.02


def test_chaos_is_speckled_by_group(store):
    picture = drawn(store)
    reddish = (picture[..., 0] > 0.3) & (picture[..., 1] < 0.1) & (picture[..., 2] < 0.1)
    assert len(np.unique(picture[reddish][:, 0].round(2))) >= 3


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


@pytest.mark.parametrize("layer", [Layer.GROUP, Layer.PERIOD, Layer.STEP])
def test_the_same_store_gives_the_same_bytes(store, layer):
    one, other = io.BytesIO(), io.BytesIO()
    draw_basin(store.location, one, layer=layer)
    draw_basin(store.location, other, layer=layer)
    assert one.getvalue() == other.getvalue()


def test_a_place_that_is_no_store_is_refused(tmp_path):
    with pytest.raises(StoreConflict, match="is no basin store"):
        draw_basin(str(tmp_path), io.BytesIO())


def test_motions_of_one_name_are_told_apart_and_kinds_keep_their_colours():
    twin = motion(AttractorKind.PERIODIC, (1, 1, 0), [0.6], [3.5])
    first, second = colours.colours_of((RATTLE, twin))
    assert first != second
    assert colours.colours_of((CHAOS, QUIET)) == [colours.CHAOTIC, colours.PERMANENT_CONTACT]


def test_every_variable_has_dimensions_and_a_fill_that_is_no_value():
    for variable in (
        *layout.COORDINATES,
        *layout.MAPPED,
        *layout.LABELLED,
        layout.LEDGER,
        layout.GRAZING,
        *layout.ATTRACTORS,
    ):
        assert variable.dims and variable.meaning
        assert variable.fill in (layout.MISSING, np.inf, 0, "")
