"""Boxes of which nothing falls quiet: the largest set that comes back to itself, without the lowest row."""

import numpy as np
import pytest

from rattle_kernels import (
    PERMANENT_CONTACT,
    AttractorKind,
    CellGrid,
    Oscillator,
    find_attractors,
    map_points,
    next_impacts,
)
from rattle_proof.enclosures import cells as cells_
from rattle_proof.enclosures.cells import ENDS_ELSEWHERE, WHOLE, prove_cells
from rattle_proof.enclosures.growth import IMPACTS, NUMBERS, empty_trails, follow_boxes, grow_all, never_quiet
from rattle_proof.enclosures.lattice import UNPROVEN, refined
from rattle_proof.enclosures.machine import machine_of
from rattle_proof.enclosures.targets import NO_QUIET, RATTLES, prove_targets

QUIET, ORBIT = 1, 2
ROWS, COLUMNS = 8, 8


def trails_to(images):
    """Trails of boxes whose images each lie inside of a box, by impact; None where nothing is known."""
    trails = np.full((len(images), IMPACTS, NUMBERS), np.nan, np.float32)
    for k, each in enumerate(images):
        for n, place in enumerate(each):
            if place is not None:
                row, column = place
                times, rows = ((column + 0.4) / COLUMNS, (column + 0.6) / COLUMNS), (row + 0.4, row + 0.6)
                trails[k, n] = *times, *rows, *rows, 0.0
    return trails


def found(ends, images, quiet=QUIET, parts=1):
    """The set, of boxes with images; of all others nothing is known."""
    boxes = np.array(list(images), np.int32).reshape(-1, 2)
    rattling = never_quiet(ends, quiet, boxes, trails_to(list(images.values())), parts=parts)
    known = np.zeros(ends.shape, np.bool_)
    known[boxes[:, 0], boxes[:, 1]] = True
    # A box that was not followed is one that is proven.
    assert (known | (ends != UNPROVEN)).all()
    return rattling


def lattice(**given):
    """Ends of a lattice whose other boxes fall quiet: places by end."""
    ends = np.full((ROWS, COLUMNS), QUIET, np.uint16)
    for end, places in given.items():
        for place in places:
            ends[place] = {"open": UNPROVEN, "orbit": ORBIT}[end]
    return ends


def test_a_cycle_of_boxes_stays_and_what_comes_to_it():
    images = {(3, 1): [(4, 5)], (4, 5): [(3, 1)], (5, 5): [(4, 5)]}
    assert np.argwhere(found(lattice(open=images), images)).tolist() == [[3, 1], [4, 5], [5, 5]]


def test_a_chain_that_leads_out_goes_box_by_box():
    images = {(n, 2): [(n - 1, 2)] for n in range(2, ROWS)}
    assert not found(lattice(open=images), images).any(), "the first falls quiet"
    images[2, 2] = [None]
    assert not found(lattice(open=images), images).any(), "of the first nothing is known"


def test_one_impact_that_comes_back_is_enough():
    """After four it is within; where it is before does not matter, as what falls quiet has no way back."""
    images = {(3, 1): [(6, 6), None, (0, 0), (3, 1)]}
    assert np.argwhere(found(lattice(open=images), images)).tolist() == [[3, 1]]


def test_what_comes_to_an_orbit_belongs_to_it_and_so_does_the_orbit():
    images = {(3, 1): [(5, 5)]}
    assert np.argwhere(found(lattice(open=images, orbit=[(5, 5)]), images)).tolist() == [[3, 1], [5, 5]]


def test_an_image_that_only_touches_what_falls_quiet_is_out():
    ends = lattice(open=[(3, 1)], orbit=[(5, 5)])
    boxes, trails = np.array([[3, 1]], np.int32), trails_to([[(5, 5)]])
    trails[0, 0, 3] = trails[0, 0, 5] = 6.1
    assert np.argwhere(never_quiet(ends, QUIET, boxes, trails)).tolist() == [[5, 5]]


def test_the_lowest_row_holds_rest_and_is_out():
    """Also of each of several lattices above each other."""
    images = {(0, 1): [(0, 1)], (1, 1): [(0, 1)], (2, 2): [(2, 2)]}
    ends = lattice(open=images)
    assert np.argwhere(found(ends, images)).tolist() == [[2, 2]]
    both = images | {(ROWS + row, column): image for (row, column), image in images.items()}
    twice = found(np.tile(ends, (2, 1)), both, parts=2)
    assert np.argwhere(twice).tolist() == [[2, 2], [ROWS + 2, 2]]


def test_lattices_of_parts_do_not_lean_on_each_other():
    images = {(3, 1): [(4, 5)], (4, 5): [(3, 1)], (ROWS + 3, 1): [(4, 5)]}
    ends = np.full((2 * ROWS, COLUMNS), QUIET, np.uint16)
    for place in images:
        ends[place] = UNPROVEN
    assert np.argwhere(found(ends, images, parts=2)).tolist() == [[3, 1], [4, 5]]


def test_where_no_motion_is_known_to_fall_quiet_what_leads_nowhere_is_out_all_the_same():
    images = {(row, column): [None] for row in range(ROWS) for column in range(COLUMNS)}
    images[3, 1] = [(3, 1)]
    ends = np.full((ROWS, COLUMNS), UNPROVEN, np.uint16)
    assert np.argwhere(found(ends, images, NO_QUIET)).tolist() == [[3, 1]]


