"""What a viewer draws from, read while it is being written."""

import numpy as np
import pytest

from worker.results.summary import summarise
from worker.results.viewer import outline_basin
from worker.stores import layout


@pytest.mark.parametrize("which", [0, 1])
def test_points_of_which_half_is_written_are_not_there_yet(store, which):
    store.arrays.fresh(layout.POINTS[which])[...] = np.nan
    outline = outline_basin(store.location, 0)
    assert [attractor.name for attractor in outline.solutions] == ["permanent contact", "P(1,1,0)", "chaotic"]
    assert all(attractor.time.size == attractor.velocity.size == 0 for attractor in outline.solutions)
    assert [solution.points for solution in summarise(store.location).solutions] == [[], [], []]


@pytest.mark.parametrize("which", [0, 1])
def test_points_that_there_is_no_room_for_yet_are_not_there_yet(store, which):
    store.arrays.fresh(layout.POINTS[which]).resize((2, 1))
    outline = outline_basin(store.location, 0)
    assert [attractor.time.size for attractor in outline.solutions] == [0, 1, 0]
