"""What is tried one by one: boxes of the rattling set, boxes of the lattice, cells of the picture."""

from collections import deque
from typing import NamedTuple

import numpy as np
from flint import arb

from rattle_proof.verification.claims import RATTLES, Claims, Disc, Lattice
from rattle_proof.verification.ends import NEVER_QUIET, NOWHERE, Ends, box_of, boxes_of, end_in, in_frame
from rattle_proof.verification.following import CUTS, Arriving, Lost, failure_of, lost_part
from rattle_proof.verification.machine import Machine, ball
from rattle_proof.verification.moving import Moving, advance, box
from rattle_proof.verification.targets.quiet import halves
from rattle_proof.verification.verdict import Failure, contradicted, undecided

_DEPTH, _DEPTH_OF_PART = 18, 6
# How often a 64th of a cell is cut and the tolerances are, one try after the other, where it does not come as it is.
_OF_ONE, _OF_MANY = ((_DEPTH_OF_PART, 0),), ((0, CUTS), (_DEPTH_OF_PART, CUTS))
_CUT = 8
WHOLE = 64
"""Parts of a cell that are counted."""
_LONGEST = 16


class Plane(NamedTuple):
    """The cells of a picture: its edges, the motion that each is coloured as, and the 64ths that are proven of it."""

    time: tuple[float, float]
    velocity: tuple[float, float]
    solution: np.ndarray
    proven: np.ndarray
    never_quiet: np.ndarray

    def cell(self, row: int, column: int, cut: int = 1) -> list[tuple[arb, arb]]:
        """Times and speeds of a cell, cut into so many parts each way."""
        rows, columns = (cut * count for count in self.solution.shape)
        return [
            (_part_of(self.time, cut * column + j, columns), _part_of(self.velocity, cut * row + i, rows))
            for i in range(cut)
            for j in range(cut)
        ]


def _part_of(ends: tuple[float, float], number: int, count: int) -> arb:
    low, length = arb(ends[0]), arb(ends[1]) - arb(ends[0])
    return low + length * ball(number, number + 1) / count


def try_cell(ends: Ends, plane: Plane, row: int, column: int) -> Failure | None:
    """Prove that all departures of a cell end as it is coloured; or of as many 64ths of it as is claimed."""
    end, claimed = 1 + int(plane.solution[row, column]), int(plane.proven[row, column])
    place = f"cell ({row}, {column})"
    if claimed < WHOLE:
        return _try_parts(ends, place, plane.cell(row, column, _CUT), end, claimed, ends.of)
    ((t, v),) = plane.cell(row, column)
    # To the targets alone first, for the lattice has been looked at in a sample only.
    lost = lost_part(ends, t, v, end, _LONGEST, ends.at_target, 0, 0)
    if lost is not None and lost.found == NOWHERE:
        lost = lost_part(ends, t, v, end, _LONGEST, ends.of)
    return None if lost is None else failure_of(ends, place, end, lost)


def try_cell_that_rattles(ends: Ends, plane: Plane, row: int, column: int) -> Failure | None:
    """Prove that of as many 64ths of a cell as is claimed no departure falls quiet."""
    claimed, place = int(plane.never_quiet[row, column]), f"cell ({row}, {column})"
    if claimed == WHOLE:
        ((t, v),) = plane.cell(row, column)
        if lost_part(ends, t, v, NEVER_QUIET, _LONGEST, ends.quiet_or_not, _DEPTH_OF_PART) is None:
            return None
    return _try_parts(ends, place, plane.cell(row, column, _CUT), NEVER_QUIET, claimed, ends.quiet_or_not)


def _try_parts(
    ends: Ends, place: str, parts: list[tuple[arb, arb]], end: int, claimed: int, arrived: Arriving
) -> Failure | None:
    """Whether as many parts as are claimed come to an end; which of them they are is not said."""
    refuted: list[Lost] = []
    left: list[Lost] = []
    # All of them impact by impact: most that come to the end do so soon, and then the others are followed no further.
    going: deque[tuple[int, arb, arb, Moving | None]] = deque((0, *part, None) for part in parts)
    while going:
        impacts, t, v, before = going.popleft()
        moving = box(t, v) if before is None else _moved(ends.machine, before)
        found = NOWHERE if moving is None else arrived(moving)
        if found == end:
            claimed -= 1
            if claimed == 0:
                return None
        elif found != NOWHERE:
            refuted.append(Lost(t, v, found))
        elif moving is None or impacts == _LONGEST:
            left.append(Lost(t, v, found))
        else:
            going.append((impacts + 1, t, v, moving))
    for depth, cuts in _OF_MANY if ends.machine.halves() else _OF_ONE:
        trying, left = left, []
        for part in trying:
            lost = lost_part(ends, part.t, part.v, end, _LONGEST, arrived, depth, cuts)
            if lost is None:
                claimed -= 1
            else:
                (left if lost.found == NOWHERE else refuted).append(lost)
            if claimed == 0:
                return None
    for lost in refuted if len(left) < claimed else left:
        return failure_of(ends, f"{place}, of which {claimed} 64ths more are claimed", end, lost)
    return contradicted(place, f"{claimed} 64ths are claimed beyond those that it has")