def test_the_set_is_that_of_a_plain_search():
    """Of random maps of boxes: a box is out if all its images are, until none goes any more."""
    random = np.random.default_rng(0)
    for _ in range(50):
        ends = random.choice(np.array([QUIET, ORBIT, UNPROVEN], np.uint16), (ROWS, COLUMNS), p=[0.3, 0.05, 0.65])
        images = {
            (int(row), int(column)): [
                None if random.random() < 0.3 else (int(random.integers(ROWS)), int(random.integers(COLUMNS)))
                for _ in range(int(random.integers(1, 3)))
            ]
            for row, column in np.argwhere(ends == UNPROVEN)
        }
        within = {(row, column) for row, column in np.argwhere(ends != QUIET).tolist() if row > 0}
        while out := {place for place in within & set(images) if not any(each in within for each in images[place])}:
            within -= out
        assert {(row, column) for row, column in np.argwhere(found(ends, images)).tolist()} == within


# A machine whose motions pass long transients before they come to P(2,2,1), P(4,4,2), P(5,5,2) or P(8,8,6).
WANDERING = Oscillator(0.6, 0.089, 0.6)
GRID = CellGrid(time_cells=60, velocity_cells=60)
_DEPARTURES = 40_000


@pytest.fixture(scope="module")
def wandering():
    random = np.random.default_rng(0)
    settled = next_impacts(WANDERING, random.random(300), 7.0 * random.random(300), 1000)
    rattling = np.isfinite(settled.t)
    attractors = find_attractors(WANDERING, settled.t[rattling], settled.v[rattling])
    machine = machine_of(WANDERING)
    targets = prove_targets(machine, WANDERING, attractors, fastest=7.0, columns=512).targets
    rounds = np.zeros_like(targets.lattice.ends)
    for level in range(2):
        if level:
            targets = targets._replace(lattice=refined(targets.lattice))
            rounds = rounds.repeat(2, 0).repeat(2, 1)
        boxes = np.argwhere(targets.lattice.ends == UNPROVEN).astype(np.int32)
        ends, trails = np.zeros(len(boxes), np.uint16), empty_trails(len(boxes))
        follow_boxes(machine, WANDERING, targets, boxes, ends, trails)
        on = ends == RATTLES
        ends[on] = UNPROVEN
        targets.lattice.ends[boxes[:, 0], boxes[:, 1]] = ends
        grow_all(targets.lattice.ends, rounds, boxes, trails)
    rattles = never_quiet(targets.lattice.ends, targets.quiet, boxes[~on], trails[~on])
    return attractors, targets._replace(never_quiet=targets.lattice._replace(ends=rattles))


def _falls_quiet(t, v):
    return map_points(WANDERING, GRID, 4999, t, v).image_cell == PERMANENT_CONTACT


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_no_departure_of_a_box_falls_quiet(wandering):
    random = np.random.default_rng(1)
    _, targets = wandering
    lattice = targets.lattice
    i, j = np.nonzero((lattice.ends == UNPROVEN) & (targets.never_quiet.ends == 1))
    assert i.size > 0.03 * lattice.ends.size, "beyond what is proven to come to an orbit"
    some = random.integers(0, i.size, _DEPARTURES)
    t = (j[some] + random.random(some.size)) / lattice.ends.shape[1]
    v = (lattice.first + i[some] + random.random(some.size)) * lattice.height
    assert not _falls_quiet(t, v).any()


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_no_departure_of_a_cell_falls_quiet_and_the_reason_says_so(wandering):
    random = np.random.default_rng(2)
    attractors, targets = wandering
    (quiet,) = (n for n, each in enumerate(attractors) if each.kind == AttractorKind.PERMANENT_CONTACT)
    centres = (np.arange(60) + 0.5) / 60
    falls = _falls_quiet(*(each.ravel() for each in np.meshgrid(centres, 7.0 * centres))).reshape(60, 60)
    # Which motion a cell is coloured as is not looked at here: none is that of its disc.
    colours = np.where(falls, quiet, len(attractors)).astype(np.int16)
    here = machine_of(WANDERING), WANDERING, targets, GRID, (0, 60), (0, 60)
    cells = prove_cells(*here, colours, 1)
    whole = cells.never_quiet == WHOLE
    assert whole.any() and not (falls & whole).any()
    i, j = np.argwhere(whole)[random.integers(0, whole.sum(), _DEPARTURES)].T
    t, v = (j + random.random(i.size)) / 60, 7.0 * (i + random.random(i.size)) / 60
    assert not _falls_quiet(t, v).any()
    # Cells that are partly proven to come to an orbit end otherwise than these colours say.
    assert set(np.unique(cells.reason[whole])) <= {ENDS_ELSEWHERE, cells_.RATTLES}
    assert (cells.reason[whole] == cells_.RATTLES).any()
    plain = prove_cells(*here, colours, 0)
    assert (plain.never_quiet <= cells.never_quiet).all()
    turned = prove_cells(*here, np.full_like(colours, quiet), 1)
    np.testing.assert_array_equal(turned.never_quiet, cells.never_quiet)
    assert (turned.reason[whole] == ENDS_ELSEWHERE).all()
