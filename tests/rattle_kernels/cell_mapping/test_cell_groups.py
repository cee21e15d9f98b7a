"""Hsu's algorithm by the image set against a direct one on the whole map."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle_kernels import find_groups, label_cells
from rattle_kernels.cell_mapping.image_set import has_members, mark_images, members_of, place_images, unite


def direct_hsu(image):
    """Group, period and step of every cell of a whole map, written straight from the definitions."""
    cells = len(image)
    cycle_of = {}
    for start in range(cells):
        here = start
        for _ in range(cells + 1):
            here = image[here] if here >= 0 else here
        if here >= 0 and here not in cycle_of:
            cycle, at = [here], image[here]
            while at != here:
                cycle.append(at)
                at = image[at]
            cycle_of |= dict.fromkeys(cycle, sorted(cycle))
    number = {cycle[0]: i + 1 for i, cycle in enumerate(sorted({tuple(c) for c in cycle_of.values()}))}
    answer = []
    for start in range(cells):
        here, step = start, 0
        while here >= 0 and here not in cycle_of:
            here, step = image[here], step + 1
        if here < 0:
            answer.append((here + 1, 0, step))
        else:
            answer.append((number[cycle_of[here][0]], len(cycle_of[here]), step))
    return tuple(np.array(column, np.int32) for column in zip(*answer, strict=True))


def image_set_hsu(image):
    image = np.array(image, np.int64)
    members = unite(image.size, [mark_images(image.size, image)])
    return label_cells(groups_of(members, image), np.arange(image.size), image)


def groups_of(members, image):
    return find_groups(members, places_of(members, image))


def places_of(members, image):
    place = np.empty(members.size, np.int32)
    place_images(members, (0, 0), image.size, image.reshape(1, -1), place)
    return place


@st.composite
def maps(draw):
    """Random maps of up to 60 cells with reserved images; a narrow range of images makes long tails and cycles."""
    cells = draw(st.integers(1, 60))
    highest = draw(st.integers(0, cells - 1))
    return draw(st.lists(st.integers(-3, highest), min_size=cells, max_size=cells))


@given(maps())
def test_the_image_set_gives_hsus_numbers_of_the_whole_map(image):
    for ours, direct in zip(image_set_hsu(image), direct_hsu(image), strict=True):
        np.testing.assert_array_equal(ours, direct)


@given(st.permutations(range(40)))
def test_in_a_permutation_every_cell_is_on_a_cycle(image):
    group, period, step = image_set_hsu(image)
    assert (step == 0).all()
    for number in range(1, group.max() + 1):
        assert (group == number).sum() == period[group == number][0]


@given(maps())
def test_step_is_zero_exactly_on_cycles(image):
    _, period, step = image_set_hsu(image)
    for cell in range(len(image)):
        here = cell
        for _ in range(period[cell]):
            here = image[here]
        assert (step[cell] == 0) == (period[cell] > 0 and here == cell)


def test_a_long_tail_is_walked_without_recursion():
    image = np.arange(1, 200_001)
    image[-1] = image.size - 1
    group, period, step = image_set_hsu(image)
    assert (group == 1).all() and (period == 1).all()
    np.testing.assert_array_equal(step, np.arange(image.size)[::-1])


def image_set(cells, members):
    return unite(cells, [mark_images(cells, np.array(members, np.int64))])


@given(st.lists(st.integers(-3, 299), max_size=40), st.lists(st.integers(-3, 299), max_size=40))
def test_the_image_set_holds_each_image_once(some, others):
    parts = [mark_images(300, np.array(part, np.int64)) for part in (some, others)]
    members = members_of(unite(300, parts))
    assert members.tolist() == sorted({cell for cell in some + others if cell >= 0})


@given(st.sets(st.integers(0, 299)), st.integers(0, 19), st.integers(1, 20), st.integers(0, 14), st.integers(1, 15))
def test_a_rectangle_of_the_grid_knows_its_members(cells, row, rows, column, columns):
    members = image_set(300, sorted(cells))
    rectangle = (row, min(row + rows, 20)), (column, min(column + columns, 15))
    image = np.arange(300).reshape(20, 15)[slice(*rectangle[0]), slice(*rectangle[1])]
    inside = set(image.ravel().tolist()) & cells
    assert has_members(members, *rectangle, 15) == bool(inside)
    place = np.full(members.size, -9, np.int32)
    place_images(members, rectangle_start(rectangle), 15, np.where(np.isin(image, list(cells)), image, -1), place)
    of_inside = members_of(members)[place != -9]
    assert set(of_inside.tolist()) == inside
    np.testing.assert_array_equal(members_of(members)[place[place != -9]], of_inside)


def rectangle_start(rectangle):
    return tuple(start for start, _ in rectangle)


@pytest.mark.parametrize("missing", [5, 64_000])
def test_an_image_set_that_is_not_closed_is_refused(missing):
    with pytest.raises(ValueError, match=f"image {missing} is no member"):
        groups_of(image_set(9, [1, 2]), np.array([-1, 2, missing]))


def test_a_map_without_periodic_cells_has_only_reserved_groups():
    group, period, step = image_set_hsu([-1, -2, -3])
    assert group.tolist() == [0, -1, -2] and period.tolist() == [0, 0, 0] and step.tolist() == [1, 1, 1]
