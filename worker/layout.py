"""The Zarr layout, every array once: name, dimensions, type, fill value, meaning.

Fill values are no legal values, so that what is missing never looks like data; but what is missing is told by
``tile_state``, never guessed from values. Leading dimensions of swept parameters go before those named here.
"""

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np

from rattle_kernels import AttractorKind

LAYOUT_VERSION = 2
MISSING = -9
"""Fill value of all integer arrays: no cell number, group, period, step or index."""


class TileState(IntEnum):
    """Ledger of the tiles; 0 is the fill value and means nothing."""

    PENDING = 1
    """Not computed, or not known to be."""
    COMPUTED = 2
    """Images and landing points are in the store."""
    ASSEMBLED = 3
    """Groups, periods, steps and solutions are, too."""


@dataclass(frozen=True)
class Variable:
    """One array of the store."""

    name: str
    dims: tuple[str, ...]
    dtype: Any
    fill: Any
    meaning: str
    attributes: dict[str, Any] = field(default_factory=dict)

    def attrs(self) -> dict[str, Any]:
        """Attributes as stored: CF ``long_name`` and what else belongs to the variable."""
        return {"long_name": self.meaning} | self.attributes


def _flags(codes: type[IntEnum]) -> dict[str, Any]:
    return {
        "flag_values": [int(code) for code in codes],
        "flag_meanings": " ".join(code.name.lower() for code in codes),
    }


_CELLS = ("velocity", "time")
_PERIODS = {"units": "1", "comment": "forcing periods"}
_SPEED = {"units": "1", "comment": "nondimensional speed"}

COORDINATES = (
    Variable("time", ("time",), np.float64, np.inf, "phase of the cell centres", _PERIODS | {"axis": "X"}),
    Variable("velocity", ("velocity",), np.float64, np.inf, "speed of the cell centres", _SPEED | {"axis": "Y"}),
)

MAPPED = (
    Variable(
        "image_cell", _CELLS, np.int64, MISSING, "cell of P^k(centre); -1 sink, -2 permanent contact, -3 undecided",
        {"reserved_values": [-1, -2, -3], "reserved_meanings": "sink permanent_contact undecided"},
    ),
    Variable("landing_time", _CELLS, np.float64, np.inf, "phase of P^k(centre), NaN where captured", _PERIODS),
    Variable("landing_velocity", _CELLS, np.float64, np.inf, "speed of P^k(centre), NaN where captured", _SPEED),
)  # fmt: skip
"""Written tile by tile while tiles are mapped."""

LABELLED = (
    Variable(
        "group", _CELLS, np.int32, MISSING,
        "Hsu's group: 1, 2, ... by lowest cell, 0 sink, -1 permanent contact, -2 undecided",
    ),
    Variable("period", _CELLS, np.int32, MISSING, "Hsu's period: cells in the group's cycle, 0 where there is none"),
    Variable("step", _CELLS, np.int32, MISSING, "Hsu's step: applications to reach the group, 0 on its cycle"),
    Variable("solution", _CELLS, np.int16, MISSING, "motion that the cell ends in: index into the dimension attractor"),
)  # fmt: skip
"""Written tile by tile after assembly."""

LEDGER = Variable(
    "tile_state", ("tile_velocity", "tile_time"), np.uint8, 0, "what is in the store, tile by tile", _flags(TileState)
)

GRAZING = Variable(
    "grazing_velocity", ("time",), np.float64, np.inf, "grazing curve v*(t) at the cell centres' phases", _SPEED
)

ATTRACTORS = (
    Variable("kind", ("attractor",), np.int8, 0, "kind of motion", _flags(AttractorKind)),
    Variable("forcing_periods", ("attractor",), np.int32, MISSING, "m of P(m, n+, n-), 0 where not periodic"),
    Variable("upper_contacts", ("attractor",), np.int32, MISSING, "n+ of P(m, n+, n-): contacts with +beta a turn"),
    Variable("lower_contacts", ("attractor",), np.int32, MISSING, "n- of P(m, n+, n-): contacts with -beta a turn"),
    Variable("lyapunov_exponent", ("attractor",), np.float64, np.inf, "largest Lyapunov exponent per forcing period"),
    Variable("lyapunov_error", ("attractor",), np.float64, np.inf, "standard error of lyapunov_exponent"),
    Variable("share", ("attractor",), np.float64, np.inf, "share of the cells that end in it"),
    Variable("name", ("attractor",), str, "", "P(m, n+, n-), chaotic, permanent contact or undecided"),
    Variable("attractor_time", ("attractor", "point"), np.float64, np.inf, "phases of its departures, NaN-padded"),
    Variable("attractor_velocity", ("attractor", "point"), np.float64, np.inf, "speeds of its departures, NaN-padded"),
)
"""Written at assembly, when it is known how many attractors there are."""

IMAGE_SET_GROUP = "image_set"
IMAGE_SET = (
    Variable("words", ("word",), np.uint64, 0, "distinct image cells: bit cell % 64 of word cell // 64 marks a member"),
    Variable("group", ("member",), np.int32, MISSING, "groups of the members, in ascending order of their cells"),
    Variable("step", ("member",), np.int32, MISSING, "their steps"),
    Variable("period", ("group_number",), np.int32, MISSING, "period of each group, 0 for group 0"),
)
"""In a subgroup of its own: what tiles look their labels up in."""
