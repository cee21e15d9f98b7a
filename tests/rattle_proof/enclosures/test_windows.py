"""Windows around orbits: what is proven of a box is true of its departures, and rests on boxes proven before."""

import functools

import numpy as np
import pytest

from rattle_kernels import Oscillator, find_attractors, next_impacts
from rattle_proof.enclosures.flight import Box
from rattle_proof.enclosures.interval import Interval
from rattle_proof.enclosures.lattice import UNPROVEN, Lattice, find_end, find_end_within
from rattle_proof.enclosures.machine import machine_of
from rattle_proof.enclosures.moving_set import advance, set_out, strip_of
from rattle_proof.enclosures.orbit_disc import disc_rows, lies_in_disc, orbit_disc
from rattle_proof.enclosures.targets import NO_QUIET, NOTHING_KNOWN, Targets, proven_end
from rattle_proof.enclosures.windows import (
    ACROSS,
    IMPACTS,
    Windows,
    _follow,
    empty_windows,
    grown_windows,
)
from tests.rattle_proof.enclosures.exact_flights import ExactMap
from tests.rattle_proof.enclosures.test_lattice import _lattice, _strips

# P(2,2,1) has a small disc, P(1,1,0) a wide one.
OSCILLATOR = Oscillator(0.6, 0.0945)
MACHINE = machine_of(OSCILLATOR)


@functools.cache
def _grown():
    """The orbits, the number of P(2,2,1), its disc, and its windows."""
    random = np.random.default_rng(0)
    settled = next_impacts(OSCILLATOR, random.random(500), 7.0 * random.random(500), 1000)
    rattling = np.isfinite(settled.t)
    orbits = find_attractors(OSCILLATOR, settled.t[rattling], settled.v[rattling])
    number = next(n for n, each in enumerate(orbits) if each.name == "P(2,2,1)")
    disc = orbit_disc(MACHINE, OSCILLATOR, orbits[number])
    return orbits, number, disc, grown_windows(MACHINE, OSCILLATOR, {number: disc}, orbits, 1024)


def _departures(windows, boxes, random):
    """One departure of each box, in all of it."""
    place = windows.places[boxes[:, 0]]
    within_t, within_v = random.random((2, len(boxes)))
    t = (place[:, 3] + boxes[:, 2] + within_t) / place[:, 2]
    return t % 1.0, (place[:, 1] + boxes[:, 1] + within_v) * place[:, 0]


def test_far_more_than_the_disc_is_proven_around_an_orbit():
    orbits, number, _, windows = _grown()
    assert set(np.unique(windows.ends)) == {UNPROVEN, 1 + number}
    places = len(orbits[number].time)
    assert len(windows.places) == 2 * places
    # In the finest window the disc is 32 of 128 boxes wide and high at most: a sixteenth.
    assert all(np.count_nonzero(each) > ACROSS**2 / 4 for each in windows.ends[:places])


def test_departures_of_proven_boxes_end_in_the_orbit():
    orbits, number, disc, windows = _grown()
    boxes = np.argwhere(windows.ends != UNPROVEN)
    t, v = _departures(windows, boxes, np.random.default_rng(1))
    # Its weaker multiplier is 0.892: 400 periods leave 1e-20 of a distance.
    landed = next_impacts(OSCILLATOR, t, v, 400 * disc.impacts)
    off = np.abs((landed.t[:, None] - orbits[number].time + 0.5) % 1.0 - 0.5)
    near = (off < 1e-9) & (np.abs(landed.v[:, None] - orbits[number].velocity) < 1e-8)
    assert near.any(axis=1).all()


def test_exact_flights_from_proven_boxes_come_to_the_disc():
    _, _, disc, windows = _grown()
    random = np.random.default_rng(2)
    boxes = random.permutation(np.argwhere(windows.ends != UNPROVEN))[:40]
    exact = ExactMap(OSCILLATOR)
    for t, v in zip(*_departures(windows, boxes, random), strict=True):
        distance, impacts = np.inf, 0
        while not distance < disc.radius and impacts < 200:
            distance = np.hypot(*(disc.frame @ [(t - disc.t + 0.5) % 1.0 - 0.5, v - disc.v]))
            landed = exact.image(t, v)
            t, v, impacts = float(landed.t.mid()), float(landed.v.mid()), impacts + 1
        assert distance < disc.radius


