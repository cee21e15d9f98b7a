"""Generations of images: the image set R, its images P(R), their images P(P(R)), and so on.

Each generation holds the next one, and all hold every cycle. Where the map contracts they shrink fast, so Hsu's
algorithm runs on the last of them, the *core*. The members of each generation before it take their numbers from their
images, all of which lie in the next one. A generation is a bitmap of the members of R, 7 MB for 58 million, so marking
images stays within the caches. No member waits for another of its generation.
"""

import numpy as np

from rattle_kernels.cell_mapping.image_set import ImageSet, bits_below, place_of
from rattle_kernels.numerics.jit import kernel

# Another generation costs 2 ns for each member that stays, and saves 25 ns for each that leaves.
_LEAST_LEAVING = 1 / 8


@kernel
def _mark_images(place, generation, images):
    for number in range(generation.size):
        word = generation[number]
        while word != 0:
            bit = word & -word
            word ^= bit
            image = place[number * 64 + bits_below(bit)]
            if image >= 0:
                images[image >> 6] |= np.uint64(1) << np.uint64(image & 63)


@kernel
def _places_within(core, place, within):
    found = 0
    for number in range(core.words.size):
        word = core.words[number]
        while word != 0:
            bit = word & -word
            word ^= bit
            image = place[number * 64 + bits_below(bit)]
            within[found] = image if image < 0 else place_of(core, image)
            found += 1


@kernel
def _number_core(core, group, step, numbers):
    found = 0
    for number in range(core.words.size):
        word = core.words[number]
        while word != 0:
            bit = word & -word
            word ^= bit
            member = number * 64 + bits_below(bit)
            numbers[member, 0], numbers[member, 1] = group[found], step[found]
            found += 1


@kernel
def _number_by_images(place, generation, following, numbers):
    for number in range(generation.size):
        word = generation[number] & ~following[number]
        while word != 0:
            bit = word & -word
            word ^= bit
            member = number * 64 + bits_below(bit)
            image = place[member]
            if image < 0:
                numbers[member, 0], numbers[member, 1] = image + 1, 1
            else:
                numbers[member, 0], numbers[member, 1] = numbers[image, 0], numbers[image, 1] + 1


def generations_of(place: np.ndarray) -> list[np.ndarray]:
    """All members, their images, and so on, while an eighth or more leaves with each.

    Parameters
    ----------
    place : ndarray of int32
        As in `cell_groups.find_groups`.

    Returns
    -------
    list of ndarray of uint64
        Bit ``member % 64`` of word ``member // 64`` is set if the member is of that generation.
    """
    everyone = np.full(-(-place.size // 64), ~np.uint64(0))
    if place.size % 64:
        everyone[-1] >>= np.uint64(64 - place.size % 64)
    generations, size = [everyone], place.size
    while size > 0:
        images = np.zeros_like(everyone)
        _mark_images(place, generations[-1], images)
        following = int(np.bitwise_count(images).sum())
        if size - following < _LEAST_LEAVING * size:
            break
        generations.append(images)
        size = following
    return generations


def places_within(core: ImageSet, place: np.ndarray) -> np.ndarray:
    """For each member of the core, the place of its image among the members of the core, or its reserved image."""
    within = np.empty(core.size, np.int32)
    _places_within(core, place, within)
    return within


def number_outwards(
    generations: list[np.ndarray], core: ImageSet, place: np.ndarray, group: np.ndarray, step: np.ndarray,
    numbers: np.ndarray,
) -> None:  # fmt: skip
    """Number all members from the core outwards.

    Parameters
    ----------
    generations : list of ndarray
        Of `generations_of`.
    core : ImageSet
        The last of them.
    place : ndarray of int32, shape (members,)
        As in `cell_groups.find_groups`.
    group, step : ndarray of int32, shape (core.size,)
        Of the members of the core.
    numbers : ndarray of int, shape (members, 2)
        Overwritten by group and step of every member. It may share its memory with ``place``, and with ``group`` if all
        members are of the core, entry by entry: each is read once, just before the numbers are written.
    """
    _number_core(core, group, step, numbers)
    for generation, following in zip(generations[-2::-1], generations[:0:-1], strict=True):
        _number_by_images(place, generation, following, numbers)