def _moved(machine: Machine, moving: Moving) -> Moving | None:
    advanced = advance(machine, moving)
    return None if advanced is None else advanced[0]


def try_box(ends: Ends, trail: int, row: int, column: int) -> Failure | None:
    """Prove that a box of the lattice comes to a target, or to boxes of earlier rounds, of its end."""
    lattice = ends.claims.lattice
    t, v = box_of(lattice, row, column)
    end, this_round = int(lattice.ends[row, column]), int(lattice.rounds[row, column])

    def arrived(moving: Moving) -> int:
        return ends.at_target(moving) or end_in(lattice, moving.strip, this_round)

    lost = lost_part(ends, t, v, end, trail, arrived)
    place = f"box ({row}, {column}) of the lattice, of round {this_round}"
    return None if lost is None else failure_of(ends, place, end, lost)


def try_box_of_window(ends: Ends, impacts: int, number: int, row: int, column: int) -> Failure | None:
    """Prove that a box of a window comes to a disc, or to boxes of windows that were proven earlier, of its end."""
    window = ends.claims.windows[number]
    end, order = int(window.ends[row, column]), int(window.rounds[row, column])
    lost = lost_part(ends, *box_of(window, row, column), end, impacts, lambda moving: ends.near_orbit(moving, order))
    return None if lost is None else failure_of(ends, f"box ({row}, {column}) of window {number}", end, lost)


def try_box_that_rattles(ends: Ends, trail: int, row: int, column: int) -> Failure | None:
    """Prove that a box of which nothing is claimed to fall quiet comes back to such boxes, and is not of rest."""
    lattice = ends.claims.never_quiet
    place = f"box ({row}, {column}) of those that never fall quiet"
    if lattice.first + row <= 0:
        return contradicted(place, "it holds departures at rest")
    lost = lost_part(ends, *box_of(lattice, row, column), NEVER_QUIET, trail, ends.quiet_or_not, first=1)
    return None if lost is None else failure_of(ends, place, NEVER_QUIET, lost)


def try_rattling_box(claims: Claims, rattling: Lattice, row: int, column: int) -> Failure | None:
    """Prove that P maps a box of the rattling set into the set, and that it lies apart from what ends otherwise."""
    place = f"box ({row}, {column}) of the rattling set"
    t, v = box_of(rattling, row, column)
    if claims.core is not None and not v**3 > claims.core.level * claims.machine.acceleration(t):
        return contradicted(place, "it may hold departures of the quiet core")
    for disc in claims.discs if rattling.ends[row, column] != RATTLES else ():
        if not _apart(disc, t, v, _DEPTH):
            return contradicted(place, f"it may hold departures of the disc around t = {disc.t}, v = {disc.v}")
    waiting = [(t, v, _DEPTH)]
    while waiting:
        t, v, depth = waiting.pop()
        if _stays(claims.machine, rattling, box(t, v)):
            continue
        where = f"near t = {float(t.mid()):.12g}, v = {float(v.mid()):.12g}"
        if _leaves(claims.machine, rattling, t.mid(), v.mid()):
            return contradicted(place, f"the image of departures {where} lies outside of the set")
        if depth == 0:
            return undecided(place, f"not decided {where}")
        waiting += [(*part, depth - 1) for part in _parts(t, v, depth)]
    return None


def _parts(t: arb, v: arb, depth: int) -> list[tuple[arb, arb]]:
    return [(half, v) for half in halves(t)] if depth % 2 else [(t, half) for half in halves(v)]


def _apart(disc: Disc, t: arb, v: arb, depth: int) -> bool:
    off = t - arb(disc.t)
    x, y = in_frame(disc, off - (off.mid() + 0.5).floor(), v - arb(disc.v))
    if x * x + y * y > arb(disc.radius) ** 2:
        return True
    return depth > 0 and all(_apart(disc, *part, depth - 1) for part in _parts(t, v, depth))


def _stays(machine: Machine, rattling: Lattice, moving: Moving) -> bool:
    advanced = advance(machine, moving)
    return advanced is not None and end_in(rattling, advanced[0].strip) != NOWHERE


def _leaves(machine: Machine, rattling: Lattice, t: arb, v: arb) -> bool:
    """Whether the image of a departure lies outside for certain: all boxes that it touches do."""
    advanced = advance(machine, box(t, v))
    if advanced is None:
        return False
    touched = boxes_of(rattling, advanced[0].strip)
    return not any(boxes is not None and rattling.ends[boxes].any() for boxes in touched)
