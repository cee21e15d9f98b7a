"""A list of machines that a sweep computes one after the other, over a coordinate; and the axes of a sweep.

A sweep steps along axes. An axis is a swept parameter, or a design: numbers of the oscillator that change together, as
all of them do with the speed of a machine. What reads a sweep asks its axes for names, values and machines, and need
not know which of the two they are.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import AfterValidator, Field, WithJsonSchema

from rattle_kernels import Oscillator
from worker.errors import InvalidJob
from worker.jobs.request import Real, Request, in_schema
from worker.jobs.swept_parameter import Parameter, SweptParameter, check_parameter, check_values, is_parameter

_NAME = re.compile("[a-z][a-z0-9_]{0,39}")
_UNITS = re.compile(r"[^\s\x00-\x1f\x7f](?:[^\x00-\x1f\x7f]{0,22}[^\s\x00-\x1f\x7f])?")
RESERVED = frozenset(
    """
    allow_no_quiet_solution assembly attractor attractor_time attractor_velocity basin basin_entropy
    boundary_entropy change change_beside change_from change_kind change_parameter change_solution change_to
    complete creator dataset end expected_impact_power expected_impact_power_error expected_impacts_per_period
    expected_impacts_per_period_error expected_largest_impact_speed expected_largest_impact_speed_error
    expected_time_in_contact expected_time_in_contact_error finished forcing_periods fused_multiply_add gamma
    git_revision global_integrity grazing_velocity grid group group_number harmonics history image_cell image_counts
    impact_power impact_power_error impacts_per_period impacts_per_period_error integrity_factor iterations kind
    landing landing_time landing_velocity largest_impact_speed largest_impact_speed_error layout_version
    least_disturbance license local_integrity lower_contacts lyapunov_error lyapunov_exponent mean_life member model
    name oscillator own_solution period permanent_contact point references request request_sha256 reserved sample
    scrambling share share_error solution source started step tile tile_cells tile_state tile_time tile_velocity
    time time_in_contact time_in_contact_error title transient_ends uncertainty_error uncertainty_exponent
    undecided_share upper_contacts velocity velocity_scale versions window word words
    """.split()
)
"""Names of arrays, dimensions and attributes of a sweep's results, which no coordinate may take."""


def _coordinate(name: str) -> str:
    if not _NAME.fullmatch(name):
        raise ValueError(f"a coordinate is named in small letters, digits and _, as in speed, not {name!r}")
    if is_parameter(name):
        raise ValueError(f"{name} is a parameter, and no coordinate: what it takes belongs into parameters")
    if name in RESERVED:
        raise ValueError(f"{name} is a name of results already: give the coordinate another one")
    return name


def _units(units: str) -> str:
    if not _UNITS.fullmatch(units):
        raise ValueError(f"units are 1 to 24 printed characters, as in rpm, not {units!r}")
    return units


Column = Annotated[tuple[Real, ...], Field(fail_fast=True), in_schema(minItems=1)]


class Design(Request):
    """Machines of a sweep, in the order in which they follow one another, over a coordinate such as the speed."""

    name: Annotated[
        str, AfterValidator(_coordinate), WithJsonSchema({"type": "string", "pattern": f"^{_NAME.pattern}$"})
    ] = Field(description="Of the coordinate, as in `speed`")
    units: Annotated[str, AfterValidator(_units), in_schema(minLength=1, maxLength=24)] | None = Field(
        None, description="Of its values, as in `rpm`"
    )
    values: Column = Field(description="Of the coordinate, ascending or descending: one for each machine")
    parameters: dict[Parameter, Column] = Field(
        min_length=1, description="Numbers of the oscillator that change: of each parameter one value for each machine"
    )

    @property
    def columns(self) -> Mapping[str, tuple[float, ...]]:
        """Values of each parameter that changes along the axis."""
        return self.parameters

    @property
    def size(self) -> int:
        """Number of machines."""
        return len(self.values)

    def least(self, parameter: str) -> float | None:
        """Least value above 0 that a parameter takes, or None if it does not change."""
        if parameter not in self.parameters:
            return None
        return min((value for value in self.parameters[parameter] if value > 0.0), default=1.0)

    def at(self, index: int) -> dict[str, float]:
        """Values of the parameters of a machine."""
        return {name: values[index] for name, values in self.parameters.items()}

    def settled(self) -> "Design":
        """The same machines in canonical form."""
        sorted_by_name = self.model_copy(update={"parameters": dict(sorted(self.parameters.items()))})
        return sorted_by_name.settled_to(("name", "values", "parameters", *(("units",) if self.units else ())))


SweepAxis = SweptParameter | Design
"""What a sweep steps along."""


def changes_at(axes: Sequence[SweepAxis], place: Sequence[int]) -> dict[str, float]:
    """Values of all parameters that change, at a place along each axis.

    Parameters
    ----------
    axes : sequence of SweptParameter or Design
    place : sequence of int

    Returns
    -------
    dict
        Values by the parameter's name.
    """
    return {name: value for axis, at in zip(axes, place, strict=True) for name, value in axis.at(at).items()}


def check_design(design: Design, oscillator: Oscillator) -> None:
    """Refuse numbers that the oscillator does not have, columns of unequal lengths, and coordinates that turn round.

    Parameters
    ----------
    design : Design
    oscillator : Oscillator
        Whose numbers they are, unchecked.

    Raises
    ------
    InvalidJob
        With the location of the fault.
    """
    check_values(design.name, design.values, ("design", "values"))
    for name, values in design.parameters.items():
        place = ("design", "parameters", name)
        check_parameter(name, oscillator, place)
        if len(values) != design.size:
            raise InvalidJob(f"{name} has {len(values)} values for {design.size} machines: give one for each", place)


def is_sweep(request: Mapping[str, Any]) -> bool:
    """Whether a request of basins is one of several."""
    return "vary" in request or "design" in request
