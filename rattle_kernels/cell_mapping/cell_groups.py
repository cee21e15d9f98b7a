"""Group, period and step of every cell, as Hsu (1980, 1987) defines them, from the image set alone.

A cell map sends each cell to one image, so following images from any cell ends on a cycle of cells (a group; its length
is the period) or in a reserved image. The *image set* R, the distinct images of all cells, is closed under the map and
holds every cycle. So `find_groups` runs Hsu's algorithm on R only, which for ``P^k`` with a large k is far smaller than
the grid, and `label_cells` then labels any cells by looking up their images: ``group(c) = group(image(c))``, and
``step(c) = step(image(c)) + 1`` unless c is on a cycle.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.cell_mapping.image_set import ImageSet, place_of
from rattle_kernels.numerics.jit import kernel


class CellGroups(NamedTuple):
    """Hsu's numbers on the image set.

    ``members`` is the image set R; ``group`` and ``step`` (int32) have an entry for each of its members in ascending
    order: ``group`` is 1, 2, ... by each cycle's lowest cell number, 0 the sink, -1 permanent contact, -2 undecided;
    ``step`` the applications to reach the cycle, 0 on it, or to get into the reserved image. ``period_of_group``
    (int32) is the length of each group's cycle, 0 for entry 0.
    """

    members: ImageSet
    group: np.ndarray
    step: np.ndarray
    period_of_group: np.ndarray


@kernel
def _peel(place, degree, order):
    """Take off members that are no member's image any more, until cycles alone are left; return how many.

    `order` lists them as they come off, so that each stands before its image; `degree` counts the images a member
    still is. Unlike a walk along images, one member after the other, the steps of this pass do not wait for one
    another: twice as fast where images lie scattered.
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
    """Number the cycles that peeling has left; in ascending order of members, so by their lowest cell.

    Their members' place is replaced by the number of the cycle, their degree (1 on a cycle) by 0, their step.
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
    """Replace the place of what was peeled by its group, from the cycles and reserved images outwards."""
    for i in range(peeled - 1, -1, -1):
        member = order[i]
        image = place[member]
        if image < 0:
            place[member], step[member] = image + 1, 1
        else:
            place[member], step[member] = place[image], step[image] + 1


def find_groups(members: ImageSet, place: np.ndarray) -> CellGroups:
    """Run Hsu's algorithm on the image set.

    Parameters
    ----------
    members : ImageSet
        The distinct images of all cells that are cell numbers; below 2e9 of them.
    place : ndarray of int32, shape (members.size,)
        Where among the members each one's image stands, or its reserved image (see `image_set.place_images`).
        Overwritten: with 1e8 members, to touch another 400 MB costs as much as the work.

    Returns
    -------
    CellGroups

    References
    ----------
    Hsu and Guttalu (1980); Hsu, Cell-to-Cell Mapping (1987), Sec. 8.
    """
    order, degree = np.empty(members.size, np.int32), np.zeros(members.size, np.int32)
    peeled = _peel(place, degree, order)
    period = np.zeros(members.size - peeled + 1, np.int32)
    cycles = _number_cycles(place, degree, period)
    group, step = place, degree  # what they have become
    _step_back(group, order, peeled, step)
    return CellGroups(members, group, step, period[: cycles + 1].copy())


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
    """Group, period and step of any cells, by their images.

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
