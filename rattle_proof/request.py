"""What of a basin is to be proven: how finely, for which machines, and on how large a lattice."""

import math
from collections.abc import Collection
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, ConfigDict, Field

from rattle_kernels import CellGrid, Oscillator
from rattle_proof.enclosures import MOST_LEVELS
from worker.additions import Cost
from worker.errors import InvalidJob
from worker.jobs.request import INTEGRAL, Real, Request

if TYPE_CHECKING:
    from rattle_proof.enclosures.machine import Machine

LEVELS = 4
"""How often the lattice grows: as it is first, and each time that its boxes have been cut into four."""
# Its columns at the end: eight for each cell of the longer side of the grid. A box of 1/8192 serves finer grids, too.
_COLUMNS_A_CELL, _FEWEST_COLUMNS, _MOST_COLUMNS = 8, 512, 8192
# Lattices of several parts have as many boxes together as one of these columns: much of them is never proven.
_COLUMNS_OF_PARTS = 4096
# Seconds that a core takes for a box of a lattice, with all that follows from it; and bytes of its arrays.
# Fig. 7 (bottom) takes 2.8e-6 with 1000 x 1000 cells, of which most are proven; damping 0.59 to 0.61 takes 14e-6.
_OF_A_BOX, _BYTES_OF_A_BOX = 14e-6, 5


class ProofRequest(Request):
    """A proof of a basin of the impacting model."""

    model_config = ConfigDict(title="ProofRequest")

    levels: Annotated[int, Field(strict=True, ge=0, le=MOST_LEVELS), INTEGRAL] = Field(
        MOST_LEVELS, description="How often a cell that is not proven whole may be cut into four"
    )
    tolerances: dict[str, tuple[Real, Real]] = Field(
        default_factory=dict,
        description="Least and greatest value of parameters: what is proven holds for every machine within",
    )


def check_proof(
    proof: ProofRequest, oscillator: Oscillator, axes: Collection[Any], sample: Any | None, large: bool
) -> ProofRequest:
    """A proof request in canonical form: all fields there, parameters in order.

    Parameters
    ----------
    proof : ProofRequest
    oscillator : Oscillator
    axes, sample : object
        What the job sweeps, and its points in place of cells, if any.
    large : bool
        Whether it has so many cells that they have levels.

    Returns
    -------
    ProofRequest

    Raises
    ------
    InvalidJob
        If it cannot be proven, or a tolerance is of a parameter that the oscillator lacks, does not hold its value, or
        ends in reverse or where no machine is.
    OutsideDomain
        If Eq. (8) cannot be proven for all machines within.
    """
    refusals = (
        (axes, "a sweep is not proven: ask for a basin at each value of interest"),
        (sample is not None, "points of a sample are not proven: ask for cells"),
        (large, "basins of more than 4000 cells on a side are not proven: ask for a window"),
        (math.isfinite(oscillator.stiffness), "only the impacting model is proven: leave out stiffness"),
    )
    for refused, why in refusals:
        if refused:
            raise InvalidJob(why, ("prove",))
    # Every request of a basin has a field from here. Enclosures take as long to load as ten such requests.
    from rattle_proof.enclosures.machine import ABOVE_ZERO, machine_of, parameters_within

    known = parameters_within(oscillator)
    for name, (least, greatest) in proof.tolerances.items():
        place = ("prove", "tolerances", name)
        if name not in known:
            raise InvalidJob(f"{name} has no tolerance: use one of {', '.join(known)}", place)
        value = oscillator.value_of(name)
        if least > greatest:
            raise InvalidJob(f"the tolerance of {name} ends below its beginning: {least:g} to {greatest:g}", place)
        if not least <= value <= greatest:
            raise InvalidJob(f"{name} = {value:g} does not lie between {least:g} and {greatest:g}", place)
        if not known[name][0] <= least <= greatest <= known[name][1]:
            raise InvalidJob(f"{name} lies between {known[name][0]:g} and {known[name][1]:g}", place)
        if least == 0.0 and name in ABOVE_ZERO:
            raise InvalidJob(f"{name} must lie above 0 in all of its tolerance", place)
    machine_of(oscillator, proof.tolerances)
    tolerances = {name: proof.tolerances[name] for name in known if name in proof.tolerances}
    return ProofRequest(levels=proof.levels, tolerances=tolerances)


def _of_flag(given: Any) -> Any:
    """``true`` asks for a proof as it is by default, ``false`` for none."""
    return ({} if given else None) if isinstance(given, bool) else given


def _or_flag(schema: dict[str, Any]) -> None:
    schema["anyOf"].insert(0, {"type": "boolean"})


FIELD = (
    Annotated[ProofRequest | None, BeforeValidator(_of_flag), Field(json_schema_extra=_or_flag)],
    Field(None, description="Prove of each cell that every departure in it ends as the cell is coloured: true, or how"),
)
"""Field of a request; also ``true`` or ``false``."""


def asked_of(job: Any) -> ProofRequest | None:
    """What a job asks to be proven; None if nothing. The class has its field from here."""
    asked: ProofRequest | None = getattr(job, "prove", None)
    return asked


def machine_asked_of(job: Any) -> "Machine":
    """The machines of a job that asks for a proof, with its tolerances."""
    from rattle_proof.enclosures.machine import machine_of

    asked = asked_of(job)
    assert asked is not None
    return machine_of(job.oscillator, asked.tolerances)


def first_columns(grid: CellGrid, parts: int) -> int:
    """Columns of each lattice before its boxes are cut, where tolerances are cut into so many parts."""
    wanted = _COLUMNS_A_CELL * max(grid.time_cells, grid.velocity_cells)
    most = _MOST_COLUMNS if parts == 1 else 2 ** math.floor(math.log2(_COLUMNS_OF_PARTS / math.sqrt(parts)))
    columns = min(max(2 ** math.ceil(math.log2(wanted)), _FEWEST_COLUMNS), most)
    return columns >> (LEVELS - 1)


def most_boxes(grid: CellGrid, parts: int) -> int:
    """Boxes of all lattices at the end, at most, where the grid holds the fastest motion."""
    columns = first_columns(grid, parts) << (LEVELS - 1)
    # A row is at least half as high as the speeds of all columns divided by their number.
    return 2 * parts * columns * columns


def cost_of(job: Any) -> Cost:
    """What a proof needs, at most: its boxes are followed whatever the speed of the map is."""
    from rattle_proof.enclosures.machine import parts_of

    boxes = most_boxes(job.grid, len(parts_of(machine_asked_of(job))))
    return Cost(boxes * _OF_A_BOX, boxes * _BYTES_OF_A_BOX)
