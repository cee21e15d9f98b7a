"""Parts of a cell are followed together, and no further than until as many have come as are claimed."""

from types import SimpleNamespace

import numpy as np
import pytest

from rattle_proof.verification import samples
from rattle_proof.verification.ends import NEVER_QUIET, NOWHERE
from rattle_proof.verification.machine import Machine, ball
from rattle_proof.verification.samples import Plane, try_cell, try_cell_that_rattles

EXACT = Machine((0.6, 0.6), (0.6, 0.6), (1.0, 1.0), [(1.0, 0.1, 0.1, 0.0, 0.0)])
HERE, ELSEWHERE = 1, 2


def tried(monkeypatch, claimed, found):
    """What becomes of a cell, and how many impacts its parts had; `found` tells the end of part and impacts."""
    monkeypatch.setattr(samples, "box", lambda t, v: (t, v, 0))
    advanced = []

    def advance(machine, moving):
        advanced.append(moving)
        return (moving[:2] + (moving[2] + 1,), None)

    def end_of(moving):
        t, v, impacts = moving
        column, row = (int(8.0 * float(each.mid())) for each in (t, v))
        return found(8 * row + column, impacts)

    monkeypatch.setattr(samples, "advance", advance)
    monkeypatch.setattr(samples, "lost_part", lambda ends, t, v, *_: samples.Lost(t, v, NOWHERE))
    monkeypatch.setattr(samples, "failure_of", lambda ends, place, end, lost: (place, lost.found))
    counted = np.array([[claimed]], np.uint8)
    plane = Plane((0.0, 1.0), (0.0, 1.0), np.zeros((1, 1), np.int64), counted, counted)
    return try_cell(SimpleNamespace(machine=EXACT, of=end_of), plane, 0, 0), len(advanced)


def test_nothing_is_followed_further_once_all_that_is_claimed_has_come(monkeypatch):
    # 16 come at once, 16 after an impact, the others never.
    def found(part, impacts):
        return HERE if part < 16 or (part < 32 and impacts == 1) else NOWHERE

    assert tried(monkeypatch, 16, found) == (None, 0)
    assert tried(monkeypatch, 32, found) == (None, 16)
    failure, impacts = tried(monkeypatch, 33, found)
    assert failure == ("cell (0, 0), of which 1 64ths more are claimed", NOWHERE)
    assert impacts == 16 + 32 * samples._LONGEST


def test_parts_that_end_elsewhere_are_none_of_those_claimed(monkeypatch):
    def found(part, impacts):
        return ELSEWHERE if part % 2 else HERE

    assert tried(monkeypatch, 32, found) == (None, 0)
    assert tried(monkeypatch, 33, found)[0] == ("cell (0, 0), of which 1 64ths more are claimed", ELSEWHERE)


@pytest.mark.parametrize("part", [0, 27, 63])
def test_a_part_counts_once(monkeypatch, part):
    failure, _ = tried(monkeypatch, 2, lambda each, impacts: HERE if each == part else ELSEWHERE)
    assert failure == ("cell (0, 0), of which 1 64ths more are claimed", ELSEWHERE)


def test_more_parts_than_a_cell_has_are_a_contradiction(monkeypatch):
    monkeypatch.setattr(samples, "lost_part", lambda *_: 1 / 0)
    cell = Plane((0.0, 1.0), (0.0, 1.0), np.zeros((1, 1)), np.zeros((1, 1)), np.full((1, 1), 70, np.uint8))
    ends = SimpleNamespace(machine=EXACT, quiet_or_not=lambda moving: NEVER_QUIET)
    failure = try_cell_that_rattles(ends, cell, 0, 0)
    assert failure.contradicted and failure.why == "6 64ths are claimed beyond those that it has"


def test_parts_make_up_their_cell():
    plane = Plane((0.0, 1.0), (0.0, 7.0), *(np.zeros((5, 4), np.int64),) * 3)
    ((t, v),), parts = plane.cell(2, 3), plane.cell(2, 3, 8)
    assert len(parts) == 64 and t.contains(ball(0.75, 1.0)) and v.contains(ball(2.8, 4.2))
    for whole, n in ((t, 0), (v, 1)):
        low, high = min(part[n].lower() for part in parts), max(part[n].upper() for part in parts)
        assert abs(float(low - whole.lower())) < 1e-8 and abs(float(high - whole.upper())) < 1e-8
