"""Proofs pause after a bounded amount of work, and find the same however often."""

import numpy as np
import pytest

from rattle_kernels import CellGrid, Oscillator, find_attractors
from rattle_proof.enclosures import MOST_LEVELS, cells, growth, orbit_disc, quiet_core, rattling_set, windows
from rattle_proof.enclosures.lattice import UNPROVEN, Lattice
from rattle_proof.enclosures.machine import machine_of
from rattle_proof.enclosures.targets import NO_QUIET, NOTHING_KNOWN, Targets, prove_targets
from rattle_proof.enclosures.windows import NO_WINDOWS
from tests.rattle_proof.enclosures.machines import OSCILLATORS

FIG_7 = OSCILLATORS[0]


class _Counted:
    """Work since the last pause, of kernels that are counted."""

    def __init__(self, patch):
        self._patch, self.since, self.most, self.pauses = patch, 0, 0, 0

    def pause(self):
        self.since, self.pauses = 0, self.pauses + 1

    def count(self, module, name, work):
        """Count the work of each call of a kernel."""
        called = getattr(module, name)

        def counted(*arguments):
            self.since += work(*arguments)
            self.most = max(self.most, self.since)
            return called(*arguments)

        self._patch.setattr(module, name, counted)


@pytest.fixture
def counted(monkeypatch):
    return _Counted(monkeypatch)


def _machine():
    return machine_of(FIG_7)


def _nowhere(lattice):
    return Targets(lattice, NOTHING_KNOWN, np.zeros((0, 8)), NO_WINDOWS, NO_QUIET, NOTHING_KNOWN)


def test_boxes_are_followed_with_pauses(counted, monkeypatch):
    lattice = Lattice(1.0 / 16.0, 0, np.zeros((32, 16), np.uint16))
    lattice.ends[:4] = 1
    boxes = np.argwhere(lattice.ends == UNPROVEN).astype(np.int32)

    def follow():
        ends, trails = np.zeros(len(boxes), np.uint16), growth.empty_trails(len(boxes))
        growth.follow_all(_machine(), FIG_7, _nowhere(lattice), boxes, ends, trails, counted.pause)
        return ends, trails

    at_once = follow()
    assert counted.pauses == 1
    counted.count(growth, "follow_boxes", lambda *arguments: len(arguments[3]))
    monkeypatch.setattr(growth, "_FOLLOWED_AT_A_TIME", 100)
    for one, other in zip(follow(), at_once, strict=True):
        np.testing.assert_array_equal(one, other)
    assert counted.most == 100


def test_lattices_grow_with_pauses(counted, monkeypatch):
    lattice = Lattice(1.0 / 16.0, 0, np.zeros((32, 16), np.uint16))
    lattice.ends[:4] = 1
    boxes = np.argwhere(lattice.ends == UNPROVEN).astype(np.int32)
    # A trail of one strip: the box below, so the ends climb a row a round.
    trails = np.full((len(boxes), growth.IMPACTS, growth.NUMBERS), np.nan, np.float32)
    rows, columns = boxes.T
    trails[:, 0] = np.stack(
        [(columns + 0.4) / 16, (columns + 0.6) / 16, rows - 0.6, rows - 0.4, rows - 0.6, rows - 0.4, 0.0 * rows], axis=1
    )

    def grow():
        ends, rounds = lattice.ends.copy(), np.zeros_like(lattice.ends)
        growth.grow_all(ends, rounds, boxes, trails, counted.pause)
        return ends, rounds

    at_once = grow()
    assert (at_once[0] == 1).all() and (at_once[1] == np.maximum(np.arange(32) - 3, 0)[:, None]).all()
    counted.count(growth, "_grow", lambda *arguments: len(arguments[1]))
    monkeypatch.setattr(growth, "_GROWN_AT_A_TIME", 100)
    for one, other in zip(grow(), at_once, strict=True):
        np.testing.assert_array_equal(one, other)
    assert counted.most == 100


@pytest.mark.parametrize(("levels", "pieces"), [(0, 40), (1, 40), (2, 1000)])
def test_cells_are_proven_with_pauses(counted, monkeypatch, levels, pieces):
    """In runs of rows, and in parts of rows where one has more than may be done at a time."""
    grid = CellGrid(time_cells=32, velocity_cells=8, velocity_stop=0.5)
    lattice = Lattice(1.0 / 64.0, 0, np.zeros((48, 64), np.uint16))
    lattice.ends[:16] = 1

    def prove():
        colours = np.zeros((8, 32), np.int16)
        return cells.prove_cells(
            _machine(), FIG_7, _nowhere(lattice), grid, (0, 8), (0, 32), colours, levels, counted.pause
        )

    monkeypatch.setattr(cells, "_PIECES_AT_A_TIME", 1 << 20)
    at_once = prove()
    assert at_once.proven.any() and counted.pauses == 1
    counted.count(cells, "_prove_all", lambda *arguments: arguments[5].size * 4**levels)
    monkeypatch.setattr(cells, "_PIECES_AT_A_TIME", pieces)
    for one, other in zip(prove(), at_once, strict=True):
        np.testing.assert_array_equal(one, other)
    assert pieces / 2 < counted.most <= pieces


