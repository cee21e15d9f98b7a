"""Boxes are cut where it helps, and tolerances into machines that together are the one."""

from types import SimpleNamespace

import numpy as np

from rattle_proof.verification import following
from rattle_proof.verification.following import lost_part
from rattle_proof.verification.machine import Machine, ball, cover
from rattle_proof.verification.moving import box

EXACT = (0.6, 0.6), (0.6, 0.6), (1.0, 1.0), [(1.0, 0.1, 0.1, 0.0, 0.0)]
WIDE = Machine((0.5, 0.7), (0.6, 0.6), (0.9, 0.9), [(1.0, 0.1, 0.1, 0.0, 0.0), (2.0, 0.01, 0.01, 0.25, 0.75)])
LATTICE = SimpleNamespace(height=1.0 / 256.0, ends=np.zeros((4, 1024)))


def ends_of(machine):
    return SimpleNamespace(machine=machine, claims=SimpleNamespace(lattice=LATTICE))


def test_a_box_is_cut_along_the_side_that_is_longer():
    tried = []

    def arrived(moving):
        tried.append(moving)
        return 1 if moving.all_v.rad() < 0.2 else 0

    t, v = ball(0.5, 0.5 + 1e-6), ball(0.5, 1.0)
    assert lost_part(ends_of(Machine(*EXACT)), t, v, 1, 0, arrived, depth=1) is None
    assert [float(each.all_t.rad()) for each in tried] == [float(t.rad())] * 3


def test_after_a_hull_a_box_is_cut_by_what_was_known_before(monkeypatch):
    start, traced, hull = (box(ball(0.4, 0.6), ball(1.0, top)) for top in (1.5, 1.1, 9.0))
    ways = {
        id(start): (traced, SimpleNamespace(slope=1)), id(traced): (hull, SimpleNamespace(slope=None)),
        id(hull): (hull, SimpleNamespace(slope=1)),
    }  # fmt: skip
    monkeypatch.setattr(following, "advance", lambda machine, moving: ways[id(moving)])
    for impacts, known in enumerate((start, traced, traced, traced)):
        assert following._end_of(Machine(*EXACT), start, impacts, lambda moving: 0) == (0, known)


def test_halves_of_a_machine_together_are_the_machine():
    assert Machine(*EXACT).halves() == []
    # The phase first: 16 pi^2 0.01 pi of the acceleration, over 4 pi 0.7, is more than the 0.2 of 0.7 of damping.
    for machine, cut in ((WIDE, lambda each: each.waves[1].phase), (WIDE.halves()[0], lambda each: each.damping)):
        low, high = map(cut, machine.halves())
        whole = cut(machine)
        assert low.union(high).contains(whole) and max(low.rad(), high.rad()) < 0.51 * whole.rad()


def test_parts_cover_a_machine_or_not():
    parts = [machine for half in WIDE.halves() for machine in half.halves()]
    assert cover(parts, WIDE) and cover(parts[::-1], WIDE) and cover([WIDE], WIDE)
    assert cover([*WIDE.halves(), parts[0]], WIDE)
    for n in range(4):
        assert not cover(parts[:n] + parts[n + 1 :], WIDE)
    assert not cover([], WIDE)
    low, _ = WIDE.halves()
    shrunk = Machine((0.5, 0.6999), (0.6, 0.6), (0.9, 0.9), [(1.0, 0.1, 0.1, 0.0, 0.0), (2.0, 0.01, 0.01, 0.25, 0.75)])
    assert not cover([low, *shrunk.halves()[1:]], WIDE)
    assert not cover([Machine(*EXACT)], WIDE)
