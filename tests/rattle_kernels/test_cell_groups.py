"""Hsu's algorithm by the image set against a direct one on the whole map."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle_kernels import find_groups, label_cells


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
    cells = np.unique(image[image >= 0])
    return label_cells(find_groups(cells, image[cells]), np.arange(image.size), image)


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


def test_cells_far_apart_are_found():
    cells = np.array([3, 10**6, 10**12])
    groups = find_groups(cells, np.array([10**12, 10**6, 3]))
    assert groups.group.tolist() == [1, 2, 1]
    group, _, step = label_cells(groups, np.array([3, 4, 10**12]), np.array([10**12, 10**6, 3]))
    assert group.tolist() == [1, 2, 1] and step.tolist() == [0, 1, 0]


def test_an_image_set_that_is_not_closed_is_refused():
    with pytest.raises(ValueError, match="not closed"):
        find_groups(np.array([1, 2]), np.array([2, 5]))
    with pytest.raises(ValueError, match="ascending"):
        find_groups(np.array([2, 1]), np.array([2, 1]))


def test_a_map_without_periodic_cells_has_only_reserved_groups():
    group, period, step = image_set_hsu([-1, -2, -3])
    assert group.tolist() == [0, -1, -2] and period.tolist() == [0, 0, 0] and step.tolist() == [1, 1, 1]
