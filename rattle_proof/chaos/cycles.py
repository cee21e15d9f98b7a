"""No cycle of a set attracts, up to a number of impacts.

Parts of boxes are followed. A part holds no departure that comes back to itself after n impacts, if that can be told
from where it comes to. If it may hold one, DP^n is enclosed over the part. Its determinant d and its trace s tell that
an eigenvalue is larger than 1: where ``|s| > 1 + d`` or ``|d| > 1``. Then what comes back there repels. A part of which
neither is known is halved.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_proof.enclosures.flight import Box, halves_of_part
from rattle_proof.enclosures.following import WIDEST
from rattle_proof.enclosures.interval import Interval, add, multiply, point, subtract, up, width
from rattle_proof.enclosures.lattice import Lattice, box_at
from rattle_proof.enclosures.machine import Machine
from rattle_proof.enclosures.moving_set import advance, set_out

MOST = 30
"""Impacts of a cycle, at most: they are bits of one number."""
DEPTH = 40
"""How often a box is halved at most."""
_FURTHEST = 2.0**20
# Boxes between two pauses.
_AT_A_TIME = 64


class Cycles(NamedTuple):
    """Up to how many impacts every cycle of a set repels, and parts that were not decided, by impacts from 1 on."""

    repel: int
    open_parts: np.ndarray


@inlined_as_written
def _may_return(moving, start):
    """Whether a departure may come back to itself, whole periods later."""
    one = point(1.0)
    m = moving.slope
    off_t = add(add(multiply(subtract(m.tt, one), moving.dt), multiply(m.tv, moving.dv)), moving.rest.t)
    off_v = add(add(multiply(m.vt, moving.dt), multiply(subtract(m.vv, one), moving.dv)), moving.rest.w)
    off_t = add(off_t, subtract(point(moving.t), point(start.t)))
    off_v = add(off_v, subtract(point(moving.v), point(start.v)))
    # By hulls, too: they are all that is known once the set has met the grazing curve.
    far_t, far_v = subtract(moving.all.t, start.all.t), subtract(moving.all.w, start.all.w)
    if moving.grazed:
        off_t, off_v = far_t, far_v
    low, high = max(off_t.low, far_t.low), min(off_t.high, far_t.high)
    if not (abs(low) < _FURTHEST and abs(high) < _FURTHEST):
        return True
    apart_v = off_v.low > 0.0 or off_v.high < 0.0 or far_v.low > 0.0 or far_v.high < 0.0
    return not (apart_v or math.ceil(low) > math.floor(high))


@inlined_as_written
def _repels(moving):
    """Whether DP^n has an eigenvalue beyond 1 all over the set."""
    m = moving.slope
    trace = add(m.tt, m.vv)
    determinant = subtract(multiply(m.tt, m.vv), multiply(m.tv, m.vt))
    most = up(1.0 + determinant.high)
    return trace.low > most or trace.high < -most or determinant.low > 1.0 or determinant.high < -1.0


@inlined_as_written
def _undecided(machine, oscillator, box, asked, impacts):
    """The bits of `asked`, of impacts less 1, that a part leaves undecided."""
    start = set_out(box, False)
    moving, left = start, 0
    for n in range(impacts):
        if asked >> n == 0:
            break
        proven, moving = advance(machine, oscillator, moving)
        if not (proven and width(moving.all.t) < WIDEST):
            left |= (asked >> n) << n
            break
        if asked >> n & 1 and _may_return(moving, start) and (moving.grazed or not _repels(moving)):
            left |= 1 << n
    return left


@kernel_as_written
def _decide(machine, oscillator, lattice, rows, columns, impacts, depth, open_parts):
    waiting, asked = np.empty((depth + 2, 5)), np.empty(depth + 2, np.int64)
    for k in range(rows.size):
        whole = box_at(lattice, rows[k], columns[k])
        waiting[0] = whole.t.low, whole.t.high, whole.w.low, whole.w.high, 0.0
        asked[0], left = (1 << impacts) - 1, 1
        while left > 0:
            left -= 1
            part = waiting[left, 0], waiting[left, 1], waiting[left, 2], waiting[left, 3], waiting[left, 4]
            box = Box(Interval(part[0], part[1]), Interval(part[2], part[3]))
            undecided = _undecided(machine, oscillator, box, asked[left], impacts)
            if undecided == 0:
                continue
            if part[4] >= depth:
                for n in range(impacts):
                    open_parts[n] += undecided >> n & 1
                continue
            waiting[left], waiting[left + 1] = halves_of_part(part)
            asked[left] = asked[left + 1] = undecided
            left += 2


def repelling_cycles(
    machine: Machine,
    oscillator: Oscillator,
    lattice: Lattice,
    impacts: int,
    pause: Pause = never_stopped,
    depth: int = DEPTH,
) -> Cycles:
    """Up to how many impacts every cycle of a set repels.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.
    lattice : Lattice
        Whose boxes with an end are the set.
    impacts : int
        How many are tried, up to MOST.
    pause : callable
        Called now and then; an exception raised there ends the work.
    depth : int
        How often a box is halved at most.

    Returns
    -------
    Cycles
    """
    rows, columns = np.nonzero(lattice.ends)
    open_parts = np.zeros(impacts, np.int64)
    for start in range(0, rows.size, _AT_A_TIME):
        pause()
        run = slice(start, start + _AT_A_TIME)
        _decide(machine, oscillator, lattice, rows[run], columns[run], impacts, depth, open_parts)
    decided = np.flatnonzero(open_parts)
    return Cycles(int(decided[0]) if decided.size else impacts, open_parts)
