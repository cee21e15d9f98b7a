"""Following a box of departures until all of it has come to the end that is claimed; cut in two where that fails."""

from collections.abc import Callable
from typing import NamedTuple

from flint import arb, ctx

from rattle_proof.verification.ends import NEVER_QUIET, NOWHERE, Ends
from rattle_proof.verification.machine import Machine
from rattle_proof.verification.moving import Moving, advance, box
from rattle_proof.verification.targets.quiet import halves
from rattle_proof.verification.verdict import Failure, contradicted, undecided

DEPTH = 16
"""How often a box may be cut in two."""
CUTS = 6
"""How often the tolerances may be."""
# A point is followed with so many bits, and so far, to see where it really comes.
_BITS, _IMPACTS = 160, 120

Arriving = Callable[[Moving], int]


class Lost(NamedTuple):
    """A part of a box that does not come to its end: its times and speeds, and where it comes, as far as known."""

    t: arb
    v: arb
    found: int


def lost_part(
    ends: Ends,
    t: arb,
    v: arb,
    end: int,
    impacts: int,
    arrived: Arriving,
    depth: int = DEPTH,
    cuts: int = CUTS,
    first: int = 0,
) -> Lost | None:
    """A part of a box that is not proven to come to an end; None if all of it is.

    Parameters
    ----------
    ends : Ends
    t, v : arb
        Times and speeds.
    end : int
        What is claimed.
    impacts : int
        How many at most.
    arrived : callable
        The end that all of a set is known to come to.
    depth : int
        How often the box may be cut in two.
    cuts : int
        How often the tolerances may be, first of all.
    first : int
        How many impacts at least.

    Returns
    -------
    Lost or None
    """
    lattice = ends.claims.lattice
    speed = lattice.height * lattice.ends.shape[1]
    waiting = [(ends.machine, cuts, t, v, depth)]
    while waiting:
        machine, cuts, t, v, depth = waiting.pop()
        found, last = _end_of(machine, box(t, v), impacts, arrived, first)
        if found == end:
            continue
        machines = machine.halves() if cuts and found == NOWHERE else []
        if machines:
            waiting += [(half, cuts - 1, t, v, depth) for half in machines]
        elif found != NOWHERE or depth == 0:
            return Lost(t, v, found)
        else:
            waiting += [(machine, 0, *part) for part in _parts(t, v, depth - 1, last, speed)]
    return None


def failure_of(ends: Ends, place: str, end: int, lost: Lost) -> Failure:
    """Why a box failed; where nothing is known, a departure is followed to a target."""
    t, v, found = lost
    if found == NOWHERE:
        found = _end_of_point(ends, t.mid(), v.mid())
    where = f"near t = {float(t.mid()):.12g}, v = {float(v.mid()):.12g}"
    if found in (NOWHERE, end) or (end == NEVER_QUIET and found != ends.claims.quiet):
        return undecided(place, f"not decided {where}")
    names = ends.claims.motions
    name = names[found - 1] if found <= len(names) else f"motion {found - 1}"
    return contradicted(place, f"departures {where} end in {name}")


def _end_of(machine: Machine, moving: Moving, impacts: int, arrived: Arriving, first: int = 0) -> tuple[int, Moving]:
    """The end of a set, and the last that is known of it whose sides are images of its own."""
    known, of_its_own = moving, True
    for n in range(impacts + 1):
        found = arrived(moving) if n >= first else NOWHERE
        if found != NOWHERE or n == impacts:
            return found, known
        advanced = advance(machine, moving)
        if advanced is None:
            break
        moving, mapped = advanced
        # The sides of a hull say nothing of those that it comes from.
        of_its_own &= mapped.slope is not None
        known = moving if of_its_own else known
    return NOWHERE, known


def _parts(t: arb, v: arb, depth: int, last: Moving, speed: float) -> list[tuple[arb, arb, int]]:
    """Two halves: cut is the side that has grown longer, where a period is as long as a speed."""
    by_time, by_speed = (abs(float(side_t)) * speed + abs(float(side_v)) for side_t, side_v in last.sides)
    if by_time >= by_speed:
        return [(half, v, depth) for half in halves(t)]
    return [(t, half, depth) for half in halves(v)]


def _end_of_point(ends: Ends, t: arb, v: arb) -> int:
    bits, ctx.prec = ctx.prec, _BITS
    try:
        return _end_of(ends.machine, box(t, v), _IMPACTS, ends.at_target)[0]
    finally:
        ctx.prec = bits
