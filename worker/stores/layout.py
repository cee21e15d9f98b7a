"""The Zarr layout, every array once: name, dimensions, type, fill value, meaning.

Fill values are not legal values, so missing values never look like data. But ``tile_state`` says what is missing, and
readers never guess it from values. A variable that is `per_basin` has a dimension for each swept parameter, with its
name, before those named here.
"""

from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Any

import numpy as np

from rattle_kernels import AttractorKind

Columns = dict[str, np.ndarray]
"""Arrays by name."""

LAYOUT_VERSION = 5
READABLE_LAYOUTS = (3, 4, LAYOUT_VERSION)
"""Chunks of layouts 3 and 4 are compressed by Zstandard, those of layout 3 without checksums."""
MISSING = -9
"""Fill value of all integer arrays: no cell number, group, period, step or index."""
NOT_THERE = 255
"""Fill value of arrays of bytes."""


class TileState(IntEnum):
    """Ledger of the tiles; 0 is the fill value and means nothing."""

    PENDING = 1
    """Not computed, or not known to be."""
    COMPUTED = 2
    """Images and landing points are in the store."""
    ASSEMBLED = 3
    """Groups, periods, steps and solutions are, too."""


class ChangeKind(IntEnum):
    """What can happen to a solution between two neighbouring values of a parameter."""

    BIRTH = 1
    """Absent before, present after."""
    DEATH = 2
    """Present before, absent after."""


@dataclass(frozen=True)
class Variable:
    """One array of the store."""

    name: str
    dims: tuple[str, ...]
    dtype: Any
    fill: Any
    meaning: str
    attributes: dict[str, Any] = field(default_factory=dict)
    per_basin: bool = True
    group: str = ""

    @property
    def path(self) -> str:
        """Name within the store."""
        return f"{self.group}/{self.name}" if self.group else self.name

    def attrs(self) -> dict[str, Any]:
        """Attributes as stored: CF ``long_name`` and the variable's other attributes."""
        return {"long_name": self.meaning} | self.attributes


def flags(codes: type[IntEnum]) -> dict[str, Any]:
    """CF attributes of an array of codes."""
    return {
        "flag_values": [int(code) for code in codes],
        "flag_meanings": " ".join(code.name.lower() for code in codes),
    }


_CELLS = ("velocity", "time")
PERIODS = {"units": "1", "comment": "forcing periods"}
SPEED = {"units": "1", "comment": "nondimensional speed"}

COORDINATES = (
    Variable("time", ("time",), np.float64, np.inf, "phase of the cell centres", PERIODS | {"axis": "X"}, False),
    Variable("velocity", ("velocity",), np.float64, np.inf, "speed of the cell centres", SPEED | {"axis": "Y"}, False),
)

_LANDINGS = (
    ("landing_time", "phase of P^k(start), NaN where captured", PERIODS),
    ("landing_velocity", "speed of P^k(start), NaN where captured", SPEED),
)

MAPPED = (
    Variable(
        "image_cell", _CELLS, np.int64, MISSING, "cell of P^k(centre); -1 sink, -2 permanent contact, -3 undecided",
        {"reserved_values": [-1, -2, -3], "reserved_meanings": "sink permanent_contact undecided"},
    ),
    *(Variable(name, _CELLS, np.float64, np.inf, meaning, attributes) for name, meaning, attributes in _LANDINGS),
)  # fmt: skip
"""Written tile by tile while tiles are mapped."""

LABELLED = (
    Variable(
        "group", _CELLS, np.int32, MISSING,
        "Hsu's group: 1, 2, ... by lowest cell, 0 sink, -1 permanent contact, -2 undecided",
    ),
    Variable("period", _CELLS, np.int32, MISSING, "Hsu's period: cells in the group's cycle, 0 where there is none"),
    Variable("step", _CELLS, np.int32, MISSING, "Hsu's step: applications to reach the group, 0 on its cycle"),
)  # fmt: skip
"""Written tile by tile after assembly."""

_ENDS_IN = "motion that it ends in: index into the dimension attractor"
SOLUTION = Variable("solution", _CELLS, np.int16, MISSING, _ENDS_IN)
"""Written tile by tile once the solutions of the basin have their numbers."""


LEDGER = Variable(
    "tile_state", ("tile_velocity", "tile_time"), np.uint8, 0, "what is in the store, tile by tile", flags(TileState)
)

GRAZING = Variable(
    "grazing_velocity", ("time",), np.float64, np.inf, "grazing curve v*(t) at the cell centres' phases", SPEED
)

_SAMPLE = ("sample",)
SAMPLE_COORDINATES = (
    Variable("time", _SAMPLE, np.float64, np.inf, "phase of the sample's points", PERIODS, False),
    Variable("velocity", _SAMPLE, np.float64, np.inf, "speed of the sample's points", SPEED, False),
)
SAMPLE_MAPPED = (
    Variable(
        "landing", _SAMPLE, np.int8, MISSING, "what became of a point under P^k",
        {"flag_values": [-1, -2, -3], "flag_meanings": "landed permanent_contact undecided"},
    ),
    *(Variable(name, _SAMPLE, np.float64, np.inf, meaning, attributes) for name, meaning, attributes in _LANDINGS),
)  # fmt: skip
SAMPLE_SOLUTION = Variable("solution", _SAMPLE, np.int16, MISSING, _ENDS_IN)
SAMPLE_LEDGER = Variable("tile_state", ("tile",), np.uint8, 0, "what is in the store, tile by tile", flags(TileState))


