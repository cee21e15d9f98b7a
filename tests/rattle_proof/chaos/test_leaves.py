"""Leaves cut a set in two, each of them; where that is not so, it is seen."""

import numpy as np
import pytest

from rattle_proof.chaos.leaves import (
    BESIDE_FIRST,
    BESIDE_LAST,
    INSIDE,
    LEFT,
    OUTSIDE,
    RIGHT,
    Leaves,
    NotSeparated,
    places_of,
    sides_of,
)
from rattle_proof.enclosures.lattice import Lattice

ROWS, COLUMNS, HEIGHT = 12, 32, 1.0 / 4.0
# Rows 5 to 7, columns 4 to 27.
BAND = [(row, column) for row in (5, 6, 7) for column in range(4, 28)]


def lattice(*more, boxes=BAND):
    found = Lattice(HEIGHT, 8, np.zeros((ROWS, COLUMNS), np.uint16))
    for row, column in (*boxes, *more):
        found.ends[row, column] = 1
    return found


def leaves(*times, bottom=3, top=10, lean=0.0):
    """Straight leaves between two nodes, leaning by some columns over a row."""
    nodes = np.arange(top - bottom + 1)
    return Leaves(np.array([(t + lean * nodes) / COLUMNS for t in times]), 8 + bottom, HEIGHT, 2.0**-36)


def test_boxes_of_a_band_lie_before_between_and_behind_its_leaves():
    found = places_of(leaves(10.5, 16.5, 20.5), lattice())
    assert (found[6, :4] == 0).all() and (found[0] == 0).all()
    expected = [LEFT] * 6 + [BESIDE_FIRST] + [INSIDE] * 9 + [BESIDE_LAST] + [RIGHT] * 7
    assert found[6, 4:28].tolist() == expected


def test_a_box_that_hangs_together_with_neither_end_lies_nowhere():
    assert places_of(leaves(10.5, 20.5), lattice((0, 16), (11, 30)))[[0, 11], [16, 30]].tolist() == [OUTSIDE, OUTSIDE]


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ([(row, 15) for row in (2, 3, 4)], "above or below"),
        ([(row, 15) for row in (8, 9, 10)], "above or below"),
        ([(9, 15)], "above or below"),
        ([(3, 15)], "above or below"),
        # By way of the rows above the window, and by way of the period's end.
        ([(8, 5), (9, 5), (10, 5), *((11, column) for column in range(5, 27)), (10, 26), (9, 26), (8, 26)], "round"),
        ([(6, column) for column in (0, 1, 2, 3, 28, 29, 30, 31)], "round"),
        # Corner to corner.
        ([(4, 3), (3, 2), (2, 1), (1, 0), (2, 31), (3, 30), (4, 29), (5, 28)], "round"),
    ],
)
def test_a_set_that_gets_past_the_leaves_is_seen(more, why):
    with pytest.raises(NotSeparated, match=why):
        places_of(leaves(10.5, 20.5), lattice(*more))


def test_a_set_that_ends_in_the_window_or_is_cut_there_leads_through_nowhere():
    with pytest.raises(NotSeparated, match="ends in it"):
        places_of(leaves(10.5, 20.5), lattice(boxes=[each for each in BAND if each[1] < 16]))
    with pytest.raises(NotSeparated, match="does not lead through"):
        places_of(leaves(10.5, 20.5), lattice(boxes=[each for each in BAND if each[1] != 16]))


def test_leaves_that_meet_or_leave_the_period_are_none():
    crossing = leaves(10.5, 12.5)
    crossing.times[0, -1] = crossing.times[1, -1]
    with pytest.raises(NotSeparated, match="meet"):
        places_of(crossing, lattice())
    with pytest.raises(NotSeparated, match="period"):
        places_of(leaves(10.5, 32.0), lattice())
    with pytest.raises(NotSeparated, match="meet"):
        places_of(leaves(10.5, 20.5)._replace(height=0.5 * HEIGHT), lattice())


@pytest.mark.parametrize("lean", [0.0, 0.7, -0.7])
def test_sides_are_those_of_every_point_of_a_box(lean):
    """Of leaves as polylines, at many points of boxes anywhere in the window: certain where it is said, else open."""
    random = np.random.default_rng(1)
    cut = leaves(8.5, 12.0, 12.6, 19.3, lean=lean)
    cut.times[:] += random.uniform(-0.2, 0.2, cut.times.shape) / COLUMNS
    nodes = (cut.first + np.arange(cut.times.shape[1])) * HEIGHT
    for _ in range(2000):
        early, low = random.random(), random.uniform(nodes[0], nodes[-1])
        late, high = early + random.random() ** 3 / COLUMNS, min(low + random.random() ** 3 * HEIGHT, nodes[-1])
        surely, most = sides_of(cut, early, late, low, high)
        speeds = np.linspace(low, high, 9)
        at = np.array([np.interp(speeds, nodes, times) for times in cut.times])
        assert (at[:surely] < early).all() and (at[most:] > late).all()
        assert surely <= most
        if high - low == 0.0:
            assert surely == (at[:, 0] < early).sum()
