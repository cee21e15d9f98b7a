"""Following a box of departures until all of it has come to the end that is claimed; cut in two where that fails."""

from collections.abc import Callable

from flint import arb, ctx

from rattle.verification.ends import NOWHERE, Ends
from rattle.verification.moving import Moving, advance, box
from rattle.verification.quiet import halves
from rattle.verification.verdict import Failure, contradicted, undecided

DEPTH = 16
"""How often a box may be cut in two."""
# A point is followed with so many bits, and so far, to see where it really comes.
_BITS, _IMPACTS = 160, 120

Arriving = Callable[[Moving], int]


def follow(
    ends: Ends, place: str, t: arb, v: arb, end: int, impacts: int, arrived: Arriving,
    depth: int = DEPTH,
) -> Failure | None:  # fmt: skip
    """Prove that all departures of a box come to an end.

    Parameters
    ----------
    ends : Ends
    place : str
        What the box is, for a failure.
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

    Returns
    -------
    Failure or None
    """
    waiting = [(t, v, depth)]
    while waiting:
        t, v, depth = waiting.pop()
        found, last = _end_of(ends, box(t, v), impacts, arrived)
        if found == end:
            continue
        if found != NOWHERE:
            return contradicted(place, _elsewhere(ends, t, v, found))
        if depth == 0:
            return _why(ends, place, t.mid(), v.mid(), end)
        waiting += _parts(t, v, depth - 1, last)
    return None


def _end_of(ends: Ends, moving: Moving, impacts: int, arrived: Arriving) -> tuple[int, Moving]:
    """The end of a set, and the last that is known of it."""
    for n in range(impacts + 1):
        found = arrived(moving)
        if found != NOWHERE or n == impacts:
            return found, moving
        advanced = advance(ends.machine, moving)
        if advanced is None:
            break
        moving = advanced[0]
    return NOWHERE, moving


def _parts(t: arb, v: arb, depth: int, last: Moving) -> list[tuple[arb, arb, int]]:
    """Two halves: cut is the side that has grown longer."""
    by_time, by_speed = last.sides
    if abs(float(by_time[0])) >= abs(float(by_speed[0])):
        return [(half, v, depth) for half in halves(t)]
    return [(t, half, depth) for half in halves(v)]


def _why(ends: Ends, place: str, t: arb, v: arb, end: int) -> Failure:
    """Whether a departure of the box comes to a target of another end."""
    bits, ctx.prec = ctx.prec, _BITS
    try:
        found, _ = _end_of(ends, box(t, v), _IMPACTS, ends.at_target)
    finally:
        ctx.prec = bits
    if found not in (NOWHERE, end):
        return contradicted(place, _elsewhere(ends, t, v, found))
    return undecided(place, f"not decided near t = {float(t):.12g}, v = {float(v):.12g}")


def _elsewhere(ends: Ends, t: arb, v: arb, found: int) -> str:
    names = ends.claims.motions
    name = names[found - 1] if found <= len(names) else f"motion {found - 1}"
    return f"departures near t = {float(t.mid()):.12g}, v = {float(v.mid()):.12g} end in {name}"
