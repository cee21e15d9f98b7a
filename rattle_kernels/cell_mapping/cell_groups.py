"""Group, period and step of every cell, as Hsu (1980, 1987) defines them, from the image set alone.

A cell map sends each cell to one image. The sequence of images from any cell therefore ends on a cycle of cells (a
group, whose length is the period) or in a reserved image. The *image set* R holds the distinct images of all cells. It
is closed under the map and contains every cycle, and for ``P^k`` with a large k it is far smaller than the grid. So
`find_groups` runs Hsu's algorithm on R only, or on a part of it. `label_cells` then labels any cells by their images:
``group(c) = group(image(c))``, and ``step(c) = step(image(c)) + 1`` unless c is on a cycle.

*Generations* are the image set R, its images P(R), their images P(P(R)), and so on. Each holds the next one, and all
hold every cycle. Where the map contracts they shrink fast, so Hsu's algorithm runs on the last of them, the *core*. The
members of each generation before it take their numbers from their images, all of which lie in the next one. A
generation is a bitmap of the members of R, 7 MB for 58 million, so marking images stays within the caches. No member
waits for another of its generation.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.cell_mapping.image_set import ImageSet, bits_below, place_of, with_counts
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
        As in `find_groups`.

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
        As in `find_groups`.
    group, step : ndarray of int32, shape (core.size,)
        Of the members of the core.
    numbers : ndarray of int, shape (members, 2)
        Overwritten by group and step of every member. It may share its memory with ``place``, and with ``group`` if all
        members are of the core, entry by entry: each is read once, just before the numbers are written.
    """
    _number_core(core, group, step, numbers)
    for generation, following in zip(generations[-2::-1], generations[:0:-1], strict=True):
        _number_by_images(place, generation, following, numbers)


class CellGroups(NamedTuple):
    """Hsu's numbers on the image set.

    ``members`` is the image set R. ``group`` and ``step`` (both int16 if all numbers fit, else int32) have an entry for
    each member, in ascending order. They are columns of one array, so that a look-up of both takes one line of the
    cache. ``group`` is 1, 2, ... in the order of each cycle's lowest cell number, 0 for the sink, -1 for
    permanent contact, -2 for not converged. ``step`` is the number of applications to the cycle (0 on it) or to the
    reserved image. ``period_of_group`` (int32) is the length of each group's cycle, 0 for entry 0.
    """

    members: ImageSet
    group: np.ndarray
    step: np.ndarray
    period_of_group: np.ndarray


@kernel
def _peel(place, degree, order):
    """Remove members that are no longer the image of a member, until only cycles remain; return how many.

    `order` lists them in the order of removal, so each precedes its image. `degree` is the number of remaining members
    that map to a member. The steps of this pass do not wait for one another, unlike those of a walk from image to
    image. That makes it twice as fast when images are scattered.
    """
    for i in range(place.size):
        if place[i] >= 0:
            degree[place[i]] += 1
    peeled = 0
    for i in range(place.size):
        if degree[i] == 0:
            order[peeled] = i
            peeled += 1
    following = 0
    while following < peeled:
        image = place[order[following]]
        following += 1
        if image >= 0:
            degree[image] -= 1
            if degree[image] == 0:
                order[peeled] = image
                peeled += 1
    return peeled


@kernel
def _number_cycles(place, degree, period):
    """Number the cycles that remain after peeling, in the order of their lowest cells.

    For their members, the cycle's number replaces the place, and the step, 0, replaces the degree, which is 1.
    """
    cycles = 0
    for start in range(place.size):
        if degree[start] == 0:
            continue
        cycles += 1
        here = start
        while degree[here] != 0:
            degree[here] = 0
            following = place[here]
            place[here] = cycles
            period[cycles] += 1
            here = following
    return cycles


@kernel
def _step_back(place, order, peeled, step):
    """Replace the places of peeled members by their groups, from the cycles and reserved images outwards."""
    for i in range(peeled - 1, -1, -1):
        member = order[i]
        image = place[member]
        if image < 0:
            place[member], step[member] = image + 1, 1
        else:
            place[member], step[member] = place[image], step[image] + 1


def _solve(place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Group and step of members (int32), and the groups' periods, from the places of their images. Overwrites these."""
    order, degree = np.empty(place.size, np.int32), np.zeros(place.size, np.int32)
    peeled = _peel(place, degree, order)
    period = np.zeros(place.size - peeled + 1, np.int32)
    cycles = _number_cycles(place, degree, period)
    group, step = place, degree  # the same arrays, overwritten
    _step_back(group, order, peeled, step)
    return group, step, period[: cycles + 1].copy()


def find_groups(members: ImageSet, place: np.ndarray) -> CellGroups:
    """Run Hsu's algorithm on the image set.

    Parameters
    ----------
    members : ImageSet
        The distinct images of all cells, without reserved images; fewer than 2e9.
    place : ndarray of int32, shape (members.size,)
        For each member, the place of its image among the members, or its reserved image (``image_set.place_images``).
        Overwritten, since touching another 400 MB, with 1e8 members, costs as much as the work itself.

    Returns
    -------
    CellGroups

    References
    ----------
    Hsu and Guttalu (1980); Hsu, Cell-to-Cell Mapping (1987), Sec. 8.
    """
    generations = generations_of(place)
    core = with_counts(generations[-1])
    # If nobody leaves, a copy would only cost memory.
    group, step, period = _solve(places_within(core, place) if len(generations) > 1 else place)
    # Each generation adds at most one step to those of the next.
    highest = max(period.size - 1, int(step.max(initial=0)) + len(generations) - 1)
    small = highest <= np.iinfo(np.int16).max
    numbers = place.view(np.int16).reshape(-1, 2) if small else np.empty((place.size, 2), np.int32)
    number_outwards(generations, core, place, group, step, numbers)
    return CellGroups(members, numbers[:, 0], numbers[:, 1], period)


@kernel
def _label(groups, own_cells, image_cell, labels):
    members, group_of, step_of, period_of_group = groups
    group, period, step = labels
    for i in range(image_cell.size):
        image = image_cell[i]
        if image < 0:
            group[i], period[i], step[i] = image + 1, 0, 1
            continue
        at = place_of(members, image)
        group[i], step[i] = group_of[at], step_of[at] + 1
        period[i] = period_of_group[max(group_of[at], 0)]
        if step_of[at] == 0:  # the cell itself may be on the cycle
            own = place_of(members, own_cells[i])
            if own >= 0 and step_of[own] == 0:
                step[i] = 0


def label_cells(
    groups: CellGroups, own_cells: np.ndarray, image_cell: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Group, period and step of any cells, from their images.

    Parameters
    ----------
    groups : CellGroups
        Of the whole map.
    own_cells, image_cell : ndarray of int64, one shape
        Cell numbers, and their images.

    Returns
    -------
    group, period, step : ndarray of int32, that shape
    """
    labels = tuple(np.empty(image_cell.size, np.int32) for _ in range(3))
    _label(groups, own_cells.ravel(), image_cell.ravel(), labels)
    group, period, step = (label.reshape(image_cell.shape) for label in labels)
    return group, period, step