_ATTRACTOR = ("attractor",)
MOTIONS = (
    Variable("kind", _ATTRACTOR, np.int8, 0, "kind of motion", flags(AttractorKind), False),
    Variable("forcing_periods", _ATTRACTOR, np.int32, MISSING, "m of P(m, n+, n-), 0 where not periodic", {}, False),
    Variable("upper_contacts", _ATTRACTOR, np.int32, MISSING, "n+ of P(m, n+, n-): contacts with +beta", {}, False),
    Variable("lower_contacts", _ATTRACTOR, np.int32, MISSING, "n- of P(m, n+, n-): contacts with -beta", {}, False),
    Variable("name", _ATTRACTOR, str, "", "P(m, n+, n-), or in words what is not periodic", {}, False),
)
"""The motion of each solution by number, the same in all basins."""

_NOT_THERE = "NaN where the panel has no such solution, or is not complete"
MEASURED = (
    Variable("share", _ATTRACTOR, np.float64, np.inf, f"share of the cells that end in it; {_NOT_THERE}"),
    Variable("lyapunov_exponent", _ATTRACTOR, np.float64, np.inf, "largest Lyapunov exponent per forcing period"),
    Variable("lyapunov_error", _ATTRACTOR, np.float64, np.inf, "standard error of lyapunov_exponent"),
    Variable(
        "mean_life", _ATTRACTOR, np.float64, np.inf,
        "of chaos that motions leave again: impacts until one does, on average; NaN where none was seen to leave",
    ),
)  # fmt: skip
"""Properties of each solution in each basin."""


def measured(scramblings: int | None) -> tuple[Variable, ...]:
    """Properties of each solution in each basin; `scramblings` is None for cells, whose shares have no error."""
    if scramblings is None:
        return MEASURED
    of = "of as many independent points" if scramblings == 1 else f"by the scatter of {scramblings} scramblings"
    return *MEASURED, Variable("share_error", _ATTRACTOR, np.float64, np.inf, f"standard error of share, {of}")


POINTS = (
    Variable(
        "attractor_time", ("attractor", "point"), np.float64, np.nan, "phases of its departures, NaN-padded", PERIODS
    ),
    Variable(
        "attractor_velocity", ("attractor", "point"), np.float64, np.nan, "speeds of its departures, NaN-padded", SPEED
    ),
)
"""NaN means that there is no point. No other fill value has a meaning, but that of `ENDS`."""

ENDS = Variable(
    "transient_ends",
    ("attractor", "end"),
    np.float64,
    np.nan,
    "of a chaotic transient: share of its ensemble that ended in each solution (end: index into attractor); NaN: none",
)
"""What chaotic transients end in. Older stores do not have it."""

CHANGES = (
    Variable("change_kind", ("change",), np.int8, 0, "what happens to a solution", flags(ChangeKind), False),
    Variable("change_solution", ("change",), np.int16, MISSING, "which: index into attractor", {}, False),
    Variable("change_parameter", ("change",), str, "", "parameter that changes", {}, False),
    Variable("change_from", ("change",), np.float64, np.inf, "its value before", {}, False),
    Variable("change_to", ("change",), np.float64, np.inf, "its value after", {}, False),
    Variable("change_beside", ("change",), np.float64, np.inf, "value of the other swept parameter or NaN", {}, False),
)
"""Births and deaths of solutions from one basin to the next; in sweeps only, once all basins are complete."""

_ASSEMBLY = "assembly"
IMAGE_WORDS = Variable(
    "words", ("word",), np.uint64, 0, "distinct image cells: bit cell % 64 of word cell // 64 marks a member",
    group=_ASSEMBLY,
)  # fmt: skip
IMAGE_SET = (
    Variable("group", ("member",), np.int32, MISSING, "groups of the members, by their cells", group=_ASSEMBLY),
    Variable("step", ("member",), np.int32, MISSING, "their steps", group=_ASSEMBLY),
    Variable("period", ("group_number",), np.int32, MISSING, "period of each group, 0 for group 0", group=_ASSEMBLY),
)
"""In a separate subgroup: the table in which tiles look up their labels."""
IMAGE_COUNTS = Variable(
    "image_counts", ("reserved",), np.int64, MISSING, "places with the images -1, -2, -3", group=_ASSEMBLY
)
_OWN = "index into the panel's own catalogue, before solutions have the numbers that all panels share"


@dataclass(frozen=True)
class Places:
    """The arrays with one value for each cell of a grid, or for each point of a sample."""

    coordinates: tuple[Variable, ...]
    mapped: tuple[Variable, ...]
    labelled: tuple[Variable, ...]
    solution: Variable
    own_solution: Variable
    ledger: Variable


def _own(solution: Variable) -> Variable:
    return replace(solution, meaning=_OWN, group=_ASSEMBLY)


CELLS = Places(COORDINATES, MAPPED, LABELLED, SOLUTION, _own(SOLUTION), LEDGER)
SAMPLE = Places(SAMPLE_COORDINATES, SAMPLE_MAPPED, (), SAMPLE_SOLUTION, _own(SAMPLE_SOLUTION), SAMPLE_LEDGER)
