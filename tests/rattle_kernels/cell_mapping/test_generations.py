"""Generations of images, from the definitions; and numbers from the core outwards."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle_kernels import find_groups
from rattle_kernels.cell_mapping.cell_groups import generations_of, places_within
from rattle_kernels.cell_mapping.image_set import members_of, with_counts
from tests.rattle_kernels.cell_mapping.test_cell_groups import direct_hsu, groups_of, image_set, places_of


def members_in(words):
    return members_of(with_counts(words)).tolist()


@st.composite
def places(draw):
    """Places of images among up to 200 members, some of them reserved: of whatever set, closed or not."""
    members = draw(st.integers(0, 200))
    return np.array(draw(st.lists(st.integers(-3, members - 1), min_size=members, max_size=members)), np.int32)


@given(places())
def test_each_generation_holds_the_images_of_the_one_before(place):
    generations = [members_in(words) for words in generations_of(place)]
    assert generations[0] == list(range(place.size))
    for generation, following in zip(generations, generations[1:], strict=False):
        assert following == sorted({place[member] for member in generation if place[member] >= 0})
        assert len(generation) - len(following) >= len(generation) / 8
    images = {place[member] for member in generations[-1] if place[member] >= 0}
    assert not generations[-1] or len(generations[-1]) - len(images) < len(generations[-1]) / 8


@given(places())
def test_the_core_is_closed_and_knows_its_own_images(place):
    core = with_counts(generations_of(place)[-1])
    members = members_of(core)
    within = places_within(core, place)
    inside = within >= 0
    np.testing.assert_array_equal(members[within[inside]], place[members[inside]])
    np.testing.assert_array_equal(within[~inside], place[members[~inside]])


def bushy_tail(length):
    """Cells in a chain that ends in a fixed cell; nine more cells hang on each, three of them on the other six."""
    chain = np.maximum(np.arange(length) - 1, 0)
    hang = np.arange(length)
    middle = np.concatenate([hang, hang, hang])
    outer = length + np.tile(np.arange(3 * length), 2)
    return np.concatenate([chain, middle, outer])


@pytest.mark.parametrize(("length", "kept"), [(300, np.int16), (32_767, np.int16), (32_768, np.int32)])
def test_numbers_are_of_16_bits_as_long_as_all_fit(length, kept):
    """Steps are up to length - 1 in the chain, and one more in the cells that hang on it."""
    image = bushy_tail(length)
    members = image_set(image.size, image)
    groups = groups_of(members, image)
    assert len(generations_of(places_of(members, image))) > 1
    assert groups.group.dtype == groups.step.dtype == kept
    assert groups.group.tolist() == [1] * members.size and groups.period_of_group.tolist() == [0, 1]
    steps = np.arange(length)
    np.testing.assert_array_equal(groups.step, np.concatenate([steps, np.tile(steps + 1, 3)]))


def test_many_cycles_need_32_bits():
    place = np.arange(40_000, dtype=np.int32)
    groups = find_groups(image_set(40_000, place), place.copy())
    assert groups.group.dtype == np.int32
    np.testing.assert_array_equal(groups.group, place + 1)
    assert not groups.step.any()


def test_a_map_that_shrinks_for_several_generations_has_hsus_numbers():
    rng = np.random.default_rng(5)
    image = np.minimum(rng.integers(-2, 400, 400), rng.integers(-2, 400, 400))
    members = image_set(400, image)
    assert len(generations_of(places_of(members, image))) > 2
    groups = groups_of(members, image)
    group, _, step = direct_hsu(image.tolist())
    np.testing.assert_array_equal(groups.group, group[members_of(members)])
    np.testing.assert_array_equal(groups.step, step[members_of(members)])
