"""The arrays of a proof: what is proven of cells, and the lattice that it follows from."""

from dataclasses import replace
from enum import IntEnum

import numpy as np

from worker.stores.layout import NOT_THERE, SOLUTION, Variable, flags


class Unproven(IntEnum):
    """Why not all of a cell is proven to end as it is coloured."""

    PROVEN = 0
    """All of it is."""
    ARRIVES_NOWHERE = 1
    SPREADS = 2
    GRAZES = 3
    ENDS_ELSEWHERE = 4
    """Some of it is proven to end otherwise."""
    RATTLES = 5
    """All of the rest never falls quiet; in which motion it ends is not proven."""


PROVEN = Variable(
    "proven", SOLUTION.dims, np.uint8, NOT_THERE,
    "sixty-fourths of the cell of which every departure ends as the solution says",
)  # fmt: skip
NEVER_QUIET = Variable(
    "never_quiet", SOLUTION.dims, np.uint8, NOT_THERE, "sixty-fourths of the cell of which no departure falls quiet"
)
UNPROVEN_REASON = Variable(
    "unproven_reason", SOLUTION.dims, np.uint8, NOT_THERE, "why not all of the cell is proven", flags(Unproven)
)
"""Written tile by tile after the solution, where a proof was asked for."""

PROOF = "proof"
"""Group of what cells are proven from."""
_GROWING = "proof/growing"
_BOXES = ("lattice_velocity", "lattice_time")
_LOST = 2**16 - 1
LATTICE_ENDS = Variable(
    "ends", _BOXES, np.uint16, _LOST, "1 + the motion in which all departures of a box end, 0 where not proven", {},
    False, PROOF,
)  # fmt: skip
LATTICE_ROUNDS = Variable(
    "rounds", _BOXES, np.uint16, _LOST, "round in which a box was proven, from boxes of earlier rounds", {}, False,
    PROOF,
)  # fmt: skip
LATTICE_NEVER_QUIET = Variable(
    "never_quiet", _BOXES, np.uint8, NOT_THERE, "1 where no departure of a box falls quiet", {}, False, PROOF
)
RATTLING = Variable(
    "rattling", ("rattling_velocity", "rattling_time"), np.uint8, NOT_THERE,
    "1 where a box belongs to the set that rattles for ever", {}, False, PROOF,
)  # fmt: skip
_OF_WINDOWS = ("window", "window_velocity", "window_time")
WINDOW_ENDS = Variable(
    "window_ends", _OF_WINDOWS, np.uint16, _LOST, LATTICE_ENDS.meaning, {}, False, PROOF,
)  # fmt: skip
WINDOW_ORDER = Variable(
    "window_order", _OF_WINDOWS, np.uint32, 2**32 - 1, "when a box was proven, from boxes of lower numbers", {}, False,
    PROOF,
)  # fmt: skip
"""What cells are proven from. ``rounds`` and ``window_order`` mean nothing where ends are 0."""
FOLLOWED = Variable(
    "followed", ("box",), np.uint16, _LOST, "end of a box that comes to a target at once", {}, False, _GROWING
)
TRAILS = Variable(
    "trails", ("box", "impact", "strip"), np.float32, np.nan, "strips that hold the images of a box", {}, False,
    _GROWING,
)  # fmt: skip
"""Of the boxes that are followed at one level, while the lattice grows."""


def grown(variable: Variable, level: int) -> Variable:
    """A variable of the lattice as it is once it has grown at a level that is not the last."""
    return replace(variable, name=f"{variable.name}_{level}", group=_GROWING)