def test_each_box_is_proven_from_the_disc_or_boxes_before_it():
    _, number, disc, windows = _grown()
    row = disc_rows({number: disc})[0]
    order = windows.order[windows.ends != UNPROVEN]
    assert np.array_equal(np.sort(order), np.arange(1, order.size + 1))
    boxes = np.argwhere(windows.ends != UNPROVEN)
    for box in np.random.default_rng(3).permutation(boxes)[:100]:
        before = (windows.order > 0) & (windows.order < windows.order[tuple(box)])
        known = Windows(
            windows.places, np.where(before, windows.ends, UNPROVEN).astype(np.uint16), windows.order.copy()
        )
        _follow(MACHINE, OSCILLATOR, row, known, box[None], 1)
        assert known.ends[tuple(box)] == 1 + number


def test_a_box_far_from_proven_ones_is_not_proven():
    _, number, disc, windows = _grown()
    alone = empty_windows(windows.places)
    outer = np.array([[len(windows.places) - 1, 0, 0]])
    assert _follow(MACHINE, OSCILLATOR, disc_rows({number: disc})[0], alone, outer, 7) == 7
    assert not alone.ends.any() and not alone.order.any()


def _without(windows, t, v):
    """The windows with no proof of any box that holds a departure."""
    ends = windows.ends.copy()
    height, first, columns, left = windows.places.T
    rows, across = np.floor(v / height) - first, (np.floor(t * columns) - left) % columns
    for n in np.flatnonzero((rows >= 0) & (rows < ACROSS) & (across < ACROSS)):
        ends[n, int(rows[n]), int(across[n])] = UNPROVEN
    return windows._replace(ends=ends)


def test_a_box_is_not_proven_where_none_of_its_images_lies_in_proven_boxes_alone():
    _, number, disc, windows = _grown()
    row, tried = disc_rows({number: disc})[0], 0
    for n, i, j in np.random.default_rng(4).permutation(np.argwhere(windows.ends != UNPROVEN))[:400]:
        height, first, columns, left = windows.places[n]
        times = Interval((left + j) / columns, (left + j + 1) / columns)
        images = [set_out(Box(times, Interval((first + i) * height, (first + i + 1) * height)), False)]
        for _ in range(IMPACTS):
            images.append(advance(MACHINE, OSCILLATOR, images[-1])[1])
        if any(lies_in_disc(row, each) for each in images):
            continue
        known = windows
        for each in images:
            known = _without(known, each.t, each.v)
        tried += 1
        _follow(MACHINE, OSCILLATOR, row, known, np.array([[n, i, j]]), 1)
        assert known.ends[n, i, j] == UNPROVEN
    assert tried > 50


@pytest.mark.parametrize("left", [-7, 0, 20, 28, 61])
def test_a_window_says_what_a_lattice_with_its_boxes_says(left):
    random, known = np.random.default_rng(5), 0
    lattice = _lattice(random)
    rows, columns = lattice.ends.shape
    within = (np.arange(columns) - left) % columns < 12
    ends = np.roll(lattice.ends, -left, axis=1)[:, :12]
    same = Lattice(lattice.height, lattice.first, np.where(within, lattice.ends, UNPROVEN).astype(np.uint16))
    for strip in _strips(random):
        found = find_end_within(lattice.height, lattice.first, columns, left, ends, strip).end
        # A strip that only its times take out of the window is not looked up in all of it.
        assert found in (UNPROVEN, find_end(same, strip).end)
        known += found != UNPROVEN
    assert known > 10


def test_a_wide_disc_has_no_windows():
    orbits, _, _, _ = _grown()
    number = next(n for n, each in enumerate(orbits) if each.name == "P(1,1,0)")
    disc = orbit_disc(MACHINE, OSCILLATOR, orbits[number])
    assert not len(grown_windows(MACHINE, OSCILLATOR, {number: disc}, orbits, 1024).places)


def test_what_lies_in_boxes_of_a_window_has_a_proven_end():
    """Where nothing else is known."""
    _, number, _, windows = _grown()
    targets = Targets(NOTHING_KNOWN, NOTHING_KNOWN, np.zeros((0, 8)), windows, NO_QUIET, NOTHING_KNOWN)
    for n, i, j in np.random.default_rng(6).permutation(np.argwhere(windows.ends != UNPROVEN))[:200]:
        height, first, columns, left = windows.places[n]
        times = Interval((left + j + 0.4) / columns, (left + j + 0.6) / columns)
        moving = set_out(Box(times, Interval((first + i + 0.4) * height, (first + i + 0.6) * height)), False)
        assert proven_end(targets, moving, strip_of(moving)) == 1 + number
