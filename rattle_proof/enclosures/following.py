"""Following all departures of a box until they have come to a proven place."""

from typing import NamedTuple

from rattle_kernels.numerics.jit import inlined_as_written
from rattle_proof.enclosures.interval import width
from rattle_proof.enclosures.lattice import UNPROVEN
from rattle_proof.enclosures.moving_set import WIDEST, advance, set_out, strip_of
from rattle_proof.enclosures.targets import proven_end, rattles

# Why a box is not proven.
ARRIVES_NOWHERE = 1
SPREADS = 2
GRAZES = 3


class Followed(NamedTuple):
    """Where a box ends (UNPROVEN: nowhere proven), why not, and whether none of it falls quiet."""

    end: int
    reason: int
    never_quiet: bool


@inlined_as_written
def follow(machine, oscillator, targets, box, impacts):
    """Follow all departures of a box.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.
    targets : Targets
    box : Box
        Times and speeds.
    impacts : int
        How many impacts at most.

    Returns
    -------
    Followed
    """
    moving = set_out(box, False)
    never_quiet = False
    for n in range(impacts + 1):
        strip = strip_of(moving)
        end = proven_end(targets, moving, strip)
        if end != UNPROVEN:
            return Followed(end, 0, end != targets.quiet)
        never_quiet = never_quiet or rattles(targets, strip)
        if n == impacts:
            break
        proven, moving = advance(machine, oscillator, moving)
        if not (proven and width(moving.all.t) < WIDEST):
            return Followed(UNPROVEN, GRAZES if moving.grazed else SPREADS, never_quiet)
    return Followed(UNPROVEN, GRAZES if moving.grazed else ARRIVES_NOWHERE, never_quiet)
