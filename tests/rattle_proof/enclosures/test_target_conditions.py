"""Each condition on which a target rests, alone: where it alone is broken, nothing is proven."""

from types import SimpleNamespace

import numpy as np
import pytest

from rattle_kernels.attractors.attractor import AttractorKind
from rattle_proof.enclosures import targets
from rattle_proof.enclosures.lattice import Lattice, empty_lattice
from rattle_proof.enclosures.machine import machine_of
from rattle_proof.enclosures.orbit_disc import OrbitDisc
from tests.rattle_proof.enclosures.machines import OSCILLATORS

FIG_7 = OSCILLATORS[0]
# Boxes of 1/32 in time by 1/16 in speed, from 1/2 on.
COLUMNS, FIRST, HEIGHT = 32, 8, 1.0 / 16.0
MACHINE = SimpleNamespace(greatest_acceleration=2.0)
RADIUS = 0.05


def rattling(*boxes):
    lattice = Lattice(HEIGHT, FIRST, np.zeros((16, COLUMNS), np.uint16))
    for row, column in boxes:
        lattice.ends[row, column] = 1
    return lattice


def centre(row, column):
    return (column + 0.5) / COLUMNS, (FIRST + row + 0.5) * HEIGHT


def disc(t, v):
    return OrbitDisc(1, t, v, np.eye(2), RADIUS)


def motion(t, v):
    return SimpleNamespace(time=np.array(t), velocity=np.array(v))


def holds_no_other(boxes, level=0.0, discs=(), others=()):
    return targets._holds_no_other(MACHINE, rattling(*boxes), level, discs, others)


@pytest.mark.parametrize(("row", "column"), [(5, 4), (5, 0), (5, COLUMNS - 1)])
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("across", ["time", "speed"])
def test_a_disc_that_reaches_into_a_box_is_not_clear_of_it(row, column, side, across):
    """By a tenth of its radius, so its centre is further from that of the box than its radius."""
    t, v = centre(row, column)
    inside = 0.9 * RADIUS
    if across == "time":
        t = (t + side * (0.5 / COLUMNS + inside)) % 1.0
    else:
        v += side * (0.5 * HEIGHT + inside)
    assert not holds_no_other([(row, column)], discs=[disc(t, v)])


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("across", ["time", "speed"])
def test_a_disc_that_is_clear_of_a_box_in_one_direction_is_clear_of_it(side, across):
    t, v = centre(5, 16)
    if across == "time":
        t += side * (2.0 / COLUMNS + RADIUS)
    else:
        v += side * (2.0 * HEIGHT + RADIUS)
    assert holds_no_other([(5, 16)], discs=[disc(t, v)])


def test_a_disc_is_clear_of_all_boxes_and_all_discs_are():
    far = disc(*centre(5, 28))
    # One box is clear in time, the other in speed.
    assert holds_no_other([(5, 16), (12, 28)], discs=[far])
    assert not holds_no_other([(5, 16), (5, 28)], discs=[far])
    assert not holds_no_other([(5, 16)], discs=[far, disc(*centre(5, 16))])


def test_a_set_lies_above_the_quiet_core():
    """All of it, where the core is highest: v^3 < level times the greatest acceleration."""
    lowest = (FIRST + 5) * HEIGHT
    edge = lowest**3 / MACHINE.greatest_acceleration
    assert holds_no_other([(5, 16), (9, 16)], level=0.999 * edge)
    assert not holds_no_other([(5, 16), (9, 16)], level=1.001 * edge)


def test_an_empty_set_rattles_not():
    assert not holds_no_other([])


@pytest.mark.parametrize("turns", [0.0, 1.0, -1.0])
def test_no_departure_of_another_motion_lies_in_a_box(turns):
    t, v = centre(5, 16)
    inside, outside = motion([0.1, t + turns], [v, v]), motion([t + turns, t], [v + HEIGHT, 0.1])
    assert not holds_no_other([(5, 16)], others=[outside, inside])
    assert holds_no_other([(5, 16)], others=[outside])


@pytest.mark.parametrize("clear", [True, False])
def test_a_set_with_another_motion_is_no_target(monkeypatch, clear):
    chaos = SimpleNamespace(kind=AttractorKind.CHAOTIC, is_chaotic=True, time=np.array([0.2]), velocity=np.array([2.0]))
    found = rattling((5, 16))
    monkeypatch.setattr(targets, "quiet_level", lambda *_, pause: 0.0)
    monkeypatch.setattr(targets, "rattling_set", lambda *_: found)
    monkeypatch.setattr(targets, "_holds_no_other", lambda *_: clear)
    monkeypatch.setattr(targets, "largest_grazing_speed", lambda _: 5.0)
    monkeypatch.setattr(targets, "wandering", lambda *_: [])
    proven = targets.prove_targets(machine_of(FIG_7), FIG_7, [chaos], columns=8)
    assert (proven.rattling == 0) == clear and (proven.targets.rattling is found) == clear


@pytest.mark.parametrize("level", [0.0, 100.0])
def test_a_set_around_what_wanders_is_one_in_which_nothing_falls_quiet_if_it_lies_above_the_core(monkeypatch, level):
    """Whichever motions it holds: it has the end of none."""
    found, asked = rattling((5, 16)), []
    monkeypatch.setattr(targets, "quiet_level", lambda *_, pause: level)
    monkeypatch.setattr(targets, "rattling_set", lambda search, t, v, end: asked.append((t, v, end)) or found)
    monkeypatch.setattr(targets, "largest_grazing_speed", lambda _: 5.0)
    monkeypatch.setattr(targets, "wandering", lambda *_: [(1, 2), (3, 4)])
    proven = targets.prove_targets(machine_of(FIG_7), FIG_7, [], columns=8)
    assert proven.rattling is None
    if level:
        assert proven.targets.rattling is targets.NOTHING_KNOWN and len(asked) == 2, "the later seeds are tried, too"
    else:
        assert proven.targets.rattling is found and asked == [(1, 2, targets.RATTLES)]


def test_boxes_of_the_core_lie_in_it_with_all_their_departures():
    level, lattice = 0.1, empty_lattice(0.0, 1.5, 64, 1.0 / 128.0)
    targets._fill_core(machine_of(FIG_7), level, lattice, 1)
    rows, columns = np.nonzero(lattice.ends)
    assert rows.size
    top = (lattice.first + rows + 1) * lattice.height
    for part in np.linspace(0.0, 1.0, 9):
        turn = 2.0 * np.pi * (columns + part) / 64
        forcing = 2.0 * np.pi * np.cos(turn) + FIG_7.damping * np.sin(turn)
        felt = 4.0 * np.pi * FIG_7.damping - 2.0 * np.pi * FIG_7.eccentricity * forcing
        assert (top**3 < level * felt).all()