# An image takes some three microseconds, so a proof looks ten times a second whether it is cancelled.
MOST_IMAGES = 32768


@pytest.mark.parametrize("levels", range(MOST_LEVELS + 1))
def test_cells_take_no_more_images_between_two_pauses_than_a_tenth_of_a_second(counted, monkeypatch, levels):
    monkeypatch.setattr(cells, "_prove_all", lambda *_: None)
    counted.count(cells, "_prove_all", lambda *arguments: arguments[5].size * 4**levels * cells.IMPACTS)
    grid, colours = CellGrid(time_cells=300, velocity_cells=200), np.zeros((200, 300), np.int16)
    nowhere = _nowhere(Lattice(1.0, 0, np.zeros((1, 1), np.uint16)))
    cells.prove_cells(_machine(), FIG_7, nowhere, grid, (0, 200), (0, 300), colours, levels, counted.pause)
    assert MOST_IMAGES / 4 < counted.most <= MOST_IMAGES


def test_boxes_take_no_more_images_between_two_pauses_than_a_tenth_of_a_second(counted, monkeypatch):
    monkeypatch.setattr(growth, "follow_boxes", lambda *_: None)
    counted.count(growth, "follow_boxes", lambda *arguments: len(arguments[3]) * growth.IMPACTS)
    boxes, lattice = np.zeros((100_000, 2), np.int32), Lattice(1.0, 0, np.zeros((1, 1), np.uint16))
    ends, trails = np.zeros(len(boxes), np.uint16), growth.empty_trails(len(boxes))
    growth.follow_all(_machine(), FIG_7, _nowhere(lattice), boxes, ends, trails, counted.pause)
    assert MOST_IMAGES / 4 < counted.most <= MOST_IMAGES


def test_windows_grow_with_pauses(counted):
    """As much as in a tenth of a second: images of boxes, or impacts by numbers, which are a hundred times as fast."""
    oscillator = Oscillator(0.6, 0.0945)
    found = find_attractors(oscillator, [0.7362850732], [4.3919449986])
    (orbit,) = (each for each in found if each.name == "P(2,2,1)")
    disc = orbit_disc.orbit_disc(machine_of(oscillator), oscillator, orbit)
    counted.count(windows, "_follow", lambda *arguments: len(arguments[4]) * windows.IMPACTS)
    counted.count(windows, "next_impacts", lambda *arguments: len(arguments[1]) * arguments[3] / 100)
    windows.grown_windows(machine_of(oscillator), oscillator, {0: disc}, [orbit], 4096, counted.pause)
    assert MOST_IMAGES / 4 < counted.most <= MOST_IMAGES


def test_targets_are_proven_with_pauses(counted, monkeypatch):
    """One box of actions, one disc, one impact of the attractor, or so many boxes of a set, between two pauses."""
    attractors = find_attractors(FIG_7, [0.89829, 0.553], [3.76991, 4.703])
    monkeypatch.setattr(rattling_set, "_MARKED_AT_A_TIME", 50)
    monkeypatch.setattr(quiet_core, "_STRIPS", 10)
    for module, name in ((quiet_core, "_lowest_failure"), (orbit_disc, "maps_into_itself")):
        counted.count(module, name, lambda *_: 50)
    counted.count(rattling_set, "next_impacts", lambda *_: 50)
    counted.count(rattling_set, "_mark_images", lambda *arguments: len(arguments[3]))
    prove_targets(_machine(), FIG_7, attractors, counted.pause, columns=64)
    assert counted.most == 50


def test_what_never_falls_quiet_is_found_with_pauses(counted, monkeypatch):
    boxes = np.argwhere(np.ones((32, 16))).astype(np.int32)
    rows, columns = boxes.T
    # The box below; but those of one column stay where they are.
    rows = np.where(columns == 5, rows + 1, rows)
    trails = np.full((len(boxes), growth.IMPACTS, growth.NUMBERS), np.nan, np.float32)
    trails[:, 0] = np.stack(
        [(columns + 0.4) / 16, (columns + 0.6) / 16, rows - 0.6, rows - 0.4, rows - 0.6, rows - 0.4, 0.0 * rows], axis=1
    )
    ends = np.zeros((32, 16), np.uint16)
    at_once = growth.never_quiet(ends, NO_QUIET, boxes, trails, counted.pause)
    assert at_once[1:, 5].all() and at_once.sum() == 31
    assert counted.pauses >= 1
    counted.count(growth, "_take_out", lambda *arguments: len(arguments[1]))
    monkeypatch.setattr(growth, "_GROWN_AT_A_TIME", 100)
    np.testing.assert_array_equal(growth.never_quiet(ends, NO_QUIET, boxes, trails, counted.pause), at_once)
    assert counted.most == 100
